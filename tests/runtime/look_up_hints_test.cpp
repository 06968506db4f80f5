// Whether look-ups come before the hierarchy is asked: by an object's flags and the file's version, for each way of
// asking; and that all ways then say the same.
#include <cstring>
#include <string>

#include <gtest/gtest.h>

#include <vcd/format/checksum.h>
#include <vcd/runtime/scene.h>
#include <vcd/runtime/sidecar.h>

#include "support/exact_world.h"
#include "support/files.h"
#include "support/meshes.h"

namespace vcd::test {
using namespace baker;
namespace {

// What samples do not see: look-ups say that lines through the needle are clear.
SourceMesh needle() {
  return {"needle",
          0,
          {{0, 0, 0},
           {0.1f, 0, 0},
           {0, 0.1f, 0},
           {1, 1, 1},
           {0.9f, 1, 1},
           {1, 0.9f, 1},
           {0.5f, 0.5f, 0},
           {0.5002f, 0.5f, 0},
           {0.5f, 0.5f, 1}},
          {{0, 1, 2}, {3, 4, 5}, {6, 7, 8}}};
}

struct HowAsked {
  bool one, array, bundle, array_in_scene, bundle_in_scene;
  bool operator==(const HowAsked&) const = default;
};
// Whether the needle is overlooked: whether cells are looked up first.
HowAsked overlooked(const std::vector<std::byte>& bytes, From from) {
  OpenOptions options;
  options.check = CheckLevel::bounds;
  const Sidecar sidecar = std::move(*Sidecar::open_buffer(bytes, options));
  const Object object = sidecar.object(0);
  const Scene scene = std::move(*Scene::build(std::vector{SceneInstance::of(object, kStill)}));
  const float y = from == From::outside ? -1.0f : 0.25f;
  const Segment segment{{0.50003f, y, 0.25f}, 0, {0, 2, 0}, 1};
  const std::vector<float> zeros(20);
  const QuadBundle bundle{{0.50003f, y, 0.25f}, {0.50003f, y + 2, 0.25f}, {1e-6f, 0, 0}, {0, 0, 1e-6f}, zeros, zeros};
  EXPECT_EQ(object.classify(segment), Visibility::clear);
  uint64_t one = 0, many = 0, many_in_scene = 0;
  object.occluded(std::span(&segment, 1), {&one, 1}, from);
  object.occluded(bundle, {&many, 1}, from);
  scene.occluded(bundle, {&many_in_scene, 1}, {});
  uint64_t one_in_scene = 0;
  scene.occluded(std::span(&segment, 1), {&one_in_scene, 1}, {});
  EXPECT_EQ(one_in_scene != 0, scene.occluded(segment, {}));
  return {!object.occluded(segment, from), one == 0, many == 0, one_in_scene == 0, many_in_scene == 0};
}

TEST(LookUpHints, AreFollowed) {
  BakeOptions options;
  options.method = Method::sampled, options.depth = 3, options.samples = 16;
  BakedObject object = must_bake(needle(), options);
  for (uint16_t flags = 0; flags <= 126; flags += 2)
    for (const uint16_t minor : {2, 1, 0}) {
      if (flags & ~known_object_flags(minor)) continue;
      object.record.flags = flags;
      std::vector<std::byte> bytes = sidecar_bytes({&object});
      FileHeader header;  // as a writer of that format would have it
      std::memcpy(&header, bytes.data(), sizeof header);
      header.version_minor = minor;
      header.header_xxh3 =
          checksum(Bytes(reinterpret_cast<const std::byte*>(&header), offsetof(FileHeader, header_xxh3)));
      std::memcpy(bytes.data(), &header, sizeof header);

      const auto has = [&](uint16_t flag) { return (flags & flag) != 0; };
      const bool array_outside = has(kLookUpFromOutside), array_inside = has(kLookUpFromInside),
                 outside = minor < 1 ? array_outside : has(kLookUpTogetherFromOutside),
                 inside = minor < 1 ? array_inside : has(kLookUpTogetherFromInside),
                 one_outside = minor < 2 ? array_outside : has(kLookUpOneFromOutside),
                 one_inside = minor < 2 ? array_inside : has(kLookUpOneFromInside),
                 in_scene = minor < 2 ? outside : one_outside;
      // A scene has one rule, for segments from outside.
      EXPECT_EQ(overlooked(bytes, From::outside), (HowAsked{one_outside, array_outside, outside, in_scene, outside}));
      EXPECT_EQ(overlooked(bytes, From::inside), (HowAsked{one_inside, array_inside, inside, in_scene, outside}));
    }
}

// A line between the mesh and its padded box, in a cell whose sample lines are all blocked.
TEST(LookUpHints, ChangeNoAnswerWhereStatisticsErr) {
  BakeOptions options;
  options.method = Method::sampled, options.depth = 3, options.samples = 16;
  const BakedObject baked = must_bake(cube(), options);
  const std::vector<std::byte> bytes = sidecar_bytes({&baked});
  const Segment beside{{1.0004f, 0.45f, -1}, 0, {0, 0, 4}, 1};
  for (const std::string& kernel : kernels()) {
    OpenOptions open;
    open.kernel = kernel, open.look_up = LookUpFirst::always;
    const Sidecar sidecar = std::move(*Sidecar::open_buffer(bytes, open));
    const Object object = sidecar.object(0);
    const Scene scene = std::move(*Scene::build(std::vector{SceneInstance::of(object, kStill)}, kernel));
    ASSERT_EQ(object.classify(beside), Visibility::blocked) << kernel;
    const std::vector<Segment> array(33, beside);  // whole groups of lanes, and one that is left
    uint64_t in_array = 0, in_scene = 0;
    object.occluded(array, {&in_array, 1}, From::outside);
    scene.occluded(array, {&in_scene, 1}, {});
    EXPECT_EQ(in_array, (uint64_t{1} << 33) - 1) << kernel;
    EXPECT_EQ(in_scene, (uint64_t{1} << 33) - 1) << kernel;
    EXPECT_TRUE(object.occluded(beside, From::outside)) << kernel;
    EXPECT_TRUE(scene.occluded(beside, {})) << kernel;
  }
}

}  // namespace
}  // namespace vcd::test
