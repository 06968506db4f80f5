// Meshes in memory → a sidecar: for exporters of modelling programs, and for renderers that bake when they load. This
// is all of vcd::baker that is installed.
//
//   const vcd::baker::MeshToBake tree{"tree", {positions, position_count}, {indices, triangle_count}};
//   const auto size = vcd::baker::bake_sidecar("tree.vcd", {&tree, 1});
//   if (!size) return fail(size.error().message);
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <span>
#include <string>
#include <string_view>

#include <vcd/format/aligned_bytes.h>
#include <vcd/format/error.h>
#include <vcd/format/geometry_hash.h>
#include <vcd/format/layout.h>

namespace vcd::baker {

// One object of the sidecar: triangles or quads that are opaque and do not deform, in the object's own frame and unit,
// which are those of the segments that a renderer will ask. Winding, order and duplicates do not matter.
struct MeshToBake {
  std::string_view name;     // UTF-8; may be empty
  PositionBuffer positions;  // floats, at any stride
  IndexBuffer faces;         // 16 or 32 bits
};

struct SidecarOptions {
  Method method = Method::hybrid;
  uint32_t depth = 0;  // 1 … 8; 0: as deep as pays, and nothing but the hierarchy where nothing pays
  // Of a file with one of the meshes alone; 0: no limit, but 4 MiB where the depth is 0.
  uint64_t budget_bytes = 0;
  double budget_seconds = 0;  // of each mesh; 0: no limit. What is not classified in time is unclassified
  unsigned threads = 0;       // 0: all; else TBB has at most so many meanwhile, in the whole process
  bool hierarchy = true;      // keeps the triangles, so that a renderer needs no BVH of its own: some 30 bytes each
  bool horizons = false;      // for rays that start on the object: 12 bytes a triangle
  // Fresh lines that are judged in exact arithmetic after the bake, each mesh; the file says how many were wrong. 0: no
  // audit.
  uint64_t audit_lines = 50'000;
  bool compress = false;  // to ship, not to render
  std::map<std::string, std::string> provenance = {};

  // Called now and then, by one thread at a time: the index of the mesh; what is done with it, such as "classify"; and
  // how much of that is done, 0 … 1.
  std::function<void(size_t mesh, std::string_view pass, double done)> progress = {};
  std::function<bool()> stop = {};  // asked often, from many threads at once; true ends the bake with an error
};

// Bakes the meshes and writes their sidecar to `path`, which belongs to the old file or to the whole new one at any
// time. Returns the file's size. The same meshes and options give the same bytes, unless budget_seconds ended a bake.
//
// Errors: usage (an option, an index or a position out of range); invalid_file (a mesh
// has no triangle with an area); unsupported (a mesh too large or too small for 32-bit floats); io; difference (the
// audit found a wrong proof: a fault of vcd); runtime (out of memory, or stopped). An error leaves the old file.
//
// Safe from any thread. Works on threads of TBB. Exceptions of the callbacks pass through.
Result<uint64_t> bake_sidecar(const std::filesystem::path& path, std::span<const MeshToBake> meshes,
                              const SidecarOptions& options = {});

// The same bytes in memory, as Sidecar::open_buffer() in <vcd/runtime/sidecar.h> takes them.
Result<AlignedBytes> bake_sidecar(std::span<const MeshToBake> meshes, const SidecarOptions& options = {});

}  // namespace vcd::baker
