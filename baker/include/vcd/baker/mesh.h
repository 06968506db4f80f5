// The triangles of one object, as every pass of the baker hands them on.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace vcd {

using Position = std::array<float, 3>;            // x, y, z in the object's own frame and unit
using TriangleIndices = std::array<uint32_t, 3>;  // into the positions of the same mesh, counter-clockwise or not

// One object as its source file gives it: nothing welded, dropped or moved.
struct SourceMesh {
  std::string name;           // UTF-8; empty where the source has none
  uint32_t source_index = 0;  // index of the glTF mesh; 0 for formats with one object a file
  std::vector<Position> positions;
  std::vector<TriangleIndices> triangles;
};

}  // namespace vcd
