#include <limits>

#include "mesh_files.h"

namespace vcd::baker {
namespace {

using test::any_note_has;
using test::packed;
using test::soup_of;
using test::with_crlf;

class Stl : public test::MeshFiles {};

using Facet = std::array<Position, 3>;

const std::vector<Facet> kFacets = {{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}},
                                    {{{1, 0, 0}, {1, 1, 0}, {0, 1, 0}}},
                                    // Nearly the first facet's corners: welding by any tolerance would show.
                                    {{{1e-30f, 0, 0}, {1, 1e-39f, 0}, {0.1f, 1.0000001f, 1e-20f}}}};

std::string binary(const std::vector<Facet>& facets, const std::string& header = "") {
  std::string bytes = header;
  bytes.resize(80, ' ');
  bytes += packed(static_cast<uint32_t>(facets.size()));
  for (const Facet& facet : facets) {
    for (int i = 0; i < 3; ++i) bytes += packed(std::numeric_limits<float>::quiet_NaN());  // the normal
    for (const Position& corner : facet) {
      for (const float c : corner) bytes += packed(c);
    }
    bytes += "\x12\x34";
  }
  return bytes;
}

std::string text(const std::vector<Facet>& facets, const std::string& name = "solid name") {
  std::string result = "solid " + name + "\n";
  for (const Facet& facet : facets) {
    result += "  facet normal 0 -nan(ind) 1\n    outer loop\n";
    for (const Position& corner : facet) {
      char line[100];
      std::snprintf(line, sizeof(line), "      vertex %.9g %.9g %.9g\n", double{corner[0]}, double{corner[1]},
                    double{corner[2]});
      result += line;
    }
    result += "    endloop\n  endfacet\n";
  }
  return result + "endsolid " + name + "\n";
}

TEST_F(Stl, BinaryAndTextGiveTheSameFloatsUnwelded) {
  const Ingested from_binary = read("part.stl", binary(kFacets));
  const Ingested from_text = read("text.stl", text(kFacets));
  EXPECT_EQ(from_binary.meshes[0].name, "part");
  EXPECT_EQ(from_binary.meshes[0].positions.size(), 9u);
  EXPECT_EQ(soup_of(from_binary.meshes[0]), kFacets);
  EXPECT_EQ(soup_of(from_text.meshes[0]), kFacets);
  EXPECT_TRUE(from_binary.notes.empty() && from_text.notes.empty());
}

TEST_F(Stl, BinaryWhoseHeaderBeginsWithSolid) {
  EXPECT_EQ(soup_of(read("a.stl", binary(kFacets, "solid part")).meshes[0]), kFacets);
  expect_invalid("b.stl", binary(kFacets, std::string("solid part\0", 11)).substr(0, 200), {"announces 3 facets"});
}

TEST_F(Stl, TextDialects) {
  const std::string plain = text(kFacets);
  EXPECT_EQ(soup_of(read("crlf.stl", with_crlf(plain)).meshes[0]), kFacets);
  EXPECT_EQ(soup_of(read("no_end.stl", plain.substr(0, plain.size() - 1)).meshes[0]), kFacets);
  std::string upper = plain;
  for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  EXPECT_EQ(soup_of(read("upper.stl", upper).meshes[0]), kFacets);
}

TEST_F(Stl, SeveralSolidsMakeOneMesh) {
  const Ingested in = read("a.stl", text({kFacets[0]}) + "\n" + text({kFacets[1], kFacets[2]}, ""));
  EXPECT_EQ(in.meshes.size(), 1u);
  EXPECT_EQ(soup_of(in.meshes[0]), kFacets);
}

TEST_F(Stl, TheBinaryCountMustMatchTheFile) {
  std::string bytes = binary(kFacets);
  expect_invalid("cut.stl", bytes.substr(0, bytes.size() - 1), {"byte 80", "3 facets", "149 bytes"});
  expect_invalid("short.stl", bytes.substr(0, 83), {"too short"});
  expect_invalid("empty.stl", "", {"too short"});
  bytes[80] = 2;
  expect_invalid("fewer.stl", bytes, {"2 facets", "150 bytes"});
  bytes.replace(80, 4, "\xFF\xFF\xFF\xFF");
  expect_invalid("many.stl", bytes, {"4294967295 facets"});
  EXPECT_TRUE(any_note_has(read("padded.stl", binary(kFacets) + "\n"), "1 byte after the last facet"));
  expect_invalid("none.stl", binary({}), {"no triangle"});
}

TEST_F(Stl, NonFiniteCornersAreErrors) {
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<Facet> facets = kFacets;
    facets[1][2][axis] = std::numeric_limits<float>::infinity();
    expect_invalid("a.stl", binary(facets), {"facet 1 (byte 134)", "corner 2", "not finite"});
    expect_invalid("b.stl", text(facets), {"line 13", "facet 1", "not finite"});
  }
}

TEST_F(Stl, TruncatedTextIsAnErrorWhereverItEnds) {
  const std::string whole = text(kFacets, "");
  for (size_t size = 6; size < whole.find("endsolid") + 8; ++size) {
    expect_invalid("a.stl", whole.substr(0, size), {});
  }
}

TEST_F(Stl, GarbageInTextIsAnErrorWithItsLine) {
  std::string garbage = text(kFacets);
  garbage.replace(garbage.find("vertex 1 0 0"), 12, "vertex 1x 0 0");
  expect_invalid("a.stl", garbage, {"line 5", "facet 0", "\"1x\" is not a number"});
  std::string four = text(kFacets);
  four.insert(four.find("    endloop"), "      vertex 0 0 0\n");
  expect_invalid("b.stl", four, {"line 7", "\"vertex\" instead of \"endloop\""});
}

std::vector<Facet> real_soup(const std::filesystem::path& path) {
  const Result<Ingested> result = ingest(path);
  EXPECT_TRUE(result.ok()) << result.error().message;
  return result ? soup_of(result->meshes[0]) : std::vector<Facet>();
}

TEST_F(Stl, RealMeshesAgreeExactlyAcrossFormats) {
  VCD_REAL_MESH_OR_SKIP(stl, "scans/trimesh/octagonal_pocket.stl");
  VCD_REAL_MESH_OR_SKIP(ply, "scans/trimesh/octagonal_pocket.ply");
  const std::vector<Facet> soup = real_soup(*stl);
  EXPECT_EQ(soup.size(), 3262u);
  EXPECT_EQ(soup, real_soup(*ply));
}

TEST_F(Stl, TheRealBunnyAgreesWithItsOrigin) {
  // Same triangles in the same order; the STL was turned upright by a tool that rounded anew.
  VCD_REAL_MESH_OR_SKIP(stl, "scans/draco/STL/bunny.stl");
  VCD_REAL_MESH_OR_SKIP(ply, "scans/draco/bun_zipper.ply");
  const std::vector<Facet> turned = real_soup(*stl);
  const std::vector<Facet> origin = real_soup(*ply);
  ASSERT_EQ(turned.size(), 69451u);
  ASSERT_EQ(origin.size(), 69451u);
  float worst = 0;
  for (size_t i = 0; i < turned.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      const Position& p = turned[i][k];
      const Position& q = origin[i][k];
      worst = std::max({worst, std::abs(p[0] - q[0]), std::abs(p[1] + q[2]), std::abs(p[2] - q[1])});
    }
  }
  EXPECT_LT(worst, 1e-6f);
}

}  // namespace
}  // namespace vcd::baker
