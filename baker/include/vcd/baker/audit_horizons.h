// Horizons held against exact arithmetic.
#pragma once

#include <cstdint>
#include <functional>

#include <vcd/baker/prepare.h>
#include <vcd/format/hierarchy.h>
#include <vcd/format/horizon.h>

namespace vcd::baker {

struct HorizonAudit {
  uint64_t segments = 0, clear = 0, wrong = 0;  // asked; answered; answered though the mesh blocks them
  bool stopped = false;
};

// Asks about `segments` segments that begin above triangles of the mesh, half of them as near to what is not answered
// as floats can be. The same on any number of threads; safe from any thread. Throws std::bad_alloc.
//
// stop: asked often, from many threads at once; may be empty.
HorizonAudit audit_horizons(const PreparedMesh& mesh, const HierarchyView& hierarchy, const HorizonView& horizon,
                            uint64_t segments, const std::function<bool()>& stop = {});

}  // namespace vcd::baker
