#include "object_mesh.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <unordered_map>
#include <utility>

#include <vcd/format/hierarchy.h>
#include <vcd/format/horizon.h>

#include "common/describe.h"
#include "common/meshes.h"
#include "common/paths.h"

namespace vcd::tools {

using namespace baker;
namespace {

// The triangles of a hierarchy, leaf by leaf.
struct Leaves {
  SourceMesh mesh;
  std::unordered_map<uint32_t, size_t> first_triangle;  // by the unit where a leaf begins
};

template <uint32_t kVertices>
void append(const HierarchyLeaf<kVertices>& leaf, SourceMesh& mesh) {
  const auto base = static_cast<uint32_t>(mesh.positions.size());
  for (uint32_t v = 0; v < kVertices; ++v)
    mesh.positions.push_back({leaf.vertex[0][v], leaf.vertex[1][v], leaf.vertex[2][v]});
  for (uint32_t t = 0; t < kNodeWidth; ++t)
    if (leaf.present >> t & 1)
      mesh.triangles.push_back({base + leaf.corner[0][t] % kVertices, base + leaf.corner[1][t] % kVertices,
                                base + leaf.corner[2][t] % kVertices});
}

Leaves leaves_of(const HierarchyView& hierarchy) {
  Leaves leaves;
  std::vector<uint32_t> nodes = {kRootUnit};
  while (!nodes.empty()) {
    const HierarchyNode& node = hierarchy.node(nodes.back());
    nodes.pop_back();
    for (const uint32_t child : node.child) {
      if (child == kNoChild) continue;
      if (!(child & kLeafChild)) {
        nodes.push_back(child);
        continue;
      }
      leaves.first_triangle[child & kUnitMask] = leaves.mesh.triangles.size();
      with_leaf(hierarchy, child, [&](const auto& leaf) { append(leaf, leaves.mesh); });
    }
  }
  return leaves;
}

// Of the directions above a triangle, all alike.
float share_above(const HorizonHeader& header, const HorizonEntry& entry) {
  uint64_t codes;
  std::memcpy(&codes, entry.codes, sizeof codes);
  float sum = 0;
  for (uint32_t sector = 0; sector < kHorizonSectors; ++sector) {
    const float slope = header.slope[table_of(entry.place)][horizon_code(codes, sector)];
    if (std::isfinite(slope)) sum += 1 - slope / std::hypot(1.0f, slope);
  }
  return sum / kHorizonSectors;
}

std::vector<float> horizons_of(const HorizonView& view, const Leaves& leaves, const PreparedMesh& mesh) {
  if (!view) return {};
  std::vector<float> shares(mesh.triangles.size(), -1);
  for (uint32_t i = 0; i < view.header().entries; ++i) {
    const HorizonEntry& entry = view.entries()[i];
    const auto leaf = leaves.first_triangle.find(entry.place & kPlaceUnitMask);
    if (entry.place == 0 || leaf == leaves.first_triangle.end()) continue;
    const size_t number = leaf->second + triangle_of(entry.place);
    if (number >= mesh.source_triangles.size() || mesh.source_triangles[number] == kNone) continue;
    shares[mesh.source_triangles[number]] = share_above(view.header(), entry);
  }
  return shares;
}

Result<ObjectMesh> from_hierarchy(const ObjectContents& object) {
  Leaves leaves = leaves_of(object.hierarchy);
  auto mesh = prepare(std::move(leaves.mesh));
  if (!mesh) return mesh.error();
  ObjectMesh found{std::move(*mesh), "the triangles in the sidecar's hierarchy", {}};
  found.horizons = horizons_of(object.horizon, leaves, found.mesh);
  return found;
}

class MeshesOfFile {
 public:
  MeshesOfFile(const std::string& path, const IngestOptions& options) : path_(path), options_(options) {}

  Result<PreparedMesh> find(const ObjectRecord& record, const std::string& place) {
    if (path_.empty())
      return Error{ErrorCode::usage, place +
                                         ": the sidecar holds no triangles of it (no hierarchy): name its mesh file "
                                         "with --mesh, and its page with --page"};
    if (!is_read_) {
      auto loaded = load_meshes(path_, options_);
      if (!loaded) return loaded.error();
      meshes_ = std::move(loaded->meshes), is_read_ = true;
    }
    const auto found = std::ranges::find(meshes_, record.geometry_hash, &PreparedMesh::geometry_hash);
    if (found != meshes_.end()) return *found;
    return Error{ErrorCode::usage, shown(path_) + ": has no mesh of the geometry of " + place};
  }

 private:
  std::string path_;
  IngestOptions options_;
  bool is_read_ = false;
  std::vector<PreparedMesh> meshes_;
};

bool is_inside(const PreparedMesh& mesh, const ObjectRecord& record) {
  return std::ranges::all_of(mesh.positions, [&](const Position& p) {
    for (size_t a = 0; a < 3; ++a)
      if (!(p[a] >= record.box_min[a] && p[a] <= record.box_max[a])) return false;
    return true;
  });
}

}  // namespace

Result<std::vector<ObjectMesh>> meshes_of(const std::string& path, const SidecarContents& sidecar,
                                          const std::string& mesh_file, const IngestOptions& options) {
  MeshesOfFile file(mesh_file, ingest_options_of(sidecar, options));
  std::vector<ObjectMesh> meshes;
  for (const ObjectContents& object : sidecar.objects) {
    const ObjectRecord& record = *object.record;
    const std::string place =
        shown(path) + ": object " + std::to_string(record.source_index) + " " + printable(object.name);
    auto found = Result<ObjectMesh>(ObjectMesh{});
    if (object.hierarchy) {
      found = from_hierarchy(object);
    } else {
      auto mesh = object.geometry.empty() ? file.find(record, place) : embedded_mesh(path, object);
      if (!mesh) return mesh.error();
      found->mesh = std::move(*mesh);
      found->source = object.geometry.empty() ? "the mesh file" : "the geometry embedded in the sidecar";
    }
    if (!found) return Error{ErrorCode::invalid_file, place + ": hierarchy: " + found.error().message};
    if (found->mesh.geometry_hash != record.geometry_hash)
      return Error{ErrorCode::invalid_file, place + ": its triangles are not those of its geometry hash"};
    if (!is_inside(found->mesh, record))
      return Error{ErrorCode::invalid_file, place + ": its triangles are not inside its box"};
    std::ranges::copy(record.box_min, found->mesh.box_min.begin());
    std::ranges::copy(record.box_max, found->mesh.box_max.begin());
    meshes.push_back(std::move(*found));
  }
  return meshes;
}

}  // namespace vcd::tools
