#include <vcd/verify/check.h>

#include <new>

#include <vcd/format/file_bytes.h>
#include <vcd/runtime/sidecar.h>

#include "answers.h"
#include "common/memory.h"
#include "common/meshes.h"
#include "common/paths.h"
#include "hierarchy_triangles.h"
#include "mesh_facts.h"
#include "mesh_source.h"
#include "pairing.h"

namespace vcd::verify {

using namespace baker;
using namespace tools;
using namespace library;
namespace {

// Nothing, and the outcome says why, if what is embedded is not the object's mesh.
std::optional<PreparedMesh> embedded(const ObjectContents& object, const std::string& place, Outcome& outcome) {
  auto mesh = embedded_mesh(outcome.path.string(), object);
  if (mesh && mesh->geometry_hash == object.record->geometry_hash) return std::move(*mesh);
  const std::string why =
      mesh ? "it is not the mesh that the object was baked from" : reason(mesh.error(), outcome.path);
  outcome.add(IssueId::embedded_geometry, mesh ? ErrorCode::invalid_file : mesh.error().code, place, why);
  return std::nullopt;
}

// Where an object's mesh comes from.
struct Meshes {
  MeshSource* source;    // null: there is none but what is embedded
  bool decode_embedded;  // and checked: in a child process
};

void check_object(const ObjectContents& object, const Answering& answering, const Meshes& meshes,
                  const CheckOptions& options, Outcome& outcome, ObjectCheck& check) {
  std::optional<PreparedMesh> own;
  if (meshes.decode_embedded && !object.geometry.empty()) {
    own = embedded(object, check.place, outcome);
    if (!own) return;
  } else if (!meshes.source) {  // no geometry at hand is fine: then the structure is all there is
    if (options.segment || options.max_wrong >= 0)
      outcome.add(IssueId::no_geometry, ErrorCode::usage, check.place,
                  "no geometry is embedded; --segment and --max-wrong need --against MESH");
    return;
  }
  const PreparedMesh* mesh = meshes.source ? meshes.source->mesh_of(object, check.place, outcome) : &*own;
  if (!mesh) return;
  check_facts(*object.record, *mesh, check.place, outcome);
  check_triangles(object.hierarchy, *mesh, check.place, outcome);
  if (object.horizon && !options.segment) check_horizons(object, *mesh, check.place, options, outcome);
  check_answers(answering, *mesh, check.place, options, outcome, check);
}

void check_objects(Bytes bytes, const SidecarContents& contents, const Meshes& meshes, const CheckOptions& options,
                   Outcome& outcome) {
  const auto all = Sidecar::open_buffer(bytes, {.check = CheckLevel::bounds});
  const auto proven = Sidecar::open_buffer(bytes, {.check = CheckLevel::bounds, .proven_only = true});
  if (!all || !proven) return outcome.add(IssueId::unreadable, ErrorCode::runtime, "", "out of memory");
  for (size_t i = 0; i < contents.objects.size(); ++i) {
    const ObjectContents& object = contents.objects[i];
    outcome.geometries.push_back(object.record->geometry_hash);
    ObjectCheck& check = outcome.objects.emplace_back();
    check.name = object.name;
    check.place = "object " + std::to_string(i) + " " + printable(object.name);
    check_object(object, {all->object(i), proven->object(i)}, meshes, options, outcome, check);
    if (options.stop()) throw Interrupted{};
  }
}

// The structure, byte by byte. Nothing if the findings include an error.
std::optional<SidecarContents> check_structure(Bytes bytes, Outcome& outcome) {
  std::vector<Finding> findings;
  auto contents = read_sidecar(bytes, CheckLevel::canonical, findings);
  for (const Finding& finding : findings) outcome.add(finding);
  return contents ? std::optional(std::move(*contents)) : std::nullopt;
}

void check_file(const FoundFile& file, const CheckOptions& options, Outcome& outcome) {
  std::error_code unknown;
  const uint64_t size = std::filesystem::file_size(file.path, unknown);
  if (!unknown)
    if (const auto fault = check_memory(file.path.string(), size))
      return outcome.add(IssueId::unreadable, fault->code, "", reason(*fault, file.path));
  const auto bytes = FileBytes::copy(file.path);
  if (!bytes) return outcome.add(IssueId::unreadable, bytes.error().code, "", reason(bytes.error(), file.path));
  const auto contents = check_structure(bytes->bytes(), outcome);
  if (!contents) return;
  std::unique_ptr<MeshSource> source;
  if (options.library) source = against_library(*options.library, file, *contents);
  else if (!options.against.empty())
    source = against_file(options.against, ingest_options_of(*contents, options.ingest));
  check_objects(bytes->bytes(), *contents, {source.get(), true}, options, outcome);
}

// What `check` finds, or why it came to no end.
template <class Check>
Outcome checked(const std::filesystem::path& path, const CheckOptions& options, Check check) {
  Outcome outcome{.subject = Subject::sidecar, .path = path};
  try {
    if (options.stop()) throw Interrupted{};
    check(outcome);
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

}  // namespace

Outcome check_sidecar(const FoundFile& file, const CheckOptions& options) {
  return checked(file.path, options, [&](Outcome& outcome) { check_file(file, options, outcome); });
}

Outcome check_bytes(Bytes sidecar, std::span<const PreparedMesh> meshes, const CheckOptions& options,
                    const std::filesystem::path& name) {
  return checked(name, options, [&](Outcome& outcome) {
    const auto contents = check_structure(sidecar, outcome);
    if (!contents) return;
    const auto source = against_meshes(meshes);
    check_objects(sidecar, *contents, {source.get(), false}, options, outcome);
  });
}

}  // namespace vcd::verify
