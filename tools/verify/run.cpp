#include <vcd/verify/run.h>

#include <algorithm>
#include <memory>

#include <tbb/parallel_pipeline.h>
#include <tbb/task_arena.h>

#include <vcd/baker/threads.h>

#include "common/exit_codes.h"
#include "pairing.h"

namespace vcd::verify {

using namespace baker;
using namespace tools;
using namespace library;
namespace {

// take(0), take(1), … one at a time, each after its make(i); those run side by side.
void in_order(size_t count, const std::function<void(size_t)>& make, const std::function<void(size_t)>& take) {
  using Mode = tbb::filter_mode;
  constexpr size_t kAhead = 256;  // that may wait for a slow one before them; a thread works on one alone
  size_t next = 0;
  const auto give = tbb::make_filter<void, size_t>(Mode::serial_in_order, [&](tbb::flow_control& flow) {
    if (next == count) flow.stop();
    return next == count ? count : next++;
  });
  // Isolated, so that a thread that waits within one file does not take up another: no more files are in memory than
  // there are threads.
  const auto work = tbb::make_filter<size_t, size_t>(Mode::parallel, [&](size_t i) {
    tbb::this_task_arena::isolate([&] { make(i); });
    return i;
  });
  const auto end = tbb::make_filter<size_t, void>(Mode::serial_in_order, take);
  tbb::parallel_pipeline(kAhead, give & work & end);
}

class Runner {
 public:
  Runner(const RunOptions& options, const std::function<void(Outcome&)>& tell)
      : options_(options), check_(options.check), tell_(tell) {}

  Run go() {
    std::vector<Outcome> faults;
    if (!options_.against_libraries.empty()) faults = read_libraries();
    check_sidecars();
    for (Outcome& fault : faults) add(std::move(fault));
    if (library_)
      for (Outcome& asset : compare(*library_, run_.outcomes, run_.totals.not_verified == 0)) add(std::move(asset));
    return std::move(run_);
  }

 private:
  std::vector<Outcome> read_libraries() {
    std::vector<Outcome> faults;
    std::vector<FoundFile> files;
    for (Input& input : find_inputs(options_.against_libraries, mesh_extensions(), "mesh")) {
      if (input.fault) faults.push_back(std::move(*input.fault));
      else files.push_back(std::move(input.file));
    }
    library_ = std::make_unique<Library>(std::move(files), options_.check.ingest, options_.check.stop);
    check_.library = library_.get();
    run_.totals.has_library = true;
    return faults;
  }

  void check_sidecars() {
    std::vector<Input> inputs = find_inputs(options_.inputs, kSidecarExtensions, "sidecar");
    std::vector<Outcome> made(inputs.size());
    in_order(
        inputs.size(),
        [&](size_t i) {
          made[i] = inputs[i].fault ? std::move(*inputs[i].fault) : check_sidecar(inputs[i].file, check_);
        },
        [&](size_t i) { add(std::move(made[i])); });
  }

  void add(Outcome&& outcome) {
    for (Issue& issue : outcome.issues)
      if (options_.allowed.contains(issue.info->id)) issue.severity = Severity::warning;
    run_.totals.add(outcome);
    tell_(outcome);
    run_.outcomes.push_back(std::move(outcome));
  }

  const RunOptions& options_;
  CheckOptions check_;
  const std::function<void(Outcome&)>& tell_;
  std::unique_ptr<verify::Library> library_;
  Run run_;
};

}  // namespace

int Run::exit_code() const {
  std::vector<int> codes;
  for (const Outcome& outcome : outcomes)
    if (outcome.subject != Subject::asset || outcome.failed()) codes.push_back(outcome.exit_code());
  return batch_exit_code(codes);
}

Run run(const RunOptions& options, const std::function<void(Outcome&)>& tell) {
  return with_threads(options.threads, [&] { return Runner(options, tell).go(); });
}

}  // namespace vcd::verify
