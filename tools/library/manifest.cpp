#include <vcd/library/manifest.h>

#include <algorithm>

#include <vcd/baker/source.h>

#include <vcd/library/assets.h>
#include "common/describe.h"
#include "common/paths.h"

namespace vcd::library {
namespace {

using namespace tools;

namespace fs = std::filesystem;

constexpr int kManifestVersion = 1;

class Manifest {
 public:
  Manifest(const fs::path& path, const BakeSettings& base) : path_(path), settings_(base) {}

  Result<std::vector<ManifestEntry>> read() {
    const auto text = baker::read_file(path_);
    if (!text) return text.error();
    const Json json = Json::parse(*text, nullptr, /*allow_exceptions=*/false);
    if (json.is_discarded()) return fault("", "not JSON");
    if (!json.is_object() || !json.contains("vcd_manifest"))
      return fault("", "no \"vcd_manifest\": it is not a manifest");
    if (json["vcd_manifest"] != kManifestVersion)
      return Error{ErrorCode::unsupported, shown(path_) + ": vcd_manifest: only version 1 is known"};
    if (auto unknown = unknown_member(json, {"vcd_manifest", "output", "settings", "assets"}, ""))
      return *std::move(unknown);
    if (!json.contains("assets") || !json["assets"].is_array()) return fault("", "no array \"assets\"");
    if (json.contains("settings")) {
      if (auto wrong = change(settings_, json["settings"], "")) return *std::move(wrong);
    }
    if (json.contains("output")) {
      auto folder = path_from_json(json["output"]);
      if (!folder) return fault("output", folder.error().message);
      folder_ = beside(*folder);
    }
    for (size_t i = 0; i < json["assets"].size(); ++i)
      if (auto wrong = read_asset(json["assets"][i], "assets[" + std::to_string(i) + "]")) return *std::move(wrong);
    return std::move(entries_);
  }

 private:
  Error fault(const std::string& place, const std::string& reason) const {
    return {ErrorCode::usage, shown(path_) + ": " + (place.empty() ? "" : place + ": ") + reason};
  }

  fs::path beside(const fs::path& path) const { return path.is_absolute() ? path : path_.parent_path() / path; }

  std::optional<Error> unknown_member(const Json& object, const std::vector<std::string>& known,
                                      const std::string& place) const {
    for (const auto& [name, value] : object.items())
      if (std::find(known.begin(), known.end(), name) == known.end())
        return fault(place, "unknown member \"" + name + "\"");
    return std::nullopt;
  }

  static bool is_file(const std::string& name) {
    return std::ranges::any_of(settings_table(), [&](const Setting& setting) {
      return setting.name == name && setting.form == Setting::Form::file;
    });
  }

  std::optional<Error> change(BakeSettings& settings, const Json& members, const std::string& place) const {
    if (!members.is_object()) return fault(place, "settings: not an object");
    for (const auto& [name, value] : members.items()) {
      if (!value.is_primitive() || value.is_null())
        return fault(place, "settings: " + name + ": not a number, text, true or false");
      std::string text = value.is_string() ? value.get<std::string>() : value.dump();
      if (is_file(name)) text = beside(text).string();
      const auto wrong = set(settings, name, text);
      if (wrong) return fault(place, "settings: " + wrong->message);
    }
    return std::nullopt;
  }

  std::optional<Error> read_asset(const Json& json, const std::string& place) {
    if (!json.is_object() || !json.contains("input")) return fault(place, "no \"input\"");
    if (auto unknown = unknown_member(json, {"input", "output", "settings"}, place)) return unknown;
    const auto input = path_from_json(json["input"]);
    if (!input || input->empty()) return fault(place + ".input", input ? "empty" : input.error().message);
    ManifestEntry entry{beside(*input), {}, folder_, settings_};
    if (json.contains("output")) {
      const auto output = path_from_json(json["output"]);
      if (!output || output->empty()) return fault(place + ".output", output ? "empty" : output.error().message);
      std::error_code ignored;
      if (fs::is_directory(entry.input, ignored)) entry.folder = beside(*output);
      else entry.sidecar = beside(*output);
    }
    if (json.contains("settings"))
      if (auto wrong = change(entry.settings, json["settings"], place)) return wrong;
    entries_.push_back(std::move(entry));
    return std::nullopt;
  }

  fs::path path_;
  BakeSettings settings_;
  fs::path folder_;
  std::vector<ManifestEntry> entries_;
};

}  // namespace

Result<std::vector<ManifestEntry>> read_manifest(const fs::path& path, const BakeSettings& base) {
  return Manifest(path, base).read();
}

std::string manifest_of(const std::vector<Asset>& assets) {
  Json json{{"vcd_manifest", kManifestVersion}, {"assets", Json::array()}};
  for (const Asset& asset : assets) {
    std::error_code ignored;
    Json settings = Json::parse(settings_text(asset.settings, Scope::file));
    if (!asset.settings.demand.path.empty())
      settings["for"] = fs::absolute(asset.settings.demand.path, ignored).string();
    json["assets"].push_back({{"input", path_to_json(fs::absolute(asset.input, ignored))},
                              {"output", path_to_json(fs::absolute(asset.output, ignored))},
                              {"settings", std::move(settings)}});
  }
  return json_text(json, 1) + "\n";
}

}  // namespace vcd::library
