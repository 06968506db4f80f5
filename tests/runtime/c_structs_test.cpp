// The C interface: structs of zeros mean the defaults, sizes tell versions apart, and versions can be asked for.
#include <vcd/runtime/vcd.h>

#include <cstring>
#include <string>
#include <type_traits>
#include <vector>

#include <gtest/gtest.h>

#include <vcd/format/layout.h>
#include <vcd/runtime/sidecar.h>

#include "support/files.h"
#include "support/meshes.h"

namespace vcd::test {
namespace {

// Their first member.
static_assert(offsetof(vcd_open_options, size) == 0 && offsetof(vcd_error, size) == 0 &&
              offsetof(vcd_quad_bundle, size) == 0 && offsetof(vcd_sphere_bundle, size) == 0 &&
              offsetof(vcd_instance, size) == 0 && offsetof(vcd_scene_query, size) == 0 &&
              offsetof(vcd_unclassified_segments, size) == 0);

class CStructs : public testing::Test {
 protected:
  ~CStructs() override { vcd_scene_free(scene_), vcd_close(sidecar_); }

  vcd_result open(const std::vector<std::byte>& bytes, const vcd_open_options* options, vcd_error* error = nullptr) {
    vcd_close(sidecar_);
    return vcd_open_buffer(bytes.data(), bytes.size(), options, &sidecar_, error);
  }
  vcd_instance instance(float x) {
    if (!sidecar_) (void)open(bytes_, nullptr);
    vcd_instance zeros{};
    zeros.object = vcd_object_at(sidecar_, 0);
    for (int a = 0; a < 3; ++a) zeros.to_world[5 * a] = 1;
    zeros.to_world[3] = x;
    return zeros;
  }
  vcd_result build(const std::vector<vcd_instance>& instances, vcd_error* error = nullptr) {
    vcd_scene_free(scene_);
    return vcd_scene_build(instances.data(), instances.size(), nullptr, &scene_, error);
  }

  baker::BakedObject baked_ = must_bake(cube(), proven(3));
  std::vector<std::byte> bytes_ = sidecar_bytes({&baked_});
  const vcd_sidecar* sidecar_ = nullptr;
  vcd_scene* scene_ = nullptr;
  // Through the middle of the cube at x = 0.
  vcd_segment through_ = {{0.4f, -1, 0.45f}, 0, {0, 3, 0}, 1};
};

TEST_F(CStructs, FilesAreOpenedAtThreeLevels) {
  const auto accepted = [&](const std::vector<std::byte>& bytes) {
    std::string levels;
    for (const vcd_check check : {VCD_CHECK_BOUNDS, VCD_CHECK_CHECKSUMS, VCD_CHECK_CANONICAL}) {
      vcd_open_options options{};
      options.check = check;
      levels += open(bytes, &options) == VCD_SUCCESS ? "+" : "-";
    }
    return levels;
  };
  EXPECT_EQ(accepted(bytes_), "+++");

  // A cell is damaged; and the same with checksums that fit, so that only the counts of cells are wrong.
  auto damaged = bytes_;
  for (size_t i = 0; i < 16; ++i) {
    SectionEntry entry;
    std::memcpy(&entry, bytes_.data() + sizeof(FileHeader) + i * sizeof entry, sizeof entry);
    if (entry.type != kSectionTree) continue;
    damaged[entry.offset + entry.stored_size - 1] ^= std::byte{1};
    break;
  }
  EXPECT_EQ(accepted(damaged), "+--");
  baker::BakedObject wrong = must_bake(cube(), proven(3));
  ++wrong.record.nodes_folded;
  EXPECT_EQ(accepted(sidecar_bytes({&wrong})), "++-");

  vcd_open_options none{};
  none.check = static_cast<vcd_check>(3);
  vcd_error error{};
  EXPECT_EQ(open(bytes_, &none, &error), VCD_ERROR_USAGE);
  EXPECT_NE(std::string(error.message).find("check"), std::string::npos);
}

TEST_F(CStructs, SizesAreZeroOrAtLeastTheFirstVersions) {
  vcd_open_options options{};
  for (const size_t size : {size_t{0}, sizeof options, sizeof options + 8}) {
    options.size = static_cast<uint32_t>(size);
    EXPECT_EQ(open(bytes_, &options), VCD_SUCCESS) << size;
  }
  options.size = sizeof options - 1;
  EXPECT_EQ(open(bytes_, &options), VCD_ERROR_USAGE);
  EXPECT_EQ(sidecar_, nullptr);

  // An error of another size gets what fits.
  struct Later {
    vcd_error error;
    char more[100];
  } later{};
  for (const size_t size : {size_t{0}, sizeof(vcd_error), size_t{20}}) {
    later.error.size = static_cast<uint32_t>(size);
    std::memset(later.error.message, 'x', sizeof later.error.message);
    EXPECT_EQ(vcd_open("/nowhere/at/all/there/is/none.vcd", nullptr, &sidecar_, &later.error), VCD_ERROR_IO);
    EXPECT_EQ(std::strlen(later.error.message) == 15, size == 20) << later.error.message;
  }
}

TEST_F(CStructs, InstancesOfALaterVersionHaveTheirOwnStride) {
  struct Later {
    vcd_instance first;
    uint64_t more;
  };
  std::vector<Later> later(3, {instance(5), ~uint64_t{0}});
  later[1].first = instance(0);
  for (Later& one : later) one.first.size = sizeof(Later);
  ASSERT_EQ(vcd_scene_build(&later[0].first, later.size(), nullptr, &scene_, nullptr), VCD_SUCCESS);
  EXPECT_EQ(vcd_scene_classify(scene_, &through_, 0, VCD_NO_INSTANCE), VCD_BLOCKED);
  for (uint32_t i = 0; i < 3; ++i) EXPECT_EQ(vcd_scene_use(scene_, i), VCD_INSTANCE_ASKED);
  vcd_scene_free(scene_), scene_ = nullptr;

  later[2].first.size = 0;
  vcd_error error{};
  EXPECT_EQ(vcd_scene_build(&later[0].first, later.size(), nullptr, &scene_, &error), VCD_ERROR_USAGE);
  EXPECT_NE(std::string(error.message).find("instance 2"), std::string::npos);
  vcd_instance small = instance(0);
  small.size = sizeof small - 4;
  EXPECT_EQ(build({small}), VCD_ERROR_USAGE);
}

TEST_F(CStructs, AMaskOfZeroIsAll) {
  vcd_instance seen = instance(0), masked = instance(0);
  masked.mask = 4;
  for (const auto& [one, mask, answer] :
       {std::tuple{seen, 0u, VCD_BLOCKED}, std::tuple{seen, 2u, VCD_BLOCKED}, std::tuple{masked, 0u, VCD_BLOCKED},
        std::tuple{masked, 4u, VCD_BLOCKED}, std::tuple{masked, 2u, VCD_CLEAR}}) {
    ASSERT_EQ(build({one}), VCD_SUCCESS);
    EXPECT_EQ(vcd_scene_classify(scene_, &through_, mask, VCD_NO_INSTANCE), answer) << mask;
    vcd_scene_query query{};
    query.mask = mask;
    uint64_t blocked = 7;
    vcd_scene_occluded(
        scene_, &through_, 1, &query, [](void*, const vcd_unclassified_segments*) {}, nullptr, &blocked);
    EXPECT_EQ(blocked, answer == VCD_BLOCKED ? 1u : 0u);
  }
}

TEST_F(CStructs, ScenesSayWhatBecomesOfInstances) {
  vcd_instance flat = instance(0), hidden{}, open = instance(0), not_finite = instance(0);
  flat.to_world[5] = 0;
  hidden.object = flat.object;
  open.object = nullptr;
  for (int a = 0; a < 3; ++a) open.box_max[a] = 1;
  not_finite.to_world[3] = HUGE_VALF;
  ASSERT_EQ(build({instance(0), flat, hidden, open, not_finite}), VCD_SUCCESS);
  const vcd_instance_use expected[] = {VCD_INSTANCE_ASKED, VCD_INSTANCE_LEFT, VCD_INSTANCE_ABSENT, VCD_INSTANCE_LEFT,
                                       VCD_INSTANCE_LEFT};
  for (uint32_t i = 0; i < 5; ++i) EXPECT_EQ(vcd_scene_use(scene_, i), expected[i]) << i;

  // A flat instance is handed over in the world's frame, one that only has no object in its own.
  std::string handed;
  through_.origin[1] = -0.5f, through_.direction[0] = 0.9f, through_.direction[1] = 3;
  ASSERT_EQ(build({flat, open}), VCD_SUCCESS);
  uint64_t blocked;
  vcd_scene_occluded(
      scene_, &through_, 1, nullptr,
      [](void* into, const vcd_unclassified_segments* left) {
        EXPECT_EQ(left->size, sizeof *left);
        *static_cast<std::string*>(into) += std::to_string(left->instance) + (left->in_world ? " world " : " object ");
      },
      &handed, &blocked);
  EXPECT_EQ(handed, "0 world 1 object ");

  const float still[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
  std::vector<float> transforms(still, still + 12);
  transforms.insert(transforms.end(), still, still + 12);
  EXPECT_EQ(vcd_scene_set_transforms(scene_, transforms.data(), nullptr), VCD_SUCCESS);
  EXPECT_EQ(vcd_scene_use(scene_, 0), VCD_INSTANCE_ASKED);
}

TEST(Version, OfHeadersAndLibraryIsOne) {
  EXPECT_EQ(vcd_runtime_version(), static_cast<uint32_t>(VCD_RUNTIME_VERSION));
  EXPECT_EQ(runtime_version(), vcd_runtime_version());
  EXPECT_EQ(std::string(runtime_version_string()), std::to_string(VCD_RUNTIME_VERSION_MAJOR) + "." +
                                                       std::to_string(VCD_RUNTIME_VERSION_MINOR) + "." +
                                                       std::to_string(VCD_RUNTIME_VERSION_PATCH));
  static_assert(VCD_RUNTIME_VERSION_MINOR < 1000 && VCD_RUNTIME_VERSION_PATCH < 1000);
}

}  // namespace
}  // namespace vcd::test
