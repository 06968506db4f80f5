// Mesh files to triangles.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include <vcd/baker/child_process.h>
#include <vcd/baker/mesh.h>
#include <vcd/baker/scene_light.h>
#include <vcd/baker/source.h>
#include <vcd/format/error.h>

namespace vcd::baker {

struct IngestOptions {
  // Bake alpha-masked, blended, transmissive, skinned and morphed parts as if they were opaque and rigid, as they
  // stand in the file. By default they are left out, with a note for each.
  bool treat_all_as_opaque = false;
  // Read where the default scene's nodes put the meshes. Off: placements stays empty.
  bool placements = false;
  // Read the lights of the default scene, and the placements too.
  bool lights = false;
  // A mesh file may name others (the buffers of .gltf). By default these must lie in the mesh file's folder or below
  // it, links followed, since a file from elsewhere could else have any file of this machine read, and its bytes baked.
  bool files_outside = false;
  // Subtracted in double precision from every coordinate before it is rounded to a 32-bit float; of glTF and Draco,
  // whose coordinates are floats already, from each mesh in its own frame. For georeferenced meshes, far from their
  // origin.
  std::array<double, 3> shift{};
  // Take a mesh even if the rounding of its coordinates moves them by more than 2^-10 of its extent. Beyond 2^-16 there
  // is a note in any case.
  bool coarse = false;
  // How often each mesh is subdivided by Loop's scheme, for files that hold the control mesh of a subdivision surface;
  // at most kMostSubdivisions. Each time a triangle becomes four. Polygons are cut into triangles first. Only surfaces
  // can be subdivided: a mesh with an edge of three triangles is an error (unsupported). The result is the same on
  // every machine; a renderer's own subdivision gives other floats, so let it load what vc-scene writes.
  uint32_t subdivide = 0;
};

inline constexpr uint32_t kMostSubdivisions = 6;  // a triangle becomes 4096

// One mesh in one place.
struct Placement {
  uint64_t mesh = 0;  // index into Ingested::meshes
  // Row-major 3 x 4, mesh frame -> scene frame; column 3 is the translation. Finite and invertible, also when rounded
  // to 32-bit floats; may mirror.
  std::array<double, 12> transform = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

  bool operator==(const Placement&) const = default;
};

struct Ingested {
  std::vector<SourceMesh> meshes;  // at least one; each has at least one triangle, finite positions, indices in range
  std::vector<std::string> notes;  // what was left out or passed over, one sentence each, naming mesh and primitive
  // If asked for: where the meshes stand in the scene, a mesh in any number of places. Empty, with a note, if a glTF
  // file's scene holds none of them or its nodes cannot be read: then each may as well stand as it is. Formats other
  // than glTF: each as it is. A shift is taken back, so that all stands where it would without.
  std::vector<Placement> placements;
  // If asked for: the lights of a glTF file's scene, in the order of its nodes and the sky last. None, with a note, if
  // its nodes or lights cannot be read.
  std::vector<SceneLight> lights;
  std::vector<SourceFile> sources;  // every file that was read: the mesh file, then those that it names. Hashes are of
                                    // the bytes as they were parsed, whatever the files hold by now
};

// Reads one mesh file: .glb, .gltf (2.0), .drc, .obj, .ply, .stl or .off, told apart by its extension (any case).
//
// Returns one mesh per glTF mesh (all its primitives together, in mesh space, whichever and however many nodes use
// it, and even if none does), or one mesh for a file of any other format. Polygons become triangles.
// Errors: io (cannot be read, a buffer it names is missing), invalid_file (breaks its format: a non-finite position,
// an index out of range, no triangle at all, …), unsupported (glTF 1.0, a required extension that is not known).
// The message names file, mesh, primitive and element.
//
// The parsers underneath are not safe on hostile bytes. Programs call ingest_isolated.
// Safe from any thread; no state is shared.
Result<Ingested> ingest(const std::filesystem::path& path, const IngestOptions& options = {});

// Of the files that ingest() reads, in lower case and without the dot: "glb", "gltf", …
std::vector<std::string> mesh_extensions();

using IngestLimits = ChildLimits;

// ingest() in a child process with limits on time and memory: a file that crashes, hangs or floods its parser ends in
// an Error (code runtime for a crash, a time-out or exhausted memory), and the caller lives on.
Result<Ingested> ingest_isolated(const std::filesystem::path& path, const IngestOptions& options = {},
                                 const IngestLimits& limits = {});

}  // namespace vcd::baker
