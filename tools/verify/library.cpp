#include <vcd/verify/library.h>

#include <new>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <vcd/verify/inputs.h>
#include "common/describe.h"
#include "common/meshes.h"

namespace vcd::verify {

using namespace baker;
using namespace tools;
using namespace library;
namespace {

namespace fs = std::filesystem;

Reading ingest_hashes(const fs::path& path, const IngestOptions& options) try {
  Reading reading{.done = true};
  const TakeMesh take = [&](const std::string& name, uint32_t index, Result<PreparedMesh>&& mesh) {
    if (mesh) return reading.meshes.push_back({index, name, mesh->geometry_hash});
    reading.unusable.emplace_back("mesh " + std::to_string(index) + " " + printable(name), mesh.error());
  };
  reading.fault = each_mesh(path.string(), options, take);
  return reading;
} catch (const std::bad_alloc&) {
  return {.done = true, .fault = Error{ErrorCode::runtime, "out of memory"}};
}

template <class Map>
std::span<const size_t> find_in(const Map& map, const typename Map::key_type& key) {
  const auto found = map.find(key);
  return found == map.end() ? std::span<const size_t>() : found->second;
}

}  // namespace

Library::Library(std::vector<FoundFile> files, IngestOptions ingest, Stop stop)
    : ingest_(ingest), stop_(std::move(stop)) {
  for (FoundFile& file : files) {
    const size_t index = assets_.size();
    by_place_[place_of(file.path)].push_back(index);
    by_path_below_[file.below].push_back(index);
    by_name_[file.path.filename()].push_back(index);
    assets_.push_back({std::move(file), {}});
  }
  read(opaque_parts);
}

IngestOptions Library::options(Parts parts) const {
  IngestOptions options = ingest_;
  options.treat_all_as_opaque = parts == all_parts;
  return options;
}

void Library::read(Parts parts) {
  tbb::parallel_for(
      tbb::blocked_range<size_t>(0, assets_.size(), 1),
      [&](const tbb::blocked_range<size_t>& range) {
        for (size_t i = range.begin(); i < range.end() && !stop_(); ++i)
          // Isolated, so that a thread that waits within one asset does not take up another.
          tbb::this_task_arena::isolate([&] {
            Reading reading = ingest_hashes(assets_[i].file.path, options(parts));
            if (!stop_())
              assets_[i].readings[parts] = std::move(reading);  // else the child may have been interrupted as well
          });
      },
      tbb::simple_partitioner());
  for (size_t i = 0; i < assets_.size(); ++i)
    for (const AssetMesh& mesh : assets_[i].readings[parts].meshes) {
      std::vector<size_t>& same = by_geometry_[parts][mesh.geometry];
      if (same.empty() || same.back() != i) same.push_back(i);
    }
}

std::span<const size_t> Library::with_geometry(const GeometryHash& geometry, Parts parts) {
  if (parts == all_parts) std::call_once(all_parts_read_, [&] { read(all_parts); });
  return find_in(by_geometry_[parts], geometry);
}

std::optional<size_t> Library::named_by_path(const FoundFile& sidecar) const {
  const auto without_extension = [](fs::path path) { return path.replace_extension(); };
  const auto beside = find_in(by_place_, without_extension(place_of(sidecar.path)));
  if (!beside.empty()) return beside[0];
  const fs::path below = without_extension(sidecar.below);
  // A file that was named itself has lost its folder: then its name says where it belongs only if no other asset has
  // it.
  if (!below.has_parent_path() && find_in(by_name_, below).size() > 1) return std::nullopt;
  const auto mirrored = find_in(by_path_below_, below);
  if (mirrored.empty()) return std::nullopt;
  return mirrored[0];
}

std::vector<size_t> Library::named(const fs::path& file_name) const {
  const auto found = find_in(by_name_, file_name);
  return {found.begin(), found.end()};
}

}  // namespace vcd::verify
