#include <vcd/verify/library.h>

#include <algorithm>
#include <iterator>
#include <limits>
#include <new>

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <vcd/verify/inputs.h>
#include "common/meshes.h"

namespace vcd::verify {

using namespace baker;
using namespace tools;
using namespace library;
namespace {

namespace fs = std::filesystem;

constexpr double kLowest = -std::numeric_limits<double>::infinity();
constexpr Way kFirstWay = {false, {kLowest, kLowest, kLowest}, 0};  // in their order

Reading ingest_hashes(const fs::path& path, const IngestOptions& options) try {
  auto file = MeshFile::read(path, options);
  if (!file) return {.done = true, .fault = file.error()};
  Reading reading{.done = true};
  while (const auto mesh = file->next())
    reading.meshes.push_back({mesh->source_index, mesh->name, mesh->geometry_hash});
  reading.fault = file->fault();
  if (!reading.fault)
    for (const MeshFile::Unusable& mesh : file->unusable()) reading.unusable.emplace_back(mesh.place, mesh.error);
  return reading;
} catch (const std::bad_alloc&) {
  return {.done = true, .fault = Error{ErrorCode::runtime, "out of memory"}};
}

bool has_mesh(const Reading& reading, const GeometryHash& geometry) {
  return std::ranges::find(reading.meshes, geometry, &AssetMesh::geometry) != reading.meshes.end();
}

template <class Map>
std::span<const size_t> find_in(const Map& map, const typename Map::key_type& key) {
  const auto found = map.find(key);
  return found == map.end() ? std::span<const size_t>() : found->second;
}

}  // namespace

Library::Library(std::vector<FoundFile> files, IngestOptions ingest, Stop stop)
    : files_(std::move(files)), ingest_(ingest), stop_(std::move(stop)) {
  for (size_t i = 0; i < files_.size(); ++i) {
    by_place_[place_of(files_[i].path)].push_back(i);
    by_path_below_[files_[i].below].push_back(i);
    by_name_[files_[i].path.filename()].push_back(i);
  }
  (void)with_geometry({}, {});  // all are read
}

IngestOptions Library::options(const Way& way) const {
  IngestOptions options = ingest_;
  options.treat_all_as_opaque = way.all_as_opaque;
  options.shift = way.shift;
  options.subdivide = way.subdivide;
  options.coarse = true;  // whether to bake it was decided when it was baked
  return options;
}

const Reading& Library::reading(size_t asset, const Way& way) {
  Slot& slot = [&]() -> Slot& {
    const std::lock_guard lock(mutex_);
    return slots_[{asset, way}];
  }();
  std::call_once(slot.once, [&] {
    if (stop_()) return;
    Reading reading = ingest_hashes(files_[asset].path, options(way));
    if (!stop_()) slot.reading = std::move(reading);  // else the child may have been interrupted as well
  });
  return slot.reading;
}

bool Library::any_other_reading_has(size_t asset, const std::function<bool(const AssetMesh&)>& is_wanted) const {
  const std::lock_guard lock(mutex_);
  for (auto slot = slots_.lower_bound({asset, kFirstWay}); slot != slots_.end() && slot->first.first == asset; ++slot)
    if (slot->first.second != Way{} && std::ranges::any_of(slot->second.reading.meshes, is_wanted)) return true;
  return false;
}

void Library::read_all(const Way& way, Index& index) {
  tbb::parallel_for(
      tbb::blocked_range<size_t>(0, size(), 1),
      [&](const tbb::blocked_range<size_t>& range) {
        // Isolated, so that a thread that waits within one asset does not take up another.
        for (size_t i = range.begin(); i < range.end(); ++i)
          tbb::this_task_arena::isolate([&] { (void)reading(i, way); });
      },
      tbb::simple_partitioner());
  for (size_t i = 0; i < size(); ++i)
    for (const AssetMesh& mesh : reading(i, way).meshes) {
      std::vector<size_t>& same = index.assets[mesh.geometry];
      if (same.empty() || same.back() != i) same.push_back(i);
    }
}

std::span<const size_t> Library::with_geometry(const GeometryHash& geometry, const Way& way) {
  Index& index = [&]() -> Index& {
    const std::lock_guard lock(mutex_);
    return indices_[way];
  }();
  std::call_once(index.once, [&] { read_all(way, index); });
  return find_in(index.assets, geometry);
}

std::vector<size_t> Library::with_geometry(const GeometryHash& geometry, const Way& way,
                                           std::span<const size_t> assets) {
  std::vector<size_t> found;
  std::ranges::copy_if(assets, std::back_inserter(found),
                       [&](size_t asset) { return has_mesh(reading(asset, way), geometry); });
  return found;
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
