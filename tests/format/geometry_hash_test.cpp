// A mesh in a renderer's buffers is known by the hash that the baker gives it.
#include <vcd/format/geometry_hash.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <vector>

#include <gtest/gtest.h>

#include <vcd/baker/prepare.h>

#include "support/meshes.h"

namespace vcd::test {
namespace {

using baker::SourceMesh;

GeometryHash hash_of_baker(SourceMesh mesh) { return baker::prepare(std::move(mesh)).value().geometry_hash; }

TEST(GeometryHash, IsTheBakers) {
  for (const SourceMesh& mesh : {cube(), sphere(), leaves(50)}) {
    const auto hash = geometry_hash(mesh.positions, mesh.triangles);
    ASSERT_TRUE(hash.ok());
    EXPECT_EQ(*hash, hash_of_baker(mesh));
  }
  EXPECT_NE(hash_of_baker(cube()), hash_of_baker(sphere()));
}

// As renderers interleave them: a position every 20 bytes from an odd address, indices every 7 or 14.
template <class Index>
void expect_the_same_from_strided_buffers() {
  const SourceMesh mesh = sphere();
  constexpr size_t kStride = 20, kFaceStride = 3 * sizeof(Index) + 1;
  std::vector<std::byte> vertices(1 + kStride * mesh.positions.size(), std::byte{0xFF});
  for (size_t i = 0; i < mesh.positions.size(); ++i)
    std::memcpy(&vertices[1 + i * kStride], mesh.positions[i].data(), sizeof(Position));
  std::vector<std::byte> faces(kFaceStride * mesh.triangles.size(), std::byte{0xFF});
  for (size_t i = 0; i < mesh.triangles.size(); ++i)
    for (size_t corner = 0; corner < 3; ++corner) {
      const auto index = static_cast<Index>(mesh.triangles[i][corner]);
      std::memcpy(&faces[i * kFaceStride + corner * sizeof index], &index, sizeof index);
    }
  const auto hash = geometry_hash({&vertices[1], mesh.positions.size(), kStride},
                                  {faces.data(), mesh.triangles.size(), 3, sizeof(Index), kFaceStride});
  ASSERT_TRUE(hash.ok());
  EXPECT_EQ(*hash, hash_of_baker(mesh));
}

TEST(GeometryHash, TakesStridedBuffersOfEitherIndex) {
  expect_the_same_from_strided_buffers<uint16_t>();
  expect_the_same_from_strided_buffers<uint32_t>();
}

TEST(GeometryHash, CutsQuadsAsEmbreeDoes) {
  // Not flat, so that the other diagonal is other geometry.
  SourceMesh mesh{"", 0, {{0, 0, 0}, {1, 0, 0}, {1, 1, 1}, {0, 1, 0}, {5, 5, 5}}, {{0, 1, 3}, {2, 3, 1}}};
  const uint16_t quads[] = {0, 1, 2, 3};
  const PositionBuffer positions{mesh.positions.data(), mesh.positions.size()};
  EXPECT_EQ(*geometry_hash(positions, {quads, 1, 4, 2}), hash_of_baker(mesh));
  // A triangle {a, b, d} as a quad.
  const uint32_t one[] = {0, 1, 3, 3};
  mesh.triangles.pop_back();
  EXPECT_EQ(*geometry_hash(positions, {one, 1, 4}), hash_of_baker(mesh));
}

TEST(GeometryHash, RefusesWhatCannotBeBaked) {
  const auto code = [](const auto& positions, const auto& faces) {
    return geometry_hash(positions, faces).error().code;
  };
  SourceMesh far = triangle(), odd = triangle(), flat = triangle();
  far.triangles[0][1] = 3;
  odd.positions[2][0] = std::numeric_limits<float>::infinity();
  flat.triangles[0][1] = 0;
  EXPECT_EQ(code(far.positions, far.triangles), ErrorCode::usage);
  EXPECT_EQ(code(odd.positions, odd.triangles), ErrorCode::usage);
  EXPECT_EQ(code(flat.positions, flat.triangles), ErrorCode::invalid_file);
  EXPECT_EQ(geometry_hash(PositionBuffer{nullptr, 0}, IndexBuffer{nullptr, 0}).error().code, ErrorCode::invalid_file);
  const PositionBuffer positions{far.positions.data(), 3};
  EXPECT_EQ(code(positions, IndexBuffer{far.triangles.data(), 1, 5}), ErrorCode::usage);
  EXPECT_EQ(code(positions, IndexBuffer{far.triangles.data(), 1, 3, 8}), ErrorCode::usage);
}

}  // namespace
}  // namespace vcd::test
