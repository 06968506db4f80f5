#include <vcd/runtime/sidecar_store.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include <gtest/gtest.h>

#include <vcd/runtime/vcd.h>

#include "support/files.h"
#include "support/meshes.h"

namespace vcd::test {
namespace {

class Store : public testing::Test {
 protected:
  Store() {
    std::filesystem::create_directories(folder_ / "a/b");
    write_file(folder_ / "a/b/cube.vcd", sidecar_bytes({&cube_}));
    write_file(folder_ / "both.vcd", sidecar_bytes({&cube_, &leaves_}));
    write_file(folder_ / "a/note.txt", {});
  }
  static GeometryHash hash(const baker::SourceMesh& mesh) { return *geometry_hash(mesh.positions, mesh.triangles); }
  SidecarStore open(const std::vector<std::filesystem::path>& folders, const OpenOptions& options = {}) const {
    return std::move(SidecarStore::open(folders, options).value());
  }

  baker::BakedObject cube_ = must_bake(cube(), proven(2)), leaves_ = must_bake(leaves(20), proven(2));
  TemporaryFolder folder_;
};

TEST_F(Store, FindsObjectsByTheirGeometry) {
  const SidecarStore store = open({folder_ / ""});
  EXPECT_EQ(store.size(), 2u);
  EXPECT_TRUE(store.passed_over().empty());
  const auto cubes = store.find(hash(cube())), found = store.find(hash(leaves(20))), none = store.find(hash(sphere()));
  ASSERT_TRUE(cubes && *cubes && found && *found);
  EXPECT_EQ((*cubes)->name(), "cube");
  EXPECT_EQ((*found)->name(), "leaves");
  ASSERT_TRUE(none.ok());
  EXPECT_FALSE(none->has_value());
}

TEST_F(Store, TakesTheFirstOfTwo) {
  // By path: a/b/cube.vcd, which is damaged beyond its tables, comes before both.vcd.
  auto bytes = sidecar_bytes({&cube_});
  bytes.back() ^= std::byte{1};
  write_file(folder_ / "a/b/cube.vcd", bytes);
  EXPECT_EQ(open({folder_ / ""}).find(hash(cube())).error().code, ErrorCode::invalid_file);
  std::filesystem::create_directory(folder_ / "c");
  write_file(folder_ / "c/cube.vcd", sidecar_bytes({&cube_}));
  EXPECT_TRUE(open({folder_ / "c", folder_ / ""}).find(hash(cube())).ok());
}

TEST_F(Store, OpensAFileOnceWhoeverAsks) {
  const SidecarStore store = open({folder_ / ""});
  std::vector<const ObjectRecord*> records(8);
  std::vector<std::thread> threads;
  for (size_t i = 0; i < records.size(); ++i)
    threads.emplace_back([&, i] { records[i] = &store.find(hash(i % 2 ? cube() : leaves(20))).value()->record(); });
  for (std::thread& thread : threads) thread.join();
  for (size_t i = 2; i < records.size(); ++i) EXPECT_EQ(records[i], records[i - 2]);  // in one file's memory
}

TEST_F(Store, OpensNothingBeforeItIsAsked) {
  const SidecarStore store = open({folder_ / ""});
  std::filesystem::remove(folder_ / "both.vcd");
  EXPECT_EQ(store.find(hash(leaves(20))).error().code, ErrorCode::io);
  const SidecarStore again = open({folder_ / ""});
  write_file(folder_ / "a/b/cube.vcd", sidecar_bytes({&leaves_}));
  EXPECT_EQ(again.find(hash(cube())).error().code, ErrorCode::io);
}

TEST_F(Store, PassesOverWhatIsNoSidecar) {
  auto bytes = sidecar_bytes({&cube_});
  for (const size_t size : {size_t{0}, size_t{63}, size_t{200}, bytes.size() - 1}) {
    write_file(folder_ / "both.vcd", {bytes.begin(), bytes.begin() + static_cast<ptrdiff_t>(size)});
    const SidecarStore store = open({folder_ / ""});
    EXPECT_EQ(store.size(), 1u);
    ASSERT_EQ(store.passed_over().size(), 1u);
    EXPECT_NE(store.passed_over()[0].message.find("both.vcd"), std::string::npos);
  }
  const std::vector<std::filesystem::path> nowhere = {folder_ / "nowhere"};
  EXPECT_EQ(SidecarStore::open(nowhere).error().code, ErrorCode::io);
}

TEST_F(Store, IsTheSameInC) {
  const std::string folder = (folder_ / "").string();
  const char* folders[] = {folder.c_str()};
  vcd_store* store = nullptr;
  ASSERT_EQ(vcd_store_open(folders, 1, nullptr, &store, nullptr), VCD_SUCCESS);
  const baker::SourceMesh mesh = cube();
  vcd_mesh_buffers buffers{};
  buffers.positions = mesh.positions.data(), buffers.position_count = mesh.positions.size();
  buffers.indices = mesh.triangles.data(), buffers.face_count = mesh.triangles.size();
  uint8_t geometry[16];
  ASSERT_EQ(vcd_geometry_hash(&buffers, geometry, nullptr), VCD_SUCCESS);
  EXPECT_TRUE(std::ranges::equal(geometry, hash(cube())));
  const vcd_object *object = nullptr, *again = nullptr;
  ASSERT_EQ(vcd_store_find(store, geometry, &object, nullptr), VCD_SUCCESS);
  ASSERT_EQ(vcd_store_find(store, geometry, &again, nullptr), VCD_SUCCESS);
  ASSERT_NE(object, nullptr);
  EXPECT_EQ(object, again);
  size_t length = 0;
  EXPECT_EQ(std::string_view(vcd_object_name(object, &length), 4), "cube");
  geometry[0] ^= 1;
  EXPECT_EQ(vcd_store_find(store, geometry, &object, nullptr), VCD_SUCCESS);
  EXPECT_EQ(object, nullptr);
  EXPECT_EQ(vcd_store_size(store), 2u);
  EXPECT_EQ(vcd_store_passed_over(store, 0), nullptr);
  vcd_store_close(store);

  std::ofstream(folder_ / "none.vcd") << "no sidecar";
  ASSERT_EQ(vcd_store_open(folders, 1, nullptr, &store, nullptr), VCD_SUCCESS);
  EXPECT_EQ(vcd_store_size(store), 2u);
  EXPECT_NE(std::string(vcd_store_passed_over(store, 0)).find("none.vcd"), std::string::npos);
  EXPECT_EQ(vcd_store_passed_over(store, 1), nullptr);
  vcd_store_close(store);

  vcd_error error{};
  buffers.position_count = 7;
  EXPECT_EQ(vcd_geometry_hash(&buffers, geometry, &error), VCD_ERROR_USAGE);
  EXPECT_NE(std::string(error.message).find("index"), std::string::npos);
  folders[0] = "/nowhere";
  EXPECT_EQ(vcd_store_open(folders, 1, nullptr, &store, nullptr), VCD_ERROR_IO);
  EXPECT_EQ(store, nullptr);
}

TEST_F(Store, OpensWithItsOptions) {
  OpenOptions options;
  options.kernel = "abacus";
  EXPECT_EQ(open({folder_ / ""}, options).find(hash(cube())).error().code, ErrorCode::usage);
}

}  // namespace
}  // namespace vcd::test
