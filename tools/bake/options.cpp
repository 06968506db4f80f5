#include "options.h"

namespace vcd::tools {

using namespace library;

void add_asset_request(CLI::App& app, AssetRequest& request) {
  app.add_option("inputs", request.inputs,
                 "Mesh files (.glb .gltf .drc .obj .ply .stl .off), folders of them, or patterns with * ? [] **; "
                 "@FILE: a list of them")
      ->type_name("MESH...");
  app.add_option("--manifest", request.manifests, "A library as a JSON file, with settings for single assets")
      ->type_name("FILE");
  app.add_option("-o,--output", request.output,
                 "Folder to write to, where the sidecars of a folder are mirrored; for one mesh also its sidecar, "
                 "NAME.vcd\n(default: beside each mesh, MESH.vcd)")
      ->type_name("PATH");
}

void add_setting(CLI::App& app, BakeSettings& settings, const Setting& setting) {
  const std::string name = "--" + std::string(setting.name);
  const std::string names = setting.letter ? std::string("-") + setting.letter + "," + name : name;
  const auto take = [&settings, &setting](const std::string& text) {
    if (const auto fault = set(settings, setting.name, text)) throw CLI::ValidationError("--" + fault->message);
  };
  if (setting.form == Setting::Form::flag)
    app.add_flag_callback(
        names, [take] { take("true"); }, std::string(setting.help));
  else app.add_option_function<std::string>(names, take, std::string(setting.help))->type_name(values_of(setting));
}

void add_reading_settings(CLI::App& app, BakeSettings& settings) {
  for (const Setting& setting : settings_table())
    if (setting.scope == Scope::asset) add_setting(app, settings, setting);
}

void add_settings(CLI::App& app, BakeSettings& settings) {
  for (const Setting& setting : settings_table()) add_setting(app, settings, setting);
}

}  // namespace vcd::tools
