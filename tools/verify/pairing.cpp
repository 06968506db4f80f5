#include "pairing.h"

#include <algorithm>
#include <set>

#include "common/describe.h"
#include "common/meshes.h"
#include "common/paths.h"

namespace vcd::verify {

using namespace baker;
using namespace tools;
using namespace library;
namespace {

// What breaks its format will never have a sidecar. Of what could not be read today nobody knows.
bool is_unusable(const Error& error) {
  return error.code == ErrorCode::invalid_file || error.code == ErrorCode::unsupported;
}

class FromLibrary : public MeshSource {
 public:
  FromLibrary(Library& library, const FoundFile& file, const SidecarContents& sidecar)
      : library_(library), way_(way_of(sidecar)), by_path_(library.named_by_path(file)) {
    for (const ObjectContents& object : sidecar.objects) wanted_.insert(object.record->geometry_hash);
    for (const auto& [key, value] : sidecar.provenance)
      if (key == "source") named_ = library.named(value);
    if (by_path_) named_ = {*by_path_};
  }

  const PreparedMesh* mesh_of(const ObjectContents& object, const std::string& place, Outcome& outcome) override {
    const GeometryHash& geometry = object.record->geometry_hash;
    std::vector<size_t> assets;
    Way way;
    std::tie(assets, way) = assets_of(geometry);
    if (assets.empty()) {
      tell_why_none(geometry, place, outcome);
      return nullptr;
    }
    const auto is_among = [&](size_t asset) { return std::ranges::find(assets, asset) != assets.end(); };
    if (by_path_ && !is_among(*by_path_))
      outcome.add(IssueId::misnamed, ErrorCode::difference, place,
                  "it has the geometry of " + name_of(assets[0]) + ", not of " + name_of(*by_path_));
    if (!(loaded_ && loaded_->second == way && is_among(loaded_->first)))
      load(by_path_ && is_among(*by_path_) ? *by_path_ : assets[0], way);
    return loaded_mesh(geometry, place, outcome);
  }

 private:
  static Way way_of(const SidecarContents& sidecar) {
    const IngestOptions options = ingest_options_of(sidecar);
    return {options.treat_all_as_opaque, options.shift, options.subdivide};
  }
  std::string name_of(size_t asset) const { return shown(library_.file(asset).path); }

  // Read as the sidecar says: those that it names; else as by default; else all as it says.
  std::pair<std::vector<size_t>, Way> assets_of(const GeometryHash& geometry) const {
    std::vector<size_t> named = library_.with_geometry(geometry, way_, named_);
    if (!named.empty()) return {std::move(named), way_};
    for (const Way& way : {Way{}, way_})
      if (const auto found = library_.with_geometry(geometry, way); !found.empty())
        return {{found.begin(), found.end()}, way};
    return {};
  }

  void tell_why_none(const GeometryHash& geometry, const std::string& place, Outcome& outcome) const {
    if (named_.empty())
      return outcome.add(IssueId::orphaned, ErrorCode::difference, place,
                         "no asset has its geometry hash " + hex(geometry) + ", or its name");
    for (const size_t asset : named_)
      if (const auto& fault = library_.reading(asset, way_).fault; fault && !is_unusable(*fault))
        return outcome.add(IssueId::mesh_unreadable, fault->code, place,
                           name_of(asset) + ": " + reason(*fault, library_.file(asset).path));
    outcome.stale_against.insert(outcome.stale_against.end(), named_.begin(), named_.end());
    std::string assets = name_of(named_[0]);
    if (named_.size() > 1) assets += " and " + std::to_string(named_.size() - 1) + " of the same name";
    outcome.add(IssueId::stale, ErrorCode::stale, place,
                "it was made for " + assets + ", and no asset has its geometry hash " + hex(geometry));
  }

  void load(size_t asset, const Way& way) {
    meshes_.clear();
    loaded_ = {asset, way};
    auto file = MeshFile::read(library_.file(asset).path, library_.options(way));
    fault_ = file ? std::nullopt : std::optional(file.error());
    while (!fault_) {
      auto mesh = file->next();
      if (!mesh) break;
      if (wanted_.contains(mesh->geometry_hash)) meshes_.push_back(std::move(*mesh));
    }
  }

  const PreparedMesh* loaded_mesh(const GeometryHash& geometry, const std::string& place, Outcome& outcome) const {
    const auto found = std::ranges::find(meshes_, geometry, &PreparedMesh::geometry_hash);
    if (found != meshes_.end()) return &*found;
    const std::string changed = name_of(loaded_->first) + ": was changed while the library was verified";
    outcome.add(IssueId::mesh_unreadable, fault_ ? fault_->code : ErrorCode::runtime, place,
                fault_ ? fault_->message : changed);
    return nullptr;
  }

  Library& library_;
  Way way_;
  std::optional<size_t> by_path_;
  std::vector<size_t> named_;  // that one, else those of the file name in its provenance
  std::set<GeometryHash> wanted_;
  std::optional<std::pair<size_t, Way>> loaded_;
  std::vector<PreparedMesh> meshes_;
  std::optional<Error> fault_;
};

// "a, b, c and 7 more"
std::string listed(const std::vector<std::string>& names) {
  constexpr size_t kMost = 10;
  std::string text;
  for (size_t i = 0; i < std::min(names.size(), kMost); ++i) text += (i ? ", " : "") + names[i];
  if (names.size() > kMost) text += " and " + std::to_string(names.size() - kMost) + " more";
  return text;
}

class Comparison {
 public:
  Comparison(Library& library, const std::vector<Outcome>& sidecars, bool is_complete)
      : library_(library), is_complete_(is_complete) {
    for (const Outcome& sidecar : sidecars) {
      seen_.insert(sidecar.geometries.begin(), sidecar.geometries.end());
      for (const size_t asset : sidecar.stale_against) stale_[asset].insert(shown(sidecar.path));
    }
  }

  Outcome outcome_of(size_t asset) const {
    const std::filesystem::path& path = library_.file(asset).path;
    Outcome outcome{.subject = Subject::asset, .path = path};
    const Reading& reading = library_.reading(asset, {});
    if (!reading.done) {
      outcome.add(IssueId::not_verified, ErrorCode::runtime, "", "interrupted");
      return outcome;
    }
    if (reading.fault && !other_way(asset)) add_unusable(outcome, "", *reading.fault, path);
    for (const auto& [mesh, error] : reading.unusable) add_unusable(outcome, mesh, error, path);
    std::vector<std::string> without;
    for (const AssetMesh& mesh : reading.meshes) {
      const bool has_sidecar = seen_.contains(mesh.geometry) || other_way(asset, mesh.source_index);
      outcome.meshes.push_back({mesh.source_index, mesh.name, mesh.geometry, has_sidecar});
      if (!has_sidecar) without.push_back("mesh " + std::to_string(mesh.source_index) + " " + printable(mesh.name));
    }
    if (!without.empty()) add_missing(outcome, asset, without, reading.meshes.size());
    return outcome;
  }

 private:
  // Whether a sidecar has the asset's meshes, or one of them, baked in another way than the default one.
  bool other_way(size_t asset, std::optional<uint32_t> source_index = {}) const {
    return library_.any_other_reading_has(asset, [&](const AssetMesh& mesh) {
      return seen_.contains(mesh.geometry) && (!source_index || *source_index == mesh.source_index);
    });
  }

  static void add_unusable(Outcome& outcome, const std::string& mesh, const Error& error,
                           const std::filesystem::path& path) {
    outcome.add(is_unusable(error) ? IssueId::unusable_asset : IssueId::unreadable_asset, error.code, mesh,
                reason(error, path));
  }

  void add_missing(Outcome& outcome, size_t asset, const std::vector<std::string>& without, size_t all) const {
    if (!is_complete_)
      return outcome.add(IssueId::not_verified, ErrorCode::runtime, "",
                         "interrupted before all sidecars were looked at");
    std::string text = "no sidecar has the geometry of " + listed(without);
    if (all > 1) text += ", " + std::to_string(without.size()) + " of " + std::to_string(all) + " meshes";
    if (const auto stale = stale_.find(asset); stale != stale_.end())
      text += "; stale: " + listed({stale->second.begin(), stale->second.end()});
    outcome.add(IssueId::missing, ErrorCode::difference, "", text);
  }

  Library& library_;
  bool is_complete_;
  std::set<GeometryHash> seen_;
  std::map<size_t, std::set<std::string>> stale_;
};

}  // namespace

std::unique_ptr<MeshSource> against_library(Library& library, const FoundFile& file, const SidecarContents& sidecar) {
  return std::make_unique<FromLibrary>(library, file, sidecar);
}

std::vector<Outcome> compare(Library& library, const std::vector<Outcome>& sidecars, bool is_complete) {
  const Comparison comparison(library, sidecars, is_complete);
  std::vector<Outcome> outcomes;
  for (size_t i = 0; i < library.size(); ++i) outcomes.push_back(comparison.outcome_of(i));
  return outcomes;
}

}  // namespace vcd::verify
