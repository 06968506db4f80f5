#include <vcd/library/record.h>

namespace vcd::library {

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
    totals.bytes += record.outcome.baked.bytes;
    totals.objects_reused += record.outcome.baked.objects_reused;
  }
  return totals;
}

}  // namespace vcd::library
