// vc-farm: a library over many machines. Cuts it into shards that any scheduler can run, runs them by Slurm, merges
// what came of them.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <map>
#include <thread>

#include <unistd.h>

#include "bake/options.h"
#include "bake/report.h"
#include "common/paths.h"
#include "common/program.h"
#include "common/progress.h"
#include "farm/command.h"
#include "farm/plan.h"
#include "farm/slurm.h"
#include "farm/this_program.h"

namespace {

namespace fs = std::filesystem;
using namespace vcd;
using namespace vcd::tools;
using namespace vcd::library;
using namespace vcd::farm;

struct Options {
  CommonOptions common;
  AssetRequest request;
  std::string plan, report;
  unsigned shards = 16, shard = 0, tries = 3;
  double poll = 10;
  SlurmOptions slurm;
  bool detach = false;
};

int fail(const Error& error) {
  print_error(error.message);
  return exit_code(error.code);
}

int make(const Options& options) {
  const auto found = collect_assets(options.request);
  if (!found) return fail(found.error());
  for (const Error& error : found->errors) print_error(error.message);
  if (!found->errors.empty()) {
    print_error("nothing is planned, because not all inputs could be read");
    return exit_code(found->errors[0].code);
  }
  const bool shares = std::ranges::any_of(found->assets, [](const Asset& a) { return a.settings.total_mb > 0; });
  if (shares && options.shards > 1)
    return fail({ErrorCode::usage, "--total-mb: assets share it within a run, and each shard is a run of its own"});
  const auto plan = make_plan(options.plan, found->assets, options.shards);
  if (!plan) return fail(plan.error());
  if (options.common.quiet) return kExitOk;
  if (options.common.format == OutputFormat::json) {
    Json shards = Json::array();
    for (const Shard& shard : plan->shards)
      shards.push_back({{"number", shard.number}, {"assets", shard.assets}, {"seconds", shard.seconds}});
    print_json(
        {{"tool", "vc-farm"}, {"version", VCD_VERSION}, {"plan", path_to_json(plan->folder)}, {"shards", shards}});
    return kExitOk;
  }
  for (const Shard& shard : plan->shards)
    std::printf("shard %u: %zu assets, about %s on one thread\n", shard.number, shard.assets,
                readable_seconds(shard.seconds).c_str());
  return kExitOk;
}

std::string this_process() {
  char host[256] = {};
  gethostname(host, sizeof host - 1);
  return host + ("-" + std::to_string(getpid()));
}

// Exit code 0 once the shard is done, whatever became of its assets: for a scheduler that is success.
int run_shard(const Options& options, const std::vector<std::string>& bake_options) {
  const auto plan = open_plan(options.plan);
  if (!plan) return fail(plan.error());
  if (options.shard < 1 || options.shard > plan->shards.size())
    return fail({ErrorCode::usage, shown(options.plan) + ": has no shard " + std::to_string(options.shard)});
  const Shard& shard = plan->shards[options.shard - 1];
  if (std::find(bake_options.begin(), bake_options.end(), "--prune") != bake_options.end())
    return fail({ErrorCode::usage, "--prune: a shard does not know the assets of the others"});
  // Its own, until it is whole: two of one shard may run at once, or this one be broken off.
  const std::string report = plan->file(shard.number, ".report").string() + "-" + this_process();
  std::vector<std::string> command = {(program_folder() / "vc-bake").string(),
                                      "--manifest",
                                      plan->file(shard.number, ".json").string(),
                                      "--resume",
                                      "--quiet",
                                      "--events",
                                      plan->file(shard.number, ".events.jsonl").string(),
                                      "--report",
                                      report};
  command.insert(command.end(), bake_options.begin(), bake_options.end());
  catch_interruptions();
  const auto code = run_command(command);
  if (!code) return fail(code.error());
  if (take_report(*plan, shard, report)) return kExitOk;
  return *code == kExitOk ? exit_code(ErrorCode::runtime) : *code;
}

struct Progress {
  size_t shards_done = 0, assets = 0, ended = 0, failed = 0;
  std::vector<unsigned> unfinished;  // shards that are not done

  void add(const Shard& shard, const ShardState& state) {
    shards_done += state.done;
    assets += shard.assets;
    ended += std::min(state.ended, shard.assets);
    failed += state.failed;
    if (!state.done) unfinished.push_back(shard.number);
  }
};

std::string readable(const FarmPlan& plan, const Progress& s) {
  return std::to_string(s.shards_done) + "/" + std::to_string(plan.shards.size()) + " shards, " +
         std::to_string(s.ended) + "/" + std::to_string(s.assets) + " assets" +
         (s.failed ? ", " + std::to_string(s.failed) + " failed" : "");
}

int show_status(const Options& options) {
  const auto plan = open_plan(options.plan);
  if (!plan) return fail(plan.error());
  Json shards = Json::array();
  Progress progress;
  for (const Shard& shard : plan->shards) {
    const ShardState state = state_of(*plan, shard);
    progress.add(shard, state);
    const char* const word = state.done ? "done" : state.started ? "begun" : "not begun";
    shards.push_back({{"number", shard.number},
                      {"state", word},
                      {"assets", shard.assets},
                      {"ended", state.ended},
                      {"failed", state.failed}});
    if (options.common.format == OutputFormat::text)
      std::printf("shard %u: %s, %zu of %zu assets ended, %zu failed\n", shard.number, word, state.ended, shard.assets,
                  state.failed);
  }
  if (options.common.format == OutputFormat::json)
    print_json({{"tool", "vc-farm"}, {"version", VCD_VERSION}, {"shards", shards}});
  else std::printf("%s\n", readable(*plan, progress).c_str());
  return kExitOk;
}

int merge(const FarmPlan& plan, const Options& options) {
  const Json report = merged_report(plan);
  const std::string name = options.report.empty() ? (plan.folder / "report").string() : options.report;
  const fs::path place = place_of(name);
  const std::string file = place.filename().string();
  if (place.parent_path() == place_of(plan.folder / "plan").parent_path() &&
      (file == "plan" || file.starts_with("shard-")))
    return fail({ErrorCode::usage, shown(name) + ": would replace a part of the plan"});
  if (const auto fault = write_report(name, report)) return fail(*fault);
  if (options.common.format == OutputFormat::json) print_json(report);
  const Json& totals = report["totals"];
  const auto count = [&](const char* key) { return totals.value(key, size_t{0}); };
  if (!options.common.quiet && options.common.format == OutputFormat::text)
    std::printf("%zu baked, %zu up to date, %zu failed, %zu not run; %s.html\n", count("baked"), count("up_to_date"),
                count("failed") + count("failed_before"), count("not_run"), shown(name).c_str());
  if (count("not_run") > 0)
    return print_error(std::to_string(count("not_run")) + " assets are of shards that are not done"),
           exit_code(ErrorCode::runtime);
  return count("failed") + count("failed_before") + report["errors"].size() > 0 ? kExitBatch : kExitOk;
}

// Submits what is neither done nor queued, follows it, and submits again what a node lost.
class SlurmRun {
 public:
  SlurmRun(const FarmPlan& plan, Slurm& slurm, const Options& options)
      : plan_(plan), slurm_(slurm), options_(options), line_("", options.common.quiet) {}

  int run() {
    catch_interruptions();
    for (; !interrupted(); std::this_thread::sleep_for(std::chrono::duration<double>(options_.poll))) {
      const auto queue = slurm_.queue();
      const Progress progress = look();  // after the queue: what left it has written its report
      if (progress.unfinished.empty()) break;
      if (!queue) {
        note_once(queue.error().message);
        continue;
      }
      if (!queue->held.empty())
        note_once(std::to_string(queue->held.size()) + " shards are held by Slurm: scontrol release lets them go");
      const std::vector<unsigned> lost = lost_ones(progress.unfinished, queue->shards);
      if (auto fault = submit(lost)) return fail(*fault);
      if (options_.detach) return kExitOk;
      line_.show(readable(plan_, progress) + ", " + std::to_string(queue->shards.size()) + " shards in Slurm's queue");
    }
    line_.wipe();
    if (!interrupted()) return merge(plan_, options_);
    print_error("interrupted; what is submitted goes on. The same command follows it again, scancel ends it");
    return exit_code(ErrorCode::runtime);
  }

 private:
  // Shards that are neither done nor queued. A report may take a moment to be seen from here, on a folder that is
  // shared: only what is missing twice since it was submitted is lost.
  std::vector<unsigned> lost_ones(const std::vector<unsigned>& unfinished, const std::set<unsigned>& queued) {
    std::vector<unsigned> lost;
    std::set<unsigned> missing;
    for (const unsigned shard : unfinished) {
      if (queued.contains(shard)) continue;
      if (submitted_.empty() || missing_.contains(shard)) lost.push_back(shard);
      else missing.insert(shard);
    }
    missing_ = std::move(missing);
    return lost;
  }

  // Reports of shards that are done are read once.
  Progress look() {
    Progress progress;
    for (const Shard& shard : plan_.shards) {
      ShardState& state = states_[shard.number];
      if (!state.done) state = state_of(plan_, shard);
      progress.add(shard, state);
    }
    return progress;
  }

  std::optional<Error> submit(const std::vector<unsigned>& shards) {
    if (shards.empty()) return std::nullopt;
    for (const unsigned shard : shards)
      if (++submitted_[shard] > options_.tries)
        return Error{ErrorCode::runtime, "shard " + std::to_string(shard) + " was submitted " +
                                             std::to_string(options_.tries) + " times and is not done; see " +
                                             shown(plan_.folder / "slurm-*.out")};
    if (auto fault = slurm_.submit(shards, options_.slurm)) return fault;
    if (!options_.common.quiet) print_note(std::to_string(shards.size()) + " shards submitted");
    return std::nullopt;
  }

  void note_once(const std::string& text) {
    if (text != noted_) print_note(text);
    noted_ = text;
  }

  const FarmPlan& plan_;
  Slurm& slurm_;
  const Options& options_;
  ProgressLine line_;
  std::map<unsigned, ShardState> states_;
  std::map<unsigned, unsigned> submitted_;  // how often
  std::set<unsigned> missing_;              // when the queue was last looked at
  std::string noted_;
};

template <class Body>
int with_plan(const Options& options, Body body) {
  const auto plan = open_plan(options.plan);
  return plan ? body(*plan) : fail(plan.error());
}

int run_slurm(const Options& options) {
  return with_plan(options, [&](const FarmPlan& plan) {
    auto slurm = Slurm::find(plan);
    return slurm ? SlurmRun(plan, *slurm, options).run() : fail(slurm.error());
  });
}

struct Commands {
  CLI::App *plan, *run, *status, *slurm, *merge;
};

CLI::App* add_command(CLI::App& app, Options& options, const char* name, const char* description) {
  CLI::App* const command = app.add_subcommand(name, description);
  command->add_option("plan", options.plan, "Folder of the plan")->required()->type_name("PLAN");
  return command;
}

void add_plan_options(CLI::App& command, Options& options) {
  add_asset_request(command, options.request);
  command.add_option("--shards", options.shards, "How many, at the most (default: 16)")
      ->check(CLI::Range(1u, 1000000u));
  add_settings(command, options.request.settings);
}

void add_slurm_options(CLI::App& command, Options& options) {
  const auto pass_on = [&](const char* name, std::vector<std::string>& to, const char* description) {
    command.add_option(name, to, description)->type_name("OPTION")->expected(1)->take_all();
  };
  pass_on("--bake", options.slurm.bake, "An option for vc-bake, such as --bake=--cache=DIR; any number of them");
  pass_on("--sbatch", options.slurm.arguments,
          "An option for sbatch, such as --sbatch=--partition=night; any number of them");
  command.add_option("--threads", options.slurm.threads, "Processors that each shard asks for and uses (default: 1)")
      ->check(CLI::Range(1u, 1024u));
  command.add_option("--tries", options.tries, "How often a shard is submitted, at the most (default: 3)")
      ->check(CLI::Range(1u, 1000u));
  command.add_option("--poll", options.poll, "Seconds between questions to Slurm (default: 10)")
      ->check(NumberRange(0.1, 3600.0));
  command.add_flag("--detach", options.detach, "Submit the shards and exit; do not wait for them");
}

Commands add_commands(CLI::App& app, Options& options) {
  app.require_subcommand(1);
  const Commands commands{
      add_command(app, options, "plan", "Cut a library into shards"),
      add_command(app, options, "run",
                  "Bake one shard; what follows its number goes to vc-bake. Started again, it goes on where it was"),
      add_command(app, options, "status", "Show how far the shards are"),
      add_command(app, options, "slurm",
                  "Submit the shards that are not done to Slurm, follow them, submit again those that a node lost, "
                  "and merge"),
      add_command(app, options, "merge", "Make one report of all shards")};
  add_plan_options(*commands.plan, options);
  commands.run->add_option("shard", options.shard, "Its number, from 1")->required()->type_name("NUMBER");
  commands.run->prefix_command();
  add_slurm_options(*commands.slurm, options);
  for (CLI::App* const command : {commands.slurm, commands.merge})
    command->add_option("--report", options.report, "Write NAME.json and NAME.html (default: PLAN/report)")
        ->type_name("NAME");
  for (CLI::App* const command : {commands.plan, commands.run, commands.status, commands.slurm, commands.merge})
    add_common_options(*command, options.common);
  add_common_options(app, options.common);
  return commands;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{
      "Bakes a library on many machines. `plan` cuts it into shards of equal cost, in a folder that all of them reach; "
      "`run`\n"
      "bakes one shard, started by any scheduler; `slurm` has Slurm run them all; `merge` makes one report."};
  const Commands commands = add_commands(app, options);
  return run_program(app, argc, argv, [&] {
    if (*commands.plan) return make(options);
    if (*commands.run) return run_shard(options, commands.run->remaining());
    if (*commands.status) return show_status(options);
    if (*commands.merge) return with_plan(options, [&](const FarmPlan& p) { return merge(p, options); });
    return run_slurm(options);
  });
}
