// A library as a JSON file: which assets, with settings of their own. spec/library.md describes it.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <vcd/library/settings.h>

namespace vcd::library {

struct ManifestEntry {
  std::filesystem::path input;    // a file, folder or pattern
  std::filesystem::path sidecar;  // for a file: what to write; else empty
  std::filesystem::path folder;   // mirror below this; empty: beside, or what -o says
  BakeSettings settings;
};

// Relative paths start from the manifest's folder. `base`: the settings of the command line, which the manifest's
// override. Errors: io; usage, naming the manifest, the asset and the member.
Result<std::vector<ManifestEntry>> read_manifest(const std::filesystem::path& path, const BakeSettings& base);

// The text of a manifest that names these assets one by one, each with all of its settings.
struct Asset;
std::string manifest_of(const std::vector<Asset>& assets);

}  // namespace vcd::library
