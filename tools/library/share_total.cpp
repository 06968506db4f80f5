#include <vcd/library/share_total.h>

#include <algorithm>
#include <array>
#include <map>

#include "common/paths.h"

namespace vcd::library {
namespace {

using namespace tools;

// Hears of progress, and of what failed; the assets are baked again, and only then they ended.
class Measuring : public BatchListener {
 public:
  explicit Measuring(std::span<BatchListener* const> listeners) : listeners_(listeners) {}
  void started(size_t, size_t) override {}
  void attempt_started(const Asset&, const Grant&) override {}
  void going_on(const std::vector<Running>& running, size_t ended, double seconds_left) override {
    for (BatchListener* listener : listeners_) listener->going_on(running, ended, seconds_left);
  }
  void ended(const Asset& asset, const Record& record) override {
    if (record.ok()) return;
    for (BatchListener* listener : listeners_) listener->ended(asset, record);
  }

 private:
  std::span<BatchListener* const> listeners_;
};

class Sharers {
 public:
  Sharers(std::vector<Asset>& assets, std::vector<Record>& records, std::vector<size_t> of, const BatchOptions& options,
          BatchListener& listener)
      : assets_(assets), records_(records), of_(std::move(of)), options_(options), listener_(listener) {
    options_.measure = true, options_.update = false;
  }

  void share() {
    for (const size_t i : of_)
      if (records_[i].fate == Fate::up_to_date) wait(i, "shares --total-mb with one that is baked");
    const auto total = static_cast<uint64_t>(assets_[of_[0]].settings.total_mb * 1048576);
    for (;;) {
      if (!measure()) return;
      std::vector<WantedBytes> wanted;
      uint32_t deepest = 0;
      uint64_t least = 0;
      for (const size_t i : of_)
        for (const WantedBytes& object : records_[i].outcome.baked.wanted) {
          wanted.push_back(object);
          deepest = std::max(deepest, object.depth), least += object.least;
        }
      if (const auto shares = share_out(total, wanted)) return hand_out(*shares);
      // Each picked its depth for all bytes: together the tables of such deep trees may be too much.
      const bool may_be_less = std::ranges::all_of(of_, [&](size_t i) { return assets_[i].settings.depth == 0; });
      if (!may_be_less || deepest <= 2) return fail_all(least);
      hand_out(std::vector<uint64_t>(wanted.size(), total), deepest - 1);
    }
  }

 private:
  void wait(size_t i, std::string reason) {
    Record record;
    record.reason = std::move(reason), record.cost = records_[i].cost;
    records_[i] = std::move(record);
  }

  // The records say what each would do with bytes. False if nobody is left to share.
  bool measure() {
    std::vector<Asset> assets;
    std::vector<Record> records;
    for (const size_t i : of_) {
      wait(i, records_[i].reason);
      assets.push_back(assets_[i]), records.push_back(records_[i]);
    }
    run_batch(assets, records, options_, std::array{&listener_});
    const bool broken_off = std::ranges::any_of(records, [&](const Record& r) {
      return r.fate == Fate::not_run || (options_.fail_fast && r.fate == Fate::failed);
    });
    std::vector<size_t> left;
    for (size_t k = 0; k < of_.size(); ++k) {
      if (records[k].ok() && broken_off) {
        leave_out(assets[k], records[k]);
      } else if (records[k].ok()) {
        records[k].fate = Fate::waiting;
        left.push_back(of_[k]);
      }
      records_[of_[k]] = std::move(records[k]);
    }
    of_ = std::move(left);
    return !of_.empty();
  }

  static void leave_out(const Asset& asset, Record& record) {
    record.fate = Fate::not_run;
    record.outcome = {};
    record.outcome.code = static_cast<int>(ErrorCode::runtime);
    record.outcome.kind = "not-run";
    record.outcome.message = shown(asset.input) + ": not run: the run ended before --total-mb was shared";
  }

  void hand_out(const std::vector<uint64_t>& shares, uint32_t most_depth = UINT32_MAX) {
    size_t next = 0;
    for (const size_t i : of_) {
      assets_[i].shares.clear();
      for (const WantedBytes& object : records_[i].outcome.baked.wanted)
        assets_[i].shares.push_back({shares[next++], std::min(object.depth, most_depth)});
      wait(i, records_[i].reason);
    }
  }

  void fail_all(uint64_t least) {
    for (const size_t i : of_) {
      Record& record = records_[i];
      record.fate = Fate::failed;
      record.outcome = {};
      record.outcome.code = static_cast<int>(ErrorCode::usage);
      record.outcome.kind = error_kind(ErrorCode::usage);
      record.outcome.message = shown(assets_[i].input) + ": the objects that share --total-mb take " +
                               std::to_string(least) + " bytes at the least, more than that";
      listener_.ended(assets_[i], record);
    }
  }

  std::vector<Asset>& assets_;
  std::vector<Record>& records_;
  std::vector<size_t> of_;
  BatchOptions options_;
  BatchListener& listener_;
};

}  // namespace

void share_totals(std::vector<Asset>& assets, std::vector<Record>& records, const BatchOptions& options,
                  std::span<BatchListener* const> listeners) {
  std::map<double, std::vector<size_t>> groups;
  for (size_t i = 0; i < assets.size(); ++i)
    if (assets[i].settings.total_mb > 0 && (records[i].ok() || records[i].fate == Fate::waiting))
      groups[assets[i].settings.total_mb].push_back(i);
  Measuring measuring(listeners);
  for (auto& [total_mb, group] : groups) {
    const bool any_waits = std::ranges::any_of(group, [&](size_t i) { return records[i].fate == Fate::waiting; });
    if (group.size() > 1 && any_waits) Sharers(assets, records, std::move(group), options, measuring).share();
  }
}

}  // namespace vcd::library
