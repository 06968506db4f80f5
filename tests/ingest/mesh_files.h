// Small mesh files for tests: written to a folder that goes with the test, read back through ingest().
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>
#include <vcd/baker/ingest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

namespace vcd::test {

using Triangles = std::vector<baker::TriangleIndices>;
// Of the two faces of a strip of four vertices.
const Triangles kBoth = {{0, 1, 2}, {1, 3, 2}};

class MeshFiles : public ::testing::Test {
 protected:
  MeshFiles() {
    std::string folder = (std::filesystem::temp_directory_path() / "vcd-ingest-XXXXXX").string();
    if (::mkdtemp(folder.data()) != nullptr) folder_ = folder;
  }
  ~MeshFiles() override {
    std::error_code ignored;
    if (!folder_.empty()) std::filesystem::remove_all(folder_, ignored);
  }

  std::filesystem::path write(const std::string& name, const std::string& bytes) const {
    std::ofstream(folder_ / name, std::ios::binary) << bytes;
    return folder_ / name;
  }

  // Ingests a file of these bytes; on an error the test fails and an empty mesh comes back.
  baker::Ingested read(const std::string& name, const std::string& bytes) const {
    Result<baker::Ingested> result = baker::ingest(write(name, bytes));
    if (result) {
      EXPECT_EQ(result->meshes.size(), 1u);
      return *std::move(result);
    }
    ADD_FAILURE() << result.error().message;
    baker::Ingested empty;
    empty.meshes.resize(1);
    return empty;
  }

  // Ingesting these bytes must fail with this code and a message that names the file and holds all `parts`.
  void expect_error(const std::string& name, const std::string& bytes, ErrorCode code,
                    const std::vector<std::string>& parts) const {
    const std::filesystem::path path = write(name, bytes);
    const Result<baker::Ingested> result = baker::ingest(path);
    ASSERT_FALSE(result.ok()) << "accepted: " << bytes.substr(0, 200);
    EXPECT_EQ(result.error().code, code) << result.error().message;
    EXPECT_TRUE(result.error().message.starts_with(path.string() + ": ")) << result.error().message;
    for (const std::string& part : parts) {
      EXPECT_NE(result.error().message.find(part), std::string::npos) << part << " in " << result.error().message;
    }
  }
  void expect_invalid(const std::string& name, const std::string& bytes, const std::vector<std::string>& parts) const {
    expect_error(name, bytes, ErrorCode::invalid_file, parts);
  }

  std::filesystem::path folder_;
};

// The triangles with their positions written out, in order.
inline std::vector<std::array<baker::Position, 3>> soup_of(const baker::SourceMesh& mesh) {
  std::vector<std::array<baker::Position, 3>> soup;
  for (const baker::TriangleIndices& t : mesh.triangles) {
    soup.push_back({mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]});
  }
  return soup;
}

// Sum of the signed areas of the triangles, seen from above (z).
inline double area_from_above(const baker::SourceMesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : soup_of(mesh)) {
    sum += 0.5 * ((double{b[0]} - a[0]) * (double{c[1]} - a[1]) - (double{b[1]} - a[1]) * (double{c[0]} - a[0]));
  }
  return sum;
}

// The smallest of them: negative if one triangle is turned around.
inline double least_area_from_above(const baker::SourceMesh& mesh) {
  double least = HUGE_VAL;
  for (const baker::TriangleIndices& t : mesh.triangles) {
    baker::SourceMesh one = {"", 0, mesh.positions, {t}};
    least = std::min(least, area_from_above(one));
  }
  return least;
}

inline bool any_note_has(const baker::Ingested& ingested, const std::string& part) {
  return std::any_of(ingested.notes.begin(), ingested.notes.end(),
                     [&](const std::string& note) { return note.find(part) != std::string::npos; });
}

// The bytes of a value, in either order.
template <class T>
std::string packed(T value, bool big_endian = false) {
  std::string bytes(sizeof(T), '\0');
  std::memcpy(bytes.data(), &value, sizeof(T));
  if (big_endian) std::reverse(bytes.begin(), bytes.end());
  return bytes;
}

inline std::string with_crlf(const std::string& text) {
  std::string result;
  for (const char c : text) result += c == '\n' ? "\r\n" : std::string(1, c);
  return result;
}

// A file of the folder of real meshes, which is no part of the project; nothing where there is no such
// folder.
inline std::optional<std::filesystem::path> real_mesh(const std::string& name) {
  const char* folder = std::getenv("VCD_TEST_DATA");
#ifdef VCD_SHARED_DATA_DIR
  if (folder == nullptr) folder = VCD_SHARED_DATA_DIR;
#endif
  if (folder == nullptr || !std::filesystem::exists(std::filesystem::path(folder) / name)) return std::nullopt;
  return std::filesystem::path(folder) / name;
}

#define VCD_REAL_MESH_OR_SKIP(variable, name)                                         \
  const std::optional<std::filesystem::path> variable = ::vcd::test::real_mesh(name); \
  if (!variable) GTEST_SKIP() << name << " is not here; VCD_TEST_DATA names the folder of real meshes"

}  // namespace vcd::test
