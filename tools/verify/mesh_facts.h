// What a record says of its mesh and only the mesh can tell.
#pragma once

#include <vcd/baker/prepare.h>
#include <vcd/format/layout.h>

#include <vcd/verify/outcome.h>

namespace vcd::verify {

// Its counts, and the padding of its box.
void check_facts(const ObjectRecord& record, const baker::PreparedMesh& mesh, const std::string& place,
                 Outcome& outcome);

}  // namespace vcd::verify
