// A library of assets by the geometry of their meshes. Holds hashes, no meshes.
#pragma once

#include <array>
#include <compare>
#include <functional>
#include <map>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include <vcd/baker/ingest.h>

#include <vcd/library/find.h>
#include <vcd/verify/outcome.h>

namespace vcd::verify {

struct AssetMesh {
  uint32_t source_index;
  std::string name;
  GeometryHash geometry;
};

// How an asset is read: with which parts, moved by what, and subdivided how often. By default as vc-bake reads it by
// default; sidecars say where they were baked otherwise.
struct Way {
  bool all_as_opaque = false;
  std::array<double, 3> shift = {};
  uint32_t subdivide = 0;

  auto operator<=>(const Way&) const = default;
};

// What reading an asset in one way gave.
struct Reading {
  bool done = false;                // or the run was interrupted
  std::optional<Error> fault = {};  // of the whole file, or of its last mesh if none can be prepared
  std::vector<AssetMesh> meshes = {};
  std::vector<std::pair<std::string, Error>> unusable = {};  // meshes, as shown, that cannot be prepared
};

class Library {
 public:
  using Stop = std::function<bool()>;

  // Reads every asset by default in a child process, one a thread; no more meshes are in memory at once than an asset
  // has for each thread. `ingest` says what no sidecar does: files_outside.
  Library(std::vector<library::FoundFile> files, baker::IngestOptions ingest, Stop stop);

  // Assets are numbered in the order of the files. Safe from any thread, but for any_other_reading_has(), which comes
  // when all are read.
  size_t size() const { return files_.size(); }
  const library::FoundFile& file(size_t asset) const { return files_[asset]; }
  baker::IngestOptions options(const Way& way) const;

  // One asset read in one way, now or before.
  const Reading& reading(size_t asset, const Way& way);
  // Whether a reading of the asset in another way than the default one, as far as there are any, has such a mesh.
  bool any_other_reading_has(size_t asset, const std::function<bool(const AssetMesh&)>& is_wanted) const;

  // Assets with a mesh of this geometry, in their order, if they are read in this way: of all, or of some. The first
  // question about all in a way reads them all.
  std::span<const size_t> with_geometry(const GeometryHash& geometry, const Way& way);
  std::vector<size_t> with_geometry(const GeometryHash& geometry, const Way& way, std::span<const size_t> assets);

  // The asset that a sidecar names by where it lies, as X.vcd beside X or at the same place below its own folder.
  std::optional<size_t> named_by_path(const library::FoundFile& sidecar) const;
  std::vector<size_t> named(const std::filesystem::path& file_name) const;  // in any folder

 private:
  struct Slot {
    std::once_flag once;
    Reading reading;
  };
  struct Index {
    std::once_flag once;
    std::map<GeometryHash, std::vector<size_t>> assets;
  };
  void read_all(const Way& way, Index& index);

  std::vector<library::FoundFile> files_;
  baker::IngestOptions ingest_;
  Stop stop_;
  std::map<std::filesystem::path, std::vector<size_t>> by_place_, by_path_below_, by_name_;
  mutable std::mutex mutex_;  // of the two maps, not of what they hold
  std::map<std::pair<size_t, Way>, Slot> slots_;
  std::map<Way, Index> indices_;
};

}  // namespace vcd::verify
