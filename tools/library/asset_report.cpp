#include "asset_report.h"

#include <cstdio>

#include "common/describe.h"
#include "common/paths.h"
#include "common/plan_report.h"
#include "common/readable.h"

namespace vcd::library {

using namespace baker;
namespace {

using namespace tools;

std::string percent(double share, int digits = 1) {
  char text[32];
  std::snprintf(text, sizeof text, "%.*f %%", digits, 100 * share);
  return text;
}

double cells_of(const ObjectRecord& record) { return static_cast<double>(tree_shape(record.depth).cells()); }

// What was forecast beside what came.
std::string outcome(const BakedObject& object) {
  const Plan& plan = *object.plan;
  if (plan.depth == 0) return "  plan      not worth it: " + plan.reason + "\n";
  const DepthForecast& f = plan.forecasts[plan.depth - 1];
  const double unclassified = static_cast<double>(object.record.cells[2]) / cells_of(object.record);
  char gain[32];
  std::snprintf(gain, sizeof gain, "%.2f", f.gain);
  return "  plan      depth " + std::to_string(plan.depth) + ", " + plan.reason +
         "; forecast and outcome: " + readable_bytes(f.bytes) + " and " + readable_bytes(object.bytes_before_demotion) +
         ", " + readable_seconds(f.seconds) + " and " + readable_seconds(object.seconds) + ", " + percent(f.resolved) +
         " and " + percent(1 - unclassified) + " resolved\n  expected  " + percent(f.resolved_shadow) +
         " of shadow rays that pierce the box answered, traced " + gain + " times faster one by one\n";
}

std::string baked_lines(const BakedObject& object, uint64_t file_bytes) {
  std::string text;
  if (object.plan) text += outcome(object);
  if (object.cells_demoted)
    text += "  budget    made " + readable_bytes(file_bytes) + " of " + readable_bytes(object.bytes_before_demotion) +
            ": " + percent(static_cast<double>(object.cells_demoted) / cells_of(object.record), 2) +
            " of all cells lost their class\n";
  if (object.out_of_time) text += "  time      is over: what was not classified by then is unclassified\n";
  if (object.record.method == static_cast<uint8_t>(Method::none)) return text;
  return text + "  baked     in " + readable_seconds(object.seconds) + ", " +
         readable_count(static_cast<double>(object.rays)) + " rays, " +
         readable_count(static_cast<double>(object.rays) / object.seconds) + " rays/s\n";
}

Json describe_demand(const DemandReport& report) {
  return {{"kept_out", report.segments}, {"kept_out_weight", report.weight},
          {"answered", report.share()},  {"answered_segments", report.answered},
          {"wrong", report.wrong},       {"wrong_rate_bound_95", upper_bound_95(report.wrong, report.answered)}};
}

std::string demand_summary(const DemandReport& report) {
  if (report.segments == 0) return "  demand    too few segments to keep some out: the share answered is not known\n";
  char text[160];
  std::snprintf(
      text, sizeof text,
      "  demand    %s of what was kept out of the bake answered: %llu segments, %llu wrong (95 %% bound %.2g)\n",
      percent(report.share()).c_str(), static_cast<unsigned long long>(report.segments),
      static_cast<unsigned long long>(report.wrong), upper_bound_95(report.wrong, report.answered));
  return text;
}

}  // namespace

std::string asset_report(const Asset& asset, uint64_t bytes, const std::vector<std::string>& notes,
                         const std::vector<FinishedObject>& objects) {
  Json json{
      {"input", path_to_json(asset.input)}, {"output", path_to_json(asset.output)}, {"bytes", bytes}, {"notes", notes}};
  json["objects"] = Json::array();
  for (const FinishedObject& object : objects) {
    const ObjectToWrite written = object.to_write();
    const TreeView tree = object.known ? object.known->tree() : object.baked.tree();
    Json entry = describe_object(
        {&written.record, written.name, tree, written.geometry, {written.hierarchy.data()}, {written.horizon.data()}});
    entry["duplicate_triangles"] = object.duplicate_triangles;
    entry["zero_area_triangles"] = object.zero_area_triangles;
    entry["reused"] = object.known.has_value();
    entry["demand"] = object.demand ? describe_demand(*object.demand) : Json(nullptr);
    entry["plan"] = nullptr;
    if (!object.known) {
      if (object.baked.plan) entry["plan"] = describe_plan(*object.baked.plan);
      entry["bytes_before_demotion"] = object.baked.bytes_before_demotion;
      entry["cells_demoted"] = object.baked.cells_demoted;
      entry["out_of_time"] = object.baked.out_of_time;
      entry["rays"] = object.baked.rays;
      if (object.demand) entry["cells_classified"] = object.baked.cells_classified;
      entry["seconds"] = object.baked.seconds;
    }
    json["objects"].push_back(std::move(entry));
  }
  return json_text(json);
}

std::string asset_summary(const Asset& asset, uint64_t bytes, const std::vector<FinishedObject>& objects) {
  std::string text = shown(asset.input) + " -> " + shown(asset.output) + ", " + readable_bytes(bytes) + "\n";
  for (const FinishedObject& object : objects) {
    const ObjectToWrite written = object.to_write();
    text += "object " + std::to_string(written.record.source_index) + " " + printable(std::string(written.name)) +
            "\n" + object_summary(written.record) + hierarchy_summary(written.record, {written.hierarchy.data()}) +
            horizon_summary({written.horizon.data()});
    if (object.duplicate_triangles || object.zero_area_triangles)
      text += "  dropped   " + std::to_string(object.duplicate_triangles) + " duplicate and " +
              std::to_string(object.zero_area_triangles) + " zero-area triangles\n";
    if (object.demand) text += demand_summary(*object.demand);
    text += object.known ? "  baked     before: its geometry and settings are the same\n"
                         : baked_lines(object.baked, bytes);
  }
  return text;
}

}  // namespace vcd::library
