#include "plan.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <numeric>
#include <set>
#include <span>

#include <vcd/baker/source.h>
#include <vcd/writer/atomic_file.h>

#include <vcd/library/cost.h>
#include <vcd/library/manifest.h>
#include "bake/report.h"
#include "common/paths.h"

namespace vcd::farm {

using namespace tools;
using namespace library;
namespace {

namespace fs = std::filesystem;

constexpr int kPlanVersion = 1;

std::optional<Error> write_text(const fs::path& path, const std::string& text) {
  AtomicFile file(path);
  file.append(std::as_bytes(std::span(text)));
  const auto written = file.commit();
  return written ? std::nullopt : std::optional(written.error());
}

// The longest first, each to the shard that has least: none ends later than 4/3 of the best there is (Graham 1969).
std::vector<std::vector<size_t>> balanced(const std::vector<double>& seconds, size_t shards) {
  std::vector<size_t> order(seconds.size());
  std::iota(order.begin(), order.end(), size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](size_t a, size_t b) { return seconds[a] > seconds[b]; });
  std::vector<std::vector<size_t>> parts(shards);
  std::vector<double> load(shards, 0);
  for (const size_t asset : order) {
    const size_t least = static_cast<size_t>(std::min_element(load.begin(), load.end()) - load.begin());
    parts[least].push_back(asset);
    load[least] += seconds[asset];
  }
  for (auto& part : parts) std::sort(part.begin(), part.end());
  return parts;
}

// Null where it is not there or not JSON.
Json read_json(const fs::path& path) {
  const auto text = baker::read_file(path);
  if (!text) return nullptr;
  Json json = Json::parse(*text, nullptr, /*allow_exceptions=*/false);
  return json.is_discarded() ? Json(nullptr) : json;
}

// Whether it tells what became of each of the shard's assets, and of no others.
bool is_whole(const Json& report, const FarmPlan& plan, const Shard& shard) {
  for (const char* list : {"files", "errors"})
    if (!report.is_object() || !report.contains(list) || !report[list].is_array()) return false;
  if (report.contains("dry_run") || !report.contains("totals") || !report["totals"].is_object()) return false;
  const Json manifest = read_json(plan.file(shard.number, ".json"));
  if (!manifest.is_object() || !manifest.contains("assets") || !manifest["assets"].is_array()) return false;
  std::set<std::string> unreported;
  for (const Json& asset : manifest["assets"])
    if (asset.is_object()) unreported.insert(asset.value("output", Json()).dump());
  for (const Json& file : report["files"])
    if (!file.is_object() || file.value("fate", Json()) == fate_name(Fate::not_run) ||
        unreported.erase(file.value("output", Json()).dump()) == 0)
      return false;
  return unreported.size() == report["errors"].size();  // those without an input are errors
}

}  // namespace

fs::path FarmPlan::file(unsigned shard, const std::string& extension) const {
  char name[32];
  std::snprintf(name, sizeof name, "shard-%04u", shard);
  return folder / (name + extension);
}

Result<FarmPlan> make_plan(const fs::path& folder, const std::vector<Asset>& assets, unsigned shards) {
  if (assets.empty()) return Error{ErrorCode::usage, "no mesh file found: there is nothing to plan"};
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) return Error{ErrorCode::io, shown(folder) + ": " + error.message()};
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (name == "plan.json" || name.starts_with("shard-"))
      return Error{ErrorCode::usage,
                   shown(folder) + ": holds a plan already (" + shown(name) + "); remove the folder or name another"};
  }
  if (error) return Error{ErrorCode::io, shown(folder) + ": " + error.message()};
  std::vector<double> seconds;
  for (const Asset& asset : assets) seconds.push_back(guess_cost(asset).seconds);
  FarmPlan plan{fs::absolute(folder, error), {}};
  Json json{{"vcd_plan", kPlanVersion}, {"version", VCD_VERSION}, {"shards", Json::array()}};
  for (const auto& part : balanced(seconds, std::min<size_t>(shards, assets.size()))) {
    std::vector<Asset> chosen;
    Shard shard{static_cast<unsigned>(plan.shards.size() + 1), part.size(), 0};
    for (const size_t asset : part) chosen.push_back(assets[asset]), shard.seconds += seconds[asset];
    if (auto fault = write_text(plan.file(shard.number, ".json"), manifest_of(chosen))) return *std::move(fault);
    plan.shards.push_back(shard);
    json["shards"].push_back({{"number", shard.number}, {"assets", shard.assets}, {"seconds", shard.seconds}});
  }
  // Last: a plan is there only when all of it is.
  if (auto fault = write_text(folder / "plan.json", json_text(json, 1) + "\n")) return *std::move(fault);
  return plan;
}

Result<FarmPlan> open_plan(const fs::path& folder) {
  std::error_code error;
  const fs::path path = folder / "plan.json";
  const auto text = baker::read_file(path);
  if (!text) return text.error();
  const Json json = Json::parse(*text, nullptr, /*allow_exceptions=*/false);
  const Error fault{ErrorCode::invalid_file, shown(path) + ": not a plan of vc-farm"};
  if (!json.is_object() || json.value("vcd_plan", Json(nullptr)) != kPlanVersion || !json.contains("shards") ||
      !json["shards"].is_array())
    return fault;
  FarmPlan plan{fs::absolute(folder, error), {}};
  for (const Json& shard : json["shards"]) {
    const bool sound = shard.is_object() && shard.contains("number") && shard["number"].is_number_unsigned() &&
                       shard.contains("assets") && shard["assets"].is_number_unsigned() && shard.contains("seconds") &&
                       shard["seconds"].is_number();
    if (!sound || shard["number"] != plan.shards.size() + 1) return fault;
    plan.shards.push_back(
        {shard["number"].get<unsigned>(), shard["assets"].get<size_t>(), shard["seconds"].get<double>()});
  }
  return plan;
}

ShardState state_of(const FarmPlan& plan, const Shard& shard) {
  ShardState state;
  if (const Json report = read_json(plan.file(shard.number, ".report.json")); is_whole(report, plan, shard)) {
    state.done = state.started = true;
    state.ended = shard.assets;
    const Json& totals = report["totals"];
    state.failed =
        totals.value("failed", size_t{0}) + totals.value("failed_before", size_t{0}) + report["errors"].size();
    return state;
  }
  std::ifstream events(plan.file(shard.number, ".events.jsonl"));
  for (std::string line; std::getline(events, line);) {
    const Json event = Json::parse(line, nullptr, /*allow_exceptions=*/false);
    if (!event.is_object()) continue;
    const Json name = event.value("event", Json(nullptr));
    if (name == "run-started") state = {.started = true}, state.ended = event.value("up_to_date", size_t{0});
    if (name == "ended") ++state.ended, state.failed += event.value("exit_code", 0) != 0;
  }
  return state;
}

bool take_report(const FarmPlan& plan, const Shard& shard, const std::string& name) {
  const bool is_done = is_whole(read_json(name + ".json"), plan, shard);
  const bool is_kept = is_done || !state_of(plan, shard).done;
  std::error_code error;
  for (const char* extension : {".json", ".html"}) {
    const fs::path made = name + extension;
    if (is_kept) fs::rename(made, plan.file(shard.number, ".report").string() + extension, error);
    else fs::remove(made, error);
  }
  return is_done;
}

Json merged_report(const FarmPlan& plan) {
  Json merged{{"tool", "vc-farm"}, {"version", VCD_VERSION}, {"seconds", 0.0}};
  Totals totals;
  Json errors = Json::array(), files = Json::array();
  double seconds = 0;
  for (const Shard& shard : plan.shards) {
    const Json report = read_json(plan.file(shard.number, ".report.json"));
    if (!is_whole(report, plan, shard)) {
      totals.assets += shard.assets, totals.not_run += shard.assets;
      errors.push_back({{"error", shown(plan.file(shard.number, ".json")) +
                                      ": this shard is not done: " + std::to_string(shard.assets) + " assets"},
                        {"exit_code", static_cast<int>(ErrorCode::runtime)}});
      continue;
    }
    const Json& t = report["totals"];
    totals += {t.value("assets", size_t{0}),
               t.value("baked", size_t{0}),
               t.value("objects_reused", size_t{0}),
               t.value("up_to_date", size_t{0}),
               t.value("failed", size_t{0}),
               t.value("failed_before", size_t{0}),
               0,
               t.value("bytes", uint64_t{0})};
    seconds += report.value("seconds", 0.0);
    for (const Json& error : report.value("errors", Json::array())) errors.push_back(error);
    for (const Json& file : report["files"]) files.push_back(file);
  }
  merged["seconds"] = seconds;
  merged["totals"] = totals_json(totals);
  merged["errors"] = std::move(errors);
  merged["files"] = std::move(files);
  return merged;
}

}  // namespace vcd::farm
