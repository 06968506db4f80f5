// What glTF ingest must refuse, with which code, and what its message says.
#include <functional>
#include <limits>

#include "gltf_builder.h"
#include "ingest/gltf.h"

namespace vcd::test {
namespace {

using namespace baker;

class GltfErrors : public GltfTest {
 protected:
  Error refuse(const std::string& content, const std::string& name = "file.gltf") {
    const Result<Ingested> result = ingest(write(name, content));
    if (!result) return result.error();
    ADD_FAILURE() << "accepted";
    return {};
  }
  void expect_refused(const std::string& content, ErrorCode code, const std::string& reason) {
    const Error error = refuse(content);
    EXPECT_EQ(error.code, code) << error.message;
    EXPECT_NE(error.message.find(reason), std::string::npos) << error.message;
    EXPECT_EQ(error.message.rfind((folder_ / "file.gltf").string() + ": ", 0), 0u) << error.message;
  }
};

TEST_F(GltfErrors, NonFinitePositionsAreNamed) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity()}) {
    GltfBuilder builder = square_file();
    std::vector<Position> positions = square;
    positions[2][1] = bad;
    builder.add_mesh(
        {builder.document["meshes"][0]["primitives"][0], GltfBuilder::primitive(builder.add_positions(positions))},
        "B\nad");
    expect_refused(builder.embedded(), ErrorCode::invalid_file,
                   "mesh 1 \"B ad\", primitive 1: the position of vertex 2 is not finite");
  }
}

TEST_F(GltfErrors, IndicesOutOfRangeAreNamed) {
  GltfBuilder builder;
  builder.add_mesh(
      {GltfBuilder::primitive(builder.add_positions(square), builder.add_indices<uint16_t>({0, 1, 2, 3, 1, 4}))});
  expect_refused(builder.embedded(), ErrorCode::invalid_file,
                 "mesh 0, primitive 0: index element 5 is 4, there are 4 vertices");
}

TEST_F(GltfErrors, PrimitiveRestartIsRefused) {
  GltfBuilder builder;
  const size_t positions = builder.add_positions(std::vector<Position>(300));
  builder.add_mesh({GltfBuilder::primitive(positions, builder.add_indices<uint8_t>({0, 1, 255}), 5)});
  expect_refused(builder.embedded(), ErrorCode::invalid_file, "index element 2 is 255, the primitive restart value");
}

TEST_F(GltfErrors, UrisThatLeaveTheFolderAreReadOnlyIfAllowed) {
  namespace fs = std::filesystem;
  fs::create_directories(folder_ / "inner" / "deeper");
  const GltfBuilder square = square_file();
  const std::string bytes(square.data().begin(), square.data().end());
  for (const char* name : {"outside.bin", "inner/own.bin", "inner/deeper/own.bin"}) write(name, bytes);
  fs::create_symlink("../outside.bin", folder_ / "inner" / "link.bin");
  fs::create_directory_symlink("..", folder_ / "inner" / "up");
  fs::create_symlink("own.bin", folder_ / "inner" / "near.bin");
  const auto read = [&](const std::string& uri, bool allowed) {
    GltfBuilder builder = square;
    builder.document["buffers"][0]["uri"] = uri;
    return ingest(write("inner/file.gltf", builder.document.dump()), {.files_outside = allowed});
  };
  for (const std::string& uri :
       {std::string("../outside.bin"), std::string("deeper/../../outside.bin"), std::string("%2e%2e%2Foutside.bin"),
        (folder_ / "outside.bin").string(), std::string("link.bin"), std::string("up/outside.bin")}) {
    const Result<Ingested> refused = read(uri, false);
    ASSERT_FALSE(refused.ok()) << uri;
    EXPECT_EQ(refused.error().code, ErrorCode::unsupported);
    EXPECT_NE(refused.error().message.find("the uri \""), std::string::npos) << refused.error().message;
    EXPECT_NE(refused.error().message.find("leads out of the file's folder"), std::string::npos);
    EXPECT_TRUE(read(uri, true).ok()) << uri;
  }
  for (const std::string uri : {"own.bin", "./own.bin", "deeper/own.bin", "deeper/../own.bin", "near.bin"})
    EXPECT_TRUE(read(uri, false).ok()) << uri;
  EXPECT_EQ(read("absent.bin", false).error().code, ErrorCode::io);
  EXPECT_EQ(read("../absent.bin", false).error().code, ErrorCode::unsupported);
}

struct Defect {
  const char* name;
  std::function<void(json&)> bend;  // of square_file(): accessor and view 0 are positions, 1 are indices
  ErrorCode code;
  const char* reason;
};

const ErrorCode invalid = ErrorCode::invalid_file;

const std::vector<Defect> defects = {
    {"count", [](json& d) { d["accessors"][0]["count"] = 5; }, invalid,
     "5 elements exceed the buffer view of 48 bytes"},
    {"huge count", [](json& d) { d["accessors"][0]["count"] = uint64_t{1} << 53; }, invalid, "exceed the buffer view"},
    {"overflowing count", [](json& d) { d["accessors"][0]["count"] = UINT64_MAX; }, invalid, "above 2^53"},
    {"count 0", [](json& d) { d["accessors"][1]["count"] = 0; }, invalid, "1 primitive passed over without a vertex"},
    {"negative count", [](json& d) { d["accessors"][0]["count"] = -4; }, invalid,
     "count is not a non-negative integer"},
    {"fraction", [](json& d) { d["accessors"][0]["count"] = 4.0; }, invalid, "count is not a non-negative integer"},
    {"no count", [](json& d) { d["accessors"][0].erase("count"); }, invalid, "accessor 0: has no count"},
    {"accessor offset", [](json& d) { d["accessors"][0]["byteOffset"] = 4; }, invalid, "room for 3"},
    {"far offset", [](json& d) { d["accessors"][0]["byteOffset"] = uint64_t{1} << 52; }, invalid, "room for 0"},
    {"odd offset", [](json& d) { d["accessors"][0]["byteOffset"] = 2; }, invalid, "not aligned"},
    {"offset as text", [](json& d) { d["accessors"][0]["byteOffset"] = "0"; }, invalid, "byteOffset is not"},
    {"VEC2", [](json& d) { d["accessors"][0]["type"] = "VEC2"; }, invalid, "positions must be VEC3"},
    {"no type", [](json& d) { d["accessors"][0].erase("type"); }, invalid, "accessor 0: has no type"},
    {"integers", [](json& d) { d["accessors"][0]["componentType"] = uint32_type; }, invalid, "32-bit integers"},
    {"no such type", [](json& d) { d["accessors"][0]["componentType"] = 5124; }, invalid, "5124 does not exist"},
    {"undeclared", [](json& d) { d["accessors"][0]["componentType"] = int8_type; }, invalid, "KHR_mesh_quantization"},
    {"normalized float", [](json& d) { d["accessors"][0]["normalized"] = true; }, invalid, "cannot be normalized"},
    {"float indices", [](json& d) { d["accessors"][1]["componentType"] = float_type; }, invalid, "unsigned integers"},
    {"signed indices", [](json& d) { d["accessors"][1]["componentType"] = int16_type; }, invalid, "unsigned integers"},
    {"VEC3 indices", [](json& d) { d["accessors"][1]["type"] = "VEC3"; }, invalid, "indices must be SCALAR"},
    {"normalized indices", [](json& d) { d["accessors"][1]["normalized"] = true; }, invalid, "cannot be normalized"},
    {"strided indices", [](json& d) { d["bufferViews"][1]["byteStride"] = 4; }, invalid, "room for 3"},
    {"odd stride", [](json& d) { d["bufferViews"][1]["byteStride"] = 3; }, invalid, "is not a multiple of 4"},
    {"small stride", [](json& d) { d["bufferViews"][0]["byteStride"] = 8; }, invalid, "less than one element"},
    {"odd stride", [](json& d) { d["bufferViews"][0]["byteStride"] = 14; }, invalid, "not a multiple of 4"},
    {"long view", [](json& d) { d["bufferViews"][1]["byteLength"] = 13; }, invalid,
     "exceed the 60 bytes of the buffer"},
    {"far view", [](json& d) { d["bufferViews"][1]["byteOffset"] = uint64_t{1} << 53; }, invalid,
     "exceed the 60 bytes"},
    {"empty view", [](json& d) { d["bufferViews"][1]["byteLength"] = 0; }, invalid, "byteLength is 0"},
    {"no buffer", [](json& d) { d["bufferViews"][1]["buffer"] = 1; }, invalid, "buffer 1 does not exist"},
    {"no view", [](json& d) { d["accessors"][1]["bufferView"] = 2; }, invalid, "bufferView 2 does not exist"},
    {"no accessor", [](json& d) { d["meshes"][0]["primitives"][0]["indices"] = 2; }, invalid,
     "accessor 2 does not exist"},
    {"far accessor", [](json& d) { d["meshes"][0]["primitives"][0]["indices"] = uint64_t{1} << 32; }, invalid,
     "does not exist"},
    {"indices as text", [](json& d) { d["meshes"][0]["primitives"][0]["indices"] = "1"; }, invalid, "indices is not"},
    {"short buffer", [](json& d) { d["buffers"][0]["byteLength"] = 61; }, invalid, "byteLength is 61, the data has 60"},
    {"mode 7", [](json& d) { d["meshes"][0]["primitives"][0]["mode"] = 7; }, invalid, "mode 7 does not exist"},
    {"no attributes", [](json& d) { d["meshes"][0]["primitives"][0].erase("attributes"); }, invalid,
     "has no attributes"},
    {"no primitives", [](json& d) { d["meshes"][0]["primitives"] = json::array(); }, invalid,
     "no triangle to bake: 1 mesh"},
    {"no material", [](json& d) { d["meshes"][0]["primitives"][0]["material"] = 0; }, invalid,
     "material 0 does not exist"},
    {"meshes as text", [](json& d) { d["meshes"] = "all"; }, invalid, "meshes is not an array"},
    {"mesh as text", [](json& d) { d["meshes"][0] = "all"; }, invalid, "mesh 0: is not a JSON object"},
    {"unbacked",
     [](json& d) {
       d["accessors"][0] = {{"componentType", 5126}, {"type", "VEC3"}, {"count", 1u << 25}};
     },
     invalid, "no buffer view"},
    {"no asset", [](json& d) { d.erase("asset"); }, invalid, "no asset.version"},
    {"no version", [](json& d) { d["asset"]["version"] = "two"; }, invalid, "\"two\" is not a version"},
    {"glTF 1.0", [](json& d) { d["asset"]["version"] = "1.0"; }, ErrorCode::unsupported, "glTF 1.0 is not supported"},
    {"early glTF 1.0",
     [](json& d) {
       d = {{"meshes", json::object()}};
     },
     ErrorCode::unsupported, "glTF 1.0 is not"},
    {"glTF 2.1 needed",
     [](json& d) {
       d["asset"] = {{"version", "2.1"}, {"minVersion", "2.1"}};
     },
     ErrorCode::unsupported, "newer than 2.0"},
    {"unknown extension",
     [](json& d) {
       d["extensionsRequired"] = {"KHR_materials_unlit", "ACME_teapot"};
     },
     ErrorCode::unsupported, "requires the extension \"ACME_teapot\""},
};

TEST_F(GltfErrors, DefectsOfTheDocumentAreRefused) {
  for (const Defect& defect : defects) {
    SCOPED_TRACE(defect.name);
    GltfBuilder builder = square_file();
    builder.document["buffers"][0]["uri"] = "data:application/octet-stream;base64," + base64(builder.data());
    defect.bend(builder.document);
    expect_refused(builder.document.dump(), defect.code, defect.reason);
  }
}

TEST_F(GltfErrors, DefectsOfSparseAccessorsAreRefused) {
  struct Case {
    std::vector<uint8_t> places;
    size_t count;
    const char* reason;
  };
  for (const Case& c : {Case{{2, 1}, 2, "element 1 does not increase"}, Case{{1, 1}, 2, "element 1 does not increase"},
                        Case{{1, 4}, 2, "element 1 exceeds"}, Case{{1, 2}, 3, "exceed the buffer view"},
                        Case{{1, 2}, 5, "count must lie between"}, Case{{1, 2}, 0, "count must lie between"}}) {
    GltfBuilder builder = square_file();
    const size_t places = builder.add_view(c.places);
    const size_t values = builder.add_view(bytes_of(square));
    builder.document["accessors"][0]["sparse"] = {{"count", c.count},
                                                  {"indices", {{"bufferView", places}, {"componentType", uint8_type}}},
                                                  {"values", {{"bufferView", values}}}};
    expect_refused(builder.embedded(), invalid, c.reason);
  }
}

TEST_F(GltfErrors, DefectsOfBufferUrisAreRefused) {
  struct Case {
    const char* uri;
    ErrorCode code;
    const char* reason;
  };
  for (const Case& c :
       {Case{"nowhere.bin", ErrorCode::io, "nowhere.bin: cannot be opened"},
        Case{"/dev/zero", ErrorCode::unsupported, "leads out of the file's folder"},
        Case{".", ErrorCode::io, "not a regular file"}, Case{"a%00b", invalid, "a zero byte"},
        Case{"https://example.org/a.bin", ErrorCode::unsupported, "not relative"},
        Case{"data:application/octet-stream;base64", invalid, "without a comma"},
        Case{"data:;base64,AAA*", invalid, "not base64"}, Case{"data:;base64,AAAAA", invalid, "impossible length"},
        Case{"data:;base64,AAAA", invalid, "the data has 3"}}) {
    GltfBuilder builder = square_file();
    builder.document["buffers"][0]["uri"] = c.uri;
    expect_refused(builder.document.dump(), c.code, c.reason);
  }
  expect_refused(square_file().document.dump(), ErrorCode::io, "buffer 0: has no uri");
}

TEST_F(GltfErrors, EveryTruncationOfAGlbIsRefused) {
  const std::string whole = square_file().glb();
  ASSERT_TRUE(ingest(write("file.glb", whole)).ok());
  for (size_t size = 0; size < whole.size(); ++size) {
    EXPECT_EQ(refuse(whole.substr(0, size), "file.glb").code, invalid) << size;
  }
  EXPECT_TRUE(ingest(write("file.glb", whole + "x")).ok());
}

TEST_F(GltfErrors, BrokenGlbContainersAreRefused) {
  const std::string text = R"({"asset":{"version":"2.0"}} )";
  const std::string json_chunk = GltfBuilder::chunk(0x4E4F534A, text);
  const std::string binary_chunk = GltfBuilder::chunk(0x004E4942, "1234");
  const std::string other_chunk = GltfBuilder::chunk(0x12345678, "1234");
  const auto container = [](uint32_t version, const std::string& chunks) {
    return "glTF" + GltfBuilder::word(version) + GltfBuilder::word(static_cast<uint32_t>(12 + chunks.size())) + chunks;
  };
  expect_refused(container(1, json_chunk), ErrorCode::unsupported, "glTF 1.0");
  expect_refused(container(3, json_chunk), ErrorCode::unsupported, "version 3");
  expect_refused(container(2, ""), invalid, "without a JSON chunk");
  expect_refused(container(2, binary_chunk + json_chunk), invalid, "JSON chunk must come first");
  expect_refused(container(2, json_chunk + json_chunk), invalid, "JSON chunk must come first, and once");
  expect_refused(container(2, json_chunk + other_chunk + binary_chunk), invalid, "binary chunk must come second");
  expect_refused(container(2, json_chunk + other_chunk), invalid, "no triangle");
  expect_refused("solid stl", invalid, "neither GLB");
}

TEST_F(GltfErrors, MalformedJsonIsRefused) {
  expect_refused("{", invalid, "malformed");
  expect_refused("[]", invalid, "neither GLB");
  expect_refused("{\"asset\":{\"version\":\"2.0\",\"name\":\"\xFF\"}}", invalid, "malformed");
  // Nesting must not exhaust the stack.
  const size_t depth = 1'000'000;
  expect_refused("{\"extras\":" + std::string(depth, '[') + std::string(depth, ']') + "}", invalid, "no asset.version");
}

TEST_F(GltfErrors, AFileWithoutTrianglesSaysWhy) {
  GltfBuilder builder = square_file();
  json& primitives = builder.document["meshes"][0]["primitives"];
  primitives.push_back(GltfBuilder::primitive(0, std::nullopt, 0));
  primitives.push_back(primitives[0]);
  primitives[0]["material"] = builder.append("materials", {{"alphaMode", "BLEND"}});
  primitives[2]["targets"] = {{{"POSITION", 0}}};
  primitives.push_back({{"attributes", {{"NORMAL", 0}}}});
  expect_refused(builder.embedded(), invalid,
                 "no triangle to bake: 1 mesh, 1 primitive left out as not opaque, 1 primitive left out as deforming, "
                 "1 primitive passed over as points or lines, 1 primitive passed over without POSITION");
}

TEST_F(GltfErrors, AMissingFileIsAnIoError) {
  const Result<Ingested> result = ingest(folder_ / "nowhere.glb");
  ASSERT_FALSE(result.ok());
  EXPECT_EQ(result.error().code, ErrorCode::io);
}

}  // namespace
}  // namespace vcd::test
