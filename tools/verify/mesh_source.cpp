#include "mesh_source.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "common/describe.h"
#include "common/meshes.h"
#include "common/paths.h"

namespace vcd::verify {

using namespace baker;
using namespace tools;
namespace {

const PreparedMesh* matching(std::span<const PreparedMesh> meshes, const std::string& none,
                             const ObjectContents& object, const std::string& place, Outcome& outcome) {
  const auto found = std::ranges::find(meshes, object.record->geometry_hash, &PreparedMesh::geometry_hash);
  if (found != meshes.end()) return &*found;
  outcome.add(IssueId::stale, ErrorCode::stale, place,
              none + " has its geometry hash " + hex(object.record->geometry_hash));
  return nullptr;
}

class InMemory : public MeshSource {
 public:
  explicit InMemory(std::span<const PreparedMesh> meshes) : meshes_(meshes) {}

  const PreparedMesh* mesh_of(const ObjectContents& object, const std::string& place, Outcome& outcome) override {
    return matching(meshes_, "no mesh", object, place, outcome);
  }

 private:
  std::span<const PreparedMesh> meshes_;
};

class File : public MeshSource {
 public:
  File(const std::string& path, const IngestOptions& options) : path_(path), options_(options) {}

  const PreparedMesh* mesh_of(const ObjectContents& object, const std::string& place, Outcome& outcome) override {
    if (!meshes_) {
      meshes_ = load_meshes(path_, options_);
      // It may hold what came of the subdivision.
      if (options_.subdivide > 0 && !(*meshes_ && has(object))) {
        IngestOptions as_it_is = options_;
        as_it_is.subdivide = 0;
        auto other = std::exchange(meshes_, load_meshes(path_, as_it_is));
        if (!(*meshes_ && has(object))) meshes_ = std::move(other);
      }
      if (*meshes_)
        for (const std::string& note : (*meshes_)->notes) outcome.notes.push_back(shown(path_ + ": " + note));
      else outcome.add(IssueId::mesh_unreadable, meshes_->error().code, "", meshes_->error().message);
    }
    if (!*meshes_) return nullptr;
    return matching((*meshes_)->meshes, "no mesh of " + path_, object, place, outcome);
  }

 private:
  bool has(const ObjectContents& object) const {
    return std::ranges::count((*meshes_)->meshes, object.record->geometry_hash, &PreparedMesh::geometry_hash) > 0;
  }

  std::string path_;
  IngestOptions options_;
  std::optional<Result<LoadedMeshes>> meshes_;
};

}  // namespace

std::unique_ptr<MeshSource> against_file(const std::string& path, const IngestOptions& options) {
  return std::make_unique<File>(path, options);
}

std::unique_ptr<MeshSource> against_meshes(std::span<const PreparedMesh> meshes) {
  return std::make_unique<InMemory>(meshes);
}

}  // namespace vcd::verify
