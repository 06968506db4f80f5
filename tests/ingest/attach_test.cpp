#include <vcd/baker/attach.h>

#include <vcd/baker/bake.h>
#include <vcd/baker/prepare.h>
#include <vcd/format/file_bytes.h>
#include <vcd/runtime/sidecar.h>

#include "attach/json_text.h"
#include "ingest/gltf_builder.h"
#include "ingest/mesh_files.h"
#include "support/files.h"
#include "support/meshes.h"

namespace vcd::test {
namespace {

using baker::attach;
using baker::Attachment;

const GeometryHash kHash = {1, 2, 3};
constexpr const char* kHashText = "01020300000000000000000000000000";

std::string edited(const std::string& text, const std::string& key) {
  baker::JsonText json(text);
  const auto value = json.member(json.root(), key);
  if (!value) json.add_member(json.root(), key, "[1]");
  else json.add_element(*value, "1");
  return json.edited();
}

TEST(JsonText, AddsToWhatIsThereAndKeepsTheRest) {
  EXPECT_EQ(edited("{}", "a"), R"({"a":[1]})");
  EXPECT_EQ(edited(R"( { "b" : 1e+2 } )", "a"), R"( {"a":[1], "b" : 1e+2 } )");
  EXPECT_EQ(edited(R"({"a":[]})", "a"), R"({"a":[1]})");
  EXPECT_EQ(edited(R"({"a" : [ "]" , {"a":[2]} ] ,"c":"\"}"})", "a"), R"({"a" : [ "]" , {"a":[2]} ,1] ,"c":"\"}"})");
  EXPECT_EQ(edited(R"({"x":{"a":[]},"\u0061":[3],"z":[]})", "a"), R"({"x":{"a":[]},"\u0061":[3,1],"z":[]})");
  EXPECT_EQ(edited(R"({"a":[7],"a":[8]})", "a"), R"({"a":[7],"a":[8,1]})");  // parsers take the last
  EXPECT_EQ(edited("\xEF\xBB\xBF{\n}\n", "a"), "\xEF\xBB\xBF{\"a\":[1]\n}\n");
}

class Attach : public MeshFiles {
 protected:
  static json document(const std::string& mesh_members = "") {
    return json::parse(R"({"asset":{"version":"2.0"},"buffers":[{"byteLength":36,"uri":"data:;base64,)" +
                       base64(Bytes(36)) + R"("}],"bufferViews":[{"buffer":0,"byteLength":36}],"accessors":[
      {"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],"meshes":[{"primitives":[
      {"attributes":{"POSITION":0}}]},{"primitives":[{"attributes":{"POSITION":0}}])" +
                       mesh_members + "}]}");
  }
  static json attached(const std::string& text, const Attachment& attachment) {
    const auto result = attach("a.gltf", text, attachment);
    EXPECT_TRUE(result) << result.error().message;
    return result ? json::parse(*result) : json();
  }
  static void expect_refused(const std::string& path, const std::string& bytes, const Attachment& attachment,
                             ErrorCode code, const std::string& reason) {
    const auto result = attach(path, bytes, attachment);
    ASSERT_FALSE(result);
    EXPECT_EQ(result.error().code, code);
    EXPECT_NE(result.error().message.find(path + ": "), std::string::npos) << result.error().message;
    EXPECT_NE(result.error().message.find(reason), std::string::npos) << result.error().message;
  }
};

TEST_F(Attach, NamesTheSidecarInEachMeshThatHasAnObject) {
  const json wanted = {{"uri", "a%20b.vcd"}, {"geometryHash", kHashText}};
  for (const char* members : {"", R"(,"extensions":null)", R"(,"extensions":{})", R"(,"extensions":{"X":{"y":[1]}})"}) {
    json before = document(members);
    for (const int indent : {-1, 2}) {
      json after = attached(before.dump(indent), {.uri = "a%20b.vcd", .meshes = {{1, kHash}}});
      EXPECT_EQ(after["extensionsUsed"], json({"VCD_visibility"}));
      EXPECT_EQ(after["meshes"][1]["extensions"]["VCD_visibility"], wanted);
      // Without it all is as before.
      after.erase("extensionsUsed");
      after["meshes"][1]["extensions"].erase("VCD_visibility");
      json bare = before;
      if (!bare["meshes"][1].contains("extensions") || bare["meshes"][1]["extensions"].is_null())
        bare["meshes"][1]["extensions"] = json::object();
      EXPECT_EQ(after, bare);
    }
  }
}

TEST_F(Attach, RefusesWhatItCannotDo) {
  const Attachment one{.uri = "a.vcd", .meshes = {{1, kHash}}};
  json twice = attached(document().dump(), one);
  expect_refused("a.gltf", twice.dump(), one, ErrorCode::usage, "has a sidecar attached already");
  twice.erase("extensionsUsed");
  expect_refused("a.gltf", twice.dump(), one, ErrorCode::usage, "has a sidecar attached already");
  expect_refused("a.gltf", document().dump(), {.uri = "a.vcd", .meshes = {{2, kHash}}}, ErrorCode::invalid_file,
                 "mesh 2 does not exist");
  expect_refused("a.gltf", document(R"(,"extensions":[])").dump(), one, ErrorCode::invalid_file, "extensions");
  expect_refused("a.gltf", "{", one, ErrorCode::invalid_file, "malformed");
  json no_list = document();
  no_list["extensionsUsed"] = "X";
  expect_refused("a.gltf", no_list.dump(), one, ErrorCode::invalid_file, "extensionsUsed");
  expect_refused("a.stl", "solid", one, ErrorCode::usage, "glTF, GLB, PLY and OBJ only");
  expect_refused("a.obj", "v", {.embedded = std::as_bytes(std::span("x", 1)), .meshes = {{0, kHash}}}, ErrorCode::usage,
                 "only glTF");
  expect_refused("a.ply", "ply", {.uri = "a.vcd", .meshes = {{0, kHash}}}, ErrorCode::invalid_file, "too early");
}

TEST_F(Attach, EmbedsInABufferOfItsOwnWhereThereIsNoBinaryChunk) {
  const std::string sidecar = "sidecar";
  const json after =
      attached(document().dump(), {.embedded = std::as_bytes(std::span(sidecar)), .meshes = {{0, kHash}}});
  EXPECT_EQ(after["meshes"][0]["extensions"]["VCD_visibility"], json({{"bufferView", 1}, {"geometryHash", kHashText}}));
  EXPECT_EQ(after["bufferViews"][1], json({{"buffer", 1}, {"byteOffset", 0}, {"byteLength", 7}}));
  EXPECT_EQ(after["buffers"][1],
            json({{"byteLength", 7}, {"uri", "data:application/octet-stream;base64,c2lkZWNhcg=="}}));
}

TEST_F(Attach, WritesACommentIntoPlyAndObj) {
  const Attachment one{.uri = "a.vcd", .meshes = {{0, kHash}}};
  const std::string line = std::string("VCD_visibility a.vcd ") + kHashText;
  const std::string ply =
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float "
      "z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 "
      "0\n3 0 1 2\n";
  const std::string obj = "\xEF\xBB\xBFv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
  for (const bool crlf : {false, true}) {
    const std::string p = crlf ? with_crlf(ply) : ply, o = crlf ? with_crlf(obj) : obj, end = crlf ? "\r\n" : "\n";
    const auto ply_after = attach("a.ply", p, one), obj_after = attach("a.obj", o, one);
    ASSERT_TRUE(ply_after && obj_after);
    EXPECT_EQ(*ply_after,
              "ply" + end + "format ascii 1.0" + end + "comment " + line + end + p.substr(p.find("element")));
    EXPECT_EQ(*obj_after, "\xEF\xBB\xBF# " + line + end + o.substr(3));
    EXPECT_EQ(soup_of(read("b.ply", *ply_after).meshes[0]), soup_of(read("a.ply", p).meshes[0]));
    EXPECT_EQ(soup_of(read("b.obj", *obj_after).meshes[0]), soup_of(read("a.obj", o).meshes[0]));
    EXPECT_FALSE(attach("a.obj", *obj_after, one));
  }
}

uint32_t u32_at(std::string_view file, size_t at) {
  uint32_t value = 0;
  std::memcpy(&value, file.data() + at, sizeof value);
  return value;
}

// A GLB file of the mesh, its binary chunk `extra` bytes longer than the buffer.
std::string glb_of(const baker::SourceMesh& mesh, size_t extra) {
  std::string binary(reinterpret_cast<const char*>(mesh.positions.data()), mesh.positions.size() * 12);
  binary.append(reinterpret_cast<const char*>(mesh.triangles.data()), mesh.triangles.size() * 12);
  const size_t positions = mesh.positions.size() * 12, indices = mesh.triangles.size() * 12;
  json document = {{"asset", {{"version", "2.0"}}},
                   {"buffers", {{{"byteLength", binary.size()}}}},
                   {"bufferViews",
                    {{{"buffer", 0}, {"byteLength", positions}},
                     {{"buffer", 0}, {"byteOffset", positions}, {"byteLength", indices}}}},
                   {"accessors",
                    {{{"bufferView", 0}, {"componentType", 5126}, {"count", mesh.positions.size()}, {"type", "VEC3"}},
                     {{"bufferView", 1}, {"componentType", 5125}, {"count", indices / 4}, {"type", "SCALAR"}}}},
                   {"meshes", {{{"primitives", {{{"attributes", {{"POSITION", 0}}}, {"indices", 1}}}}}}}};
  std::string text = document.dump();
  while (text.size() % 4 != 0) text += ' ';
  binary.append(extra, '\0');
  std::string file = "glTF";
  const auto number = [&](size_t value) {
    const auto bits = static_cast<uint32_t>(value);
    file.append(reinterpret_cast<const char*>(&bits), 4);
  };
  number(2), number(20 + text.size() + 8 + binary.size() + 12);
  number(text.size()), file += "JSON" + text;
  number(binary.size()), file += std::string("BIN\0", 4) + binary;
  number(4), file += "OTHERmor";  // a chunk of another kind
  return file;
}

// Compressed files have such a buffer: it has no uri, and lies nowhere.
TEST_F(Attach, AGlbFilesFallbackBufferStaysAsItIs) {
  const json fallback = {{"byteLength", 40000}};
  std::string text =
      json({{"asset", {{"version", "2.0"}}},
            {"buffers", {fallback}},
            {"bufferViews", {{{"buffer", 0}, {"byteLength", 36}}}},
            {"accessors", {{{"bufferView", 0}, {"componentType", 5126}, {"count", 3}, {"type", "VEC3"}}}},
            {"meshes", {{{"primitives", {{{"attributes", {{"POSITION", 0}}}}}}}}}})
          .dump();
  while (text.size() % 4 != 0) text += ' ';
  std::string file = "glTF";
  for (const size_t value : {size_t{2}, 20 + text.size(), text.size()}) {
    const auto bits = static_cast<uint32_t>(value);
    file.append(reinterpret_cast<const char*>(&bits), 4);
  }
  file += "JSON" + text;
  const std::string sidecar = "sidecar";
  const auto after = attach("a.glb", file, {.embedded = std::as_bytes(std::span(sidecar)), .meshes = {{0, kHash}}});
  ASSERT_TRUE(after) << after.error().message;
  const json document = json::parse(after->substr(20, u32_at(*after, 12)));
  EXPECT_EQ(document["buffers"][0], fallback);
  EXPECT_EQ(document["buffers"][1]["byteLength"], sidecar.size());
  EXPECT_EQ(document["bufferViews"][1]["buffer"], 1);
}

TEST_F(Attach, ASidecarInAGlbFileIsUsedInPlaceWhereTheFileIsMapped) {
  const baker::PreparedMesh mesh = *baker::prepare(sphere());
  const auto baked = baker::bake(mesh, proven(3));
  ASSERT_TRUE(baked);
  const auto sidecar = sidecar_bytes({&*baked});
  for (const size_t extra : {0, 4}) {
    const std::string before = glb_of(sphere(), extra);
    const auto after = attach("a.glb", before, {.embedded = sidecar, .meshes = {{0, mesh.geometry_hash}}});
    ASSERT_TRUE(after);
    EXPECT_EQ(u32_at(*after, 8), after->size());
    EXPECT_TRUE(after->ends_with("OTHERmor"));
    const size_t json_size = u32_at(*after, 12), binary = 20 + json_size + 8;
    const json document = json::parse(after->substr(20, json_size));
    EXPECT_EQ(document["buffers"][0]["byteLength"], u32_at(*after, 20 + json_size));
    const json& extension = document["meshes"][0]["extensions"]["VCD_visibility"];
    const json& view = document["bufferViews"][extension["bufferView"].get<size_t>()];
    const std::filesystem::path path = write("a.glb", *after);
    EXPECT_EQ(soup_of(baker::ingest(path)->meshes[0]), soup_of(baker::ingest(write("b.glb", before))->meshes[0]));

    const auto file = FileBytes::map(path);
    ASSERT_TRUE(file);
    const vcd::Bytes bytes = file->bytes().subspan(binary + view["byteOffset"].get<size_t>(), view["byteLength"]);
    EXPECT_EQ(reinterpret_cast<uintptr_t>(bytes.data()) % 64, 0u);
    const auto opened = Sidecar::open_buffer(bytes);
    ASSERT_TRUE(opened) << opened.error().message;
    EXPECT_TRUE(opened->find(mesh.geometry_hash));
    const ObjectContents& object = opened->contents().objects[0];
    EXPECT_TRUE(opened->contents().inflated.empty());
    for (const void* part : {static_cast<const void*>(object.tree.top), static_cast<const void*>(object.tree.bricks),
                             static_cast<const void*>(object.record)}) {
      EXPECT_GE(part, static_cast<const void*>(bytes.data()));
      EXPECT_LT(part, static_cast<const void*>(bytes.data() + bytes.size()));
    }
    EXPECT_EQ(opened->object(0).classify({{0, 0, -5}, 0, {0, 0, 1}, 10}), Visibility::blocked);
  }
}

}  // namespace
}  // namespace vcd::test
