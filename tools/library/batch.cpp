#include <vcd/library/batch.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <list>
#include <set>
#include <thread>

#include <poll.h>

#include <vcd/writer/atomic_file.h>

#include <vcd/library/provenance.h>
#include <vcd/library/schedule.h>
#include <vcd/library/staleness.h>
#include "common/describe.h"
#include "common/paths.h"
#include "common/seconds_since.h"

namespace vcd::library {
namespace {

using namespace tools;

using Clock = std::chrono::steady_clock;

Record look_at_one(const Asset& asset, const BatchOptions& options) {
  Record record;
  record.cost = guess_cost(asset);
  Staleness staleness;
  if (options.update) staleness = staleness_of(asset);
  else staleness.reason = "asked for";
  record.reason = staleness.reason;
  if (staleness.up_to_date()) {
    record.fate = Fate::up_to_date;
    record.outcome.baked.bytes = staleness.bytes;
    record.outcome.baked.report = std::move(staleness.report);
    record.outcome.baked.sources = std::move(staleness.dependencies);
  } else if (!options.failed_before.empty()) {
    const auto known = options.failed_before.find(failure_key(asset));
    if (known != options.failed_before.end()) record.fate = Fate::failed_before, record.outcome = known->second;
  }
  return record;
}

class Batch {
 public:
  Batch(const std::vector<Asset>& assets, std::vector<Record>& records, const BatchOptions& options,
        std::span<BatchListener* const> listeners)
      : assets_(assets),
        records_(records),
        options_(options),
        listeners_(listeners),
        jobs_(waiting_jobs()),
        schedule_(costs(), options.threads, options.memory_bytes) {}

  void run() {
    for (BatchListener* listener : listeners_) listener->started(assets_.size(), jobs_.size());
    remove_leftovers();
    while (!schedule_.idle()) {
      if (options_.stop && options_.stop()) return stop_all("interrupted");
      start_what_may();
      wait_a_little();
      if (!take_in()) return stop_all("not run: another asset failed, and --fail-fast was given");
      show();
    }
  }

 private:
  // Of earlier runs that were killed.
  void remove_leftovers() const {
    std::set<std::filesystem::path> folders;
    for (const size_t job : jobs_) folders.insert(assets_[job].output.parent_path());
    for (const std::filesystem::path& folder : folders) remove_stale_temporaries(folder);
  }

  struct Running {
    Grant grant;
    Worker worker;
  };

  std::vector<size_t> waiting_jobs() const {
    std::vector<size_t> jobs;
    for (size_t i = 0; i < records_.size(); ++i)
      if (records_[i].fate == Fate::waiting) jobs.push_back(i);
    return jobs;
  }

  std::vector<Cost> costs() const {
    std::vector<Cost> costs;
    for (const size_t job : jobs_) costs.push_back(records_[job].cost);
    return costs;
  }

  Record& record_of(const Grant& grant) { return records_[jobs_[grant.job]]; }
  const Asset& asset_of(const Grant& grant) const { return assets_[jobs_[grant.job]]; }

  void start_what_may() {
    while (const auto grant = schedule_.next()) {
      const Asset& asset = asset_of(*grant);
      Record& record = record_of(*grant);
      record.threads = grant->threads;
      ++record.attempts;
      const WorkerOptions options{grant->threads, options_.time_limit, grant->memory_bytes,
                                  options_.cache, options_.update,     options_.measure};
      for (BatchListener* listener : listeners_) listener->attempt_started(asset, *grant);
      auto worker = Worker::start(asset, options);
      if (worker) {
        running_.push_back({*grant, std::move(*worker)});
        continue;
      }
      schedule_.ended(*grant);
      record.outcome.code = static_cast<int>(worker.error().code);
      record.outcome.kind = error_kind(worker.error().code);
      record.outcome.message = worker.error().message;
      finish(*grant, Fate::failed);
    }
  }

  void wait_a_little() const {
    std::vector<pollfd> waiting;
    for (const Running& r : running_) {
      waiting.push_back({r.worker.messages(), POLLIN, 0});
      waiting.push_back({r.worker.words(), POLLIN, 0});
    }
    // A worker's pipes close a moment before it can be reaped: then there is nothing to poll, only to wait.
    const bool all_closed = std::all_of(waiting.begin(), waiting.end(), [](const pollfd& p) { return p.fd < 0; });
    ::poll(waiting.data(), waiting.size(), all_closed ? 1 : 50);
  }

  // False if the run is to stop.
  bool take_in() {
    for (auto r = running_.begin(); r != running_.end();) {
      if (!r->worker.update()) {
        ++r;
        continue;
      }
      const Grant grant = r->grant;
      Record& record = record_of(grant);
      record.outcome = r->worker.outcome();
      record.seconds = r->worker.seconds();
      record.peak_memory_bytes = r->worker.peak_memory_bytes();
      r = running_.erase(r);
      schedule_.ended(grant);
      const std::string& kind = record.outcome.kind;
      if (kind == "crash" || kind == "time" || kind == "memory")
        remove_stale_temporaries(asset_of(grant).output.parent_path());
      if (is_to_run_again(grant, record)) continue;
      finish(grant, record.outcome.ok() ? Fate::baked : Fate::failed);
      if (options_.fail_fast && !record.outcome.ok()) return false;
    }
    return true;
  }

  // What had less than all the memory may have failed for want of it; a crash too, for not all code survives that.
  bool is_to_run_again(const Grant& grant, const Record& record) {
    if (record.outcome.kind == "memory") return schedule_.again(grant, 4 * grant.memory_bytes);
    return record.outcome.kind == "crash" && record.attempts == 1 && schedule_.again(grant, options_.memory_bytes);
  }

  void finish(const Grant& grant, Fate fate) {
    const Asset& asset = asset_of(grant);
    Record& record = record_of(grant);
    record.fate = fate;
    std::error_code error;
    if (fate == Fate::failed && std::filesystem::exists(asset.output, error)) record.old_sidecar = "from before";
    ++ended_;
    for (BatchListener* listener : listeners_) listener->ended(asset, record);
    record.outcome.baked.summary.clear();  // heard; of a hundred thousand assets it would take gigabytes
  }

  void stop_all(const std::string& why) {
    schedule_.drop_waiting();
    for (Running& r : running_) {
      const std::filesystem::path folder = asset_of(r.grant).output.parent_path();
      record_of(r.grant).outcome.stage = r.worker.stage();
      { const Worker killed = std::move(r.worker); }
      remove_stale_temporaries(folder);
    }
    running_.clear();
    for (const size_t job : jobs_) {
      Record& record = records_[job];
      if (record.fate != Fate::waiting) continue;
      record.fate = Fate::not_run;
      record.outcome.code = static_cast<int>(ErrorCode::runtime);
      record.outcome.kind = "not-run";
      record.outcome.message = shown(assets_[job].input) + ": " + why;
    }
  }

  void show() {
    std::vector<BatchListener::Running> shown;
    double left = schedule_.seconds_waiting();
    for (const Running& r : running_) {
      const double cost = record_of(r.grant).cost.seconds;
      shown.push_back({&asset_of(r.grant), &r.worker, cost});
      left += cost * (1 - std::min(r.worker.seconds() * r.grant.threads / std::max(cost, 1e-3), 1.0));
    }
    done_seconds_ = total_seconds_ - left;
    const double elapsed = seconds_since(start_);
    const double seconds_left = done_seconds_ > 0 ? left * elapsed / done_seconds_ : 0;
    for (BatchListener* listener : listeners_) listener->going_on(shown, ended_, seconds_left);
  }

  const std::vector<Asset>& assets_;
  std::vector<Record>& records_;
  const BatchOptions& options_;
  std::span<BatchListener* const> listeners_;
  const std::vector<size_t> jobs_;
  Schedule schedule_;
  std::list<Running> running_;
  size_t ended_ = 0;
  const double total_seconds_ = schedule_.seconds_waiting();  // guessed
  double done_seconds_ = 0;
  Clock::time_point start_ = Clock::now();
};

}  // namespace

std::string failure_key(const Asset& asset) {
  if (has_extension(asset.input, {"gltf", "glb"})) return {};  // it may name other files
  const auto hash = baker::hash_file(asset.input);
  if (!hash) return {};
  return hex(baker::content_hash(asset.input.string() + "\n" + hex(*hash) + "\n" +
                                 settings_text(asset.settings, Scope::file) + "\n" + baker_text()));
}

std::vector<Record> look_at(const std::vector<Asset>& assets, const BatchOptions& options) {
  std::vector<Record> records(assets.size());
  std::atomic<size_t> next = 0;
  const auto look = [&] {
    for (size_t i; (i = next++) < assets.size() && !(options.stop && options.stop());)
      records[i] = look_at_one(assets[i], options);
  };
  std::vector<std::jthread> threads;
  for (unsigned t = 1; t < std::min<size_t>(options.threads, assets.size()); ++t) threads.emplace_back(look);
  look();
  return records;
}

void run_batch(const std::vector<Asset>& assets, std::vector<Record>& records, const BatchOptions& options,
               std::span<BatchListener* const> listeners) {
  Batch(assets, records, options, listeners).run();
}

}  // namespace vcd::library
