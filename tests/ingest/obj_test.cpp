#include <cmath>
#include <limits>

#include "mesh_files.h"

namespace vcd::baker {
namespace {

using test::any_note_has;
using test::area_from_above;
using test::least_area_from_above;
using test::soup_of;
using test::Triangles;
using test::with_crlf;

class Obj : public test::MeshFiles {};

const std::string kSquare = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

TEST_F(Obj, ReadsAllGroupsAsOneMeshNamedLikeTheFile) {
  const Ingested in =
      read("Two Groups.obj", "mtllib none.mtl\no a\n" + kSquare + "g x\nf 1 2 3\no b\nusemtl m\nf 1 3 4\n");
  EXPECT_EQ(in.meshes[0].name, "Two Groups");
  EXPECT_EQ(in.meshes[0].source_index, 0u);
  EXPECT_EQ(in.meshes[0].triangles, (Triangles{{0, 1, 2}, {0, 2, 3}}));
  EXPECT_TRUE(in.notes.empty());
}

TEST_F(Obj, ExtensionInAnyCase) { EXPECT_EQ(read("a.OBJ", kSquare + "f 1 2 3\n").meshes[0].triangles.size(), 1u); }

TEST_F(Obj, CornerFormsAndNegativeIndices) {
  const std::string uv = "vt 0 0\nvn 0 0 1\n";
  const Ingested in =
      read("a.obj", kSquare + uv + "f 1/1 2/1 3/1\nf 1//1 2//1 3//1\nf 1/1/1 2/1/1 3/1/1\nf -4 -3 -2\n");
  EXPECT_EQ(in.meshes[0].triangles, (Triangles{{0, 1, 2}, {0, 1, 2}, {0, 1, 2}, {0, 1, 2}}));
}

TEST_F(Obj, NegativeIndicesCountFromWhereTheyStand) {
  const Ingested in = read("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf -3 -2 -1\nv 5 5 5\nf -3 -2 -1\n");
  EXPECT_EQ(in.meshes[0].triangles, (Triangles{{0, 1, 2}, {1, 2, 3}}));
}

TEST_F(Obj, AFaceMayComeBeforeItsVertices) {
  EXPECT_EQ(read("a.obj", "f 1 2 3\n" + kSquare).meshes[0].triangles, (Triangles{{0, 1, 2}}));
  expect_invalid("b.obj", "f 1 2 5\n" + kSquare, {"line 1", "5", "out of range"});
}

TEST_F(Obj, LineEndsMarksAndContinuations) {
  const std::string text = kSquare + "f 1 2 \\\n 3\nf 1 \\\n3 \\\n4";  // no line end at the end
  const Triangles both = {{0, 1, 2}, {0, 2, 3}};
  EXPECT_EQ(read("lf.obj", text).meshes[0].triangles, both);
  EXPECT_EQ(read("crlf.obj", with_crlf(text)).meshes[0].triangles, both);
  EXPECT_EQ(read("bom.obj", "\xEF\xBB\xBF" + text).meshes[0].triangles, both);
  std::string cr = text;
  std::replace(cr.begin(), cr.end(), '\n', '\r');
  EXPECT_EQ(read("cr.obj", cr).meshes[0].triangles, both);
}

TEST_F(Obj, ABackslashAfterANameOrRemarkSwallowsNoVertex) {
  const Ingested in = read("a.obj", "# C:\\models\\\nv 0 0 0\nmtllib C:\\m\\\nv 1 0 0\nv 1 1 0\nf 1 2 3\n");
  EXPECT_EQ(in.meshes[0].positions.size(), 3u);
}

TEST_F(Obj, WeightAndColourArePassedOver) {
  const Ingested in = read("a.obj", "v 0 0 0 1\nv 1 0 0 0.5 0.5 0.5\nv 1 1 0 nan 0 0 # remark\nf 1 2 3 # remark\n");
  EXPECT_EQ(in.meshes[0].positions[2], (Position{1, 1, 0}));
}

TEST_F(Obj, PointsLinesAndOddStatementsGetANote) {
  const Ingested in = read("a.obj", kSquare + "p 1\np 2\nl 1 2\ncurv 0 1 2\nf 1 2 3\nf 1 2\nf 1 1 2\n");
  EXPECT_EQ(in.meshes[0].triangles.size(), 1u);
  EXPECT_TRUE(any_note_has(in, "mesh \"a\": 2 point statements"));
  EXPECT_TRUE(any_note_has(in, "1 line statement"));
  EXPECT_TRUE(any_note_has(in, "\"curv\" in line 8"));
  EXPECT_TRUE(any_note_has(in, "2 faces"));
}

TEST_F(Obj, NumbersAreTheNearestFloats) {
  // The first lies a hair above the middle of two floats; by way of a double it would round to the even,
  // lower one.
  const Ingested in = read("a.obj",
                           "v 1.00000017881393432617187499 +1e2 -.5\nv 1e-50 1e-45 123456789\n"
                           "v 3.4028235e38 1e-400 5.\nf 1 2 3\n");
  const std::vector<Position>& p = in.meshes[0].positions;
  EXPECT_EQ(p[0], (Position{1.00000011920928955078125f, 100.0f, -0.5f}));
  EXPECT_EQ(p[1], (Position{0.0f, std::numeric_limits<float>::denorm_min(), 123456792.0f}));
  EXPECT_EQ(p[2], (Position{std::numeric_limits<float>::max(), 0.0f, 5.0f}));
}

TEST_F(Obj, BadVerticesAreErrorsEvenIfUnused) {
  for (const std::string bad : {"nan 0 0", "0 inf 0", "0 0 -inf", "1e39 0 0"}) {
    expect_invalid("a.obj", kSquare + "v " + bad + "\nf 1 2 3\n", {"line 5", "vertex 5", "not finite"});
  }
  for (const std::string bad : {"1.x 0 0", "1,5 0 0", "3.1+e2 0 0", "0 0 0 v", "0x10 0 0", "+-1 0 0"}) {
    expect_invalid("a.obj", kSquare + "v " + bad + "\nf 1 2 3\n", {"line 5", "vertex 5", "not a number"});
  }
  expect_invalid("a.obj", kSquare + "v 1 2\nf 1 2 3\n", {"line 5", "fewer than three coordinates"});
}

TEST_F(Obj, IndicesOutOfRangeAreErrors) {
  for (const std::string bad : {"1 2 5", "-5 1 2", "1 2 4294967297", "1 2 9223372036854775807"}) {
    expect_invalid("a.obj", kSquare + "f " + bad + "\n", {"line 5", "out of range"});
  }
  expect_invalid("a.obj", kSquare + "f 0 1 2\n", {"line 5", "index 0"});
  for (const std::string bad : {"1 2 x", "1 2 3x", "1 2 3/a", "1 2 99999999999999999999", "1 2 /3"}) {
    expect_invalid("a.obj", kSquare + "f " + bad + "\n", {"line 5", "not a corner"});
  }
}

TEST_F(Obj, TextureAndNormalIndicesAreNotLookedUp) {
  EXPECT_EQ(read("a.obj", kSquare + "f 1/9/9 2/-9 3//77\n").meshes[0].triangles.size(), 1u);
}

TEST_F(Obj, NoTriangleIsAnErrorThatCountsThePoints) {
  expect_invalid("a.obj", kSquare + "p 1 2 3 4\n", {"holds 4 points and no triangle"});
  expect_invalid("a.obj", "", {"no triangle"});
}

TEST_F(Obj, Utf16IsUnsupported) {
  expect_error("a.obj", std::string("\xFE\xFF\0v\0 ", 6), ErrorCode::unsupported, {"UTF-16"});
  expect_error("a.obj", std::string("v\0 \0 0\0", 8), ErrorCode::unsupported, {"UTF-16"});
}

TEST_F(Obj, ConvexPolygonsBecomeAFanFromTheFirstCorner) {
  const Ingested in = read("a.obj", "v 1 0 0\nv 2 1 0\nv 1 2 0\nv 0 1.5 0\nv 0 .5 0\nf 2 3 4 5 1\n");
  EXPECT_EQ(in.meshes[0].triangles, (Triangles{{1, 2, 3}, {1, 3, 4}, {1, 4, 0}}));
}

// Area, orientation and count together: n - 2 triangles that all turn the polygon's way and add up to its
// area tile it.
void expect_tiled(const Ingested& in, size_t triangle_count, double area) {
  EXPECT_EQ(in.meshes[0].triangles.size(), triangle_count);
  EXPECT_NEAR(area_from_above(in.meshes[0]), area, 1e-9);
  EXPECT_GT(least_area_from_above(in.meshes[0]), 0.0);
  EXPECT_TRUE(in.notes.empty());
}

TEST_F(Obj, ConcavePolygonsAreTiled) {
  // An arrow head whose fan from the first corner would leave it; an L; a comb.
  expect_tiled(read("arrow.obj", "v 0 0 0\nv 4 2 0\nv 0 4 0\nv 1 2 0\nf 1 2 3 4\n"), 2, 6);
  expect_tiled(read("l.obj", "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\nf 3 4 5 6 1 2\n"), 4, 3);
  std::string comb = "v 0 0 0\nv 20 0 0\n";
  std::string face = "f 1 2";
  for (int i = 0; i <= 20; ++i) {
    comb += "v " + std::to_string(20 - i) + (i % 2 == 0 ? " 5 0\n" : " 1 0\n");
    face.append(" ").append(std::to_string(i + 3));
  }
  expect_tiled(read("comb.obj", comb + face + "\n"), 21, 60);
}

TEST_F(Obj, CollinearCornersLeaveNoTriangleWithoutArea) {
  expect_tiled(read("a.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nf 1 2 3 4 5\n"), 3, 4);
  expect_tiled(read("b.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nv 2 2 0\nv 0 2 0\nf 2 3 4 5 1\n"), 3, 4);
}

// How many corners lie inside an edge of a triangle.
size_t corners_on_edges(const SourceMesh& mesh) {
  size_t count = 0;
  for (const auto& facet : soup_of(mesh)) {
    for (int i = 0; i < 3; ++i) {
      const Position& a = facet[i];
      const Position& b = facet[(i + 1) % 3];
      for (const Position& p : mesh.positions) {
        const float across = (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]);
        const float along = (p[0] - a[0]) * (p[0] - b[0]) + (p[1] - a[1]) * (p[1] - b[1]);
        count += across == 0 && along < 0;
      }
    }
  }
  return count;
}

TEST_F(Obj, AHoleWithABridgeIsTiled) {
  const std::string outer = "v 0 0 0\nv 4 0 0\nv 4 4 0\nv 0 4 0\n";
  const std::string hole = "v 1 1 0\nv 1 3 0\nv 3 3 0\nv 3 1 0\n";
  for (const std::string face : {"f 1 2 3 4 1 5 6 7 8 5\n", "f 5 1 2 3 4 1 5 6 7 8\n", "f 8 5 1 2 3 4 1 5 6 7\n"}) {
    const Ingested in = read("a.obj", outer + hole + face);
    expect_tiled(in, 8, 12);
    EXPECT_EQ(corners_on_edges(in.meshes[0]), 0u) << face;
  }
}

TEST_F(Obj, PolygonsInAnyPlaneKeepTheirSide) {
  // The arrow head in the planes x = 0 and y = 0, and turned around: normals must not depend on the
  // projection.
  const std::string vertices = "v 7 0 0\nv 7 4 2\nv 7 0 4\nv 7 1 2\n";
  for (const bool turned : {false, true}) {
    const Ingested in = read("a.obj", vertices + (turned ? "f 4 3 2 1\n" : "f 1 2 3 4\n"));
    ASSERT_EQ(in.meshes[0].triangles.size(), 2u);
    for (const auto& [a, b, c] : soup_of(in.meshes[0])) {
      const double normal_x = (b[1] - a[1]) * (c[2] - a[2]) - (b[2] - a[2]) * (c[1] - a[1]);
      EXPECT_GT(turned ? -normal_x : normal_x, 0);
    }
  }
}

TEST_F(Obj, RepeatedCornersAndCrossingOutlines) {
  EXPECT_EQ(read("a.obj", kSquare + "f 1 2 2 3 3 1\n").meshes[0].triangles, (Triangles{{0, 1, 2}}));
  const Ingested bow_tie = read("b.obj", kSquare + "f 1 3 2 4\n");
  EXPECT_EQ(bow_tie.meshes[0].triangles.size(), 2u);
  EXPECT_TRUE(any_note_has(bow_tie, "crosses itself"));
  EXPECT_EQ(read("c.obj", kSquare + "f 1 2 1 2\nf 1 2 3").meshes[0].triangles.size(), 1u);
}

TEST_F(Obj, EveryPrefixEndsWell) {
  const std::string text = kSquare + "# remark\nf 1/1 2/1 \\\n 3/1\nf -1 -2 -3 -4\nl 1 2\n";
  for (size_t size = 0; size < text.size(); ++size) {
    const Result<Ingested> result = ingest(write("a.obj", text.substr(0, size)));
    EXPECT_TRUE(result.ok() || !result.error().message.empty());
  }
}

TEST_F(Obj, RealMeshes) {
  VCD_REAL_MESH_OR_SKIP(path, "scans/libigl-tutorial-data/armadillo.obj");
  const Result<Ingested> result = ingest(*path);
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_EQ(result->meshes[0].triangles.size(), 86482u);
}

class Dispatch : public test::MeshFiles {};

TEST_F(Dispatch, WhatIsNoFileIsAnIoError) {
  EXPECT_EQ(ingest(folder_ / "absent.obj").error().code, ErrorCode::io);
  std::filesystem::create_directory(folder_ / "folder.obj");
  EXPECT_EQ(ingest(folder_ / "folder.obj").error().code, ErrorCode::io);
}

TEST_F(Dispatch, AnUnknownExtensionNamesTheKnownOnes) {
  expect_error("a.3ds", "", ErrorCode::unsupported,
               {"\".3ds\"", ".glb", ".gltf", ".drc", ".obj", ".ply", ".stl", ".off"});
  expect_error("noext", "", ErrorCode::unsupported, {".obj"});
}

}  // namespace
}  // namespace vcd::baker
