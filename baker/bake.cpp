#include <vcd/baker/bake.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <new>
#include <optional>
#include <utility>

#include <tbb/info.h>

#include <vcd/baker/audit_horizons.h>
#include <vcd/baker/hierarchy.h>
#include <vcd/baker/horizon.h>
#include <vcd/baker/threads.h>
#include <vcd/format/tree_statistics.h>

#include "audit/audit_object.h"
#include "classify/make_classifier.h"
#include "demand/divide_for.h"
#include "demand/kept_out.h"
#include "demand/known_cells.h"
#include "hierarchy/look_up_worth.h"
#include "object/baked_object.h"
#include "octree/demote.h"
#include "octree/octree.h"
#include "plan/blocked_proofs.h"
#include "plan/probe.h"
#include "prepare/clearances.h"
#include "prepare/place.h"
#include "seconds_since.h"

namespace vcd::baker {
namespace {

using Clock = std::chrono::steady_clock;

// What of the budget of seconds is for everything up to the last class; the rest is for audit and writing.
constexpr double kBakeShare = 0.75;
// What of the time up to there is for the cells that a demand asks for; the rest is to make the tree of them.
constexpr double kDivideShare = 0.85;
// What a forecast may take of the seconds that are left when the depth is picked.
constexpr double kForecastShare = 0.6;

// When the last class must be there. Starts when it is made.
class Deadline {
 public:
  explicit Deadline(double budget_seconds) {
    if (budget_seconds > 0)
      end_ = Clock::now() +
             std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(kBakeShare * budget_seconds));
  }
  Clock::time_point end() const { return end_; }
  Clock::time_point after(double share) const {  // of what is left
    if (end_ == end_.max()) return end_;
    return Clock::now() + std::chrono::duration_cast<Clock::duration>(share * (end_ - Clock::now()));
  }
  bool over() const { return Clock::now() > end_; }
  double seconds_left() const {
    return end_ == end_.max() ? std::numeric_limits<double>::infinity() : -seconds_since(end_);
  }

 private:
  Clock::time_point end_ = Clock::time_point::max();
};

std::optional<Error> check_options(const BakeOptions& options) {
  const auto usage = [](const char* reason) { return Error{ErrorCode::usage, reason}; };
  if (options.depth > kMaxDepth) return usage("depth must be 1 to 8, or 0 for automatic");
  if (options.demand && options.depth == 1) return usage("depth of a bake for a demand must be 2 to 8");
  if (options.demand && options.method == Method::none) return usage("method none answers no demand");
  if (options.depth_elsewhere > kMaxDepth) return usage("depth elsewhere must be 1 to 8, or 0 for none");
  if (options.depth_elsewhere > 0 && !options.demand) return usage("depth elsewhere needs a demand");
  if (options.depth > 0 && options.depth_elsewhere > options.depth)
    return usage("depth elsewhere is more than the depth");
  const bool known = options.samples == 16 || options.samples == 81 || options.samples == 256;
  if (options.samples == 0) return std::nullopt;
  if (options.method == Method::sampled && !known) return usage("samples must be 16, 81 or 256");
  if (options.method == Method::hybrid && (!known || options.samples == 16))
    return usage("samples of a hybrid bake must be 81 or 256");
  return std::nullopt;
}

Result<std::vector<std::byte>> embedded_geometry(const PreparedMesh& mesh, const BakeOptions& options) {
  if (!options.embed_geometry) return std::vector<std::byte>();
  auto geometry = encode_geometry(mesh);
  if (geometry.empty())
    return Error{ErrorCode::runtime, place_of(mesh) + ": its geometry cannot be encoded to be embedded"};
  return geometry;
}

void begin(BakePass pass, const BakeOptions& options) {
  if (options.on_pass) options.on_pass(pass);
}

struct Hierarchy {
  HierarchySection section;
  std::string why_not;  // BakedObject::without_hierarchy

  uint64_t bytes() const { return section.size() * kUnitBytes; }
};

Result<Hierarchy> hierarchy_if_asked(const PreparedMesh& mesh, const BakeOptions& options) {
  if (!options.hierarchy) return Hierarchy{};
  if (!can_have_hierarchy(mesh)) return Hierarchy{{}, "its coordinates are too large or too small for one"};
  begin(BakePass::hierarchy, options);
  auto section = with_threads(options.threads, [&] { return build_hierarchy(mesh, options.stop); });
  if (!section) return Error{ErrorCode::runtime, place_of(mesh) + ": stopped"};
  Hierarchy hierarchy{std::move(*section), {}};
  if (hierarchy.section.empty()) return Hierarchy{{}, "it has too many triangles for one"};
  if (options.budget_bytes > 0 && hierarchy.bytes() > options.budget_bytes / 2)
    return Hierarchy{{}, "its " + std::to_string(hierarchy.bytes()) + " bytes are more than half of the budget"};
  return hierarchy;
}

struct AskedHorizons {
  AlignedBytes section;
  std::optional<HorizonShare> share;
  std::string why_not;  // BakedObject::without_horizons
};

Result<AskedHorizons> horizons_if_asked(const PreparedMesh& mesh, const HierarchySection& hierarchy,
                                        const BakeOptions& options) {
  if (!options.horizons) return AskedHorizons{};
  if (hierarchy.empty()) return AskedHorizons{{}, {}, "it has no hierarchy"};
  if (!can_have_horizons(view_of(hierarchy))) return AskedHorizons{{}, {}, "its hierarchy is too large for them"};
  begin(BakePass::horizons, options);
  auto built = with_threads(options.threads, [&] { return build_horizons(mesh, view_of(hierarchy), options.stop); });
  if (!built) return Error{ErrorCode::runtime, place_of(mesh) + ": stopped"};
  AskedHorizons horizons{std::move(built->section), built->share, {}};
  if (!horizons.section.data) horizons.why_not = "they would answer too few of the rays that start on it";
  else if (options.budget_bytes > 0 && horizons.section.size > options.budget_bytes / 4)
    horizons.section = {}, horizons.why_not = "they would take more than a quarter of the budget";
  return horizons;
}

uint64_t tree_budget(uint64_t file_bytes) { return file_bytes - std::min(file_bytes, kBytesBesideTree); }

// The options of the passes behind these: what they take is not theirs.
BakeOptions without_bytes(BakeOptions options, uint64_t bytes) {
  if (options.budget_bytes > 0) options.budget_bytes -= bytes;
  return options;
}

// An error if not even a tree in which everything is uniform fits what the hierarchy leaves of the budget.
std::optional<Error> check_budget(const PreparedMesh& mesh, uint32_t depth, uint64_t budget_bytes,
                                  const Hierarchy& hierarchy) {
  const uint64_t least = tree_shape(depth).least_bytes();
  if (budget_bytes == 0 || least <= tree_budget(budget_bytes)) return std::nullopt;
  return Error{ErrorCode::usage, place_of(mesh) + ": a sidecar of depth " + std::to_string(depth) + " takes " +
                                     std::to_string(least + kBytesBesideTree + hierarchy.bytes()) +
                                     " bytes at the least, more than the budget"};
}

Plan forecast(const GridMesh& grid, const Tracer& tracer, const CellClassifier& classifier, const BakeOptions& options,
              const Deadline& deadline) {
  ProbeOptions probe_options;
  probe_options.threads = options.threads ? options.threads : static_cast<unsigned>(tbb::info::default_concurrency());
  probe_options.budget_bytes = tree_budget(options.budget_bytes ? options.budget_bytes : kDefaultBudgetBytes);
  probe_options.budget_seconds = kForecastShare * deadline.seconds_left();
  probe_options.stop = options.stop;
  return probe(grid.source, tracer, classifier, probe_options);
}

// The pass `plan`, where the depth is left to it. A demand divides as deep as it pays by itself.
std::optional<Plan> plan_if_asked(const GridMesh& grid, const Tracer& tracer, const CellClassifier& classifier,
                                  const BakeOptions& options, const Deadline& deadline) {
  if (options.depth > 0 || options.demand) return std::nullopt;
  begin(BakePass::plan, options);
  return forecast(grid, tracer, classifier, options, deadline);
}

struct ClassifiedCells {
  Octree octree;
  bool out_of_time;
  uint64_t classified = 0;  // for a demand: cells that were not known
  std::vector<WorthOfBytes> worth = {};
};

Result<ClassifiedCells> classify_cells(const GridMesh& grid, const CellClassifier& classifier, uint32_t depth,
                                       const BakeOptions& options, const Deadline& deadline) {
  begin(BakePass::classify, options);
  const auto start = Clock::now();
  const auto on_progress = [&](uint64_t done, uint64_t total, uint64_t rays) {
    const double fraction = static_cast<double>(done) / static_cast<double>(total);
    if (options.progress) options.progress({fraction, rays, seconds_since(start)});
  };
  auto octree = build_octree({classifier, depth, deadline.end(), options.stop}, options.threads, on_progress);
  if (!octree) return Error{ErrorCode::runtime, place_of(grid.source) + ": stopped"};
  return ClassifiedCells{std::move(*octree), deadline.over(), 0};
}

// The same for what a demand asks: first the cells that are worth it are divided and all classified, then the octree
// takes them as they are.
Result<ClassifiedCells> classify_asked(std::span<const AskedSegment> asked, const GridMesh& grid, const Tracer& tracer,
                                       const KnownCells& classifier, const std::vector<uint8_t>& clearances,
                                       uint32_t depth, const BakeOptions& options, const Deadline& deadline) {
  begin(BakePass::divide, options);
  auto divided = divide_for(asked, grid, tracer, classifier, clearances.data(), depth,
                            tree_budget(options.budget_bytes), deadline.after(kDivideShare), options);
  if (!divided) return divided.error();
  const CellsAsDivided cells(divided->cells);
  auto classified = classify_cells(grid, cells, divided->depth, options, Deadline(0));
  if (!classified) return classified;
  classified->octree.rays += divided->rays;
  classified->classified = divided->classified;
  classified->worth = std::move(divided->worth);
  classified->out_of_time = divided->out_of_time || deadline.over();
  return classified;
}

Demoted demote_to_budget(TreeArrays&& tree, const BakeOptions& options) {
  if (options.budget_bytes == 0) return {std::move(tree)};
  begin(BakePass::demote, options);
  return demote_merge(std::move(tree), tree_budget(options.budget_bytes), options.threads);
}

// Only blocked cells need them. known: those of the mesh, where a demand needed them before, or none.
std::vector<uint8_t> clearances_if_blocked(const GridMesh& grid, const TreeStatistics& counts,
                                           std::vector<uint8_t>&& known, const BakeOptions& options) {
  if (counts.cells[kBlocked] + counts.cells[kStatisticallyBlocked] == 0) return {};
  if (!known.empty()) return std::move(known);
  begin(BakePass::clearances, options);
  return clearances_of(grid);
}

// Audits the object, and writes the result into it.
std::optional<Error> audit_if_asked(const PreparedMesh& mesh, BakedObject& object, const BakeOptions& options) {
  if (options.audit_lines == 0) return std::nullopt;
  begin(BakePass::audit, options);
  AuditOptions audit_options;
  audit_options.lines = options.audit_lines, audit_options.stop = options.stop;
  auto report =
      with_threads(options.threads, [&] { return audit_object(mesh, object.record, object.tree(), audit_options); });
  if (!report) return report.error();
  record_audit(*report, object.record);
  object.audit = std::move(*report);
  return std::nullopt;
}

// Holds horizons against exact arithmetic.
std::optional<Error> audit_horizons_if_asked(const PreparedMesh& mesh, const ObjectToWrite& object,
                                             const BakeOptions& options) {
  if (options.audit_lines == 0 || object.horizon.empty()) return std::nullopt;
  begin(BakePass::audit, options);
  const HorizonAudit audit = with_threads(options.threads, [&] {
    return audit_horizons(mesh, {object.hierarchy.data()}, {object.horizon.data()}, options.audit_lines / 4,
                          options.stop);
  });
  if (audit.stopped) return Error{ErrorCode::runtime, place_of(mesh) + ": stopped"};
  if (audit.wrong == 0) return std::nullopt;
  return Error{ErrorCode::difference, place_of(mesh) + ": " + std::to_string(audit.wrong) + " of " +
                                          std::to_string(audit.clear) +
                                          " answers of its horizons are wrong: a fault of vcd"};
}

std::optional<Error> judge_if_asked(const PreparedMesh& mesh, BakedObject& object, std::span<const AskedSegment> asked,
                                    const BakeOptions& options) {
  if (!options.demand) return std::nullopt;
  begin(BakePass::audit, options);
  auto report = with_threads(options.threads,
                             [&] { return judge_demand(mesh, object.record, object.tree(), asked, options.stop); });
  if (!report) return report.error();
  object.demand = *report;
  return std::nullopt;
}

}  // namespace

const char* name_of(BakePass pass) {
  constexpr const char* kNames[] = {"hierarchy", "horizons", "trace",      "plan", "divide",
                                    "classify",  "demote",   "clearances", "audit"};
  return kNames[static_cast<size_t>(pass)];
}

Result<Plan> plan(const PreparedMesh& mesh, const BakeOptions& all_options) try {
  const Deadline deadline(all_options.budget_seconds);
  if (all_options.method == Method::none) return Error{ErrorCode::usage, "method none has nothing to plan"};
  if (auto fault = check_options(all_options)) return std::move(*fault);
  BakeOptions options = all_options;
  std::optional<HorizonForecast> horizons;
  if (options.budget_bytes > 0 || options.horizons) {
    const auto hierarchy = hierarchy_if_asked(mesh, options);
    if (!hierarchy) return hierarchy.error();
    options = without_bytes(options, hierarchy->bytes());
    if (options.horizons && can_have_horizons(view_of(hierarchy->section))) {
      horizons = with_threads(options.threads,
                              [&] { return forecast_horizons(mesh, view_of(hierarchy->section), options.stop); });
      if (!horizons) return Error{ErrorCode::runtime, place_of(mesh) + ": stopped"};
    }
  }
  const GridMesh grid(mesh);
  const auto tracer = trace_in_grid(grid);
  if (!tracer) return tracer.error();
  const ChosenClassifier classifier = make_classifier(grid, *tracer, options);
  Plan plan = forecast(grid, *tracer, *classifier.cells, options, deadline);
  plan.horizons = horizons;
  plan.health = mesh_health(mesh.positions.size(), mesh.triangles);
  if (classifier.proofs)
    plan.proofs = count_blocked_proofs(*classifier.proofs, mesh, plan.health, plan.depth ? plan.depth : 5);
  return plan;
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::runtime, "out of memory"};
}

Result<BakedObject> bake(const PreparedMesh& mesh, const BakeOptions& all_options) try {
  const Deadline deadline(all_options.budget_seconds);
  if (auto fault = check_options(all_options)) return std::move(*fault);
  std::span<const AskedSegment> asked;
  if (all_options.demand) {
    const auto found = asked_of(mesh, *all_options.demand);
    if (!found) return found.error();
    asked = *found;
  }
  auto geometry = embedded_geometry(mesh, all_options);
  if (!geometry) return geometry.error();
  auto hierarchy = hierarchy_if_asked(mesh, all_options);
  if (!hierarchy) return hierarchy.error();
  auto horizons = horizons_if_asked(mesh, hierarchy->section, all_options);
  if (!horizons) return horizons.error();
  const auto tell_what_is_missing = [&](BakedObject& object) {
    object.without_hierarchy = std::move(hierarchy->why_not);
    object.without_horizons = std::move(horizons->why_not), object.horizon_share = horizons->share;
  };
  const auto without_answers = [&](std::optional<Plan> plan) {
    BakedObject object = make_object_without_answers(mesh, std::move(*geometry), std::move(hierarchy->section),
                                                     std::move(horizons->section), std::move(plan));
    tell_what_is_missing(object);
    return object;
  };
  const auto audited = [&](BakedObject&& object) -> Result<BakedObject> {
    if (auto wrong = audit_horizons_if_asked(mesh, object.to_write(), all_options)) return std::move(*wrong);
    return std::move(object);
  };
  if (all_options.method == Method::none) return audited(without_answers({}));
  BakeOptions options = without_bytes(all_options, hierarchy->bytes() + horizons->section.size);
  if (options.demand && options.budget_bytes == 0) options.budget_bytes = kDemandBudgetBytes;

  begin(BakePass::trace, options);
  const GridMesh grid(mesh);
  const auto tracer = trace_in_grid(grid);
  if (!tracer) return tracer.error();
  const ChosenClassifier classifier = make_classifier(grid, *tracer, options);

  auto plan = plan_if_asked(grid, *tracer, *classifier.cells, options, deadline);
  uint32_t depth = plan ? plan->depth : options.depth;
  if (depth == 0 && !options.demand) return audited(without_answers(std::move(plan)));
  if (auto too_small = check_budget(mesh, std::max(depth, kMinDepth), options.budget_bytes, *hierarchy))
    return std::move(*too_small);

  const auto start = Clock::now();
  std::vector<uint8_t> clearances;
  if (options.demand) begin(BakePass::clearances, options), clearances = clearances_of(grid);
  const KnownCells cells(*classifier.cells, usable_cells(options.known, options, classifier.samples));
  auto classified = options.demand ? classify_asked(asked, grid, *tracer, cells, clearances, depth, options, deadline)
                                   : classify_cells(grid, *classifier.cells, depth, options, deadline);
  if (!classified) return classified.error();
  depth = classified->octree.tree.depth;
  const uint64_t bytes = classified->octree.tree.view().bytes();
  Demoted demoted = demote_to_budget(std::move(classified->octree.tree), options);
  const TreeStatistics counts = measure_tree(demoted.tree.view());
  clearances = clearances_if_blocked(grid, counts, std::move(clearances), options);

  BakedObject object = make_object(mesh, {options.method, depth, classifier.samples, options.seed}, counts,
                                   {std::move(demoted.tree), std::move(*geometry), std::move(clearances),
                                    std::move(hierarchy->section), std::move(horizons->section)});
  object.record.flags |=
      look_up_worth(mesh, object.record, object.tree(), HierarchyView{object.to_write().hierarchy.data()},
                    kept_out_segments(mesh, asked));
  object.plan = std::move(plan);
  object.rays = classified->octree.rays;
  object.cells_classified = classified->classified;
  object.worth = std::move(classified->worth);
  object.seconds = seconds_since(start);
  object.bytes_before_demotion = bytes;
  object.cells_demoted = demoted.cells_lost;
  object.out_of_time = classified->out_of_time;
  tell_what_is_missing(object);
  if (auto wrong = audit_if_asked(mesh, object, options)) return std::move(*wrong);
  if (auto wrong = judge_if_asked(mesh, object, asked, options)) return std::move(*wrong);
  return audited(std::move(object));
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::runtime, "out of memory"};
}

}  // namespace vcd::baker
