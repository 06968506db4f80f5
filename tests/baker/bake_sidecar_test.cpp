#include <vcd/baker/bake_sidecar.h>

#include <algorithm>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <gtest/gtest.h>

#include <vcd/baker/bake.h>
#include <vcd/runtime/sidecar.h>

#include "support/files.h"
#include "support/meshes.h"

namespace vcd::test {
using namespace baker;
namespace {

MeshToBake in_memory(const SourceMesh& mesh) {
  return {mesh.name, {mesh.positions.data(), mesh.positions.size()}, {mesh.triangles.data(), mesh.triangles.size()}};
}

SidecarOptions proven_quickly() { return {.method = Method::proven, .depth = 2, .audit_lines = 1000}; }

bool equal(const AlignedBytes& a, Bytes b) { return std::ranges::equal(Bytes(a.data.get(), a.size), b); }

TEST(BakeSidecar, GivesWhatTheBakerAndTheWriterGive) {
  const SourceMesh meshes[] = {cube(), sphere()};
  const MeshToBake given[] = {in_memory(meshes[0]), in_memory(meshes[1])};
  SidecarOptions options = proven_quickly();
  options.provenance = {{"exporter", "a test"}};
  const auto bytes = bake_sidecar(given, options);
  ASSERT_TRUE(bytes) << bytes.error().message;

  std::vector<BakedObject> objects;
  SidecarToWrite contents;
  contents.provenance = options.provenance;
  for (uint32_t i = 0; i < 2; ++i) {
    SourceMesh source = meshes[i];
    source.source_index = i;
    BakeOptions inner;
    inner.method = Method::proven, inner.depth = 2, inner.audit_lines = 1000;
    objects.push_back(std::move(*bake(*prepare(std::move(source)), inner)));
  }
  for (const BakedObject& object : objects) contents.objects.push_back(object.to_write());
  const AlignedBytes expected = std::move(*sidecar_bytes(contents));
  EXPECT_TRUE(equal(*bytes, {expected.data.get(), expected.size}));

  const TemporaryFolder folder;
  const auto path = folder.path() / "two.vcd";
  const auto size = bake_sidecar(path, given, options);
  ASSERT_TRUE(size) << size.error().message;
  EXPECT_EQ(*size, bytes->size);
  EXPECT_TRUE(equal(*bytes, read_file(path)));
}

TEST(BakeSidecar, TakesTheArraysOfProgramsAsTheyAre) {
  struct Vertex {
    float position[3], normal[3];
  };
  const Vertex corners[] = {{{0, 0, 0}, {}}, {{1, 0, 0}, {}}, {{1, 1, 0}, {}}, {{0, 1, 0.5f}, {}}};
  const uint16_t quad[] = {0, 1, 2, 3};
  const MeshToBake mesh{
      "quad", {corners, 4, sizeof(Vertex)}, {.first = quad, .count = 1, .corners = 4, .index_size = 2}};
  const auto bytes = bake_sidecar({&mesh, 1}, proven_quickly());
  ASSERT_TRUE(bytes) << bytes.error().message;
  const auto sidecar = Sidecar::open_buffer({bytes->data.get(), bytes->size});
  ASSERT_TRUE(sidecar);
  EXPECT_EQ(sidecar->object(0).record().triangle_count, 2u);
  EXPECT_TRUE(sidecar->find(*geometry_hash(mesh.positions, mesh.faces)));
}

TEST(BakeSidecar, TellsItsProgressAndStops) {
  const SourceMesh source = sphere();
  const MeshToBake meshes[] = {in_memory(source), in_memory(source)};
  std::set<size_t> seen;
  std::set<std::string> passes;
  double most = 0;
  SidecarOptions options = proven_quickly();
  options.progress = [&](size_t mesh, std::string_view pass, double done) {
    seen.insert(mesh), passes.emplace(pass), most = std::max(most, done);
  };
  ASSERT_TRUE(bake_sidecar(meshes, options));
  EXPECT_EQ(seen, (std::set<size_t>{0, 1}));
  EXPECT_TRUE(passes.contains("classify") && passes.contains("audit"));
  EXPECT_DOUBLE_EQ(most, 1);

  options.stop = [] { return true; };
  const TemporaryFolder folder;
  const auto stopped = bake_sidecar(folder.path() / "stopped.vcd", meshes, options);
  ASSERT_FALSE(stopped);
  EXPECT_EQ(stopped.error().code, ErrorCode::runtime);
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(BakeSidecar, NamesTheMeshThatIsWrong) {
  const SourceMesh source = cube();
  MeshToBake mesh = in_memory(source);
  const auto fault = [&](const SidecarOptions& options) {
    const auto bytes = bake_sidecar({&mesh, 1}, options);
    return bytes ? Error{} : bytes.error();
  };
  SidecarOptions too_deep = proven_quickly();
  too_deep.depth = 9;
  EXPECT_EQ(fault(too_deep).code, ErrorCode::usage);
  mesh.faces.corners = 5;
  EXPECT_EQ(fault(proven_quickly()).code, ErrorCode::usage);
  EXPECT_NE(fault(proven_quickly()).message.find("cube"), std::string::npos);
  mesh = in_memory(source);
  mesh.positions.count = 3;
  EXPECT_EQ(fault(proven_quickly()).code, ErrorCode::usage);
  EXPECT_NE(fault(proven_quickly()).message.find("cube"), std::string::npos);
  mesh.faces.count = 0;
  EXPECT_EQ(fault(proven_quickly()).code, ErrorCode::invalid_file);
}

}  // namespace
}  // namespace vcd::test
