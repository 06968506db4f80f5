#include <vcd/library/prune.h>

#include <set>

#include <vcd/format/file_bytes.h>

#include <vcd/library/provenance.h>

namespace vcd::library {
namespace {

namespace fs = std::filesystem;

bool is_ours(const fs::path& path) {
  const auto file = FileBytes::copy(path);
  if (!file) return false;
  std::vector<Finding> findings;
  const auto contents = read_sidecar(file->bytes(), CheckLevel::canonical, findings);
  return contents && provenance_value(*contents, "baker").starts_with("vc-bake ") &&
         !provenance_value(*contents, "source").empty();  // entries of a cache have none
}

}  // namespace

std::vector<fs::path> find_orphans(const Assets& assets) {
  std::set<fs::path> wanted;
  std::error_code error;
  for (const Asset& asset : assets.assets) wanted.insert(fs::weakly_canonical(asset.output, error));
  std::vector<std::string> folders;
  for (const fs::path& folder : assets.folders) folders.push_back(folder.string());
  std::vector<fs::path> orphans;
  for (const FoundFile& sidecar : find_files(folders, kSidecarExtensions).files)
    if (!wanted.contains(fs::weakly_canonical(sidecar.path, error)) && is_ours(sidecar.path))
      orphans.push_back(sidecar.path);
  return orphans;
}

}  // namespace vcd::library
