// A library of assets by the geometry of their meshes. Holds hashes, no meshes.
#pragma once

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

// What one way of ingesting an asset gave.
struct Reading {
  bool done = false;                // or the run was interrupted
  std::optional<Error> fault = {};  // of the whole file
  std::vector<AssetMesh> meshes = {};
  std::vector<std::pair<std::string, Error>> unusable = {};  // meshes, as shown, that cannot be prepared
};

// How assets are ingested: as by default, or with all parts as opaque, for sidecars that were baked so.
enum Parts : uint8_t { opaque_parts, all_parts };

struct Asset {
  library::FoundFile file;
  Reading readings[2];  // by Parts; the second only if a sidecar needed it
};

class Library {
 public:
  using Stop = std::function<bool()>;

  // Ingests every asset in a child process, one a thread; no more meshes are in memory at once than an asset has for
  // each thread.
  Library(std::vector<library::FoundFile> files, IngestOptions ingest, Stop stop);

  const std::vector<Asset>& assets() const { return assets_; }
  IngestOptions options(Parts parts) const;

  // Assets with a mesh of this geometry, in their order. The first question for all_parts ingests all of them anew. Any
  // thread.
  std::span<const size_t> with_geometry(const GeometryHash& geometry, Parts parts);

  // The asset that a sidecar names by where it lies, as X.vcd beside X or at the same place below its own folder.
  std::optional<size_t> named_by_path(const library::FoundFile& sidecar) const;
  std::vector<size_t> named(const std::filesystem::path& file_name) const;  // in any folder

 private:
  void read(Parts parts);

  std::vector<Asset> assets_;
  IngestOptions ingest_;
  Stop stop_;
  std::map<std::filesystem::path, std::vector<size_t>> by_place_, by_path_below_, by_name_;
  std::map<GeometryHash, std::vector<size_t>> by_geometry_[2];
  std::once_flag all_parts_read_;
};

}  // namespace vcd::verify
