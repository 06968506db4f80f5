// Tiny glTF files made in code, for the tests of glTF ingest.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>
#include <vcd/baker/mesh.h>

#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace vcd::test {

using nlohmann::json;
using Bytes = std::vector<uint8_t>;

template <class T>
Bytes bytes_of(const std::vector<T>& values) {
  Bytes bytes(values.size() * sizeof(T));
  if (!bytes.empty()) std::memcpy(bytes.data(), values.data(), bytes.size());
  return bytes;
}

inline std::string base64(const Bytes& bytes) {
  constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (size_t i = 0; i < bytes.size(); i += 3) {
    uint32_t group = 0;
    for (size_t k = 0; k < 3; ++k) group = group << 8 | (i + k < bytes.size() ? bytes[i + k] : 0u);
    for (size_t k = 0; k < 4; ++k) {
      const bool padding = i + k > bytes.size();
      text += padding ? '=' : alphabet[group >> (18 - 6 * k) & 63];
    }
  }
  return text;
}

// A folder of this test's own, removed at its end.
class GltfTest : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto* info = ::testing::UnitTest::GetInstance()->current_test_info();
    std::string name = std::string(info->test_suite_name()) + "-" + info->name() + "-" + std::to_string(getpid());
    for (char& c : name) c = c == '/' ? '-' : c;
    folder_ = std::filesystem::path(::testing::TempDir()) / name;
    std::filesystem::create_directories(folder_);
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  std::filesystem::path write(const std::string& name, std::string_view content) const {
    const std::filesystem::path path = folder_ / name;
    std::ofstream(path, std::ios::binary).write(content.data(), static_cast<std::streamsize>(content.size()));
    return path;
  }

  std::filesystem::path folder_;
};

constexpr int int8_type = 5120, uint8_type = 5121, int16_type = 5122, uint16_type = 5123, uint32_type = 5125,
              float_type = 5126;

// One buffer, and JSON that a test may bend as it likes before it is written.
class GltfBuilder {
 public:
  json document = {{"asset", {{"version", "2.0"}}}, {"buffers", {{{"byteLength", 0}}}}};

  size_t add_view(const Bytes& bytes, std::optional<size_t> stride = std::nullopt) {
    while (data_.size() % 4 != 0) data_.push_back(0);
    json view = {{"buffer", 0}, {"byteOffset", data_.size()}, {"byteLength", bytes.size()}};
    if (stride) view["byteStride"] = *stride;
    data_.insert(data_.end(), bytes.begin(), bytes.end());
    document["buffers"][0]["byteLength"] = data_.size();
    return append("bufferViews", view);
  }

  size_t add_accessor(std::optional<size_t> view, int component, const char* type, size_t count) {
    json accessor = {{"componentType", component}, {"type", type}, {"count", count}};
    if (view) accessor["bufferView"] = *view;
    return append("accessors", accessor);
  }

  size_t add_positions(const std::vector<baker::Position>& positions) {
    return add_accessor(add_view(bytes_of(positions)), float_type, "VEC3", positions.size());
  }

  template <class T>
  size_t add_indices(const std::vector<T>& indices) {
    const int type = sizeof(T) == 1 ? uint8_type : sizeof(T) == 2 ? uint16_type : uint32_type;
    return add_accessor(add_view(bytes_of(indices)), type, "SCALAR", indices.size());
  }

  static json primitive(size_t positions, std::optional<size_t> indices = std::nullopt, int mode = 4) {
    json result = {{"attributes", {{"POSITION", positions}}}, {"mode", mode}};
    if (indices) result["indices"] = *indices;
    return result;
  }

  size_t add_mesh(const std::vector<json>& primitives, const std::string& name = "") {
    json mesh = {{"primitives", primitives}};
    if (!name.empty()) mesh["name"] = name;
    return append("meshes", mesh);
  }

  size_t append(const char* array, const json& element) {
    document[array].push_back(element);
    return document[array].size() - 1;
  }

  const Bytes& data() const { return data_; }

  // The document with its buffer in a data URI.
  std::string embedded(const std::string& type = "application/octet-stream") const {
    json copy = document;
    copy["buffers"][0]["uri"] = "data:" + type + ";base64," + base64(data_);
    return copy.dump();
  }

  // A GLB whose buffer 0 is the binary chunk.
  std::string glb() const {
    std::string text = document.dump();
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::string binary(data_.begin(), data_.end());
    binary.resize((binary.size() + 3) / 4 * 4, '\0');
    std::string chunks = chunk(0x4E4F534A, text);
    if (!binary.empty()) chunks += chunk(0x004E4942, binary);
    return "glTF" + word(2) + word(static_cast<uint32_t>(12 + chunks.size())) + chunks;
  }

  static std::string word(uint32_t value) { return {reinterpret_cast<const char*>(&value), sizeof value}; }
  static std::string chunk(uint32_t type, const std::string& payload) {
    return word(static_cast<uint32_t>(payload.size())) + word(type) + payload;
  }

 private:
  Bytes data_;
};

inline const std::vector<baker::Position> square = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}};

// A mesh "Square" of two indexed triangles.
inline GltfBuilder square_file() {
  GltfBuilder builder;
  const size_t positions = builder.add_positions(square);
  const size_t indices = builder.add_indices<uint16_t>({0, 1, 2, 2, 1, 3});
  builder.add_mesh({GltfBuilder::primitive(positions, indices)}, "Square");
  return builder;
}

}  // namespace vcd::test
