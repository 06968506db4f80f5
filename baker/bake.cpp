#include <vcd/baker/bake.h>

#include <chrono>
#include <new>
#include <utility>

#include <vcd/format/tree_statistics.h>

#include <vcd/baker/sampled.h>
#include <vcd/baker/tracer.h>

#include "classify/proven.h"
#include "octree/octree.h"

namespace vcd {

struct BakedObject::Arrays {
  TreeArrays tree;
  std::vector<std::byte> geometry;
};

BakedObject::BakedObject() : arrays_(std::make_unique<Arrays>()) {}
BakedObject::BakedObject(BakedObject&&) noexcept = default;
BakedObject& BakedObject::operator=(BakedObject&&) noexcept = default;
BakedObject::~BakedObject() = default;

TreeView BakedObject::tree() const { return arrays_->tree.view(); }

ObjectToWrite BakedObject::to_write() const {
  return {name, record, tree_pieces(arrays_->tree.view()), arrays_->geometry};
}

namespace {

ObjectRecord describe_object(const PreparedMesh& mesh, const BakeOptions& options) {
  ObjectRecord record{};
  record.source_index = mesh.source_index;
  record.depth = static_cast<uint8_t>(options.depth);
  record.method = static_cast<uint8_t>(Method::sampled);
  std::copy(mesh.box_min.begin(), mesh.box_min.end(), record.box_min);
  std::copy(mesh.box_max.begin(), mesh.box_max.end(), record.box_max);
  record.geometry_hash = mesh.geometry_hash;
  record.triangle_count = mesh.triangles.size();
  record.vertex_count = mesh.positions.size();
  record.method_parameters[0] = options.samples;
  record.method_parameters[1] = static_cast<uint32_t>(options.seed);
  record.method_parameters[2] = static_cast<uint32_t>(options.seed >> 32);
  return record;
}

void count_tree(const TreeView& tree, ObjectRecord& record) {
  const TreeStatistics statistics = measure_tree(tree);
  std::copy(statistics.cells.begin(), statistics.cells.end(), record.cells);
  record.block256_count = tree.block256_count;
  record.block16_count = tree.block16_count;
  record.brick_count = tree.brick_count;
  record.nodes_unfolded = statistics.nodes_unfolded;
  record.nodes_folded = statistics.nodes_folded;
  record.nodes_shared = statistics.nodes_shared;
}

// The paper's method as the recursion asks.
class SampledCells : public CellClassifier {
 public:
  SampledCells(const Tracer& tracer, const BakeOptions& options)
      : depth_(options.depth), classifier_(tracer, options.samples, options.seed) {}
  uint32_t classify(const Cell& cell, Workspace& workspace) const override {
    const CellVerdict verdict = classifier_.classify(cell, workspace.rays);
    if (verdict != CellVerdict::mixed) return static_cast<uint32_t>(verdict);
    return cell.level < depth_ ? kDeeper : kUnclassified;
  }

 private:
  uint32_t depth_;
  SampledClassifier classifier_;
};

Octree blank_octree(uint32_t depth) {
  const TreeShape shape = tree_shape(depth);
  Subtree unclassified;
  unclassified.bricks.assign(size_t{1} << (4 * (shape.levels - 2 - shape.top_levels)), 2u);
  DagBuilder dag(depth);
  for (uint32_t slot = 0; slot < shape.top_words(); ++slot) dag.append(unclassified);
  return {dag.take(), 0};
}

bool valid(const BakeOptions& o) {
  return o.depth >= kMinDepth && o.depth <= kMaxDepth && (o.samples == 16 || o.samples == 81 || o.samples == 256);
}

}  // namespace

Result<BakedObject> bake(SourceMesh&& source, const BakeOptions& options) try {
  if (!valid(options)) return Error{ErrorCode::usage, "depth must be 1 to 8, samples 16, 81 or 256"};
  const std::string place = "mesh " + std::to_string(source.source_index) + " \"" + source.name + "\"";

  auto mesh = prepare(std::move(source));
  if (!mesh) return mesh.error();

  BakedObject object;
  object.name = mesh->name;
  object.record = describe_object(*mesh, options);
  object.duplicate_triangles = mesh->duplicate_triangles;
  object.zero_area_triangles = mesh->zero_area_triangles;
  if (options.embed_geometry) {
    object.arrays_->geometry = encode_geometry(*mesh);
    if (object.arrays_->geometry.empty())
      return Error{ErrorCode::runtime, place + ": its geometry cannot be encoded to be embedded"};
  }

  auto tracer = Tracer::build(positions_in_grid(*mesh), mesh->triangles);
  if (!tracer) return Error{tracer.error().code, place + ": " + tracer.error().message};

  std::unique_ptr<CellClassifier> classifier;
  if (getenv("VCD_PROVEN")) {
    const uint32_t tier = atoi(getenv("VCD_PROVEN"));
    classifier = std::make_unique<ProvenClassifier>(*mesh, *tracer, ProvenOptions{options.depth, options.seed, tier});
  }
  else classifier = std::make_unique<SampledCells>(*tracer, options);
  *mesh = {};
  const auto start = std::chrono::steady_clock::now();
  const auto seconds = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
  const auto on_progress = [&](uint64_t done, uint64_t total, uint64_t rays) {
    const double fraction = static_cast<double>(done) / static_cast<double>(total);
    if (options.progress) options.progress({fraction, rays, seconds()});
  };
  auto octree = options.blank ? blank_octree(options.depth)
                              : build_octree({*classifier, options.depth, options.stop}, options.threads, on_progress);
  if (!octree) return Error{ErrorCode::runtime, place + ": stopped"};

  object.arrays_->tree = std::move(octree->tree);
  object.rays = octree->rays;
  object.seconds = seconds();
  count_tree(object.tree(), object.record);
  return object;
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::runtime, "out of memory"};
}

}  // namespace vcd
