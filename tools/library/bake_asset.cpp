#include <vcd/library/bake_asset.h>

#include <algorithm>
#include <cerrno>
#include <climits>
#include <optional>
#include <span>
#include <utility>

#include <vcd/format/layout.h>
#include <vcd/writer/atomic_file.h>

#include <vcd/library/light_demand.h>
#include <vcd/library/object_cache.h>
#include <vcd/library/provenance.h>
#include "asset_report.h"
#include "common/describe.h"
#include "common/meshes.h"
#include "common/paths.h"

namespace vcd::library {

using namespace baker;
namespace {

using namespace tools;

namespace fs = std::filesystem;

// What keeps the sidecar from being written, as far as that can be known before the bake.
std::optional<Error> check_output(const fs::path& output) {
  std::error_code error;
  fs::path folder = output.has_parent_path() ? output.parent_path() : ".";
  if (fs::is_directory(folder, error)) return AtomicFile(output, kSidecarBegin).fault();
  const auto fault = [&](const std::string& reason) {
    return Error{ErrorCode::io, shown(output) + ": cannot be written: " + reason};
  };
  for (const fs::path& name : output)
    if (name.native().size() > NAME_MAX) return fault(std::generic_category().message(ENAMETOOLONG));
  while (!fs::exists(folder, error)) folder = folder.has_parent_path() ? folder.parent_path() : ".";
  if (!fs::is_directory(folder, error)) return fault(shown(folder) + " is not a folder");
  return AtomicFile(folder / ".vcd").fault();  // a name that nothing else has
}

class AssetBake {
 public:
  AssetBake(const Asset& asset, const BakeContext& context) : asset_(asset), context_(context), cache_(context.cache) {}

  Result<BakedAsset> run() {
    if (auto unwritable = check_output(asset_.output)) return *std::move(unwritable);
    context_.on_stage("reading");
    if (auto unusable = read_demand_if_asked()) return *std::move(unusable);
    auto file = MeshFile::read(asset_.input, asset_.settings.ingest_options(), context_.ingest);
    if (!file) return file.error();
    if (auto unfinished = asset_.settings.for_lights ? finish_lit(*file) : finish_all(*file))
      return *std::move(unfinished);
    if (auto unusable = file->fault()) return *std::move(unusable);
    if (context_.measure) {
      BakedAsset measured;
      measured.report = "{}", measured.wanted = std::move(wanted_);
      return measured;
    }
    if (asset_.settings.for_lights && !asked_any_)
      return fault(ErrorCode::usage, "none of its lights throws a shadow of its meshes");
    if (demand_ && !asked_any_)
      return Error{ErrorCode::usage, shown(asset_.settings.demand.path) + ": asks nothing of " + shown(asset_.input) +
                                         ": it was made for other meshes, or for another version of these"};
    if (auto changed = changed_source(file->sources()))
      return fault(ErrorCode::io, *changed + " changed while it was baked; bake it again");
    notes_.insert(notes_.begin(), file->notes().begin(), file->notes().end());
    return write(file->sources());
  }

 private:
  Error fault(ErrorCode code, const std::string& reason) const { return {code, asset_.input.string() + ": " + reason}; }

  std::optional<Error> read_demand_if_asked() {
    const DemandFile& demand = asset_.settings.demand;
    if (!demand.path.empty() + asset_.settings.for_lights + (asset_.settings.for_above > 0) > 1)
      return Error{ErrorCode::usage, "--for, --for-lights and --for-above exclude one another"};
    if (!asset_.settings.for_a_demand() && (asset_.settings.total_mb > 0 || asset_.settings.depth_elsewhere > 0))
      return Error{ErrorCode::usage, "--total-mb and --depth-elsewhere need --for, --for-lights or --for-above"};
    if (demand.path.empty()) return std::nullopt;
    auto read = read_demand(demand.path);
    if (!read) return read.error();
    if (const auto hash = hash_file(demand.path); !hash || hex(*hash) != demand.hash)
      return Error{ErrorCode::io, shown(demand.path) + ": changed since the run began; bake again"};
    demand_ = std::move(*read);
    return std::nullopt;
  }

  std::optional<Error> finish_one(const PreparedMesh& mesh) {
    auto object = finish(mesh);
    if (!object) return object.error();
    objects_.push_back(std::move(*object));
    return std::nullopt;
  }
  std::optional<Error> finish_all(MeshFile& file) {
    std::vector<PreparedMesh> together;
    while (auto mesh = next(file)) {
      if (asset_.settings.for_above > 0) {
        auto demand = demand_from_above(*mesh, static_cast<Axis>(asset_.settings.for_above - 1));
        if (!demand) return demand.error();
        if (!demand_) demand_.emplace();
        demand_->merge(*demand);
      }
      if (asset_.settings.total_mb > 0) together.push_back(std::move(*mesh));
      else if (auto unfinished = finish_one(*mesh)) return unfinished;
    }
    return together.empty() ? std::nullopt : finish_together(together);
  }
  // The lights' demand needs all meshes at once.
  std::optional<Error> finish_lit(MeshFile& file) {
    std::vector<PreparedMesh> meshes;
    while (auto mesh = next(file)) meshes.push_back(std::move(*mesh));
    if (meshes.empty()) return std::nullopt;  // fault() says why
    if (file.lights().empty())
      return fault(ErrorCode::usage, "has no lights: neither of KHR_lights_punctual nor in extras (spec/demand.md)");
    std::vector<LitInstance> instances;
    for (const Placement& placement : file.placements())
      instances.push_back({&meshes[placement.mesh], placement.transform});
    auto demand = demand_of_lights(instances, file.lights());
    if (!demand) return demand.error();
    demand_ = std::move(*demand);
    if (asset_.settings.total_mb > 0) return finish_together(meshes);
    for (const PreparedMesh& mesh : meshes)
      if (auto unfinished = finish_one(mesh)) return unfinished;
    return std::nullopt;
  }

  // What the demand asks of the mesh: nothing of some of a file's meshes is no error.
  std::span<const AskedSegment> asked_of(const PreparedMesh& mesh) {
    if (!demand_) return {};
    const auto found = demand_->find(mesh.geometry_hash);
    if (found == demand_->end()) {
      notes_.push_back("object " + std::to_string(mesh.source_index) + " has no cells: the demand asks nothing of it");
      return {};
    }
    asked_any_ = true;
    return found->second;
  }

  // Objects that were baked as if all bytes were each one's own.
  struct Alone {
    std::vector<FinishedObject> objects;
    std::vector<WantedBytes> wanted;
    uint64_t least = 0;  // bytes of all
    uint32_t deepest = 0;
  };
  // depths: of each, 0 for as deep as pays; set to what they became.
  Result<Alone> bake_alone(const std::vector<PreparedMesh>& meshes, uint64_t total, std::vector<uint32_t>& depths) {
    Alone alone;
    const auto [notes, left_out] = std::pair(notes_, left_out_);
    for (size_t i = 0; i < meshes.size(); ++i) {
      auto object = finish(meshes[i], Part{.budget_bytes = total, .depth = depths[i], .audited = false});
      if (!object) return object.error();
      depths[i] = object->baked.record.depth;
      alone.deepest = std::max(alone.deepest, depths[i]);
      alone.wanted.push_back(wanted_bytes(*object));
      alone.least += alone.wanted.back().least;
      alone.objects.push_back(std::move(*object));
    }
    notes_ = notes, left_out_ = left_out;  // they will be said again
    return alone;
  }

  std::optional<Error> finish_with_shares(const std::vector<PreparedMesh>& meshes) {
    if (meshes.size() != asset_.shares.size()) return fault(ErrorCode::io, "changed while it was baked; bake it again");
    for (size_t i = 0; i < meshes.size(); ++i) {
      const auto [bytes, depth] = asset_.shares[i];
      auto object = finish(meshes[i], Part{.budget_bytes = bytes, .depth = depth});
      if (!object) return object.error();
      objects_.push_back(std::move(*object));
    }
    return std::nullopt;
  }

  // Each as if all bytes were its own, then with its share of them, where what is known is not classified again.
  std::optional<Error> finish_together(const std::vector<PreparedMesh>& meshes) {
    if (!context_.measure && !asset_.shares.empty()) return finish_with_shares(meshes);
    const auto total = static_cast<uint64_t>(asset_.settings.total_mb * 1048576);
    std::vector<uint32_t> depths(meshes.size(), asset_.settings.depth);
    for (size_t i = 0; i < std::min(depths.size(), asset_.shares.size()); ++i) depths[i] = asset_.shares[i].depth;
    auto alone = bake_alone(meshes, total, depths);
    if (!alone) return alone.error();
    if (context_.measure) {
      wanted_ = std::move(alone->wanted);
      return std::nullopt;
    }
    auto shares = share_out(total, alone->wanted);
    // Each picked its depth for all bytes: together the tables of such deep trees may be too much.
    while (!shares && asset_.settings.depth == 0 && alone->deepest > 2) {
      for (uint32_t& depth : depths) depth = std::min(depth, alone->deepest - 1);
      alone = bake_alone(meshes, total, depths);
      if (!alone) return alone.error();
      shares = share_out(total, alone->wanted);
    }
    if (!shares)
      return fault(ErrorCode::usage,
                   "its objects take " + std::to_string(alone->least) + " bytes, more than --total-mb");
    for (size_t i = 0; i < meshes.size(); ++i) {
      const BakedObject& known = alone->objects[i].baked;
      auto object = finish(
          meshes[i],
          Part{.budget_bytes = (*shares)[i], .depth = depths[i], .known = KnownTree{known.record, known.tree()}});
      if (!object) return object.error();
      objects_.push_back(std::move(*object));
    }
    return std::nullopt;
  }

  // bake() leaves out hierarchies of more than half of a budget, and horizons of more than a quarter.
  static WantedBytes wanted_bytes(const FinishedObject& object) {
    const ObjectToWrite parts = object.to_write();
    const uint64_t hierarchy = parts.hierarchy.size(), horizons = parts.horizon.size();
    const uint64_t tree = object.baked.worth.empty() ? 0 : object.baked.worth.front().bytes;
    return {std::max({2 * hierarchy, 4 * horizons, kBytesBesideTree + hierarchy + horizons + tree}), object.baked.worth,
            object.baked.record.depth};
  }

  std::optional<PreparedMesh> next(MeshFile& file) {
    context_.on_stage("preparing");
    return file.next();
  }

  // What an object of several gets.
  struct Part {
    uint64_t budget_bytes = 0;
    uint32_t depth = 0;
    bool audited = true;
    std::optional<KnownTree> known = {};
  };

  // From the mesh to its object: known already, or baked.
  Result<FinishedObject> finish(const PreparedMesh& mesh, const std::optional<Part>& part = {}) {
    if (mesh.left_out.any())
      left_out_ += std::to_string(mesh.source_index) + " not-opaque=" + std::to_string(mesh.left_out.not_opaque) +
                   " deforming=" + std::to_string(mesh.left_out.deforming) + "\n";
    FinishedObject finished{mesh.duplicate_triangles, mesh.zero_area_triangles};
    const std::span<const AskedSegment> asked = asked_of(mesh);
    // What a scene's lights ask, and what is an object's share, depends on the whole scene, which neither the sidecar
    // nor the cache knows objects by.
    const bool may_be_known = !asset_.settings.for_lights && !part;
    if (context_.reuse && may_be_known) finished.known = find_in_sidecar(asset_.output, mesh, asset_.settings);
    if (!finished.known && may_be_known) finished.known = cache_.find(mesh, asset_.settings);
    if (finished.known) return judged(std::move(finished), mesh, asked);
    BakeOptions options = asset_.settings.bake_options();
    if (!asked.empty()) options.demand = &*demand_;
    else if (demand_) options.method = Method::none, options.depth_elsewhere = 0;
    std::optional<CachedObject> older;  // whose cells need not be classified again
    if (context_.reuse && options.demand) older = find_older_in_sidecar(asset_.output, mesh);
    if (older) options.known = {older->to_write().record, older->tree()};
    if (part) {
      options.budget_bytes =
          options.budget_bytes > 0 ? std::min(options.budget_bytes, part->budget_bytes) : part->budget_bytes;
      if (options.demand) options.depth = part->depth;
      if (!part->audited) options.audit_lines = 0;
      if (part->known && options.demand) options.known = part->known;
    }
    options.threads = context_.threads;
    options.progress = context_.on_progress;
    options.on_pass = [&](BakePass pass) {
      if (pass == BakePass::audit) context_.on_stage("auditing " + printable(mesh.name));
    };
    context_.on_stage("baking " + printable(mesh.name));
    auto baked = bake(mesh, options);
    if (!baked) return fault(baked.error().code, baked.error().message);
    if (!baked->without_hierarchy.empty())
      notes_.push_back("object " + std::to_string(mesh.source_index) +
                       " has no hierarchy: " + baked->without_hierarchy);
    if (!baked->without_horizons.empty())
      notes_.push_back("object " + std::to_string(mesh.source_index) + " has no horizons: " + baked->without_horizons);
    if (const auto unkept = may_be_known ? cache_.keep(mesh, asset_.settings, baked->to_write()) : std::nullopt)
      notes_.push_back("not kept in the cache: " + unkept->message);
    finished.demand = baked->demand;
    finished.baked = std::move(*baked);
    return finished;
  }

  // With what its cells answer of the demand.
  Result<FinishedObject> judged(FinishedObject&& finished, const PreparedMesh& mesh,
                                std::span<const AskedSegment> asked) const {
    if (asked.empty()) return std::move(finished);
    const ObjectToWrite object = finished.to_write();
    auto report = judge_demand(mesh, object.record, finished.known->tree(), asked);
    if (!report) return report.error();
    finished.demand = *report;
    return std::move(finished);
  }

  // The first file that no longer is what was read.
  std::optional<std::string> changed_source(const std::vector<SourceFile>& sources) const {
    for (const SourceFile& source : sources) {
      const auto hash = hash_file(asset_.input.parent_path() / source.name);
      if (!hash || *hash != source.hash) return shown(source.name);
    }
    return std::nullopt;
  }

  Result<BakedAsset> write(const std::vector<SourceFile>& sources) {
    context_.on_stage("writing");
    SidecarToWrite sidecar;
    sidecar.storage = asset_.settings.storage;
    std::string answered;
    for (const FinishedObject& object : objects_)
      if (object.demand) answered += demand_line(object.to_write().record.source_index, *object.demand);
    sidecar.provenance = provenance_of(asset_, sources, left_out_, answered);
    for (const FinishedObject& object : objects_) sidecar.objects.push_back(object.to_write());
    std::error_code error;
    if (asset_.output.has_parent_path()) fs::create_directories(asset_.output.parent_path(), error);
    const auto written = write_sidecar(asset_.output, sidecar);
    if (!written) return written.error();
    BakedAsset baked;
    baked.bytes = *written;
    baked.notes = notes_;
    baked.summary = asset_summary(asset_, *written, objects_);
    baked.report = asset_report(asset_, *written, notes_, objects_);
    for (const FinishedObject& object : objects_) baked.objects_reused += object.known.has_value();
    for (size_t i = 1; i < sources.size(); ++i) baked.sources.push_back(sources[i].name);
    return baked;
  }

  const Asset& asset_;
  const BakeContext& context_;
  ObjectCache cache_;
  std::vector<FinishedObject> objects_;
  std::vector<std::string> notes_;
  std::vector<WantedBytes> wanted_;
  std::string left_out_;
  std::optional<Demand> demand_;
  bool asked_any_ = false;  // of the meshes so far
};

}  // namespace

Result<BakedAsset> bake_asset(const Asset& asset, const BakeContext& context) {
  return AssetBake(asset, context).run();
}

}  // namespace vcd::library
