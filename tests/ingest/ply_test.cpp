#include <bit>
#include <functional>
#include <limits>

#include "mesh_files.h"

namespace vcd::baker {
namespace {

using test::any_note_has;
using test::kBoth;
using test::packed;
using test::Triangles;
using test::with_crlf;

class Ply : public test::MeshFiles {};

const std::string kXyz = "property float x\nproperty float y\nproperty float z\n";
const std::string kFaceElement = "element face 2\nproperty list uchar int vertex_indices\n";
const std::string kTextBody = "0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2\n3 1 3 2\n";

std::string header(const std::string& format, const std::string& elements) {
  return "ply\nformat " + format + " 1.0\ncomment made for a test\n" + elements + "end_header\n";
}
std::string text_ply(const std::string& body = kTextBody) {
  return header("ascii", "element vertex 4\n" + kXyz + kFaceElement) + body;
}

template <class Coordinate>
std::string vertex_bytes(bool big) {
  std::string bytes;
  for (const std::array<int, 3>& p : {std::array<int, 3>{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}) {
    for (const int c : p) bytes += packed(static_cast<Coordinate>(c), big);
  }
  return bytes;
}
template <class Count, class Index>
std::string face_bytes(bool big, const std::vector<std::vector<int64_t>>& faces = {{0, 1, 2}, {1, 3, 2}}) {
  std::string bytes;
  for (const std::vector<int64_t>& face : faces) {
    bytes += packed(static_cast<Count>(face.size()), big);
    for (const int64_t index : face) bytes += packed(static_cast<Index>(index), big);
  }
  return bytes;
}
std::string little_ply(const std::string& body) {
  return header("binary_little_endian", "element vertex 4\n" + kXyz + kFaceElement) + body;
}

TEST_F(Ply, Text) {
  const Ingested in = read("name.ply", text_ply());
  EXPECT_EQ(in.meshes[0].name, "name");
  EXPECT_EQ(in.meshes[0].triangles, kBoth);
  EXPECT_EQ(in.meshes[0].positions[3], (Position{1, 1, 0}));
  EXPECT_TRUE(in.notes.empty());
}

template <class Coordinate, class Count, class Index>
void expect_all_read(const std::function<Ingested(const std::string&)>& read_bytes, const std::string& coordinate,
                     const std::string& count, const std::string& index) {
  for (const bool big : {false, true}) {
    const std::string elements = "element vertex 4\nproperty " + coordinate + " x\nproperty " + coordinate +
                                 " y\nproperty " + coordinate + " z\nelement face 2\nproperty list " + count + " " +
                                 index + " vertex_index\n";
    const Ingested in = read_bytes(header(big ? "binary_big_endian" : "binary_little_endian", elements) +
                                   vertex_bytes<Coordinate>(big) + face_bytes<Count, Index>(big));
    EXPECT_EQ(in.meshes[0].triangles, kBoth) << coordinate << count << index << big;
    EXPECT_EQ(in.meshes[0].positions[3], (Position{1, 1, 0})) << coordinate << count << index << big;
  }
}

TEST_F(Ply, BinaryOfBothByteOrdersAndAllTypes) {
  const auto read_bytes = [&](const std::string& bytes) { return read("a.ply", bytes); };
  expect_all_read<float, uint8_t, int32_t>(read_bytes, "float", "uchar", "int");
  expect_all_read<double, uint16_t, uint32_t>(read_bytes, "double", "ushort", "uint");
  expect_all_read<int8_t, int16_t, uint8_t>(read_bytes, "char", "short", "uchar");
  expect_all_read<uint8_t, int8_t, int8_t>(read_bytes, "uint8", "int8", "int8");
  expect_all_read<int16_t, int32_t, uint16_t>(read_bytes, "int16", "int32", "uint16");
  expect_all_read<uint16_t, uint32_t, int16_t>(read_bytes, "uint16", "uint32", "int16");
  expect_all_read<int32_t, uint8_t, uint32_t>(read_bytes, "int", "uint8", "uint32");
  expect_all_read<float, uint8_t, uint32_t>(read_bytes, "float32", "uint8", "uint32");
  expect_all_read<double, uint8_t, uint32_t>(read_bytes, "float64", "uint8", "uint32");
}

TEST_F(Ply, DoublesAndIntegersBecomeTheNearestFloats) {
  const std::string head = header("binary_little_endian",
                                  "element vertex 3\nproperty double x\nproperty int y\nproperty short z\n"
                                  "element face 1\nproperty list uchar int vertex_indices\n");
  std::string body;
  for (int i = 0; i < 3; ++i) {
    body += packed(0.1 + i) + packed(int32_t{-123456789}) + packed(int16_t{-2});
  }
  const auto in =
      ingest(write("a.ply", head + body + face_bytes<uint8_t, int32_t>(false, {{0, 1, 2}})), {.coarse = true});
  ASSERT_TRUE(in.ok()) << in.error().message;
  EXPECT_EQ(in->meshes[0].positions[0], (Position{0.1f, -123456792.0f, -2.0f}));
}

TEST_F(Ply, UnknownElementsAndPropertiesAreSkipped) {
  const std::string elements =
      "obj_info x\nelement camera 1\nproperty list uchar double view\nproperty short id\nelement empty "
      "99999999999\n"
      "element vertex 4\nproperty uchar red\nproperty float z\nproperty list int short ring\nproperty float "
      "y\n"
      "property float x\nelement face 2\nproperty list uchar float texcoord\n"
      "property list uchar int vertex_indices\nproperty double q\nelement tail 1\nproperty int a\n";
  std::string little = packed(uint8_t{2}) + packed(1.0) + packed(2.0) + packed(int16_t{7});
  std::string text = "2 1 2 7\n";
  for (const std::array<int, 2>& p : {std::array<int, 2>{0, 0}, {1, 0}, {0, 1}, {1, 1}}) {
    const auto [x, y] = p;
    little += packed(uint8_t{200}) + packed(5.0f) + packed(int32_t{1}) + packed(int16_t{3}) +
              packed(static_cast<float>(y)) + packed(static_cast<float>(x));
    text += "200 5 1 3 " + std::to_string(y) + " " + std::to_string(x) + "\n";
  }
  for (const TriangleIndices& t : kBoth) {
    little +=
        packed(uint8_t{1}) + packed(0.5f) + face_bytes<uint8_t, int32_t>(false, {{t[0], t[1], t[2]}}) + packed(0.5);
    text += "1 0.5 3 " + std::to_string(t[0]) + " " + std::to_string(t[1]) + " " + std::to_string(t[2]) + " 0.5\n";
  }
  for (const Ingested& in : {read("a.ply", header("binary_little_endian", elements) + little + packed(int32_t{1})),
                             read("b.ply", header("ascii", elements) + text + "1\n")}) {
    EXPECT_EQ(in.meshes[0].triangles, kBoth);
    EXPECT_EQ(in.meshes[0].positions[1], (Position{1, 0, 5}));
    EXPECT_TRUE(in.notes.empty());
  }
}

TEST_F(Ply, TristripsTurnEverySecondTriangleAndRestart) {
  const std::string elements =
      "element vertex 4\n" + kXyz + "element tristrips 1\nproperty list int int vertex_indices\n";
  const Triangles expected = {{0, 1, 2}, {2, 1, 3}, {1, 0, 3}};
  const std::vector<int64_t> strip = {0, 1, 2, 3, -1, 1, 0, 3};
  EXPECT_EQ(
      read("a.ply", header("ascii", elements) + kTextBody.substr(0, 24) + "8 0 1 2 3 -1 1 0 3\n").meshes[0].triangles,
      expected);
  for (const bool big : {false, true}) {
    const std::string head = header(big ? "binary_big_endian" : "binary_little_endian", elements);
    EXPECT_EQ(
        read("b.ply", head + vertex_bytes<float>(big) + face_bytes<int32_t, int32_t>(big, {strip})).meshes[0].triangles,
        expected);
  }
  expect_invalid("c.ply", header("ascii", elements) + kTextBody.substr(0, 24) + "4 0 1 2 4\n",
                 {"line 15", "tristrips 0", "index 4"});
  expect_invalid("d.ply", header("ascii", elements) + kTextBody.substr(0, 24) + "4 0 1 2 -2\n", {"index -2"});
}

TEST_F(Ply, LineEndsOfTheHeader) {
  EXPECT_EQ(read("a.ply", with_crlf(text_ply())).meshes[0].triangles, kBoth);
  const std::string body = vertex_bytes<float>(false) + face_bytes<uint8_t, int32_t>(false);
  EXPECT_EQ(read("b.ply", with_crlf(little_ply("")) + body).meshes[0].triangles, kBoth);
  std::string cr = little_ply("");
  std::replace(cr.begin(), cr.end(), '\n', '\r');
  EXPECT_EQ(read("c.ply", cr + body).meshes[0].triangles, kBoth);
}

TEST_F(Ply, BinaryDataMayBeginWithALineEnd) {
  // A first x whose lowest byte is '\n', after "\n" and after "\r".
  const float x = std::bit_cast<float>(0x3F80000Au);
  std::string body = vertex_bytes<float>(false) + face_bytes<uint8_t, int32_t>(false);
  body.replace(0, 4, packed(x));
  std::string cr = little_ply("");
  std::replace(cr.begin(), cr.end(), '\n', '\r');
  EXPECT_EQ(read("a.ply", little_ply(body)).meshes[0].positions[0][0], x);
  EXPECT_EQ(read("b.ply", cr + body).meshes[0].positions[0][0], x);
}

TEST_F(Ply, FacesBeforeVerticesAndPolygons) {
  const std::string elements = "element face 1\nproperty list uchar int vertex_indices\nelement vertex 4\n" + kXyz;
  EXPECT_EQ(read("a.ply", header("ascii", elements) + "4 0 1 3 2\n" + kTextBody.substr(0, 24)).meshes[0].triangles,
            (Triangles{{0, 1, 3}, {0, 3, 2}}));
}

TEST_F(Ply, HarmlessDeviations) {
  EXPECT_EQ(read("a.ply", text_ply("  0  0\t0 \n\n1 0 0\n0 1 0\n1 1 0\n\n3 0 1 2\n3 1 3 2")).meshes[0].triangles,
            kBoth);
  const Ingested surplus = read("b.ply", text_ply("0 0 0 9\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2 255\n3 1 3 2\nmore\n"));
  EXPECT_EQ(surplus.meshes[0].triangles, kBoth);
  EXPECT_TRUE(any_note_has(surplus, "2 lines with more values"));
  EXPECT_TRUE(any_note_has(surplus, "from line 17"));
  EXPECT_TRUE(
      any_note_has(read("c.ply", little_ply(vertex_bytes<float>(false) + face_bytes<uint8_t, int32_t>(false) + "xy")),
                   "2 bytes after"));
}

TEST_F(Ply, BinaryFilesAreRefusedWhereverTheyEnd) {
  const std::string whole = little_ply(vertex_bytes<float>(false) + face_bytes<uint8_t, int32_t>(false));
  for (size_t size = 0; size < whole.size(); ++size) expect_invalid("a.ply", whole.substr(0, size), {});
}

TEST_F(Ply, TextFilesAreRefusedWhereverTheyEnd) {
  const std::string whole = text_ply();
  for (size_t size = 0; size < whole.size() - 1; ++size) expect_invalid("a.ply", whole.substr(0, size), {});
}

TEST_F(Ply, IndicesOutOfRangeNameFaceAndByte) {
  const size_t body_offset = little_ply("").size();
  const std::string place = "face 1 (byte " + std::to_string(body_offset + 48 + 13) + ")";
  for (const int64_t bad : {int64_t{4}, int64_t{-1}, int64_t{2147483647}}) {
    const std::string faces = face_bytes<uint8_t, int32_t>(false, {{0, 1, 2}, {1, 3, bad}});
    expect_invalid("a.ply", little_ply(vertex_bytes<float>(false) + faces), {place, "index " + std::to_string(bad)});
  }
  expect_invalid("b.ply", text_ply("0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2\n3 1 3 4\n"), {"line 16", "face 1", "index 4"});
  expect_invalid("b.ply", text_ply("0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2\n3 1 3 -1\n"), {"line 16", "index -1"});
}

TEST_F(Ply, BadValuesInText) {
  expect_invalid("a.ply", text_ply("0 0 nan\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2\n3 1 3 2\n"),
                 {"line 11", "vertex 0", "not finite"});
  expect_invalid("a.ply", text_ply("0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2\n3 1 3 2\n"), {"line 11", "vertex 0", "fewer"});
  expect_invalid("a.ply", text_ply("0 0 1x\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2\n3 1 3 2\n"), {"line 11", "\"1x\""});
  expect_invalid("a.ply", text_ply("0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1\n3 1 3 2\n"),
                 {"line 15", "face 0", "ends too early"});
  expect_invalid("a.ply", text_ply("0 0 0\n1 0 0\n0 1 0\n1 1 0\n3 0 1 2.5\n3 1 3 2\n"), {"line 15", "\"2.5\""});
  expect_invalid("a.ply", text_ply("0 0 0\n1 0 0\n0 1 0\n1 1 0\n-3 0 1 2\n3 1 3 2\n"), {"line 15", "-3 items"});
}

TEST_F(Ply, NonFiniteBinaryPositionsAreErrorsEvenIfUnused) {
  std::string body = vertex_bytes<float>(false);
  body.replace(40, 4, packed(std::numeric_limits<float>::quiet_NaN()));
  const std::string faces = face_bytes<uint8_t, int32_t>(false, {{0, 1, 2}, {0, 1, 2}});
  const std::string place = "vertex 3 (byte " + std::to_string(little_ply("").size() + 36) + ")";
  expect_invalid("a.ply", little_ply(body + faces), {place, "not finite"});
}

TEST_F(Ply, CountsThatTheFileCannotHoldAreRefusedAtOnce) {
  const std::string body = vertex_bytes<float>(false) + face_bytes<uint8_t, int32_t>(false);
  for (const std::string count : {"2000000000", "9223372036854775807", "7"}) {
    const std::string elements = "element vertex " + count + "\n" + kXyz + kFaceElement;
    expect_invalid("a.ply", header("binary_little_endian", elements) + body, {"\"vertex\"", count, "can hold"});
  }
  expect_invalid("b.ply", header("ascii", "element vertex 9000000000\n" + kXyz + kFaceElement) + kTextBody,
                 {"can hold"});
  const std::string list = "element vertex 4\n" + kXyz + "element face 1\nproperty list uint int vertex_indices\n";
  expect_invalid("c.ply",
                 header("binary_little_endian", list) + vertex_bytes<float>(false) + packed(uint32_t{4000000000}),
                 {"face 0", "the file ends within it"});
  const std::string skipped = "element vertex 4\n" + kXyz + "element x 1\nproperty list uint double y\n";
  expect_invalid("d.ply",
                 header("binary_little_endian", skipped) + vertex_bytes<float>(false) + packed(uint32_t{4000000000}),
                 {"x 0", "the file ends within it"});
}

TEST_F(Ply, BrokenHeaders) {
  const std::string vertex = "element vertex 4\n" + kXyz;
  const std::pair<std::string, std::string> cases[] = {
      {"plx\n", "does not begin with \"ply\""},
      {"ply\n" + vertex + kFaceElement + "end_header\n", "names no format"},
      {"ply\nformat ascii 1.0\nformat ascii 1.0\nend_header\n", "line 3: a second format"},
      {"ply\nformat ascii 2.0\nend_header\n", "version \"2.0\""},
      {header("middle_endian", vertex), "line 2: \"middle_endian\""},
      {header("ascii", "element vertex -1\n"), "line 4: \"-1\" is not a count"},
      {header("ascii", "element vertex 4 5\n"), "line 4: \"5\" is too much"},
      {header("ascii", "property float x\n"), "line 4: a property before any element"},
      {header("ascii", vertex + vertex), "\"vertex\" is there already"},
      {header("ascii", "element vertex 4\nproperty float16 x\n"), "line 5: \"float16\" is not a type"},
      {header("ascii", vertex + "element face 2\nproperty list float int vertex_indices\n"), "cannot be counted"},
      {header("ascii", vertex + "element face 2\nproperty list uchar float vertex_indices\n") + kTextBody,
       "not integers"},
      {header("ascii", vertex + "element face 2\nproperty int vertex_indices\n") + kTextBody, "wrong kind"},
      {header("ascii", vertex + "element face 2\nproperty list uchar int corners\n") + kTextBody,
       "no list vertex_indices"},
      {header("ascii", "element vertex 4\nproperty float x\nproperty float y\n" + kFaceElement) + kTextBody,
       "x, y or z"},
      {header("ascii", vertex + "property float x\n"), "there twice"},
      {header("ascii", kFaceElement), "no element \"vertex\""},
      {header("ascii", vertex + "what is this\n"), "line 8: \"what\" is no statement"},
  };
  for (const auto& [bytes, reason] : cases) expect_invalid("a.ply", bytes, {reason});
}

TEST_F(Ply, NoTriangleIsAnErrorThatCountsThePoints) {
  expect_invalid("a.ply", header("ascii", "element vertex 4\n" + kXyz) + kTextBody.substr(0, 24),
                 {"holds 4 points and no triangle"});
}

TEST_F(Ply, RealMeshes) {
  VCD_REAL_MESH_OR_SKIP(igea, "scans/common-3d-test-models/data/igea.ply");
  const Result<Ingested> result = ingest(*igea);
  ASSERT_TRUE(result.ok()) << result.error().message;
  EXPECT_EQ(result->meshes[0].positions.size(), 134345u);
  // Two triangles a vertex less 4: what a closed surface of genus 0 has, neither more nor less.
  EXPECT_EQ(result->meshes[0].triangles.size(), 2u * 134345u - 4u);
}

}  // namespace
}  // namespace vcd::baker
