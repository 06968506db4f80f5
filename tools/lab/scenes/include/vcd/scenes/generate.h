// The paper's scenes, generated. Everything is deterministic: the same options give the same bytes on every machine.
// Options beyond their range are brought into it. Nothing here asks whether the result fits into memory: the counts
// below tell a caller beforehand (12 bytes a triangle, and 12 a position, of which there are at most two a triangle).
#pragma once

#include <cstdint>

#include <vcd/scenes/scene.h>

namespace vcd::scenes {

// Sierpinski pyramid: a regular tetrahedron, each level four half-size copies at its corners: 4^(level + 1) triangles
// (level 8: 262,144), edge length 2, standing on the ground. Corners that touch are the same to the bit. level 0 … 12.
Scene sierpinski(uint32_t level = 8);

// A ball of curled hair in the manner of Laine's hairball (Laine and Karras 2010), about 1 in radius: strands grow from
// a small core outwards, each a bent, tapering tube with open ends: strands · 2 · sides · segments triangles.
// Throws std::length_error where 32-bit indices cannot name all positions: beyond 28 million strands like the
// default's.
struct HairballOptions {
  uint32_t strands = 10000;  // with the defaults, 2.88 million triangles
  uint32_t segments = 24;    // along a strand, at least 1
  uint32_t sides = 6;        // of a tube, at least 3
  uint64_t seed = 1;
};
Scene hairball(const HairballOptions& options = {});
uint64_t hairball_triangles(const HairballOptions& options);

// Several generated tree species (broadleaf, conifer, birch, shrub), instanced over a ground with random turn about y
// and random scale, about a glade into which the camera looks. No two trunks are closer than 0.6 times the sum of their
// crowns' radii.
struct ForestOptions {
  uint32_t instances = 200;
  uint32_t species = 3;    // 1 … 4 distinct meshes
  uint32_t leaves = 8000;  // of one tree, about; fewer are larger
  uint64_t seed = 1;
};
Scene forest(const ForestOptions& options = {});
uint64_t forest_mesh_triangles_bound(const ForestOptions& options);  // of all species together, at most

// The paper's setting about any one mesh: it is turned so that `up` ('x', 'y' or 'z') points up, stands on the ground,
// and is lit and looked at from the front by lights and a camera that are placed by its size. The mesh keeps its own
// frame; its instance carries the turn, a proper rotation. Any extent that is finite will do, a flat one too.
// degrees: how far it is turned on the spot, counter-clockwise seen from above; whole quarter turns are exact.
Scene around(Mesh mesh, char up = 'y', double degrees = 0);

}  // namespace vcd::scenes
