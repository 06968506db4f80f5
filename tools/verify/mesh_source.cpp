#include "mesh_source.h"

#include <algorithm>
#include <optional>

#include "common/meshes.h"

namespace vcd::verify {
using namespace baker;
namespace {

class File : public MeshSource {
 public:
  File(const std::string& path, const IngestOptions& options) : path_(path), options_(options) {}

  const PreparedMesh* mesh_of(const ObjectContents& object, const std::string& place, Outcome& outcome) override {
    if (!meshes_) {
      meshes_ = load_meshes(path_, options_);
      if (!*meshes_) outcome.add(IssueId::mesh_unreadable, meshes_->error().code, "", meshes_->error().message);
    }
    if (!*meshes_) return nullptr;
    const auto found = std::ranges::find(**meshes_, object.record->geometry_hash, &PreparedMesh::geometry_hash);
    if (found != (*meshes_)->end()) return &*found;
    outcome.add(IssueId::stale, ErrorCode::stale, place,
                "no mesh of " + path_ + " has its geometry hash " + hex(object.record->geometry_hash));
    return nullptr;
  }

 private:
  std::string path_;
  IngestOptions options_;
  std::optional<Result<std::vector<PreparedMesh>>> meshes_;
};

}  // namespace

std::unique_ptr<MeshSource> against_file(const std::string& path, const IngestOptions& options) {
  return std::make_unique<File>(path, options);
}

}  // namespace vcd::verify
