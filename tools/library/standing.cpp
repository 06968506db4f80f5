#include "standing.h"

#include <vcd/format/file_bytes.h>

namespace vcd {

Standing standing_of(const Asset& asset) {
  Standing standing;
  std::error_code error;
  standing.exists = std::filesystem::exists(asset.output, error);
  if (!standing.exists) return standing.reason = "no sidecar yet", standing;
  const auto file = FileBytes::copy(asset.output);
  if (!file) return standing.reason = "its sidecar cannot be read", standing;
  std::vector<Finding> findings;
  const auto contents = read_sidecar(file->bytes(), CheckLevel::canonical, findings);
  if (!contents) return standing.reason = "its sidecar is damaged", standing;
  standing.reason = why_outdated(asset, *contents);
  if (!standing.up_to_date()) return standing;
  for (SourceFile& source : dependencies_of(*contents)) standing.dependencies.push_back(std::move(source.name));
  standing.bytes = file->bytes().size();
  standing.objects = Json::array();
  for (const ObjectContents& object : contents->objects) standing.objects.push_back(describe_object(object));
  return standing;
}

}  // namespace vcd
