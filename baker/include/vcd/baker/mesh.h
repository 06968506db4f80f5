// The triangles of one object, as every pass of the baker hands them on.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include <vcd/format/weld.h>

namespace vcd::baker {

using vcd::Position;
using vcd::TriangleIndices;

// Parts of an object that its source has and the triangles have not. A line that is clear of the triangles may be
// blocked by such a part.
struct LeftOut {
  uint32_t not_opaque = 0;  // glTF primitives with alpha, blending or transmission
  uint32_t deforming = 0;   // with a skin or morph targets

  bool any() const { return not_opaque > 0 || deforming > 0; }
  bool operator==(const LeftOut&) const = default;
};

// One object as its source file gives it: nothing welded or dropped. From memory, fill positions and triangles; the
// rest may stay as it is.
struct SourceMesh {
  std::string name;           // UTF-8; empty where the source has none
  uint32_t source_index = 0;  // index of the glTF mesh; 0 for formats with one object a file
  std::vector<Position> positions;
  std::vector<TriangleIndices> triangles;
  std::array<double, 3> shift{};  // what was subtracted from the source's coordinates, units
  LeftOut left_out = {};
};

}  // namespace vcd::baker
