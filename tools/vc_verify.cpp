// vc-verify: is a sidecar well-formed, does it belong to the mesh, and does it keep its promises?
#include <algorithm>
#include <cmath>
#include <cstdio>

#include <vcd/baker/audit.h>
#include <vcd/baker/referee.h>
#include <vcd/format/file_bytes.h>
#include <vcd/runtime/sidecar.h>

#include "common/audit_report.h"
#include "common/describe.h"
#include "common/meshes.h"
#include "common/program.h"

namespace {

using namespace vcd;

struct Options {
  CommonOptions common;
  std::vector<std::string> files;
  std::string against;
  std::string segment;
  AuditOptions audit;
  double max_wrong = -1;
  bool list_findings = false;
};

using PreparedMeshes = std::vector<PreparedMesh>;

// What one sidecar's check came to.
struct Outcome {
  int code = kExitOk;
  std::vector<std::string> errors;
  Json json;
  std::string text;

  void fail(ErrorCode why, const std::string& message) {
    if (code == kExitOk) code = exit_code(why);
    errors.push_back(message);
  }
};

// The highest share of wrong answers that is forgiven. The sampled method promises nothing about single lines; this only
// tells a poor tree from a broken one. About one and a half times the worst seen over some 240 real meshes, which was a
// shallow tray at depth 4; compact meshes are ten times better.
double allowed_wrong(const ObjectRecord& record) {
  if (record.method == static_cast<uint8_t>(Method::hybrid)) return 0.001;
  switch (record.method_parameters[0]) {
    case 16: return 0.1;
    case 81: return 0.02;
    default: return 0.005;
  }
}

// What the record says of the mesh and only the mesh can tell: its counts, and the padding of the box.
std::string fault_against(const ObjectRecord& record, const PreparedMesh& mesh) {
  if (record.triangle_count != mesh.triangles.size() || record.vertex_count != mesh.positions.size())
    return "its triangle and vertex counts are not the mesh's";
  double extent[3], low[3], high[3];
  for (int a = 0; a < 3; ++a) {
    extent[a] = static_cast<double>(record.box_max[a]) - record.box_min[a];
    low[a] = high[a] = mesh.positions[0][a];
    for (const Position& p : mesh.positions) {
      low[a] = std::min(low[a], static_cast<double>(p[a]));
      high[a] = std::max(high[a], static_cast<double>(p[a]));
    }
  }
  const double diagonal = std::hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]);
  for (int a = 0; a < 3; ++a) {
    const double margin = std::min(low[a] - record.box_min[a], record.box_max[a] - high[a]);
    if (margin < extent[a] * 0x1p-11 || extent[a] < diagonal * 1e-3) return "its box is not padded as it must be";
  }
  return {};
}

// One object as the runtime answers for it.
struct Answering {
  Object all, proven;  // the second trusts proofs alone
};

void audit_object(const Options& options, const std::string& name, const Answering& answering, const PreparedMesh& mesh,
                  Outcome& outcome, Json& json) {
  const AuditReport report = audit(mesh, answers_of(answering.all), answers_of(answering.proven), options.audit);
  json["audit"] = describe_audit(report);
  outcome.text += name + "\n" + audit_summary(report);
  for (const Contradiction& c : report.contradictions)
    outcome.text += std::string("  ") + (c.proven ? "proven " : "promised ") + (c.promised == Visibility::clear ? "clear" : "blocked") +
                    ", and the mesh says otherwise: --segment=" + replayable(c.segment) + "\n";
  const AuditCounts undirected = report.sum(false);
  const uint64_t wrong_proven = undirected.wrong_proven + report.sum(true).wrong_proven;
  const double rate = static_cast<double>(undirected.all_wrong()) / static_cast<double>(std::max<uint64_t>(undirected.segments, 1));
  const double allowed = options.max_wrong >= 0 ? options.max_wrong : allowed_wrong(answering.all.record());
  json["allowed_wrong_rate"] = allowed;
  if (wrong_proven > 0)
    return outcome.fail(ErrorCode::difference, name + ": " + std::to_string(wrong_proven) + " of its proven answers are wrong");
  if (rate <= allowed) return;
  char message[160];
  std::snprintf(message, sizeof message, ": %.3g of its answers are wrong, %.3g are allowed for its method", rate, allowed);
  outcome.fail(ErrorCode::difference, name + message);
}

void replay(const Options& options, const std::string& name, Object object, const PreparedMesh& mesh, Outcome& outcome, Json& json) {
  Segment segment;
  parse_segment(options.segment, segment);
  const Visibility answer = object.classify(segment);
  const bool blocked = Referee(mesh).occluded(segment);
  const char* const words[] = {"clear", "blocked", "unclassified"};
  const char* said = words[static_cast<size_t>(answer)];
  json["segment"] = {{"answer", said}, {"traced", words[blocked]}};
  outcome.text += name + ": the sidecar says " + said + ", tracing says " + words[blocked] + "\n";
  if (answer != Visibility::unclassified && (answer == Visibility::blocked) != blocked)
    outcome.fail(ErrorCode::difference, name + ": the segment's answer is wrong");
}

// Against the given mesh file, or what is embedded. No geometry at hand is fine: then the structure is all there is.
void check_against_mesh(const Options& options, const std::string& path, Bytes file, const SidecarContents& contents,
                        Outcome& outcome) {
  const auto all = Sidecar::open_buffer(file, {.check = CheckLevel::bounds});
  const auto proven = Sidecar::open_buffer(file, {.check = CheckLevel::bounds, .proven_only = true});
  if (!all || !proven) return outcome.fail(ErrorCode::runtime, path + ": out of memory");
  Result<PreparedMeshes> given = PreparedMeshes{};
  if (!options.against.empty()) given = load_meshes(options.against, &contents);
  if (!given) return outcome.fail(given.error().code, given.error().message);
  for (size_t i = 0; i < contents.objects.size(); ++i) {
    const ObjectContents& object = contents.objects[i];
    Json& json = outcome.json["objects"][i];
    json["name"] = object.name;
    const std::string name = path + ": object " + std::to_string(i) + " " + printable(object.name);
    if (options.against.empty() && object.geometry.empty()) {
      if (!options.segment.empty() || options.max_wrong >= 0)
        outcome.fail(ErrorCode::usage, name + ": no geometry is embedded; --segment and --max-wrong need --against MESH");
      continue;
    }
    PreparedMeshes embedded;
    if (!object.geometry.empty()) {
      auto mesh = embedded_mesh(path, object);
      if (!mesh || mesh->geometry_hash != object.record->geometry_hash) {
        outcome.fail(ErrorCode::invalid_file, mesh ? name + ": the embedded geometry is not the mesh it was baked from"
                                                   : mesh.error().message);
        continue;
      }
      embedded.push_back(std::move(*mesh));
    }
    const PreparedMeshes& candidates = options.against.empty() ? embedded : *given;
    const auto found = std::find_if(candidates.begin(), candidates.end(), [&](const PreparedMesh& mesh) {
      return mesh.geometry_hash == object.record->geometry_hash;
    });
    if (found == candidates.end()) {
      outcome.fail(ErrorCode::stale, name + ": stale: no mesh of " + options.against + " has its geometry hash " +
                                         hex(object.record->geometry_hash));
      continue;
    }
    if (const std::string fault = fault_against(*object.record, *found); !fault.empty())
      outcome.fail(ErrorCode::invalid_file, name + ": " + fault);
    if (options.segment.empty()) {
      audit_object(options, name, {all->object(i), proven->object(i)}, *found, outcome, json);
    } else {
      replay(options, name, all->object(i), *found, outcome, json);
    }
  }
}

Outcome verify(const Options& options, const std::string& path) {
  Outcome outcome;
  outcome.json["file"] = path;
  const auto file = FileBytes::copy(path);
  if (!file) {
    outcome.fail(file.error().code, file.error().message);
  } else {
    std::vector<Finding> findings;
    const auto contents = read_sidecar(file->bytes(), CheckLevel::full, findings);
    outcome.json["findings"] = Json::array();
    for (const Finding& finding : findings) {
      outcome.json["findings"].push_back(describe_finding(finding));
      if (finding_info(finding.id).severity == Severity::warning) {
        outcome.text += path + ": " + describe(finding) + "\n";
        continue;
      }
      outcome.fail(error_code(finding.id), path + ": " + describe(finding));
    }
    if (contents) check_against_mesh(options, path, file->bytes(), *contents, outcome);
  }
  outcome.json["errors"] = outcome.errors;
  outcome.json["exit_code"] = outcome.code;
  return outcome;
}

int list_findings(const Options& options) {
  Json json = Json::array();
  for (const FindingInfo& info : all_findings()) {
    const char* severity = info.severity == Severity::error ? "error" : "warning";
    json.push_back({{"id", info.id}, {"severity", severity}, {"message", info.message}, {"spec_section", info.spec_section}});
    if (options.common.format == OutputFormat::text)
      std::printf("%-24s %-8s %s [%s]\n", info.id, severity, info.message, info.spec_section);
  }
  if (options.common.format == OutputFormat::json) print_json(json);
  return kExitOk;
}

int run(const Options& options) {
  if (options.list_findings) return list_findings(options);
  Segment segment;
  if (options.files.empty() || (!options.segment.empty() && !parse_segment(options.segment, segment))) {
    print_error(options.files.empty() ? "no sidecar given; try --help" : options.segment + ": not eight numbers with commas");
    return exit_code(ErrorCode::usage);
  }
  std::vector<int> codes;
  Json all = Json::array();
  for (const std::string& path : options.files) {
    const Outcome outcome = verify(options, path);
    codes.push_back(outcome.code);
    all.push_back(outcome.json);
    for (const std::string& error : outcome.errors) print_error(error);
    if (options.common.format == OutputFormat::json || options.common.quiet) continue;
    std::fputs(outcome.text.c_str(), stdout);
    if (outcome.code == kExitOk) std::printf("%s: ok\n", path.c_str());
  }
  if (options.common.format == OutputFormat::json)
    print_json({{"tool", "vc-verify"}, {"version", VCD_VERSION}, {"files", all}});
  return batch_exit_code(codes);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{"Checks .vcd sidecars: first the file, byte by byte; then, with --against or embedded geometry, that it\n"
               "belongs to the mesh, and its answers against traced rays."};
  app.add_option("files", options.files, "Sidecars; @FILE: a list of them")->type_name("SIDECAR...");
  app.add_option("--against", options.against, "The mesh file that the sidecars were baked from")->type_name("MESH");
  app.add_option("--lines", options.audit.lines, "Fresh lines to ask and trace, a third of them aimed at the mesh (default: 1000000)")
      ->check(CLI::Range(9, 2000000000));
  app.add_option("--seed", options.audit.seed, "Seed of the fresh lines (default: 1)");
  app.add_option("--keep", options.audit.keep, "Contradictions to print, at most (default: 10)");
  app.add_option("--max-wrong", options.max_wrong,
                 "Largest share of wrong answers to accept (default: 0.1, 0.02, 0.005 for 16, 81, 256 samples; hybrid: 0.001).\nA wrong proven answer is never accepted")
      ->check(CLI::Range(0.0, 1.0));
  app.add_option("--segment", options.segment, "Ask and trace this one segment: ox,oy,oz,t_min,dx,dy,dz,t_max")->type_name("SEGMENT");
  app.add_flag("--list-findings", options.list_findings, "Print the table of everything that can be found, and stop");
  add_common_options(app, options.common);
  return run_program(app, argc, argv, [&] { return run(options); });
}
