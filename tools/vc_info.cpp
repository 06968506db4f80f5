// vc-info: shows what sidecars, demands and mesh files hold, turns one storage into the other, and merges demands.
#include <array>
#include <cstdio>
#include <filesystem>
#include <fstream>

#include <vcd/format/contents.h>
#include <vcd/format/demand.h>
#include <vcd/format/line_cell.h>
#include <vcd/format/tree.h>
#include <vcd/runtime/sidecar.h>
#include <vcd/writer/atomic_file.h>
#include <vcd/writer/demand.h>
#include <vcd/writer/writer.h>

#include <vcd/library/find.h>
#include "bake/options.h"
#include "common/describe.h"
#include "common/health_report.h"
#include "common/meshes.h"
#include "common/paths.h"
#include "common/program.h"
#include "common/readable.h"
#include "info/page.h"
#include "info/show_mesh.h"
#include "info/views.h"

namespace {

using namespace vcd;
using namespace vcd::tools;

struct Options {
  CommonOptions common;
  std::vector<std::string> files;
  std::string repack, merge, asked, culprits, page, picture, mesh;
  uint64_t most_segments = kMostAskedSegments;
  library::BakeSettings settings;  // its storage is that of --repack; how mesh files are read
  bool sections = false, pages = false;

  bool draws() const { return pages || !page.empty() || !picture.empty(); }
};

// How much of what a demand asks of an object its cells answer.
struct Answered {
  uint64_t segments = 0;                     // that enter the box
  double all = 0, answered = 0, proven = 0;  // weights

  static double share(double part, double whole) { return whole > 0 ? part / whole : 0; }
};

Answered answered_of(const ObjectContents& object, const Demand& demand) {
  Answered result;
  const auto asked = demand.find(object.record->geometry_hash);
  if (asked == demand.end()) return result;
  const GridFrame frame = make_grid_frame(object.record->box_min, object.record->box_max);
  TreeView tree = object.tree;
  const bool sampled = object.record->method == static_cast<uint8_t>(Method::sampled);
  for (const auto& [segment, weight] : asked->second) {
    const Place place = place_of(locate(frame, segment), segment.t_min, segment.t_max);
    if (place == Place::doubtful || place == Place::outside) continue;
    ++result.segments, result.all += weight;
    tree.answers = answer_table(Trust::statistics);
    if (classify(frame, tree, tree.shape, segment) == Visibility::unclassified) continue;
    result.answered += weight;
    tree.answers = answer_table(Trust::proofs);
    if (!sampled && classify(frame, tree, tree.shape, segment) != Visibility::unclassified) result.proven += weight;
  }
  return result;
}

Json describe(const Answered& a) {
  return {{"segments", a.segments},
          {"weight", a.all},
          {"answered", Answered::share(a.answered, a.all)},
          {"proven", Answered::share(a.proven, a.all)}};
}

baker::MeshHealth health_of(const baker::PreparedMesh& mesh) {
  return baker::mesh_health(mesh.positions.size(), mesh.triangles);
}

Json describe(const std::string& path, const SidecarContents& contents, const Demand& asked) {
  Json json{{"file", path},
            {"format_version", {contents.header->version_major, contents.header->version_minor}},
            {"file_size", contents.header->file_size}};
  json["objects"] = Json::array();
  for (const ObjectContents& object : contents.objects) {
    json["objects"].push_back(describe_object(object));
    if (!asked.empty()) json["objects"].back()["asked"] = describe(answered_of(object, asked));
    if (object.geometry.empty()) continue;
    if (const auto mesh = embedded_mesh(path, object))
      json["objects"].back()["surface"] = describe_health(health_of(*mesh));
  }
  json["sections"] = Json::array();
  for (const SectionEntry& section : contents.sections) json["sections"].push_back(describe_section(section));
  json["provenance"] = Json::object();
  for (const auto& [key, value] : contents.provenance) json["provenance"][std::string(key)] = value;
  return json;
}

void print(const std::string& path, const SidecarContents& contents, const Demand& asked, bool sections) {
  std::printf("%s: vcd %u.%u, %s, %zu object%s\n", path.c_str(), contents.header->version_major,
              contents.header->version_minor, readable_bytes(contents.header->file_size).c_str(),
              contents.objects.size(), contents.objects.size() == 1 ? "" : "s");
  for (const ObjectContents& object : contents.objects) {
    std::printf("object %u %s\n%s", object.record->source_index, printable(object.name).c_str(),
                object_summary(*object.record).c_str());
    std::printf("%s", hierarchy_summary(*object.record, object.hierarchy).c_str());
    std::printf("%s", horizon_summary(object.horizon).c_str());
    if (!object.clearance.empty())
      std::printf("  clearance known: segments may begin and end shortly behind the box's faces\n");
    if (!asked.empty()) {
      const Answered a = answered_of(object, asked);
      std::printf("  asked     %llu segments; %s of their weight answered, %s proven\n",
                  static_cast<unsigned long long>(a.segments),
                  readable_percent(Answered::share(a.answered, a.all)).c_str(),
                  readable_percent(Answered::share(a.proven, a.all)).c_str());
    }
    if (object.geometry.empty()) continue;
    std::printf("  geometry  embedded, %s\n", readable_bytes(object.geometry.size()).c_str());
    if (const auto mesh = embedded_mesh(path, object)) std::fputs(health_summary(health_of(*mesh)).c_str(), stdout);
    else print_note(mesh.error().message);
  }
  for (const auto& [key, value] : contents.provenance)
    std::printf("%s: %s\n", printable(key).c_str(), printable(value).c_str());
  if (!sections) return;
  std::printf("%-5s %6s %-7s %12s %12s %12s  %-16s\n", "type", "object", "storage", "offset", "stored", "logical",
              "logical XXH3");
  for (const SectionEntry& s : contents.sections) {
    const Json j = describe_section(s);
    const std::string object = s.object == kNone ? "-" : std::to_string(s.object);
    std::printf("%-5s %6s %-7s %12llu %12llu %12llu  %s\n", j["type"].get<std::string>().c_str(), object.c_str(),
                j["storage"].get<std::string>().c_str(), static_cast<unsigned long long>(s.offset),
                static_cast<unsigned long long>(s.stored_size), static_cast<unsigned long long>(s.logical_size),
                hex(s.logical_xxh3).c_str());
  }
}

double weight_of(const std::vector<AskedSegment>& segments) {
  double sum = 0;
  for (const AskedSegment& s : segments) sum += s.weight;
  return sum;
}

Json describe(const std::string& path, const Demand& demand) {
  Json json{{"file", path}, {"demand", Json::array()}};
  for (const auto& [hash, segments] : demand)
    json["demand"].push_back(
        {{"geometry_hash", hex(hash)}, {"segments", segments.size()}, {"weight", weight_of(segments)}});
  return json;
}

void print(const std::string& path, const Demand& demand) {
  std::printf("%s: demand for %zu object%s\n", path.c_str(), demand.size(), demand.size() == 1 ? "" : "s");
  for (const auto& [hash, segments] : demand)
    std::printf("  geometry hash %s: %zu segments that stand for %s\n", hex(hash).c_str(), segments.size(),
                readable_count(weight_of(segments)).c_str());
}

// Shows a file that begins like a demand. Its exit code.
int show_demand(const std::string& path, const Options& options, Json& all) {
  const auto demand = read_demand(path);
  if (!demand) {
    print_error(demand.error().message);
    all.push_back({{"file", path}, {"error", demand.error().message}});
    return exit_code(demand.error().code);
  }
  if (options.common.format == OutputFormat::json) all.push_back(describe(path, *demand));
  else print(path, *demand);
  return kExitOk;
}

// Why the culprits must not be written there: only culprits are replaced, since a mesh is named alike.
std::optional<Error> fault_of_culprits(const std::string& path) {
  std::error_code none;
  if (extension_of(path) != "obj") return Error{ErrorCode::usage, shown(path) + ": what is written is OBJ"};
  if (!std::filesystem::exists(std::filesystem::symlink_status(path, none))) return std::nullopt;
  std::string begin(kCulpritsBegin.size(), '\0');
  std::ifstream file(path, std::ios::binary);
  if (std::filesystem::is_regular_file(path, none) &&
      file.read(begin.data(), static_cast<std::streamsize>(begin.size())) && begin == kCulpritsBegin)
    return std::nullopt;
  return Error{ErrorCode::usage, shown(path) + ": is there and was not written by --culprits"};
}

bool is_demand(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return false;  // a pipe would wait
  std::array<char, kDemandBegin.size()> begin{};
  std::ifstream file(path, std::ios::binary);
  return file.read(begin.data(), begin.size()) && std::string_view(begin.data(), begin.size()) == kDemandBegin;
}

// Why pages or pictures must not be written.
std::optional<Error> fault_of_drawing(const Options& options) {
  if ((!options.page.empty() || !options.picture.empty()) && options.files.size() != 1)
    return Error{ErrorCode::usage, "--page and --picture take one sidecar at a time"};
  for (const std::string& file : options.files)
    if (is_demand(file) || library::has_extension(file, baker::mesh_extensions()))
      return Error{ErrorCode::usage, shown(file) + ": is no sidecar, and only sidecars are drawn"};
  for (const std::string& path : {options.page, options.picture})
    if (!path.empty() && !library::may_be_written(path))
      return Error{ErrorCode::usage, shown(path) + ": is named like a mesh or a sidecar"};
  return std::nullopt;
}

// Shows a mesh file. Its exit code.
int show_mesh(const std::string& path, const Options& options, Json& all) {
  const auto mesh = tools::show_mesh(path, options.settings.ingest_options(), options.common.quiet);
  if (!mesh) {
    print_error(mesh.error().message);
    all.push_back({{"file", path}, {"error", mesh.error().message}});
    return exit_code(mesh.error().code);
  }
  all.push_back(mesh->json);
  if (options.common.format == OutputFormat::text) std::fputs(mesh->text.c_str(), stdout);
  if (options.culprits.empty()) return kExitOk;
  AtomicFile file(options.culprits);
  file.append(std::as_bytes(std::span(mesh->culprits)));
  const auto written = file.commit();
  if (!written) return print_error(written.error().message), exit_code(written.error().code);
  return kExitOk;
}

int merge_demands(const Options& options) {
  Demand merged;
  for (const std::string& path : options.files) {
    auto demand = read_demand(path);
    if (!demand) return print_error(demand.error().message), exit_code(demand.error().code);
    const std::array<Demand, 2> both = {std::move(merged), std::move(*demand)};
    merged = merge(both);
  }
  const uint64_t count = segment_count(merged);
  const Demand thinned = thin(std::move(merged), options.most_segments);
  const auto written = write_demand(options.merge, thinned);
  if (!written) return print_error(written.error().message), exit_code(written.error().code);
  if (!options.common.quiet)
    std::printf("%zu demands, %llu segments -> %s, %llu segments, %s\n", options.files.size(),
                static_cast<unsigned long long>(count), options.merge.c_str(),
                static_cast<unsigned long long>(segment_count(thinned)), readable_bytes(*written).c_str());
  return kExitOk;
}

// Writes the page and the picture of a sidecar, if they are asked for. Its exit code.
int draw(const std::string& path, const SidecarContents& contents, const Options& options) {
  const auto write = [&](const std::string& to, const Result<std::string>& made) {
    if (!made) return print_error(made.error().message), exit_code(made.error().code);
    AtomicFile file(to);
    file.append(std::as_bytes(std::span(*made)));
    const auto written = file.commit();
    if (!written) return print_error(written.error().message), exit_code(written.error().code);
    if (!options.common.quiet)
      std::printf("%s -> %s, %s\n", shown(path).c_str(), shown(to).c_str(), readable_bytes(*written).c_str());
    return +kExitOk;
  };
  int code = kExitOk;
  if (!options.picture.empty())
    code = write(options.picture, classes_as_png(contents, shown(std::filesystem::path(path).filename())));
  const std::string page = options.pages ? path + std::string(kPageEnding) : options.page;
  if (code == kExitOk && !page.empty())
    code = write(page, page_of(path, contents, {options.mesh, options.settings.ingest_options(), interrupted}));
  return code;
}

Result<uint64_t> repack(const Sidecar& sidecar, Bytes file, const Options& options) {
  const SidecarContents& contents = sidecar.contents();
  if (contents.header->version_minor > kVersionMinor)  // its reserved fields may mean something, and would get lost
    return Error{ErrorCode::unsupported, options.files[0] + ": of a later minor version than this program can write"};
  SidecarToWrite out;
  out.storage = options.settings.storage;
  out.stop = interrupted;
  for (const auto& [key, value] : contents.provenance) out.provenance.emplace(key, value);
  for (const ObjectContents& object : contents.objects)
    out.objects.push_back({object.name, *object.record, tree_pieces(object.tree), object.geometry,
                           object.hierarchy.bytes(), object.clearance, object.horizon.all_bytes()});
  std::vector<AlignedBytes> kept;
  for (const SectionEntry& section : contents.sections) {
    if (is_known_section(section.type)) continue;
    kept.push_back(section_bytes(file, section));
    if (kept.back().size != section.logical_size)
      return Error{ErrorCode::invalid_file, options.files[0] + ": a section cannot be decompressed"};
    out.others.push_back({section, {kept.back().data.get(), kept.back().size}});
  }
  return write_sidecar(options.repack, out);
}

int run(const Options& options) {
  if (!options.repack.empty() && options.files.size() != 1) {
    print_error("--repack takes one sidecar at a time");
    return exit_code(ErrorCode::usage);
  }
  if (library::has_extension(options.repack, baker::mesh_extensions())) {
    print_error(shown(options.repack) + ": is named like a mesh; a sidecar's name ends in .vcd");
    return exit_code(ErrorCode::usage);
  }
  if (!options.merge.empty() && !library::may_be_written(options.merge)) {
    print_error(shown(options.merge) + ": is named like a mesh or a sidecar");
    return exit_code(ErrorCode::usage);
  }
  if (!options.culprits.empty()) {
    const bool is_one = options.files.size() == 1 && library::has_extension(options.files[0], baker::mesh_extensions());
    const auto fault =
        is_one ? fault_of_culprits(options.culprits) : Error{ErrorCode::usage, "--culprits takes one mesh file"};
    if (fault) return print_error(fault->message), exit_code(fault->code);
  }
  if (options.draws()) {
    const auto fault = fault_of_drawing(options);
    if (fault) return print_error(fault->message), exit_code(fault->code);
  }
  catch_interruptions();
  if (!options.merge.empty()) return merge_demands(options);
  Demand asked;
  if (!options.asked.empty()) {
    auto read = read_demand(options.asked);
    if (!read) return print_error(read.error().message), exit_code(read.error().code);
    asked = std::move(*read);
  }
  std::vector<int> codes;
  Json all = Json::array();
  for (const std::string& path : options.files) {
    if (options.repack.empty() && is_demand(path)) {
      codes.push_back(show_demand(path, options, all));
      continue;
    }
    if (options.repack.empty() && library::has_extension(path, baker::mesh_extensions())) {
      codes.push_back(show_mesh(path, options, all));
      continue;
    }
    const auto sidecar = Sidecar::open(path, {Load::copy});  // a map of a file that somebody truncates raises SIGBUS
    codes.push_back(sidecar ? kExitOk : exit_code(sidecar.error().code));
    if (!sidecar) {
      print_error(sidecar.error().message);
      all.push_back({{"file", path}, {"error", sidecar.error().message}});
      continue;
    }
    if (!options.repack.empty()) {
      const auto& header = *sidecar->contents().header;
      const Bytes file(reinterpret_cast<const std::byte*>(&header), header.file_size);
      const auto written = repack(*sidecar, file, options);
      if (!written) {
        print_error(written.error().message);
        codes.back() = exit_code(written.error().code);
      } else if (!options.common.quiet) {
        std::printf("%s (%s) -> %s (%s)\n", path.c_str(), readable_bytes(header.file_size).c_str(),
                    options.repack.c_str(), readable_bytes(*written).c_str());
      }
      continue;
    }
    if (options.draws()) {
      codes.back() = draw(path, sidecar->contents(), options);
      continue;
    }
    if (options.common.format == OutputFormat::json) {
      all.push_back(describe(path, sidecar->contents(), asked));
    } else {
      print(path, sidecar->contents(), asked, options.sections);
    }
  }
  if (options.common.format == OutputFormat::json && options.repack.empty() && !options.draws())
    print_json({{"tool", "vc-info"}, {"version", VCD_VERSION}, {"files", all}});
  return batch_exit_code(codes);
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  CLI::App app{
      "Shows what .vcd sidecars, demands and mesh files hold, writes a sidecar again with another storage, or merges\n"
      "demands."};
  app.add_option("files", options.files, "Sidecars, demands or mesh files; @FILE: a list of them")
      ->required()
      ->type_name("FILE...");
  app.add_flag("--sections", options.sections, "List the sections too");
  app.add_option("--culprits", options.culprits,
                 "Write the boundary and non-manifold edges of a mesh file as lines to this OBJ file, and non-manifold "
                 "vertices as\npoints")
      ->type_name("FILE.obj");
  app.add_option("--asked", options.asked, "Show how much each object's cells answer of what this demand asks of it")
      ->type_name("DEMAND");
  auto* const page =
      app.add_option("--page", options.page,
                     "Write a page to look at, for any browser: the object in 3-D by what look-ups answer of lines "
                     "through each\nplace and why not, the cell under the cursor, classes from eight directions")
          ->type_name("FILE.html");
  app.add_option("--mesh", options.mesh,
                 "The mesh file, for --page, of a sidecar that holds no triangles (baked with --no-hierarchy)")
      ->type_name("MESH")
      ->needs(page);
  auto* const pages =
      app.add_flag("--pages", options.pages,
                   "Write such a page beside each sidecar, as NAME.vcd.html: the report of vc-bake links to them")
          ->excludes(page);
  auto* const picture = app.add_option("--picture", options.picture,
                                       "Write a picture: the classes of lines of sight from eight directions, a line a "
                                       "pixel. White is clear; dark is\n"
                                       "blocked by a proof, blue by statistics; orange is unclassified")
                            ->type_name("FILE.png");
  auto* const repack =
      app.add_option("--repack", options.repack, "Write the sidecar's content to this file, stored as --storage says")
          ->type_name("PATH");
  auto* const merge =
      app.add_option("--merge", options.merge, "Write to this file what all these demands ask")->type_name("PATH");
  merge->excludes(repack);
  for (auto* const other : {repack, merge}) other->excludes(page), other->excludes(pages), other->excludes(picture);
  app.add_option("--most-segments", options.most_segments,
                 "Of the merged demand: a sample that stands for all (default: 16777216, the most that a file holds)")
      ->check(CLI::Range(uint64_t{1}, kMostAskedSegments))
      ->needs(merge);
  for (const library::Setting& setting : library::settings_table())
    if (setting.name == "storage") add_setting(app, options.settings, setting);
  add_reading_settings(app, options.settings);
  add_common_options(app, options.common);
  return run_program(app, argc, argv, [&] { return run(options); });
}
