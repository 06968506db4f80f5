// vc-bake: mesh files in, .vcd sidecars out.
#include <array>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <map>

#include <vcd/library/assets.h>
#include <vcd/library/batch.h>
#include <vcd/library/prune.h>
#include <vcd/library/share_total.h>
#include "bake/attach.h"
#include "bake/console.h"
#include "bake/depfile.h"
#include "bake/events.h"
#include "bake/options.h"
#include "bake/report.h"
#include "common/health_report.h"
#include "common/limits.h"
#include "common/meshes.h"
#include "common/paths.h"
#include "common/plan_report.h"
#include "common/program.h"
#include "common/readable.h"
#include "common/seconds_since.h"

namespace {

namespace fs = std::filesystem;
using namespace vcd;
using namespace vcd::baker;
using namespace vcd::tools;
using namespace vcd::library;

struct Options {
  CommonOptions common;
  AssetRequest request;
  unsigned threads = 0;
  double memory_mb = 0;
  double time_limit = 14400;
  bool plan_only = false, update = false, resume = false, fail_fast = false, dry_run = false, prune = false,
       verbose = false;
  std::string cache, report, events, depfile, depfile_target;
  AttachRequest attach;
};

unsigned threads_of(const Options& options) { return options.threads ? options.threads : available_processors(); }

BatchOptions batch_options(const Options& options) {
  BatchOptions batch;
  batch.threads = threads_of(options);
  const uint64_t free = available_memory();
  batch.memory_bytes = options.memory_mb > 0 ? static_cast<uint64_t>(options.memory_mb * 1048576)
                       : free > 0            ? free / 5 * 4
                                             : uint64_t{1} << 40;
  batch.time_limit = options.time_limit;
  batch.cache = options.cache;
  batch.update = options.update || options.resume;
  batch.fail_fast = options.fail_fast;
  if (options.resume) batch.failed_before = earlier_failures(options.events);
  batch.stop = interrupted;
  return batch;
}

void print_dry_run(const std::vector<Asset>& assets, const std::vector<Record>& records, const RunReport& run) {
  double seconds = 0;
  for (size_t i = 0; i < assets.size(); ++i) {
    const bool is_waiting = records[i].fate == Fate::waiting;
    std::printf(
        "%-10s %s -> %s (%s)\n", is_waiting ? "bake" : fate_name(records[i].fate), shown(assets[i].input).c_str(),
        shown(assets[i].output).c_str(),
        is_waiting
            ? (records[i].reason + ", about " + readable_seconds(records[i].cost.seconds) + " on one thread").c_str()
            : "nothing to do");
    seconds += is_waiting ? records[i].cost.seconds : 0;
  }
  for (const fs::path& orphan : run.pruned) std::printf("%-10s %s\n", "remove", shown(orphan).c_str());
  std::printf("about %s on one thread, guessed from the sizes of the files\n", readable_seconds(seconds).c_str());
}

void print_totals(const Totals& t, const RunReport& run) {
  std::string line = std::to_string(t.baked) + " baked, " + std::to_string(t.up_to_date) + " up to date, " +
                     std::to_string(t.failed + run.errors.size()) + " failed";
  if (t.failed_before) line += ", " + std::to_string(t.failed_before) + " failed before and not tried again";
  if (t.not_run) line += ", " + std::to_string(t.not_run) + " not run";
  if (!run.pruned.empty()) line += ", " + std::to_string(run.pruned.size()) + " orphans removed";
  std::printf("%s; %s of sidecars, %s\n", line.c_str(), readable_bytes(t.bytes).c_str(),
              readable_seconds(run.seconds).c_str());
}

// Orphans go only where everything was found: an input that could not be read may be what they belong to.
std::vector<fs::path> prune(const Options& options, const Assets& assets) {
  if (!options.prune) return {};
  if (!assets.errors.empty()) {
    print_note("--prune: nothing is removed, because not all inputs could be read");
    return {};
  }
  if (!assets.empty_folders.empty()) {
    print_note("--prune: nothing is removed, because no mesh is below " + shown(assets.empty_folders[0]));
    return {};
  }
  std::vector<fs::path> orphans = find_orphans(assets);
  std::error_code error;
  for (const fs::path& orphan : orphans)
    if (!options.dry_run && !fs::remove(orphan, error))
      print_error(shown(orphan) + ": cannot be removed: " + error.message());
  return orphans;
}

// What is written beside the sidecars must replace none of them, no mesh, no manifest, and not each other.
std::optional<Error> check_written(const Options& options, const std::vector<Asset>& assets) {
  std::map<fs::path, const char*> taken;
  for (const std::string& manifest : options.request.manifests) taken.emplace(place_of(manifest), "a manifest");
  for (const Asset& asset : assets) {
    taken.emplace(place_of(asset.output), "a sidecar");
    if (!asset.settings.demand.path.empty()) taken.emplace(place_of(asset.settings.demand.path), "a demand");
  }
  std::vector<std::string> written;
  if (options.events != "-") written.push_back(options.events);
  written.push_back(options.depfile);
  if (!options.report.empty()) written.insert(written.end(), {options.report + ".json", options.report + ".html"});
  for (const std::string& path : written) {
    if (path.empty()) continue;
    const auto [known, is_free] = taken.emplace(place_of(path), "what else this run writes");
    if (!is_free || !may_be_written(path))
      return Error{ErrorCode::usage,
                   shown(path) + ": would replace " + (is_free ? "a mesh or a sidecar" : known->second)};
  }
  return std::nullopt;
}

int fail(const Error& error) {
  print_error(error.message);
  return exit_code(error.code);
}

// The files of the run beside the sidecars, once it has ended. The codes of those that cannot be written.
std::vector<int> write_files(const Options& options, const std::vector<Asset>& assets,
                             const std::vector<Record>& records, const RunReport& run) {
  std::vector<int> codes;
  const auto note = [&](const std::optional<Error>& fault) {
    if (fault) codes.push_back(fail(*fault));
  };
  if (!options.depfile.empty() && records[0].ok()) {
    std::vector<fs::path> files = {assets[0].input};
    if (const fs::path& demand = assets[0].settings.demand.path; !demand.empty()) files.push_back(demand);
    for (const fs::path& source : records[0].outcome.baked.sources)
      files.push_back(assets[0].input.parent_path() / source);
    note(write_depfile(options.depfile,
                       options.depfile_target.empty() ? assets[0].output : fs::path(options.depfile_target), files));
  }
  if (!options.attach.to.empty() && !options.dry_run && records[0].ok())
    note(write_attached(options.attach, assets[0]));
  const bool as_json = options.common.format == OutputFormat::json;
  if (!as_json && options.report.empty()) return codes;
  const Json report = report_json(assets, records, run);
  if (as_json) print_json(report);
  if (!options.report.empty()) note(write_report(options.report, report));
  return codes;
}

// Bakes what is to be baked, or with --dry-run only finds out what that is. Error: the events' file cannot be opened.
Result<std::vector<Record>> bake(const Options& options, std::vector<Asset>& assets, bool& events_are_whole) {
  const BatchOptions batch = batch_options(options);
  auto events = Events::open(options.dry_run ? "" : options.events, options.resume);
  if (!events) return events.error();
  std::vector<Record> records = look_at(assets, batch);
  if (options.dry_run) return records;
  const auto start = std::chrono::steady_clock::now();
  events->say({{"event", "run-started"},
               {"tool", "vc-bake"},
               {"version", VCD_VERSION},
               {"assets", assets.size()},
               {"up_to_date", totals_of(records).up_to_date}});
  const auto console = make_console(options.common, options.verbose);
  const std::array<BatchListener*, 2> listeners{&*events, console.get()};
  share_totals(assets, records, batch, listeners);
  run_batch(assets, records, batch, listeners);
  const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
  events->say({{"event", "run-ended"}, {"totals", totals_json(totals_of(records))}, {"seconds", seconds.count()}});
  events_are_whole = !events->failed();
  return records;
}

// The exit code of each input and each asset.
std::vector<int> codes_of(const std::vector<Error>& errors, const std::vector<Record>& records) {
  std::vector<int> codes;
  for (const Error& error : errors) codes.push_back(exit_code(error.code));
  for (const Record& record : records) codes.push_back(record.outcome.code);
  return codes;
}

int run(const Options& options) {
  const auto start = std::chrono::steady_clock::now();
  catch_interruptions();
  auto found = collect_assets(options.request);
  if (!found) return fail(found.error());
  std::vector<Asset>& assets = found->assets;
  if (!options.depfile.empty() && assets.size() != 1) return fail({ErrorCode::usage, "--depfile is for one asset"});
  if (const auto fault = check_written(options, assets)) return fail(*fault);
  if (!options.attach.to.empty()) {
    if (assets.size() != 1) return fail({ErrorCode::usage, "--attach is for one asset"});
    if (const auto fault = check_attach(options.attach, assets[0])) return fail(*fault);
  }
  if (assets.empty() && found->errors.empty()) found->errors.push_back({ErrorCode::io, "no mesh file found"});
  for (const Error& error : found->errors) print_error(error.message);

  bool events_are_whole = true;
  const auto records = bake(options, assets, events_are_whole);
  if (!records) return fail(records.error());
  RunReport run{found->errors, interrupted() ? std::vector<fs::path>{} : prune(options, *found), found->other_files,
                found->named_again};
  run.seconds = seconds_since(start);
  run.dry_run = options.dry_run;
  for (const Record& record : *records)
    if (record.fate == Fate::not_run) print_error(record.outcome.message);
  if (interrupted()) print_error("interrupted");
  std::vector<int> codes = codes_of(run.errors, *records);
  if (!events_are_whole)
    codes.push_back(fail({ErrorCode::io, shown(options.events) + ": not all events could be written"}));
  for (const int code : write_files(options, assets, *records, run)) codes.push_back(code);
  if (options.common.quiet || options.common.format == OutputFormat::json) return batch_exit_code(codes);
  if (options.dry_run) print_dry_run(assets, *records, run);
  else if (assets.size() > 1) print_totals(totals_of(*records), run);
  return batch_exit_code(codes);
}

// --plan of one object. Its part of the report; `code` is set where it fails.
Json plan_object(const Options& options, const Asset& asset, const PreparedMesh& mesh, int& code) {
  const std::string name = printable(mesh.name);
  BakeOptions bake_options = asset.settings.bake_options();
  bake_options.threads = threads_of(options);
  bake_options.stop = interrupted;
  const auto planned = plan(mesh, bake_options);
  if (!planned) {
    const std::string message = shown(asset.input) + ": " + planned.error().message;
    code = fail({planned.error().code, message});
    return {{"source_index", mesh.source_index}, {"name", name}, {"error", message}, {"exit_code", code}};
  }
  if (options.common.format == OutputFormat::text) {
    std::printf("%s: object %u %s, %zu triangles\n", shown(asset.input).c_str(), mesh.source_index, name.c_str(),
                mesh.triangles.size());
    std::fputs(health_summary(planned->health).c_str(), stdout);
    if (planned->proofs) std::fputs(proofs_summary(*planned->proofs).c_str(), stdout);
    print_plan(*planned);
  }
  return {{"source_index", mesh.source_index},
          {"name", mesh.name},
          {"triangle_count", mesh.triangles.size()},
          {"surface", describe_health(planned->health)},
          {"proofs", planned->proofs ? describe_proofs(*planned->proofs) : Json()},
          {"plan", describe_plan(*planned)}};
}

// --plan: forecasts, no files.
int run_plan(const Options& options) {
  if (options.request.settings.for_a_demand())
    return fail({ErrorCode::usage, "--plan forecasts no bake for a demand: it is as deep as pays by itself"});
  catch_interruptions();
  const auto found = collect_assets(options.request);
  if (!found) return fail(found.error());
  std::vector<int> codes;
  Json all = Json::array();
  const auto add_failed = [&](const fs::path& input, const Error& error) {
    codes.push_back(fail(error));
    all.push_back({{"input", path_to_json(input)}, {"error", error.message}, {"exit_code", codes.back()}});
  };
  for (const Error& error : found->errors) add_failed("", error);
  for (const Asset& asset : found->assets) {
    auto file = MeshFile::read(asset.input, asset.settings.ingest_options());
    if (!file) {
      add_failed(asset.input, file.error());
      continue;
    }
    Json objects = Json::array();
    int code = kExitOk;
    while (const auto mesh = file->next()) objects.push_back(plan_object(options, asset, *mesh, code));
    if (const auto unusable = file->fault()) {
      add_failed(asset.input, *unusable);
      continue;
    }
    if (!options.common.quiet)
      for (const std::string& note : file->notes()) print_note(shown(asset.input) + ": " + note);
    codes.push_back(code);
    all.push_back({{"input", path_to_json(asset.input)}, {"objects", objects}});
  }
  if (options.common.format == OutputFormat::json)
    print_json({{"tool", "vc-bake"}, {"version", VCD_VERSION}, {"files", all}});
  return batch_exit_code(codes);
}

void add_run_options(CLI::App& app, Options& options) {
  app.add_option("-j,--threads", options.threads,
                 "Threads, for all assets together; 0: all (default). The results do not depend on it")
      ->check(CLI::Range(0, 1024));
  app.add_option("--memory-mb", options.memory_mb,
                 "MiB that all processes together may take (default: four fifths of what is free, in a container or a "
                 "Slurm\njob of "
                 "what that allows)")
      ->check(NumberRange(256.0, 1e9));
  app.add_option("--time-limit", options.time_limit,
                 "Seconds that one asset may take before it is given up; 0: no limit (default: 14400)")
      ->check(NumberRange(0.0, 1e9));
  app.add_flag(
      "--update", options.update,
      "Leave sidecars alone that are up to date: same content, settings and baker. Times of files do not count");
  app.add_flag("--resume", options.resume,
               "Go on with a run that was killed: as --update, and assets that failed according to its --events are "
               "not tried again");
  app.add_flag("--fail-fast", options.fail_fast, "Stop when an asset fails (default: the others are baked)");
  app.add_flag("-v,--verbose", options.verbose, "Print the whole summary of each asset, not one line");
  app.add_flag("--dry-run", options.dry_run, "Only say what would be baked, and why");
  app.add_flag(
      "--prune", options.prune,
      "Remove sidecars without an asset: below -o or the manifest's output, else below the folders that are inputs");
  app.add_option("--cache", options.cache,
                 "Folder of baked objects, found by their geometry and settings; may be shared")
      ->type_name("DIR");
  app.add_option("--report", options.report, "Write the results of the run to NAME.json and, as a page, to NAME.html")
      ->type_name("NAME");
  app.add_option("--events", options.events,
                 "Write each event as it happens, a JSON object a line; -: to standard output")
      ->type_name("FILE");
  auto* const attach =
      app.add_option("--attach", options.attach.to,
                     "Write one asset's mesh file again, to this file beside it, with its sidecar as an attribute: the "
                     "extension\nVCD_visibility of glTF meshes, a comment in PLY and OBJ")
          ->type_name("FILE");
  app.add_flag("--embed", options.attach.embed, "The sidecar itself, as a buffer view, and not its name; glTF only")
      ->needs(attach);
  auto* const depfile =
      app.add_option(
             "--depfile", options.depfile,
             "For Make and Ninja: write which files one asset's sidecar depends on. Names that they would misread "
             "stand\nthere as links, FILE.links/1 and so on")
          ->type_name("FILE");
  app.add_option("--depfile-target", options.depfile_target,
                 "What the dependency file names as depending on them (default: the sidecar)")
      ->type_name("NAME")
      ->needs(depfile);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{
      "Bakes visibility sidecars. For each mesh file it writes a .vcd file, which says of the lines through an "
      "object's box\n"
      "which are blocked by the object and which are clear."};
  add_asset_request(app, options.request);
  CLI::Option* plan =
      app.add_flag("--plan", options.plan_only, "Only forecast what each depth would cost and be worth; bake nothing");
  add_settings(app, options.request.settings);
  add_run_options(app, options);
  plan->excludes(app.get_option("--attach"));
  add_common_options(app, options.common);
  return run_program(app, argc, argv, [&] {
    if (options.request.inputs.empty() && options.request.manifests.empty()) {
      print_error("no mesh given; try --help");
      return exit_code(ErrorCode::usage);
    }
    return options.plan_only ? run_plan(options) : run(options);
  });
}
