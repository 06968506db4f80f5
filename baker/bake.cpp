#include <vcd/baker/bake.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <new>
#include <optional>
#include <utility>

#include <tbb/info.h>

#include <vcd/format/tree_statistics.h>

#include <vcd/baker/tracer.h>

#include "classify/proven.h"
#include "classify/sampled_cells.h"
#include "octree/demote.h"
#include "octree/octree.h"
#include "plan/probe.h"
#include "prepare/margins.h"

namespace vcd {

struct BakedObject::Arrays {
  TreeArrays tree;
  std::vector<std::byte> geometry;
  std::vector<uint8_t> margins;  // of an object in which something is blocked
};

BakedObject::BakedObject() : arrays_(std::make_unique<Arrays>()) {}
BakedObject::BakedObject(BakedObject&&) noexcept = default;
BakedObject& BakedObject::operator=(BakedObject&&) noexcept = default;
BakedObject::~BakedObject() = default;

TreeView BakedObject::tree() const {
  TreeView tree = arrays_->tree.view();
  if (!arrays_->margins.empty()) tree.clearances = arrays_->margins.data();
  return tree;
}

ObjectToWrite BakedObject::to_write() const {
  return {name, record, tree_pieces(arrays_->tree.view()), arrays_->geometry,
          std::as_bytes(std::span(arrays_->margins))};
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

std::string place_of(const PreparedMesh& mesh) {
  return "mesh " + std::to_string(mesh.source_index) + " \"" + mesh.name + "\"";
}

uint64_t tree_bytes(const TreeView& tree) {
  return tree.shape.bytes(tree.block256_count, tree.block16_count, tree.brick_count);
}

// Of a tree in which everything is uniform.
uint64_t least_bytes(uint32_t depth) {
  const TreeShape shape = tree_shape(depth);
  return shape.bytes(shape.has_blocks256 ? kUniformBlocks : 0, shape.has_blocks16 ? kUniformBlocks : 0, kUniformBlocks);
}

// What a file of so many bytes leaves for its tree: header, tables, names and the tree's page come before it.
uint64_t tree_budget(uint64_t file_bytes) { return file_bytes - std::min<uint64_t>(file_bytes, 8192); }

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

Octree blank_octree(uint32_t depth) {
  const TreeShape shape = tree_shape(depth);
  Subtree unclassified;
  unclassified.bricks.assign(size_t{1} << (4 * (shape.levels - 2 - shape.top_levels)), 2u);
  DagBuilder dag(depth);
  for (uint32_t slot = 0; slot < shape.top_words(); ++slot) dag.append(unclassified);
  return {dag.take()};
}

constexpr uint32_t kDefaultSamples = 256;

// What is wrong with options; null if nothing is.
const char* fault_of(const BakeOptions& options) {
  if (options.depth > kMaxDepth) return "depth must be 1 to 8, or 0 for automatic";
  if (options.depth == 0 && options.blank) return "a blank tree needs a depth";
  const bool known = options.samples == 16 || options.samples == 81 || options.samples == 256;
  if (options.samples == 0) return nullptr;
  if (options.method == Method::sampled && !known) return "samples must be 16, 81 or 256";
  if (options.method == Method::hybrid && (!known || options.samples == 16))
    return "samples of a hybrid bake must be 81 or 256";
  return nullptr;
}

using Clock = std::chrono::steady_clock;

// Tracer and classifier of one mesh, from which all else follows.
struct Workshop {
  std::unique_ptr<const Tracer> tracer;  // stays where it is: the classifier refers to it
  std::unique_ptr<CellClassifier> classifier;
  uint32_t samples;  // that a class by statistics rests on

  static Result<Workshop> build(const PreparedMesh& mesh, const BakeOptions& options) {
    auto tracer = Tracer::build(positions_in_grid(mesh), mesh.triangles);
    if (!tracer) return Error{tracer.error().code, place_of(mesh) + ": " + tracer.error().message};
    Workshop shop{std::make_unique<const Tracer>(std::move(*tracer)), nullptr,
                  options.samples ? options.samples : kDefaultSamples};
    if (options.method == Method::sampled) {
      shop.classifier = std::make_unique<SampledCells>(SampledClassifier(*shop.tracer, shop.samples, options.seed));
    } else {
      const ProvenOptions proven{options.seed, options.method == Method::hybrid, options.samples};
      auto classifier = std::make_unique<ProvenClassifier>(mesh, *shop.tracer, proven);
      shop.samples = classifier->samples();
      shop.classifier = std::move(classifier);
    }
    return shop;
  }
};

// What of the budget of seconds is left for the probe and the bake at `start`; the rest is for audit and writing.
constexpr double kBakeShare = 0.75, kForecastShare = 0.6;

Plan plan_with(const PreparedMesh& mesh, const Workshop& shop, const BakeOptions& options, double seconds_left) {
  ProbeOptions probe_options;
  probe_options.threads = options.threads ? options.threads : static_cast<unsigned>(tbb::info::default_concurrency());
  probe_options.budget_bytes = tree_budget(options.budget_bytes ? options.budget_bytes : kDefaultBudgetBytes);
  probe_options.budget_seconds =
      options.budget_seconds > 0 ? kForecastShare * seconds_left : std::numeric_limits<double>::infinity();
  probe_options.stop = options.stop;
  return probe(mesh, *shop.tracer, *shop.classifier, probe_options);
}

}  // namespace

Result<Plan> plan(const PreparedMesh& mesh, const BakeOptions& options) try {
  if (const char* fault = fault_of(options)) return Error{ErrorCode::usage, fault};
  const auto start = Clock::now();
  const auto shop = Workshop::build(mesh, options);
  if (!shop) return shop.error();
  return plan_with(mesh, *shop, options,
                   kBakeShare * options.budget_seconds - std::chrono::duration<double>(Clock::now() - start).count());
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::runtime, "out of memory"};
}

Result<BakedObject> bake(const PreparedMesh& mesh, const BakeOptions& given) try {
  if (const char* fault = fault_of(given)) return Error{ErrorCode::usage, fault};
  const auto start = Clock::now();
  const auto seconds = [&] { return std::chrono::duration<double>(Clock::now() - start).count(); };
  const double time_limit = kBakeShare * given.budget_seconds;

  BakedObject object;
  object.name = mesh.name;
  BakeOptions options = given;
  if (options.blank && options.samples == 0) options.samples = kDefaultSamples;
  std::optional<Workshop> shop;
  if (options.method != Method::none && !options.blank) {
    auto built = Workshop::build(mesh, options);
    if (!built) return built.error();
    shop.emplace(std::move(*built));
    options.samples = shop->samples;
    if (options.depth == 0) object.plan = plan_with(mesh, *shop, options, time_limit - seconds());
    if (object.plan && object.plan->depth == 0) options.method = Method::none;
    if (object.plan) options.depth = object.plan->depth;
  }
  object.record = describe_object(mesh, options);
  if (options.embed_geometry) {
    object.arrays_->geometry = encode_geometry(mesh);
    if (object.arrays_->geometry.empty())
      return Error{ErrorCode::runtime, place_of(mesh) + ": its geometry cannot be encoded to be embedded"};
  }
  if (options.method == Method::none || options.blank) {
    object.arrays_->tree = blank_octree(object.record.depth).tree;
    count_tree(object.tree(), object.record);
    return object;
  }

  if (const uint64_t least = least_bytes(options.depth);
      options.budget_bytes > 0 && least > tree_budget(options.budget_bytes))
    return Error{ErrorCode::usage, place_of(mesh) + ": a sidecar of depth " + std::to_string(options.depth) +
                                       " takes " + std::to_string(least + 8192) +
                                       " bytes at the least, more than the budget"};

  const auto bake_start = Clock::now();
  const auto baking = [&] { return std::chrono::duration<double>(Clock::now() - bake_start).count(); };
  const auto on_progress = [&](uint64_t done, uint64_t total, uint64_t rays) {
    const double fraction = static_cast<double>(done) / static_cast<double>(total);
    if (options.progress) options.progress({fraction, rays, baking()});
  };
  CellSource source{*shop->classifier, options.depth};
  source.one_in = options.one_in;
  source.stop = options.stop;
  if (options.budget_seconds > 0)
    source.deadline = start + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(time_limit));
  auto octree = build_octree(source, options.threads, on_progress);
  if (!octree) return Error{ErrorCode::runtime, place_of(mesh) + ": stopped"};
  object.rays = octree->rays;
  object.seconds_above = octree->seconds_above;
  object.out_of_time = Clock::now() > source.deadline;
  object.bytes_before_demotion = tree_bytes(octree->tree.view());
  if (options.budget_bytes > 0)
    octree->tree = demote_merge(std::move(octree->tree), tree_budget(options.budget_bytes), options.threads,
                                &object.cells_demoted);
  object.arrays_->tree = std::move(octree->tree);
  count_tree(object.tree(), object.record);
  if (object.record.cells[1] + object.record.statistical_cells > 0) {
    const auto margins = margins_of(mesh);
    object.arrays_->margins = std::vector<uint8_t>(margins.begin(), margins.end());
  }
  object.seconds = baking();
  return object;
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::runtime, "out of memory"};
}

}  // namespace vcd
