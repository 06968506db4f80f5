#include "settings.h"

#include <map>

#include "common/meshes.h"
#include "common/method_options.h"
#include "common/program.h"

namespace vcd {
using namespace baker;
BakeOptions BakeSettings::bake_options() const {
  BakeOptions options = bake;
  options.depth = depth == "auto" ? 0 : static_cast<uint32_t>(depth[0] - '0');
  options.budget_bytes = static_cast<uint64_t>(budget_mb * 1048576);
  options.audit_lines = audit_lines;
  return options;
}

Json BakeSettings::members() const {
  Json json{{"depth", depth}, {"method", method_name(bake.method)}};
  if (bake.samples) json["samples"] = bake.samples;
  if (budget_mb > 0) json["budget-mb"] = budget_mb;
  if (bake.budget_seconds > 0) json["budget-seconds"] = bake.budget_seconds;
  json["seed"] = bake.seed;
  json["audit"] = audit_lines;
  json["storage"] = storage == Storage::zstd ? "ship" : "raw";
  json["embed-geometry"] = bake.embed_geometry;
  json["all-as-opaque"] = ingest.treat_all_as_opaque;
  if (ingest.coarse) json["allow-rounding"] = true;
  if (ingest.shift != std::array<double, 3>{}) json["shift"] = shift_text(ingest.shift);
  if (ingest.files_outside) json["allow-outside-files"] = true;
  return json;
}

void add_settings(CLI::App& app, BakeSettings& settings) {
  app.add_option(
         "-d,--depth", settings.depth,
         "Levels of the octree, 1 to 8: each costs five to twelve times more; auto: the deepest that pays (default)")
      ->check(CLI::IsMember({"auto", "1", "2", "3", "4", "5", "6", "7", "8"}).description(""))
      ->type_name("auto|1|2|3|4|5|6|7|8");
  app.add_option(
         "--budget-mb", settings.budget_mb,
         "MiB that the sidecar of each object may take: depth, then promises are given up (default: 4, for auto only)")
      ->check(NumberRange(0.02, 1e6));
  app.add_option("--budget-seconds", settings.bake.budget_seconds,
                 "Wall time that each object may take, from mesh to file; what is not classified by then stays\n"
                 "unclassified, and the result depends on the machine (default: none)")
      ->check(NumberRange(0.1, 1e9));
  add_method_options(app, settings.bake);
  app.get_option("--method")->each([&](const std::string&) { settings.method_named = true; });
  app.add_option(
         "--audit", settings.audit_lines,
         "Fresh lines to ask and trace after each bake, a third of them aimed at the mesh; 0: none (default: 1000000)")
      ->check(CLI::Range(0, 2000000000));
  app.add_option("--seed", settings.bake.seed, "Seed of the sample rays (default: 0)");
  static const std::map<std::string, Storage> kStorages = {{"raw", Storage::raw}, {"ship", Storage::zstd}};
  app.add_option("--storage", settings.storage, "raw: to be mapped and rendered from (default); ship: compressed")
      ->transform(CLI::CheckedTransformer(kStorages, CLI::ignore_case).description(""))
      ->type_name("raw|ship");
  app.add_flag("--embed-geometry", settings.bake.embed_geometry,
               "Add the welded triangles, so that vc-verify can trace without the mesh file");
  app.add_flag("--all-as-opaque", settings.ingest.treat_all_as_opaque,
               "Bake alpha-masked, blended, transmissive, skinned and morphed parts too, as they stand");
  app.add_option_function<std::string>(
         "--shift", [&](const std::string& text) { settings.ingest.shift = parse_shift(text).value(); },
         "Subtract x,y,z from all coordinates before they are rounded to 32-bit floats, for meshes far from their "
         "origin;\nrecorded in the sidecar (default: 0,0,0)")
      ->check(CLI::Validator(
          [](const std::string& text) { return parse_shift(text) ? "" : text + ": not three numbers x,y,z"; }, ""))
      ->type_name("X,Y,Z");
  app.add_flag("--allow-rounding", settings.ingest.coarse,
               "Bake a mesh even if 32-bit floats move its coordinates by more than a thousandth of its extent");
  add_outside_files(app, settings.ingest);
}

Result<BakeSettings> changed(const BakeSettings& base, const Json& members) {
  if (!members.is_object()) return Error{ErrorCode::usage, "settings are not an object"};
  BakeSettings settings = base;
  CLI::App app;
  app.set_help_flag();
  add_settings(app, settings);
  std::vector<std::string> arguments;
  for (const auto& [name, value] : members.items()) {
    if (!value.is_primitive() || value.is_null())
      return Error{ErrorCode::usage, "setting " + name + ": not a number, text, true or false"};
    // The last argument first, as CLI11 wants them.
    arguments.insert(arguments.begin(),
                     "--" + name + "=" + (value.is_string() ? value.get<std::string>() : value.dump()));
  }
  try {
    app.parse(std::move(arguments));
  } catch (const CLI::ParseError& error) {
    return Error{ErrorCode::usage, std::string("settings: ") + error.what()};
  }
  if (base.method_named && !members.contains("method")) settings.bake.method = base.bake.method;
  return settings;
}

}  // namespace vcd
