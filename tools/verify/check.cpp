#include "check.h"

#include <new>

#include <vcd/format/file_bytes.h>
#include <vcd/runtime/sidecar.h>

#include "answers.h"
#include "common/memory.h"
#include "common/meshes.h"
#include "common/paths.h"
#include "mesh_facts.h"
#include "mesh_source.h"
#include "pairing.h"

namespace vcd::verify {
using namespace baker;
namespace {

std::unique_ptr<MeshSource> source_of(const FoundFile& file, const SidecarContents& contents,
                                      const CheckOptions& options) {
  if (options.library) return against_library(*options.library, file, contents);
  if (!options.against.empty()) return against_file(options.against, ingest_options_of(contents, options.ingest));
  return nullptr;
}

// Nothing, and the outcome says why, if what is embedded is not the object's mesh.
std::optional<PreparedMesh> embedded(const ObjectContents& object, const std::string& place, Outcome& outcome) {
  auto mesh = embedded_mesh(outcome.path.string(), object);
  if (mesh && mesh->geometry_hash == object.record->geometry_hash) return std::move(*mesh);
  const std::string why =
      mesh ? "it is not the mesh that the object was baked from" : reason(mesh.error(), outcome.path);
  outcome.add(IssueId::embedded_geometry, mesh ? ErrorCode::invalid_file : mesh.error().code, place, why);
  return std::nullopt;
}

void check_object(const ObjectContents& object, const std::string& place, const Answering& answering,
                  MeshSource* source, const CheckOptions& options, Outcome& outcome, Json& json) {
  std::optional<PreparedMesh> own;
  if (!object.geometry.empty()) {
    own = embedded(object, place, outcome);
    if (!own) return;
  } else if (!source) {  // no geometry at hand is fine: then the structure is all there is
    if (options.segment || options.max_wrong >= 0)
      outcome.add(IssueId::no_geometry, ErrorCode::usage, place,
                  "no geometry is embedded; --segment and --max-wrong need --against MESH");
    return;
  }
  const PreparedMesh* mesh = source ? source->mesh_of(object, place, outcome) : &*own;
  if (!mesh) return;
  check_facts(*object.record, *mesh, place, outcome);
  check_answers(answering, *mesh, place, options, outcome, json);
}

void check_objects(const FoundFile& file, Bytes bytes, const SidecarContents& contents, const CheckOptions& options,
                   Outcome& outcome) {
  const auto all = Sidecar::open_buffer(bytes, {.check = CheckLevel::bounds});
  const auto proven = Sidecar::open_buffer(bytes, {.check = CheckLevel::bounds, .proven_only = true});
  if (!all || !proven) return outcome.add(IssueId::unreadable, ErrorCode::runtime, "", "out of memory");
  const auto source = source_of(file, contents, options);
  for (size_t i = 0; i < contents.objects.size(); ++i) {
    const ObjectContents& object = contents.objects[i];
    outcome.geometries.push_back(object.record->geometry_hash);
    Json& json = outcome.details["objects"][i];
    json["name"] = object.name;
    const std::string place = "object " + std::to_string(i) + " " + printable(object.name);
    check_object(object, place, {all->object(i), proven->object(i)}, source.get(), options, outcome, json);
    if (options.stop()) throw Interrupted{};
  }
}

void check_file(const FoundFile& file, const CheckOptions& options, Outcome& outcome) {
  std::error_code unknown;
  const uint64_t size = std::filesystem::file_size(file.path, unknown);
  if (!unknown)
    if (const auto fault = check_memory(file.path.string(), size))
      return outcome.add(IssueId::unreadable, fault->code, "", reason(*fault, file.path));
  const auto bytes = FileBytes::copy(file.path);
  if (!bytes) return outcome.add(IssueId::unreadable, bytes.error().code, "", reason(bytes.error(), file.path));
  std::vector<Finding> findings;
  const auto contents = read_sidecar(bytes->bytes(), CheckLevel::canonical, findings);
  for (const Finding& finding : findings) outcome.add(finding);
  if (contents) check_objects(file, bytes->bytes(), *contents, options, outcome);
}

}  // namespace

Outcome check_sidecar(const FoundFile& file, const CheckOptions& options) {
  Outcome outcome{.subject = Subject::sidecar, .path = file.path};
  try {
    if (options.stop()) throw Interrupted{};
    check_file(file, options, outcome);
  } catch (const std::bad_alloc&) {
    outcome.add(IssueId::unreadable, ErrorCode::runtime, "", "out of memory");
  } catch (const Interrupted&) {
    // What was found in the bytes stands. Children that read meshes may have been interrupted too: what came of them
    // says nothing.
    std::erase_if(outcome.issues, [](const Issue& issue) { return !issue.in_bytes; });
    outcome.add(IssueId::not_verified, ErrorCode::runtime, "", "interrupted");
  }
  return outcome;
}

}  // namespace vcd::verify
