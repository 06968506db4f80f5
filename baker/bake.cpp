#include <vcd/baker/bake.h>

#include <chrono>
#include <new>
#include <utility>

#include <vcd/format/tree_statistics.h>

#include <vcd/baker/tracer.h>

#include "classify/proven.h"
#include "classify/sampled_cells.h"
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
  record.method = static_cast<uint8_t>(options.method);
  std::copy(mesh.box_min.begin(), mesh.box_min.end(), record.box_min);
  std::copy(mesh.box_max.begin(), mesh.box_max.end(), record.box_max);
  record.geometry_hash = mesh.geometry_hash;
  record.triangle_count = mesh.triangles.size();
  record.vertex_count = mesh.positions.size();
  if (options.method == Method::none) {
    record.depth = 1;
    return record;
  }
  if (options.method != Method::sampled) record.guard_band = kGuardBand;
  if (options.method != Method::proven) record.method_parameters[0] = options.samples;
  record.method_parameters[1] = static_cast<uint32_t>(options.seed);
  record.method_parameters[2] = static_cast<uint32_t>(options.seed >> 32);
  return record;
}

void count_tree(const TreeView& tree, ObjectRecord& record) {
  const TreeStatistics statistics = measure_tree(tree);
  std::copy_n(statistics.cells.begin(), 3, record.cells);
  record.statistical_cells = statistics.cells[kStatisticallyBlocked];
  record.block256_count = tree.block256_count;
  record.block16_count = tree.block16_count;
  record.brick_count = tree.brick_count;
  record.nodes_unfolded = statistics.nodes_unfolded;
  record.nodes_folded = statistics.nodes_folded;
  record.nodes_shared = statistics.nodes_shared;
}

std::unique_ptr<CellClassifier> make_classifier(const PreparedMesh& mesh, const Tracer& tracer, const BakeOptions& options) {
  if (options.method == Method::sampled)
    return std::make_unique<SampledCells>(SampledClassifier(tracer, options.samples, options.seed));
  return std::make_unique<ProvenClassifier>(
      mesh, tracer, ProvenOptions{options.seed, options.method == Method::hybrid ? options.samples : 0});
}

Octree blank_octree(uint32_t depth) {
  const TreeShape shape = tree_shape(depth);
  Subtree unclassified;
  unclassified.bricks.assign(size_t{1} << (4 * (shape.levels - 2 - shape.top_levels)), 2u);
  DagBuilder dag(depth);
  for (uint32_t slot = 0; slot < shape.top_words(); ++slot) dag.append(unclassified);
  return {dag.take(), 0};
}

// What is wrong with options; null if nothing is.
const char* fault_of(const BakeOptions& options) {
  if (options.depth < kMinDepth || options.depth > kMaxDepth) return "depth must be 1 to 8";
  const bool known = options.samples == 16 || options.samples == 81 || options.samples == 256;
  if (options.method == Method::sampled && !known) return "samples must be 16, 81 or 256";
  if (options.method == Method::hybrid && (!known || options.samples == 16)) return "samples of a hybrid bake must be 81 or 256";
  return nullptr;
}

}  // namespace

Result<BakedObject> bake(const PreparedMesh& mesh, const BakeOptions& options) try {
  if (const char* fault = fault_of(options)) return Error{ErrorCode::usage, fault};
  const std::string place = "mesh " + std::to_string(mesh.source_index) + " \"" + mesh.name + "\"";

  BakedObject object;
  object.name = mesh.name;
  object.record = describe_object(mesh, options);
  if (options.embed_geometry) {
    object.arrays_->geometry = encode_geometry(mesh);
    if (object.arrays_->geometry.empty())
      return Error{ErrorCode::runtime, place + ": its geometry cannot be encoded to be embedded"};
  }

  if (options.method == Method::none) {
    object.arrays_->tree = blank_octree(1).tree;
    count_tree(object.tree(), object.record);
    return object;
  }

  const auto tracer = Tracer::build(positions_in_grid(mesh), mesh.triangles);
  if (!tracer) return Error{tracer.error().code, place + ": " + tracer.error().message};
  const auto classifier = make_classifier(mesh, *tracer, options);

  const auto start = std::chrono::steady_clock::now();
  const auto seconds = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(); };
  const auto on_progress = [&](uint64_t done, uint64_t total, uint64_t rays) {
    const double fraction = static_cast<double>(done) / static_cast<double>(total);
    if (options.progress) options.progress({fraction, rays, seconds()});
  };
  auto octree = options.blank ? blank_octree(options.depth)
                              : build_octree({*classifier, options.depth, options.one_in, options.stop}, options.threads, on_progress);
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
