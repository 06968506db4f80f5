#include "object/baked_object.h"

#include <algorithm>
#include <cassert>
#include <span>
#include <utility>

#include "classify/shaft.h"

namespace vcd::baker {

BakedObject::BakedObject(std::unique_ptr<Arrays> arrays) : arrays_(std::move(arrays)) {}
BakedObject::BakedObject() = default;
BakedObject::BakedObject(BakedObject&&) noexcept = default;
BakedObject& BakedObject::operator=(BakedObject&&) noexcept = default;
BakedObject::~BakedObject() = default;

TreeView BakedObject::tree() const {
  assert(arrays_ && "an object that was moved from has no tree");
  TreeView tree = arrays_->tree.view();
  if (!arrays_->clearances.empty()) tree.clearances = arrays_->clearances.data();
  return tree;
}

ObjectToWrite BakedObject::to_write() const {
  assert(arrays_ && "an object that was moved from cannot be written");
  return {name,
          record,
          tree_pieces(arrays_->tree.view()),
          arrays_->geometry,
          bytes_of(arrays_->hierarchy),
          std::as_bytes(std::span(arrays_->clearances)),
          {arrays_->horizons.data.get(), arrays_->horizons.size}};
}

void describe_source(const PreparedMesh& mesh, ObjectRecord& record) {
  record.source_index = mesh.source_index;
  const int others = record.flags & ~kPartsLeftOut;  // of the geometry, not of where it came from
  record.flags = static_cast<uint16_t>(others | (mesh.left_out.any() ? kPartsLeftOut : 0));
  std::copy(mesh.shift.begin(), mesh.shift.end(), record.shift);
}

namespace {

void describe_mesh(const PreparedMesh& mesh, ObjectRecord& record) {
  describe_source(mesh, record);
  std::copy(mesh.box_min.begin(), mesh.box_min.end(), record.box_min);
  std::copy(mesh.box_max.begin(), mesh.box_max.end(), record.box_max);
  record.geometry_hash = mesh.geometry_hash;
  record.triangle_count = mesh.triangles.size();
  record.vertex_count = mesh.positions.size();
}

void describe_classification(const Classification& how, ObjectRecord& record) {
  record.depth = static_cast<uint8_t>(how.depth);
  record.method = static_cast<uint8_t>(how.method);
  if (how.method == Method::none) return;
  if (how.method != Method::sampled) record.guard_band = kGuardBand;
  if (how.method != Method::proven) record.method_parameters[0] = how.samples;
  record.method_parameters[1] = static_cast<uint32_t>(how.seed);
  record.method_parameters[2] = static_cast<uint32_t>(how.seed >> 32);
}

void describe_tree(const TreeView& tree, const TreeStatistics& counts, ObjectRecord& record) {
  std::copy_n(counts.cells.begin(), 3, record.cells);
  record.statistical_cells = counts.cells[kStatisticallyBlocked];
  record.block_counts = tree.block_counts;
  record.brick_count = tree.brick_count;
  record.nodes_unfolded = counts.nodes_unfolded;
  record.nodes_folded = counts.nodes_folded;
  record.nodes_shared = counts.nodes_shared;
}

}  // namespace

BakedObject make_object(const PreparedMesh& mesh, const Classification& classification, const TreeStatistics& counts,
                        BakedObject::Arrays&& arrays) {
  BakedObject object(std::make_unique<BakedObject::Arrays>(std::move(arrays)));
  object.name = mesh.name;
  describe_mesh(mesh, object.record);
  describe_classification(classification, object.record);
  describe_tree(object.tree(), counts, object.record);
  return object;
}

BakedObject make_object_without_answers(const PreparedMesh& mesh, std::vector<std::byte>&& geometry,
                                        HierarchySection&& hierarchy, AlignedBytes&& horizons,
                                        std::optional<Plan> plan) {
  TreeArrays tree = unclassified_tree(1);
  const TreeStatistics counts = measure_tree(tree.view());
  BakedObject object =
      make_object(mesh, {Method::none, 1, 0, 0}, counts,
                  {std::move(tree), std::move(geometry), {}, std::move(hierarchy), std::move(horizons)});
  object.plan = std::move(plan);
  return object;
}

}  // namespace vcd::baker
