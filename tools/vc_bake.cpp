// vc-bake: mesh files in, .vcd sidecars out.
#include <cstdio>
#include <filesystem>
#include <set>

#include <vcd/baker/bake.h>
#include <vcd/baker/ingest.h>
#include <vcd/format/writer.h>
#include <vcd/runtime/sidecar.h>

#include "common/audit_report.h"
#include "common/describe.h"
#include "common/method_options.h"
#include "common/program.h"
#include "common/progress.h"

namespace {

namespace fs = std::filesystem;
using namespace vcd;

struct Options {
  CommonOptions common;
  std::vector<std::string> inputs;
  std::string output;
  BakeOptions bake;
  IngestOptions ingest;
  AuditOptions audit;
  std::string depth = "auto";
  double budget_mb = 0;
  bool plan_only = false;
  Storage storage = Storage::raw;
};

struct BakedMesh {
  BakedObject object;
  uint64_t duplicate_triangles, zero_area_triangles;  // dropped while welding
};

struct BakedFile {
  fs::path output;
  uint64_t bytes = 0;
  std::vector<BakedMesh> meshes;
  std::vector<std::string> notes;
};

fs::path output_of(const Options& options, const fs::path& input) {
  if (options.output.empty()) return fs::path(input) += ".vcd";
  if (options.inputs.size() == 1 && !fs::is_directory(options.output) && options.output.back() != '/')
    return options.output;
  return (fs::path(options.output) / input.filename()) += ".vcd";
}

// Asks the very bytes of the object's sidecar, through the runtime, and writes what came of it into the record. An error
// if a proof is wrong: then nothing may be written.
std::optional<Error> audit_object(const Options& options, const PreparedMesh& mesh, BakedObject& object) {
  if (options.audit.lines == 0 || object.record.method == static_cast<uint8_t>(Method::none)) return std::nullopt;
  SidecarToWrite alone;
  alone.objects = {object.to_write()};
  const auto bytes = sidecar_bytes(alone);
  if (!bytes) return bytes.error();
  const Bytes file(bytes->data.get(), bytes->size);
  const auto all = Sidecar::open_buffer(file), proven = Sidecar::open_buffer(file, {.proven_only = true});
  if (!all || !proven) return all ? proven.error() : all.error();
  const AuditReport report = audit(mesh, answers_of(all->object(0)), answers_of(proven->object(0)), options.audit);
  const AuditCounts undirected = report.sum(false), aimed = report.sum(true);
  if (undirected.wrong_proven + aimed.wrong_proven > 0) {
    std::string segments;
    for (const Contradiction& c : report.contradictions)
      if (c.proven) segments += " --segment=" + replayable(c.segment);
    return Error{ErrorCode::difference, "an audit found " + std::to_string(undirected.wrong_proven + aimed.wrong_proven) +
                                            " wrong proven answers, so nothing is written. This is a fault of vcd, please report it:" + segments};
  }
  ObjectRecord& record = object.record;
  record.audit_lines[0] = undirected.segments, record.audit_lines[1] = aimed.segments;
  record.audit_wrong[0] = undirected.all_wrong(), record.audit_wrong[1] = aimed.all_wrong();
  record.audit_bound_95 = static_cast<float>(upper_bound_95(undirected.all_wrong(), undirected.segments));
  return std::nullopt;
}

Result<BakedMesh> bake_one(const Options& options, const fs::path& input, SourceMesh&& mesh) {
  ProgressLine line(input.filename().string() + (mesh.name.empty() ? "" : " " + printable(mesh.name)),
                    options.common.quiet);
  BakeOptions bake_options = options.bake;
  bake_options.progress = [&](const BakeProgress& progress) { line.update(progress); };
  bake_options.stop = interrupted;
  const auto prepared = prepare(std::move(mesh));
  if (!prepared) return Error{prepared.error().code, input.string() + ": " + prepared.error().message};
  auto baked = bake(*prepared, bake_options);
  if (interrupted()) return Error{ErrorCode::runtime, input.string() + ": interrupted"};
  if (!baked) return Error{baked.error().code, input.string() + ": " + baked.error().message};
  if (const auto fault = audit_object(options, *prepared, *baked))
    return Error{fault->code, input.string() + ": " + printable(prepared->name) + ": " + fault->message};
  return BakedMesh{std::move(*baked), prepared->duplicate_triangles, prepared->zero_area_triangles};
}

Result<BakedFile> bake_file(const Options& options, const fs::path& input) {
  BakedFile file;
  file.output = output_of(options, input);
  auto ingested = ingest_isolated(input, options.ingest);
  if (!ingested) return ingested.error();
  file.notes = std::move(ingested->notes);

  SidecarToWrite sidecar;
  sidecar.storage = options.storage;
  sidecar.provenance = {{"baker", "vc-bake " VCD_VERSION},
                        {"parts", options.ingest.treat_all_as_opaque ? "all, as opaque" : "opaque"},
                        {"source", input.filename().string()}};
  const bool only_one = ingested->meshes.size() == 1;
  for (SourceMesh& mesh : ingested->meshes) {
    auto baked = bake_one(options, input, std::move(mesh));
    const bool unusable = !baked && (baked.error().code == ErrorCode::invalid_file || baked.error().code == ErrorCode::unsupported);
    if (unusable && !only_one) {  // no area, no box: the file's other meshes are none the worse
      file.notes.push_back(baked.error().message + "; left out");
      continue;
    }
    if (!baked) return baked.error();
    file.meshes.push_back(std::move(*baked));
  }
  if (file.meshes.empty()) return Error{ErrorCode::invalid_file, input.string() + ": none of its meshes can be baked"};
  sidecar.stop = interrupted;
  for (const BakedMesh& mesh : file.meshes) sidecar.objects.push_back(mesh.object.to_write());
  auto written = write_sidecar(file.output, sidecar);
  if (!written) return written.error();
  file.bytes = *written;
  return file;
}

Json describe_plan(const Plan& plan) {
  Json json{{"depth", plan.depth}, {"worth_it", plan.depth > 0}, {"reason", plan.reason}, {"probe_seconds", plan.seconds}};
  json["forecasts"] = Json::array();
  for (const DepthForecast& f : plan.forecasts)
    json["forecasts"].push_back({{"depth", f.depth}, {"bytes", f.bytes}, {"seconds", f.seconds}, {"resolved", f.resolved},
                                 {"resolved_shadow", f.resolved_shadow}, {"gain", f.gain}});
  return json;
}

void print_plan(const Plan& plan) {
  std::printf("  %-6s %12s %12s %10s %16s %6s\n", "depth", "tree", "bake", "resolved", "of shadow rays", "gain");
  for (const DepthForecast& f : plan.forecasts)
    std::printf("%c %-6u %12s %12s %8.1f %% %14.1f %% %6.2f\n", f.depth == plan.depth ? '*' : ' ', f.depth, readable_bytes(f.bytes).c_str(),
                readable_seconds(f.seconds).c_str(), 100 * f.resolved, 100 * f.resolved_shadow, f.gain);
  std::printf("  %s: %s (probed in %s)\n", plan.depth ? ("depth " + std::to_string(plan.depth)).c_str() : "not worth it",
              plan.reason.c_str(), readable_seconds(plan.seconds).c_str());
}

// What was forecast beside what came.
void print_outcome(const BakedObject& object) {
  const Plan& plan = *object.plan;
  if (plan.depth == 0) return void(std::printf("  plan      not worth it: %s\n", plan.reason.c_str()));
  const DepthForecast& f = plan.forecasts[plan.depth - 1];
  const double unclassified = static_cast<double>(object.record.cells[2]) / static_cast<double>(tree_shape(object.record.depth).cells());
  std::printf("  plan      depth %u, %s; forecast and outcome: %s and %s, %s and %s, %.1f and %.1f %% resolved\n", plan.depth,
              plan.reason.c_str(), readable_bytes(f.bytes).c_str(), readable_bytes(object.bytes_before_demotion).c_str(),
              readable_seconds(f.seconds).c_str(), readable_seconds(object.seconds).c_str(), 100 * f.resolved, 100 * (1 - unclassified));
  std::printf("  expected  %.1f %% of shadow rays that pierce the box answered, traced %.2f times faster one by one\n", 100 * f.resolved_shadow, f.gain);
}

Json report(const fs::path& input, const BakedFile& file) {
  Json json{{"input", input.string()}, {"output", file.output.string()}, {"bytes", file.bytes}};
  json["notes"] = file.notes;
  json["objects"] = Json::array();
  for (const auto& [object, duplicates, zero_areas] : file.meshes) {
    Json entry = describe_object({&object.record, object.name, object.tree(), object.to_write().geometry});
    entry["duplicate_triangles"] = duplicates;
    entry["zero_area_triangles"] = zero_areas;
    entry["plan"] = object.plan ? describe_plan(*object.plan) : Json(nullptr);
    entry["bytes_before_demotion"] = object.bytes_before_demotion;
    entry["cells_demoted"] = object.cells_demoted;
    entry["out_of_time"] = object.out_of_time;
    entry["rays"] = object.rays;
    entry["seconds"] = object.seconds;
    json["objects"].push_back(entry);
  }
  return json;
}

void print_summary(const fs::path& input, const BakedFile& file) {
  std::printf("%s -> %s, %s\n", input.c_str(), file.output.c_str(), readable_bytes(file.bytes).c_str());
  for (const auto& [object, duplicates, zero_areas] : file.meshes) {
    std::printf("object %u %s\n%s", object.record.source_index, printable(object.name).c_str(),
                object_summary(object.record).c_str());
    if (duplicates || zero_areas)
      std::printf("  dropped   %llu duplicate and %llu zero-area triangles\n",
                  static_cast<unsigned long long>(duplicates),
                  static_cast<unsigned long long>(zero_areas));
    if (object.plan) print_outcome(object);
    if (object.cells_demoted)
      std::printf("  budget    made %s of %s: %.2f %% of all cells lost their class\n", readable_bytes(file.bytes).c_str(), readable_bytes(object.bytes_before_demotion).c_str(),
                  100 * static_cast<double>(object.cells_demoted) / static_cast<double>(tree_shape(object.record.depth).cells()));
    if (object.out_of_time) std::printf("  time      is over: what was not classified by then is unclassified\n");
    if (object.record.method == static_cast<uint8_t>(Method::none)) continue;
    std::printf("  baked     in %s, %s rays, %s rays/s\n", readable_seconds(object.seconds).c_str(),
                readable_count(static_cast<double>(object.rays)).c_str(),
                readable_count(static_cast<double>(object.rays) / object.seconds).c_str());
  }
}

// Empty, or why the outputs cannot all be written: two into one file, or one over a mesh.
std::string check_outputs(const Options& options) {
  std::error_code ignored;
  std::set<fs::path> inputs, outputs;
  for (const std::string& input : options.inputs) inputs.insert(fs::weakly_canonical(input, ignored));
  for (const std::string& input : options.inputs) {
    const fs::path output = output_of(options, input);
    if (!outputs.insert(fs::weakly_canonical(output, ignored)).second)
      return input + ": another input would be written to " + output.string() + " too";
    if (inputs.contains(fs::weakly_canonical(output, ignored))) return output.string() + ": is a mesh to bake, and would be replaced by a sidecar";
    const fs::path folder = output.has_parent_path() ? output.parent_path() : fs::path(".");
    if (!fs::is_directory(folder, ignored)) return output.string() + ": its folder does not exist";
  }
  return {};
}

int run(const Options& options) {
  if (options.inputs.size() > 1 && !options.output.empty() && !fs::is_directory(options.output)) {
    print_error(options.output + ": not a folder; with several inputs -o names the folder of the sidecars");
    return exit_code(ErrorCode::usage);
  }
  if (const std::string fault = check_outputs(options); !fault.empty()) {
    print_error(fault);
    return exit_code(ErrorCode::usage);
  }
  catch_interruptions();
  std::vector<int> codes;
  Json all = Json::array();
  for (const std::string& input : options.inputs) {
    const auto file = interrupted() ? Result<BakedFile>(Error{ErrorCode::runtime, input + ": interrupted"})
                                    : bake_file(options, input);
    codes.push_back(file ? kExitOk : exit_code(file.error().code));
    if (!file) {
      print_error(file.error().message);
      all.push_back({{"input", input}, {"error", file.error().message}, {"exit_code", codes.back()}});
      continue;
    }
    if (!options.common.quiet && options.common.format == OutputFormat::text) {
      for (const std::string& note : file->notes) print_note(note);
      print_summary(input, *file);
    }
    if (options.common.format == OutputFormat::json) all.push_back(report(input, *file));
  }
  if (options.common.format == OutputFormat::json)
    print_json({{"tool", "vc-bake"}, {"version", VCD_VERSION}, {"files", all}});
  return batch_exit_code(codes);
}

// --plan: forecasts, no files.
int run_plan(const Options& options) {
  catch_interruptions();
  std::vector<int> codes;
  Json all = Json::array();
  for (const std::string& input : options.inputs) {
    const auto fail = [&](const Error& error) {
      print_error(error.message);
      codes.push_back(exit_code(error.code));
      all.push_back({{"input", input}, {"error", error.message}, {"exit_code", codes.back()}});
    };
    auto ingested = ingest_isolated(input, options.ingest);
    if (!ingested) {
      fail(ingested.error());
      continue;
    }
    Json objects = Json::array();
    int code = kExitOk;
    for (SourceMesh& mesh : ingested->meshes) {
      const std::string name = printable(mesh.name);
      const uint32_t index = mesh.source_index;
      BakeOptions bake_options = options.bake;
      bake_options.stop = interrupted;
      const auto prepared = prepare(std::move(mesh));
      const auto planned = prepared ? plan(*prepared, bake_options) : Result<Plan>(prepared.error());
      if (!planned) {
        print_error(input + ": " + planned.error().message);
        code = exit_code(planned.error().code);
        continue;
      }
      Json object{{"source_index", index}, {"name", prepared->name}, {"triangle_count", prepared->triangles.size()}};
      object["plan"] = describe_plan(*planned);
      objects.push_back(object);
      if (options.common.format == OutputFormat::json) continue;
      std::printf("%s: object %u %s, %zu triangles\n", input.c_str(), index, name.c_str(), prepared->triangles.size());
      print_plan(*planned);
    }
    codes.push_back(code);
    all.push_back({{"input", input}, {"objects", objects}});
  }
  if (options.common.format == OutputFormat::json)
    print_json({{"tool", "vc-bake"}, {"version", VCD_VERSION}, {"files", all}});
  return batch_exit_code(codes);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"Bakes visibility sidecars: for each mesh file a .vcd file that says which lines through each object's\n"
               "box are blocked by it and which are clear."};
  app.add_option("inputs", options.inputs, "Mesh files (.glb .gltf .drc .obj .ply .stl .off); @FILE: a list of them")
      ->required()
      ->type_name("MESH...");
  app.add_option("-o,--output", options.output,
                 "Sidecar to write, or folder to write to (default: beside each mesh, MESH.vcd)")
      ->type_name("PATH");
  app.add_option("-d,--depth", options.depth,
                 "Levels of the octree, 1 to 8: each costs about ten times more; auto: the deepest that pays (default)")
      ->check(CLI::IsMember({"auto", "1", "2", "3", "4", "5", "6", "7", "8"}))
      ->type_name("DEPTH");
  app.add_option("--budget-mb", options.budget_mb,
                 "MiB that the sidecar of each object may take: depth, then promises are given up (default: 4, for auto only)")
      ->check(CLI::Range(0.02, 1e6));
  app.add_option("--budget-seconds", options.bake.budget_seconds,
                 "Wall time that each object may take, from mesh to file; what is not classified by then stays\n"
                 "unclassified, and the result depends on the machine (default: none)")
      ->check(CLI::Range(0.1, 1e9));
  app.add_flag("--plan", options.plan_only, "Only forecast what each depth would cost and be worth; bake nothing");
  add_method_options(app, options.bake);
  app.add_option("--audit", options.audit.lines,
                 "Fresh lines to ask and trace after each bake, a third of them aimed at the mesh; 0: none (default: 1000000)")
      ->check(CLI::Range(0, 2000000000));
  app.add_option("--seed", options.bake.seed, "Seed of the sample rays (default: 0)");
  app.add_option("-j,--threads", options.bake.threads, "Threads; 0: all (default). The result does not depend on it")
      ->check(CLI::Range(0, 1024));
  const std::map<std::string, Storage> kStorages = {{"raw", Storage::raw}, {"ship", Storage::zstd}};
  app.add_option("--storage", options.storage, "raw: to be mapped and rendered from (default); ship: compressed")
      ->transform(CLI::CheckedTransformer(kStorages, CLI::ignore_case).description(""))
      ->type_name("raw|ship");
  app.add_flag("--embed-geometry", options.bake.embed_geometry,
               "Add the welded triangles, so that vc-verify can trace without the mesh file");
  app.add_flag("--all-as-opaque", options.ingest.treat_all_as_opaque,
               "Bake alpha-masked, blended, transmissive, skinned and morphed parts too, as they stand");
  add_common_options(app, options.common);
  return run_program(app, argc, argv, [&] {
    options.bake.depth = options.depth == "auto" ? 0 : static_cast<uint32_t>(options.depth[0] - '0');
    options.bake.budget_bytes = static_cast<uint64_t>(options.budget_mb * 1048576);
    return options.plan_only ? run_plan(options) : run(options);
  });
}
