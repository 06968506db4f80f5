#include "attach.h"

#include <algorithm>
#include <string_view>

#include <vcd/baker/attach.h>
#include <vcd/baker/source.h>
#include <vcd/format/contents.h>
#include <vcd/format/file_bytes.h>
#include <vcd/writer/atomic_file.h>

#include <vcd/library/find.h>
#include <vcd/library/provenance.h>
#include "common/describe.h"
#include "common/paths.h"
#include "common/uri.h"

namespace vcd::tools {

using namespace baker;
using namespace library;
namespace {

namespace fs = std::filesystem;

Result<std::string> attached_bytes(const AttachRequest& request, const Asset& asset) {
  const auto mesh = read_file(asset.input);
  if (!mesh) return mesh.error();
  const auto sidecar = FileBytes::copy(asset.output);
  if (!sidecar) return sidecar.error();
  std::vector<Finding> findings;
  const auto contents = read_sidecar(sidecar->bytes(), CheckLevel::checksums, findings);
  if (!contents || provenance_value(*contents, "source-xxh3") != hex(content_hash(*mesh)))
    return Error{ErrorCode::io,
                 shown(asset.output) + ": is not the sidecar of " + shown(asset.input) + " as it is now"};
  Attachment attachment;
  if (request.embed) attachment.embedded = sidecar->bytes();
  else attachment.uri = uri_of(place_of(asset.output).lexically_relative(place_of(request.to).parent_path()));
  for (const ObjectContents& object : contents->objects)
    attachment.meshes.push_back({object.record->source_index, object.record->geometry_hash});
  return attach(asset.input, *mesh, attachment);
}

}  // namespace

std::optional<Error> check_attach(const AttachRequest& request, const Asset& asset) {
  const auto fault = [&](const std::string& reason) {
    return Error{ErrorCode::usage, shown(request.to) + ": " + reason};
  };
  const fs::path to = place_of(request.to), from = place_of(asset.input);
  if (extension_of(to) != extension_of(from)) return fault("--attach writes a file like " + shown(asset.input));
  if (to == from) return fault("is the mesh file itself; --attach writes another one");
  if (to.parent_path() != from.parent_path())
    return fault("--attach writes beside the mesh file, which may name others");
  if (asset.settings.subdivide > 0 || asset.settings.shift != BakeSettings().shift)
    return fault("a renderer would read other triangles from it than --subdivide and --shift make");
  const auto mesh = read_file(asset.input);
  if (!mesh) return mesh.error();
  const std::byte any{};
  const Attachment trial{request.embed ? "" : "any.vcd", Bytes(&any, request.embed ? 1 : 0), {{0, {}}}};
  if (const auto tried = attach(asset.input, *mesh, trial); !tried) return tried.error();
  std::error_code none;
  if (!fs::exists(fs::symlink_status(to, none))) return std::nullopt;
  const auto old = read_file(to);
  if (!old) return old.error();
  if (!is_attached(*old)) return fault("is there and was not written by --attach");
  return std::nullopt;
}

std::optional<Error> write_attached(const AttachRequest& request, const Asset& asset) {
  const auto bytes = attached_bytes(request, asset);
  if (!bytes) return bytes.error();
  AtomicFile file(request.to);
  file.append(std::as_bytes(std::span(*bytes)));
  const auto written = file.commit();
  return written ? std::nullopt : std::optional(written.error());
}

}  // namespace vcd::tools
