#include "console.h"

#include <cstdio>

#include "common/paths.h"
#include "common/progress.h"

namespace vcd::tools {

using namespace library;
namespace {

std::string of(const BatchListener::Running& running) {
  const Worker& worker = *running.worker;
  const bool is_baking = worker.fraction() > 0;
  return shown(running.asset->input.filename()) + " " +
         (is_baking ? readable_percent(worker.fraction()) : worker.stage());
}

class Console : public BatchListener {
 public:
  Console(const CommonOptions& options, bool verbose)
      : options_(options), verbose_(verbose), line_("", options.quiet) {}

  void started(size_t assets, size_t to_bake) override { assets_ = assets, to_bake_ = to_bake; }

  void attempt_started(const Asset&, const Grant&) override {}

  void going_on(const std::vector<Running>& running, size_t ended, double seconds_left) override {
    if (running.empty()) return;
    if (to_bake_ == 1) return line_.show(of_one(running[0]));
    std::string text = std::to_string(ended) + "/" + std::to_string(to_bake_);
    if (failed_ > 0) text += ", " + std::to_string(failed_) + " failed";
    if (ended > 0) text += ", " + readable_seconds(seconds_left) + " left";
    for (const Running& r : running) text += " | " + of(r);
    line_.show(text);
  }

  void ended(const Asset& asset, const Record& record) override {
    line_.wipe();
    failed_ += !record.ok();
    if (!record.ok()) return print_error(record.outcome.message);
    if (options_.quiet || options_.format == OutputFormat::json) return;
    const BakedAsset& baked = record.outcome.baked;
    for (const std::string& note : baked.notes) print_note(shown(asset.input) + ": " + note);
    if (assets_ == 1 || verbose_) {
      std::fputs(baked.summary.c_str(), stdout);
    } else {
      std::printf("%s -> %s, %s, %s\n", shown(asset.input).c_str(), shown(asset.output).c_str(),
                  readable_bytes(baked.bytes).c_str(), readable_seconds(record.seconds).c_str());
    }
    std::fflush(stdout);
  }

 private:
  static std::string of_one(const Running& running) {
    const Worker& worker = *running.worker;
    if (worker.bake_seconds() <= 0 || worker.fraction() <= 0) return of(running);
    std::string text = of(running) + ", " + readable_count(worker.rays() / worker.bake_seconds()) + " rays/s";
    if (worker.fraction() > 0.005)
      text += ", " + readable_seconds(worker.bake_seconds() / worker.fraction() - worker.bake_seconds()) + " left";
    return text;
  }

  CommonOptions options_;
  bool verbose_;
  ProgressLine line_;
  size_t assets_ = 0, to_bake_ = 0, failed_ = 0;
};

}  // namespace

std::unique_ptr<BatchListener> make_console(const CommonOptions& options, bool verbose) {
  return std::make_unique<Console>(options, verbose);
}

}  // namespace vcd::tools
