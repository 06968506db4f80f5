// The options that say what to bake and with which settings, the same in vc-bake and vc-farm.
#pragma once

#include <vcd/library/assets.h>

#include "common/program.h"

namespace vcd::tools {

// Adds inputs, --manifest and -o. `request` is filled when the app parses and outlives it.
void add_asset_request(CLI::App& app, library::AssetRequest& request);

// Adds an option for each setting. `settings` is filled when the app parses and outlives it.
// Those that decide how mesh files are read.
void add_reading_settings(CLI::App& app, library::BakeSettings& settings);
void add_settings(CLI::App& app, library::BakeSettings& settings);
void add_setting(CLI::App& app, library::BakeSettings& settings, const library::Setting& setting);

}  // namespace vcd::tools
