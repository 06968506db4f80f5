#include <vcd/library/staleness.h>

#include <vcd/format/file_bytes.h>

#include <vcd/library/provenance.h>
#include "common/describe.h"
#include "common/paths.h"

namespace vcd::library {
namespace {

using namespace tools;

// A clause; empty if a bake of these files would write this sidecar.
std::string why_stale(const Asset& asset, const SidecarContents& sidecar) {
  const auto now = provenance_of(asset, {});
  if (provenance_value(sidecar, "baker") != now.at("baker")) return "made by another baker";
  if (provenance_value(sidecar, "settings") != now.at("settings")) return "made with other settings";
  for (const SectionEntry& section : sidecar.sections)
    if (section.type == kSectionTree &&
        (section.alignment == kPageAlignment) != (asset.settings.storage == Storage::raw))
      return "stored in another way";
  if (provenance_value(sidecar, "source") != now.at("source")) return "made of a file of another name";
  const auto hash = baker::hash_file(asset.input);
  if (!hash || provenance_value(sidecar, "source-xxh3") != hex(*hash)) return "the mesh file has changed";
  for (const baker::SourceFile& file : dependencies_of(sidecar)) {
    const auto other = baker::hash_file(asset.input.parent_path() / file.name);
    if (!other || *other != file.hash) return shown(file.name) + " has changed";
  }
  return {};
}

}  // namespace

Staleness staleness_of(const Asset& asset) {
  Staleness staleness;
  const auto stale = [&](std::string reason) { return staleness.reason = std::move(reason), staleness; };
  std::error_code error;
  if (!std::filesystem::exists(asset.output, error)) return stale("no sidecar yet");
  const auto file = FileBytes::copy(asset.output);
  if (!file) return stale("its sidecar cannot be read");
  std::vector<Finding> findings;
  const auto contents = read_sidecar(file->bytes(), CheckLevel::canonical, findings);
  if (!contents) return stale("its sidecar is damaged");
  if (const std::string reason = why_stale(asset, *contents); !reason.empty()) return stale(reason);
  for (baker::SourceFile& source : dependencies_of(*contents)) staleness.dependencies.push_back(std::move(source.name));
  staleness.bytes = file->bytes().size();
  Json objects = Json::array();
  for (const ObjectContents& object : contents->objects) objects.push_back(describe_object(object));
  staleness.report = json_text({{"bytes", staleness.bytes}, {"objects", std::move(objects)}});
  return staleness;
}

}  // namespace vcd::library
