// make_fuzz_seeds FOLDER: the seeds that need encoders: Draco streams, glTF files with compressed parts, and what child
// processes hand back. See make_seeds.py.
#include <cstdio>

#include <meshoptimizer.h>

#include "fuzz/memory_file.h"
#include "ingest/draco_encode.h"
#include "ingest/gltf_builder.h"
#include "ingest/wire.h"
#include "support/meshes.h"

namespace vcd::test {
namespace {

void write(const std::filesystem::path& path, const std::string& bytes) {
  std::filesystem::create_directories(path.parent_path());
  std::ofstream(path, std::ios::binary) << bytes;
  std::printf("%s: %zu\n", path.c_str(), bytes.size());
}

DracoInput input_of(const baker::SourceMesh& mesh, int method, int bits) {
  DracoInput input;
  input.positions = mesh.positions, input.triangles = mesh.triangles;
  input.method = method, input.quantization_bits = bits;
  return input;
}

void write_streams(const std::filesystem::path& folder) {
  for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING}) {
    const std::string name = method == draco::MESH_SEQUENTIAL_ENCODING ? "sequential" : "edgebreaker";
    write(folder / (name + "-cube"), encode_draco(input_of(cube(), method, 0)));
    write(folder / (name + "-sphere"), encode_draco(input_of(sphere(4, 6), method, 8)));
    write(folder / (name + "-leaves"), encode_draco(input_of(leaves(3), method, 11)));
    DracoInput integers = input_of(cube(), method, 0);
    integers.as_int16 = true,
    integers.decoy = method == draco::MESH_SEQUENTIAL_ENCODING;  // two positions crash the other encoder
    write(folder / (name + "-integers"), encode_draco(integers));
    DracoInput grid = draco_grid(3);
    grid.method = method;
    write(folder / (name + "-grid"), encode_draco(grid));
  }
}

GltfBuilder draco_in_gltf() {
  const std::string stream = encode_draco(input_of(cube(), draco::MESH_EDGEBREAKER_ENCODING, 10));
  GltfBuilder builder;
  const size_t view = builder.add_view(Bytes(stream.begin(), stream.end()));
  json primitive = GltfBuilder::primitive(builder.add_accessor(std::nullopt, float_type, "VEC3", 8),
                                          builder.add_accessor(std::nullopt, uint32_type, "SCALAR", 36));
  primitive["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", view}, {"attributes", {{"POSITION", 0}}}};
  builder.add_mesh({primitive});
  builder.document["extensionsRequired"] = {"KHR_draco_mesh_compression"};
  return builder;
}

// A view whose bytes are `packed`, which expand to count * stride bytes.
size_t add_packed(GltfBuilder& builder, const Bytes& packed, size_t count, size_t stride, const char* mode) {
  const size_t view = builder.add_view(packed);
  json& object = builder.document["bufferViews"][view];
  object["extensions"]["EXT_meshopt_compression"] = {{"buffer", 0},
                                                     {"byteOffset", object["byteOffset"]},
                                                     {"byteLength", packed.size()},
                                                     {"count", count},
                                                     {"byteStride", stride},
                                                     {"mode", mode}};
  object["byteLength"] = count * stride;
  return view;
}

GltfBuilder meshopt_in_gltf() {
  const baker::SourceMesh mesh = cube();
  std::vector<uint32_t> indices;
  for (const baker::TriangleIndices& t : mesh.triangles) indices.insert(indices.end(), t.begin(), t.end());
  Bytes vertices(meshopt_encodeVertexBufferBound(8, 12)), triangles(meshopt_encodeIndexBufferBound(36, 8)),
      sequence(meshopt_encodeIndexSequenceBound(36, 8));
  vertices.resize(meshopt_encodeVertexBuffer(vertices.data(), vertices.size(), mesh.positions.data(), 8, 12));
  triangles.resize(meshopt_encodeIndexBuffer(triangles.data(), triangles.size(), indices.data(), 36));
  sequence.resize(meshopt_encodeIndexSequence(sequence.data(), sequence.size(), indices.data(), 36));
  GltfBuilder builder;
  const size_t positions =
      builder.add_accessor(add_packed(builder, vertices, 8, 12, "ATTRIBUTES"), float_type, "VEC3", 8);
  const size_t first =
      builder.add_accessor(add_packed(builder, triangles, 36, 4, "TRIANGLES"), uint32_type, "SCALAR", 36);
  const size_t second =
      builder.add_accessor(add_packed(builder, sequence, 36, 4, "INDICES"), uint32_type, "SCALAR", 36);
  builder.add_mesh({GltfBuilder::primitive(positions, first), GltfBuilder::primitive(positions, second)});
  builder.document["extensionsUsed"] = {"EXT_meshopt_compression"};
  return builder;
}

std::string on_the_wire(const Result<baker::Ingested>& result) {
  const fuzz::MemoryFile file("result");
  fuzz::require(write_result(file.descriptor(), result), "a result can be written");
  return file.content();
}

baker::Ingested two_meshes() {
  baker::Ingested ingested{{triangle(), cube()}, {"a note"}, {}, {}, {{"two.gltf", {1}}, {"two.bin", {2}}}};
  ingested.meshes[1].shift = {1.5, -2, 3e6};
  ingested.meshes[1].left_out = {1, 2};
  ingested.placements = {{.mesh = 1}, {.mesh = 0, .transform = {0, 1, 0, 4, -1, 0, 0, 5, 0, 0, 2, 6}}};
  ingested.lights = {{.position = {1, 2, 3}, .range = 9}, {.shape = baker::SceneLight::Shape::sky}};
  return ingested;
}

}  // namespace
}  // namespace vcd::test

int main(int argc, char** argv) {
  using namespace vcd::test;
  if (argc != 2) return 1;
  const std::filesystem::path folder = argv[1];
  write_streams(folder / "drc");
  write(folder / "gltf" / "draco", draco_in_gltf().glb());
  write(folder / "gltf" / "meshopt", meshopt_in_gltf().glb());
  write(folder / "wire" / "meshes", on_the_wire(two_meshes()));
  write(folder / "wire" / "error", on_the_wire(vcd::Error{vcd::ErrorCode::io, "a message"}));
  return 0;
}
