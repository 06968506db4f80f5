#include "scene_bakes.h"

#include <algorithm>

#include <vcd/baker/measure.h>
#include <vcd/writer/writer.h>

#include "common/program.h"
#include "common/progress.h"
#include "render/recorded.h"
#include "render/sidecars.h"
#include "variant_json.h"

namespace vcd::bench {

using namespace baker;
using namespace tools;
using namespace render;
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kDemandSeed = 0xDE3A;

class SceneBakes : SceneEntry {
 public:
  SceneBakes(const SceneEntry& entry, const World& world, const RenderSettings& picture, const BakesOfScene& bakes,
             bool quiet)
      : SceneEntry(entry), world_(world), picture_(picture), bakes_(bakes), quiet_(quiet) {}

  std::optional<Error> bake_all(const std::vector<Configuration>& configurations) {
    std::error_code failed;
    for (const char* folder : {"sidecars", "images"}) {
      fs::create_directories(results_.folder() / folder, failed);
      if (failed)
        return Error{ErrorCode::io, (results_.folder() / folder).string() + ": cannot be made: " + failed.message()};
    }
    for (const Configuration& c : configurations) {
      BakeOptions bake;
      bake.method = c.method, bake.depth = c.depth, bake.samples = c.samples;
      bake.horizons = bakes_.horizons && c.method != Method::sampled;
      variant(c.id())["tree"] = c.text();
      if (c.for_demand)
        if (auto error = ask_for_demand(bake)) return error;
      if (auto error = bake_variant(c.id(), bake)) return error;
    }
    return write_unclassified(std::max(configurations[0].depth, 1u));
  }

 private:
  // Recorded once, with rays of its own: those of the measured pictures are not among them.
  std::optional<Error> ask_for_demand(BakeOptions& bake) {
    if (!demand_) {
      const ProgressLine line(label("recording"), quiet_);
      RenderSettings other = picture_;
      other.seed ^= kDemandSeed;
      RenderHooks hooks;
      hooks.stop = interrupted;
      auto demand = demand_of_picture(world_, other, bakes_.most_recorded, hooks);
      if (interrupted()) return stopped();
      if (!demand) return demand.error();
      demand_.emplace(std::move(*demand));
    }
    bake.demand = &*demand_;
    bake.budget_bytes = static_cast<uint64_t>(bakes_.budget_mb * 1048576);
    return std::nullopt;
  }

  std::optional<Error> bake_variant(const std::string& id, BakeOptions bake) {
    const fs::path path = sidecar_path(id);
    if (variant(id).contains("bake_seconds") && fs::exists(path)) return std::nullopt;
    std::optional<ProgressLine> line(std::in_place, label("baking " + id), quiet_);
    bake.stop = interrupted;
    bake.threads = picture_.threads;
    const auto baked =
        bake_world(world_, bake, path, [&](const WorldObject&, const BakeProgress& p) { line->update(p); });
    line.reset();
    if (interrupted()) return stopped();
    if (!baked) return baked.error();
    Json& v = variant(id);
    v["depth"] = baked->depth;
    v["method"] = method_name(bake.method);
    if (bake.demand) v["demand"] = true;
    if (bake.method == Method::sampled) v["samples"] = bake.samples;
    return describe_file(id, *baked);
  }

  std::optional<Error> write_unclassified(uint32_t depth) {
    if (variant(kUnclassified).contains("bake_seconds") && fs::exists(sidecar_path(kUnclassified))) return std::nullopt;
    std::vector<BakedObject> objects;
    for (const WorldObject& object : world_.objects) objects.push_back(make_unclassified_object(object.mesh, depth));
    const auto written = write_world(world_, objects, sidecar_path(kUnclassified), interrupted);
    if (interrupted()) return stopped();
    if (!written) return written.error();
    variant(kUnclassified)["depth"] = depth;
    return describe_file(kUnclassified, {0, 0, *written, depth});
  }

  std::optional<Error> describe_file(const std::string& id, const WorldBake& baked) {
    Json& v = variant(id);
    v["bake_seconds"] = baked.seconds;
    v["bake_rays"] = baked.rays;
    v["file_bytes"] = baked.file_bytes;
    auto opened = open_sidecars(world_, {sidecar_path(id).string()});
    if (!opened) return opened.error();
    describe_trees(opened->objects, v);
    uint64_t hierarchy = 0, horizons = 0;
    for (const ObjectContents& o : opened->files[0].contents().objects)
      hierarchy += o.hierarchy.bytes().size(), horizons += o.horizon.all_bytes().size();
    v["hierarchy_bytes"] = hierarchy, v["horizon_bytes"] = horizons;
    if (auto error = measure_shipped(opened->files[0], id, v)) return error;
    return results_.save();
  }

  // What the file weighs when it is compressed as vc-bake --storage ship does it.
  std::optional<Error> measure_shipped(const Sidecar& sidecar, const std::string& id, Json& v) {
    SidecarToWrite ship;
    ship.storage = Storage::zstd;
    ship.stop = interrupted;
    for (const ObjectContents& o : sidecar.contents().objects)
      ship.objects.push_back(
          {o.name, *o.record, tree_pieces(o.tree), {}, o.hierarchy.bytes(), o.clearance, o.horizon.all_bytes()});
    const fs::path path = sidecar_path(id + "-ship");
    const auto written = write_sidecar(path, ship);
    if (interrupted()) return stopped();
    if (!written) return written.error();
    v["ship_bytes"] = *written;
    std::error_code ignored;
    fs::remove(path, ignored);
    return std::nullopt;
  }

  const World& world_;
  const RenderSettings& picture_;
  const BakesOfScene& bakes_;
  bool quiet_;
  std::optional<Demand> demand_;
};

}  // namespace

std::vector<Configuration> with_measured(std::vector<Configuration> wanted, const Json& scene) {
  for (const Json& v : scene.value("variants", Json::array())) {
    if (!v.contains("tree") || !v.contains("bake_seconds")) continue;
    const auto c = Configuration::parse(v["tree"]);
    if (c && std::none_of(wanted.begin(), wanted.end(), [&](const Configuration& o) { return o.id() == c->id(); }))
      wanted.push_back(*c);
  }
  return wanted;
}

std::optional<Error> bake_missing(const SceneEntry& entry, const World& world,
                                  const std::vector<Configuration>& configurations, const RenderSettings& picture,
                                  const BakesOfScene& bakes, bool quiet) {
  return SceneBakes(entry, world, picture, bakes, quiet).bake_all(configurations);
}

}  // namespace vcd::bench
