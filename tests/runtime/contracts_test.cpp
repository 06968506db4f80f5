// What callers must see to is asserted, in builds that have assertions.
#include <gtest/gtest.h>

#include <vcd/runtime/scene.h>
#include <vcd/runtime/sidecar.h>

#include "support/files.h"
#include "support/meshes.h"

namespace vcd::test {
namespace {

#ifndef NDEBUG
TEST(ContractsDeathTest, SpansThatAreTooShortAreNoticed) {
  GTEST_FLAG_SET(death_test_style, "threadsafe");  // bakes leave threads behind
  const baker::BakedObject baked = must_bake(sphere(), quick(3));
  const auto bytes = sidecar_bytes({&baked});
  const auto sidecar = Sidecar::open_buffer(bytes);
  ASSERT_TRUE(sidecar.ok());
  const Object object = sidecar->object(0);
  const std::vector<Segment> segments(64, Segment{{0, 0, -5}, 0, {0, 0, 10}, 1});
  std::vector<Visibility> answers(8);
  EXPECT_DEATH(object.classify(segments, answers), "answers.size");

  const std::vector<float> u(65), v(65);
  const QuadBundle quad{{0, 0, -5}, {0, 0, 5}, {1, 0, 0}, {0, 1, 0}, u, v};
  uint64_t blocked[2], unclassified[2];
  EXPECT_DEATH(object.classify(quad, std::span(blocked, 1), unclassified), "fits");
  QuadBundle uneven = quad;
  uneven.v = uneven.v.first(64);
  EXPECT_DEATH(object.classify(uneven, blocked, unclassified), "fits");
  EXPECT_DEATH(sidecar->object(1), "object_count");

  const Transform still{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
  const auto scene = Scene::build(std::vector{SceneInstance::of(object, still)});
  ASSERT_TRUE(scene.ok());
  EXPECT_DEATH(scene->classify(segments, answers), "answers.size");
  EXPECT_DEATH(scene->classify(quad, std::span(blocked, 1), unclassified), "fits");
  EXPECT_DEATH(scene->occluded(segments, std::span(blocked, 0), [](const UnclassifiedSegments&) {}), "has_words_for");
}
#else
TEST(ContractsDeathTest, SpansThatAreTooShortAreNoticed) { GTEST_SKIP() << "this build has no assertions"; }
#endif

}  // namespace
}  // namespace vcd::test
