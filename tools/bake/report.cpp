#include "report.h"

#include <span>

#include <vcd/writer/atomic_file.h>

#include "common/paths.h"

namespace vcd::tools {

using namespace library;
namespace {

std::optional<Error> write_text(const std::string& path, const std::string& text) {
  AtomicFile file(path);
  file.append(std::as_bytes(std::span(text)));
  const auto written = file.commit();
  return written ? std::nullopt : std::optional(written.error());
}

// An older page shows what the sidecar was before.
bool is_page_of(const std::filesystem::path& page, const std::filesystem::path& sidecar) {
  std::error_code none, of_page, of_sidecar;
  const auto drawn = std::filesystem::last_write_time(page, of_page);
  const auto baked = std::filesystem::last_write_time(sidecar, of_sidecar);
  return std::filesystem::is_regular_file(page, none) && !of_page && !of_sidecar && drawn >= baked;
}

void name_pages(Json& report) {
  for (Json& file : report["files"]) {
    const auto sidecar = path_from_json(file.contains("output") ? file["output"] : Json());
    if (!sidecar) continue;
    std::filesystem::path page = *sidecar;
    page += kPageEnding;
    if (is_page_of(page, *sidecar)) file["page"] = path_to_json(page);
    else file.erase("page");
  }
}

}  // namespace

Json record_json(const Asset& asset, const Record& record) {
  Json json{
      {"input", path_to_json(asset.input)}, {"output", path_to_json(asset.output)}, {"fate", fate_name(record.fate)}};
  if (!record.reason.empty()) json["reason"] = record.reason;
  json["exit_code"] = record.outcome.code;
  if (!record.ok() && record.fate != Fate::waiting) {
    json["kind"] = record.outcome.kind;
    json["error"] = record.outcome.message;
    if (!record.outcome.stage.empty()) json["stage"] = record.outcome.stage;
  }
  if (!record.old_sidecar.empty()) json["old_sidecar"] = record.old_sidecar;
  if (record.attempts > 0) {
    json["seconds"] = record.seconds;
    json["peak_memory_bytes"] = record.peak_memory_bytes;
    json["threads"] = record.threads;
    json["attempts"] = record.attempts;
  }
  const Json report = Json::parse(record.outcome.baked.report, nullptr, /*allow_exceptions=*/false);
  if (!report.is_object()) return json;
  for (const auto& [key, value] : report.items())
    if (!json.contains(key)) json[key] = value;
  return json;
}

Json totals_json(const Totals& t) {
  return {{"assets", t.assets},         {"baked", t.baked},   {"objects_reused", t.objects_reused},
          {"up_to_date", t.up_to_date}, {"failed", t.failed}, {"failed_before", t.failed_before},
          {"not_run", t.not_run},       {"bytes", t.bytes}};
}

Json report_json(const std::vector<Asset>& assets, const std::vector<Record>& records, const RunReport& run) {
  Json json{{"tool", "vc-bake"},
            {"version", VCD_VERSION},
            {"seconds", run.seconds},
            {"totals", totals_json(totals_of(records))}};
  if (run.dry_run) json["dry_run"] = true;
  json["errors"] = Json::array();
  for (const Error& error : run.errors)
    json["errors"].push_back({{"error", error.message}, {"exit_code", static_cast<int>(error.code)}});
  json["pruned"] = Json::array();
  for (const std::filesystem::path& path : run.pruned) json["pruned"].push_back(path_to_json(path));
  json["other_files"] = run.other_files;
  json["named_again"] = run.named_again;
  json["files"] = Json::array();
  for (size_t i = 0; i < assets.size(); ++i) {
    Json file = record_json(assets[i], records[i]);
    if (run.dry_run) {
      file["settings"] = Json::parse(settings_text(assets[i].settings, Scope::file));
      file["guess"] = {{"seconds", records[i].cost.seconds}, {"memory_bytes", records[i].cost.memory_bytes}};
    }
    json["files"].push_back(std::move(file));
  }
  return json;
}

std::optional<Error> write_report(const std::string& name, Json report) {
  std::error_code ignored;
  const std::filesystem::path folder = std::filesystem::path(name).parent_path();
  if (!folder.empty()) std::filesystem::create_directories(folder, ignored);
  name_pages(report);
  if (auto fault = write_text(name + ".json", report.dump(1, ' ', false, Json::error_handler_t::replace) + "\n"))
    return fault;
  return write_text(name + ".html", report_page(report, folder));
}

}  // namespace vcd::tools
