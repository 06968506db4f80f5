#include "record.h"

#include "common/paths.h"

namespace vcd {

const char* fate_name(Fate fate) {
  switch (fate) {
    case Fate::waiting: return "waiting";
    case Fate::baked: return "baked";
    case Fate::up_to_date: return "up-to-date";
    case Fate::failed: return "failed";
    case Fate::failed_before: return "failed-before";
    case Fate::not_run: return "not-run";
  }
  return "unknown";
}

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
  const Json report = record.packed_report.empty() ? record.outcome.report : Json::parse(record.packed_report);
  for (const auto& [key, value] : report.items())
    if (!json.contains(key)) json[key] = value;
  return json;
}

void Record::pack() {
  if (!outcome.report.is_object()) return;
  bytes = outcome.report.value("bytes", uint64_t{0});
  for (const Json& object : outcome.report.value("objects", Json::array()))
    objects_reused += object.value("reused", false);
  packed_report = outcome.report.dump(-1, ' ', false, Json::error_handler_t::replace);
  outcome.report = nullptr;
  outcome.summary.clear();
}

Totals& Totals::operator+=(const Totals& o) {
  assets += o.assets, baked += o.baked, objects_reused += o.objects_reused, up_to_date += o.up_to_date,
      failed += o.failed;
  failed_before += o.failed_before, not_run += o.not_run, bytes += o.bytes;
  return *this;
}

Totals totals_of(const std::vector<Record>& records) {
  Totals totals{.assets = records.size()};
  for (const Record& record : records) {
    totals.baked += record.fate == Fate::baked;
    totals.up_to_date += record.fate == Fate::up_to_date;
    totals.failed += record.fate == Fate::failed;
    totals.failed_before += record.fate == Fate::failed_before;
    totals.not_run += record.fate == Fate::not_run || record.fate == Fate::waiting;
    totals.bytes += record.bytes;
    totals.objects_reused += record.objects_reused;
  }
  return totals;
}

Json totals_json(const Totals& t) {
  return {{"assets", t.assets},         {"baked", t.baked},   {"objects_reused", t.objects_reused},
          {"up_to_date", t.up_to_date}, {"failed", t.failed}, {"failed_before", t.failed_before},
          {"not_run", t.not_run},       {"bytes", t.bytes}};
}

}  // namespace vcd
