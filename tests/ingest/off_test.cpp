#include "mesh_files.h"

namespace vcd::baker {
namespace {

using test::any_note_has;
using test::kBoth;
using test::with_crlf;

class Off : public test::MeshFiles {};

const std::string kVertices = "0 0 0\n1 0 0\n0 1 0\n1 1 0.5\n";
const std::string kFaces = "3 0 1 2\n3 1 3 2\n";

TEST_F(Off, ReadsVerticesAndFaces) {
  const Ingested in = read("name.off", "OFF\n4 2 0\n" + kVertices + kFaces);
  EXPECT_EQ(in.meshes[0].name, "name");
  EXPECT_EQ(in.meshes[0].triangles, kBoth);
  EXPECT_EQ(in.meshes[0].positions[3], (Position{1, 1, 0.5f}));
  EXPECT_TRUE(in.notes.empty());
}

TEST_F(Off, HeaderDialects) {
  for (const std::string header : {"OFF 4 2 0\n", "OFF4 2 0\n", "OFF\n4 2\n", "# a\n\nOFF # b\n# c\n\n 4 2 0 # d\n",
                                   "\xEF\xBB\xBFOFF\n4 2 0\n", "\t  OFF\n4 2 0\n"}) {
    EXPECT_EQ(read("a.off", header + kVertices + "# remark\n\n" + kFaces).meshes[0].triangles, kBoth) << header;
  }
  EXPECT_EQ(read("crlf.off", with_crlf("OFF\n4 2 0\n" + kVertices + kFaces)).meshes[0].triangles, kBoth);
  const std::string plain = "OFF\n4 2 0\n" + kVertices + kFaces;
  EXPECT_EQ(read("no_end.off", plain.substr(0, plain.size() - 1)).meshes[0].triangles, kBoth);
}

TEST_F(Off, NormalsColoursAndTextureCoordinatesArePassedOver) {
  const std::pair<std::string, std::string> kinds[] = {{"COFF", " 255 0 0 255"},
                                                       {"NOFF", " 0 0 1"},
                                                       {"STOFF", " 0.5 0.5"},
                                                       {"STCNOFF", " 0 0 1 1 0 0 1 0.5 0.5"},
                                                       {"OFF", " 9"}};
  for (const auto& [keyword, extra] : kinds) {
    std::string vertices;
    for (const char c : kVertices) vertices += c == '\n' ? extra + "\n" : std::string(1, c);
    const Ingested in =
        read("a.off", keyword + "\n4 2 0\n" + vertices + "3 0 1 2 255 0 0 # red\n3 1 3 2 0.1 0.2 0.3 1\n");
    EXPECT_EQ(in.meshes[0].triangles, kBoth) << keyword;
  }
}

TEST_F(Off, AnElementMayGoOnOverSeveralLines) {
  EXPECT_EQ(read("a.off", "OFF\n4 2 0\n0\n0\n0\n1 0\n0\n0 1 0\n1 1 0.5\n3 0\n1\n2\n\n3 1 3 2\n").meshes[0].triangles,
            kBoth);
}

TEST_F(Off, AMissingNumberNeverShiftsTheRestUnseen) {
  expect_invalid("a.off", "OFF\n4 2 0\n0 0\n1 0 0\n0 1 0\n1 1 0\n" + kFaces, {});
  expect_invalid("b.off", "OFF\n4 2 0\n" + kVertices + "3 0 1\n3 1 3 2\n", {});
  expect_invalid("c.off", "OFF\n4 2 0\n0 0 0 1 0 0 0 1 0 1 1 0 0 0\n1 0 0\n0 1 0\n1 1 0\n" + kFaces,
                 {"line 3", "vertex 0", "too many numbers"});
}

TEST_F(Off, WhatFollowsTheLastFaceGetsANote) {
  EXPECT_TRUE(any_note_has(read("a.off", "OFF\n4 1 0\n" + kVertices + kFaces), "from line 8"));
}

TEST_F(Off, BrokenFiles) {
  expect_invalid("a.off", "OFF\n4 2 0\n" + kVertices + "3 0 1 2\n3 1 3 4\n",
                 {"line 8", "face 1", "index 4 is out of range"});
  expect_invalid("a.off", "OFF\n4 2 0\n" + kVertices + "3 0 1 2\n3 1 3 -1\n", {"line 8", "index -1"});
  expect_invalid("a.off", "OFF\n4 2 0\n" + kVertices + "3 0 1 2\n3 1 3", {"face 1", "the file ends"});
  expect_invalid("a.off", "OFF\n4 2 0\n" + kVertices + "3 0 1 2\n", {"face 1", "the file ends"});
  expect_invalid("a.off", "OFF\n4 2 0\nnan 0 0\n1 0 0\n0 1 0\n1 1 0\n" + kFaces, {"line 3", "vertex 0", "not finite"});
  expect_invalid("a.off", "OFF\n4 2 0\n0 0 x\n1 0 0\n0 1 0\n1 1 0\n" + kFaces, {"line 3", "\"x\" is not a number"});
  expect_invalid("a.off", "OFF\n4 2 0\n" + kVertices + "3 0 1 2.5\n3 1 3 2\n", {"line 7", "\"2.5\" is not an index"});
  expect_invalid("a.off", "OFF\n4 1 0\n" + kVertices + "-3 0 1 2\n", {"line 7", "not a count of corners"});
  expect_invalid("a.off", "4 2 0\n" + kVertices + kFaces, {"keyword OFF is missing"});
  expect_invalid("a.off", "", {"keyword OFF is missing"});
  expect_invalid("a.off", "OFF\n", {"counts"});
  expect_invalid("a.off", "OFF\n4 0 0\n" + kVertices, {"holds 4 points and no triangle"});
  expect_invalid("a.off", "OFF\n4 1 0\n" + kVertices + "2 0 1\n", {"no triangle", "1 face"});
}

TEST_F(Off, CountsThatTheFileCannotHoldAreRefusedAtOnce) {
  expect_invalid("a.off", "OFF\n353535235358 2 0\n" + kVertices + kFaces, {"line 2", "353535235358", "can hold"});
  expect_invalid("a.off", "OFF\n4 9000000000000000000 0\n" + kVertices + kFaces, {"can hold"});
  expect_invalid("a.off", "OFF\n-4 2 0\n" + kVertices + kFaces, {"\"-4\" is not a count"});
  expect_invalid("a.off", "OFF\n4 1 0\n" + kVertices + "9000000000000000000 0 1 2\n", {"the file ends"});
}

TEST_F(Off, KindsThatAreNotSupported) {
  expect_error("a.off", std::string("OFF BINARY\n").append(12, '\0'), ErrorCode::unsupported, {"binary OFF"});
  expect_error("a.off", "4OFF\n4 2 0\n", ErrorCode::unsupported, {"dimensions"});
  expect_error("a.off", "nOFF 5\n4 2 0\n", ErrorCode::unsupported, {"dimensions"});
}

TEST_F(Off, RealMeshes) {
  VCD_REAL_MESH_OR_SKIP(path, "scans/libigl-tutorial-data/cow.off");
  const Result<Ingested> result = ingest(*path);
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_EQ(result->meshes[0].triangles.size(), 5520u);
}

}  // namespace
}  // namespace vcd::baker
