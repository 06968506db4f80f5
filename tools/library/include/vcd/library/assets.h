// What a run is to bake: inputs and manifests → assets.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <vcd/library/find.h>
#include <vcd/library/settings.h>
#include <vcd/library/share_out.h>

namespace vcd::library {

struct Asset {
  std::filesystem::path input;
  std::filesystem::path output;
  BakeSettings settings;
  std::vector<Share> shares = {};  // of settings.total_mb, of each object in their order; none: the asset has it all
};

struct Assets {
  std::vector<Asset> assets;                         // in the order of the inputs
  std::vector<Error> errors;                         // of inputs that are not there or cannot be read
  std::vector<std::filesystem::path> empty_folders;  // inputs without a mesh
  size_t other_files = 0;                            // not meshes
  size_t named_again = 0;
  std::vector<std::filesystem::path> folders;  // where sidecars of these assets may lie: each output's, and all below
                                               // the output folder or the folders that were searched
};

struct AssetRequest {
  std::vector<std::string> inputs;     // files, folders, patterns
  std::vector<std::string> manifests;  // JSON: spec/library.md
  std::string output;                  // empty: beside each asset; NAME.vcd, for one asset; else a folder
  BakeSettings settings;
};

// Error (usage): a manifest that is none, two assets for one sidecar, a sidecar in the place of a mesh, an output for
// several assets that is a file or is named like a sidecar. Sidecars of a folder's assets are mirrored below the output
// folder; missing folders are made when needed.
Result<Assets> collect_assets(const AssetRequest& request);

}  // namespace vcd::library
