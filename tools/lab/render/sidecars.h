// The sidecars that go with a world's objects.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <vcd/baker/bake.h>
#include <vcd/runtime/sidecar.h>

#include "world.h"

namespace vcd::render {

// Open sidecars, and for each object of a world the one that answers for it.
struct WorldSidecars {
  std::vector<Sidecar> files;
  std::vector<Object> objects;  // objects[i] is world.objects[i]'s; points into files
};

// Objects are told by the hash of their geometry. Errors: those of Sidecar::open; stale, naming an object's source for
// which no file has a tree.
Result<WorldSidecars> open_sidecars(const World& world, const std::vector<std::string>& paths,
                                    const OpenOptions& options = {});

struct WorldBake {
  double seconds = 0;  // of all objects
  uint64_t rays = 0, file_bytes = 0;
  uint32_t depth = 0;  // of the deepest
};

// Bakes all objects of a world into one sidecar, with a quick audit. progress: what is baked, and how far it is.
// Errors: those of bake() and write_sidecar().
Result<WorldBake> bake_world(const World& world, const baker::BakeOptions& options, const std::filesystem::path& path,
                             const std::function<void(const WorldObject&, const baker::BakeProgress&)>& progress);

// Writes one sidecar of a world's objects. Returns its bytes. Errors: those of write_sidecar().
Result<uint64_t> write_world(const World& world, const std::vector<baker::BakedObject>& baked,
                             const std::filesystem::path& path, const std::function<bool()>& stop = {});

}  // namespace vcd::render
