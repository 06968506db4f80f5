#include <vcd/library/assets.h>

#include <map>
#include <set>

#include <vcd/library/manifest.h>
#include "common/paths.h"

namespace vcd::library {
namespace {

using namespace tools;

namespace fs = std::filesystem;

fs::path sidecar_of(const fs::path& mesh) { return fs::path(mesh) += ".vcd"; }

class Collection {
 public:
  explicit Collection(const AssetRequest& request) : request_(request) {}

  Result<Assets> make() {
    std::error_code ignored;
    add(request_.inputs, request_.output, request_.settings);
    for (const std::string& path : request_.manifests)
      if (auto fault = add_manifest(path)) return *std::move(fault);
    // By its name alone, so that what a list or a pattern yields does not decide whether it is a file or a folder.
    const std::string& output = request_.output;
    const bool one_file = request_.manifests.empty() && request_.inputs.size() == 1 && assets_.assets.size() == 1 &&
                          !fs::is_directory(request_.inputs[0], ignored);
    const bool names_sidecar = has_extension(output, kSidecarExtensions) && !fs::is_directory(output, ignored);
    if (names_sidecar && one_file) {
      const fs::path folder = fs::path(output).parent_path();
      if (!folder.empty() && !fs::is_directory(folder, ignored))
        return Error{ErrorCode::usage, shown(output) + ": its folder does not exist"};
      assets_.assets[0].output = output;
    } else if (names_sidecar || (fs::exists(output, ignored) && !fs::is_directory(output, ignored))) {
      return Error{ErrorCode::usage, shown(output) +
                                         ": not a folder; -o names the folder of the sidecars, or for one "
                                         "mesh its sidecar, which ends in .vcd"};
    }
    if (auto fault = check_outputs()) return *std::move(fault);
    return std::move(assets_);
  }

 private:
  void add(const std::vector<std::string>& inputs, const fs::path& output, const BakeSettings& settings) {
    Found found = find_files(inputs, baker::mesh_extensions());
    for (FoundFile& file : found.files) {
      const fs::path sidecar = output.empty() ? sidecar_of(file.path) : output / sidecar_of(file.below);
      assets_.assets.push_back({std::move(file.path), sidecar, settings});
    }
    assets_.errors.insert(assets_.errors.end(), found.errors.begin(), found.errors.end());
    assets_.empty_folders.insert(assets_.empty_folders.end(), found.empty_folders.begin(), found.empty_folders.end());
    assets_.other_files += found.other_files;
    assets_.named_again += found.named_again;
    std::error_code ignored;
    if (!output.empty()) return assets_.folders.push_back(output);
    for (const std::string& input : inputs)
      if (fs::is_directory(input, ignored)) assets_.folders.push_back(input);
  }

  std::optional<Error> add_manifest(const std::string& path) {
    auto manifest = read_manifest(path, request_.settings);
    if (!manifest) return manifest.error();
    for (ManifestEntry& entry : *manifest) {
      if (entry.sidecar.empty()) {
        add({entry.input.string()}, entry.folder.empty() ? fs::path(request_.output) : entry.folder, entry.settings);
      } else {
        std::error_code error;
        if (!fs::exists(entry.input, error))
          assets_.errors.push_back({ErrorCode::io, shown(entry.input) + ": No such file or directory"});
        else assets_.assets.push_back({std::move(entry.input), std::move(entry.sidecar), std::move(entry.settings)});
      }
    }
    return std::nullopt;
  }

  // Two into one file, or one over a mesh, would harm.
  std::optional<Error> check_outputs() const {
    const auto fault = [](const std::string& message) { return Error{ErrorCode::usage, message}; };
    std::set<fs::path> meshes;
    std::map<fs::path, const Asset*> sidecars;
    for (const Asset& asset : assets_.assets) meshes.insert(true_path(asset.input));
    for (const Asset& asset : assets_.assets) {
      const fs::path output = true_path(asset.output);
      const auto [known, is_new] = sidecars.emplace(output, &asset);
      if (!is_new)
        return fault(shown(asset.input) + ": " + shown(known->second->input) + " would be written to " +
                     shown(asset.output) + " too");
      if (meshes.contains(output))
        return fault(shown(asset.output) + ": is a mesh to bake, and would be replaced by a sidecar");
      if (has_extension(output, baker::mesh_extensions()))
        return fault(shown(asset.output) + ": is named like a mesh; a sidecar's name ends in .vcd");
    }
    return std::nullopt;
  }

  static fs::path true_path(const fs::path& path) {
    std::error_code error;
    const fs::path canonical = fs::weakly_canonical(path, error);
    return error ? path : canonical;
  }

  const AssetRequest& request_;
  Assets assets_;
};

}  // namespace

Result<Assets> collect_assets(const AssetRequest& request) { return Collection(request).make(); }

}  // namespace vcd::library
