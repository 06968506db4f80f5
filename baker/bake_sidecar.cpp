#include <vcd/baker/bake_sidecar.h>

#include <memory>
#include <new>
#include <string>
#include <utility>
#include <vector>

#include <vcd/baker/bake.h>
#include <vcd/baker/prepare.h>
#include <vcd/writer/writer.h>

namespace vcd::baker {
namespace {

Result<PreparedMesh> prepare_buffers(const MeshToBake& mesh, size_t index) {
  auto triangles = triangles_of(mesh.faces);
  if (!triangles)
    return Error{triangles.error().code, "mesh \"" + std::string(mesh.name) + "\": " + triangles.error().message};
  SourceMesh source;
  source.name = mesh.name;
  source.source_index = static_cast<uint32_t>(index);
  source.positions = positions_of(mesh.positions);
  source.triangles = std::move(*triangles);
  return prepare(std::move(source));
}

BakeOptions options_of(const SidecarOptions& given, size_t index) {
  BakeOptions options;
  options.method = given.method;
  options.depth = given.depth;
  options.budget_bytes = given.budget_bytes;
  options.budget_seconds = given.budget_seconds;
  options.threads = given.threads;
  options.hierarchy = given.hierarchy;
  options.horizons = given.horizons;
  options.audit_lines = given.audit_lines;
  options.stop = given.stop;
  if (!given.progress) return options;
  // What is called here is called by one thread at a time, so that the pass needs no lock.
  const auto pass = std::make_shared<const char*>("");
  options.on_pass = [&given, index, pass](BakePass begun) { given.progress(index, *pass = name_of(begun), 0); };
  options.progress = [&given, index, pass](const BakeProgress& p) { given.progress(index, *pass, p.fraction); };
  return options;
}

// Calls write(contents) with the baked meshes, which live as long as the call.
template <class Write>
auto with_baked(std::span<const MeshToBake> meshes, const SidecarOptions& options, Write&& write)
    -> decltype(write(SidecarToWrite{})) try {
  std::vector<BakedObject> objects;
  for (size_t i = 0; i < meshes.size(); ++i) {
    const auto mesh = prepare_buffers(meshes[i], i);
    if (!mesh) return mesh.error();
    auto object = bake(*mesh, options_of(options, i));
    if (!object) return object.error();
    objects.push_back(std::move(*object));
  }
  SidecarToWrite contents;
  for (const BakedObject& object : objects) contents.objects.push_back(object.to_write());
  contents.provenance = options.provenance;
  contents.storage = options.compress ? Storage::zstd : Storage::raw;
  contents.stop = options.stop;
  return write(contents);
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::runtime, "out of memory"};
}

}  // namespace

Result<uint64_t> bake_sidecar(const std::filesystem::path& path, std::span<const MeshToBake> meshes,
                              const SidecarOptions& options) {
  return with_baked(meshes, options, [&](const SidecarToWrite& contents) { return write_sidecar(path, contents); });
}

Result<AlignedBytes> bake_sidecar(std::span<const MeshToBake> meshes, const SidecarOptions& options) {
  return with_baked(meshes, options, [](const SidecarToWrite& contents) { return sidecar_bytes(contents); });
}

}  // namespace vcd::baker
