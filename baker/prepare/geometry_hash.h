#pragma once

#include <array>
#include <cstdint>

#include <vcd/baker/prepare.h>

namespace vcd::baker {

// Of welded positions and triangles: spec/vcd-format.md, "Geometry hash".
std::array<uint8_t, 16> geometry_hash(const PreparedMesh& mesh);

}  // namespace vcd::baker
