// Segments that begin on the object: clear only where exact arithmetic says so, whatever key, place and bits they have.
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include <vcd/runtime/scene.h>
#include <vcd/runtime/sidecar.h>
#include <vcd/runtime/vcd.h>

#include "runtime/judged_mesh.h"
#include "support/count_allocations.h"
#include "support/meshes.h"
#include "support/special_floats.h"

namespace vcd::test {
using namespace baker;
namespace {

// A sphere with dents, so that parts of it stand above others; triangles turned at random.
SourceMesh dented() {
  SourceMesh mesh = sphere(16, 24);
  FloatRandom random(3);
  for (Position& p : mesh.positions) {
    const float r = 1 + 0.25f * std::sin(5 * p[0]) * std::sin(4 * p[1] + 1) * std::cos(3 * p[2]);
    for (float& x : p) x *= r;
  }
  for (TriangleIndices& t : mesh.triangles)
    if (random.below(2)) std::swap(t[1], t[2]);
  return mesh;
}

BakeOptions with_horizons() {
  BakeOptions options;
  options.method = Method::none, options.horizons = true;
  return options;
}

// A segment from above a triangle of the source.
struct FromTriangle {
  const SourceMesh& mesh;
  float height = 1e-3f, aside = 0;  // in lengths of the triangle

  Segment operator()(uint32_t triangle, FloatRandom& random) const {
    const auto& t = mesh.triangles[triangle];
    const Position &p = mesh.positions[t[0]], &q = mesh.positions[t[1]], &r = mesh.positions[t[2]];
    float a[3], b[3];
    for (int i = 0; i < 3; ++i) a[i] = q[i] - p[i], b[i] = r[i] - p[i];
    float n[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
    const float length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]), size = std::sqrt(length);
    float outward = 0;  // the mesh is around the origin
    for (int i = 0; i < 3; ++i) outward += n[i] * p[i];
    const float u = random.uniform(), v = random.uniform() * (1 - u);
    Segment s{{}, 0, {}, kInfinity};
    for (int i = 0; i < 3; ++i) {
      n[i] /= outward < 0 ? -length : length;
      s.origin[i] = p[i] + (u + aside) * a[i] + v * b[i] + height * size * n[i];
      s.direction[i] = random.between(-1, 1) + n[i];
    }
    return s;
  }
};

class HorizonTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    source_ = new SourceMesh(dented());
    judged_ = new JudgedMesh(SourceMesh(*source_));
    const BakedObject baked = must_bake(*source_, with_horizons());
    bytes_ = new std::vector<std::byte>(sidecar_bytes({&baked}));
  }
  static void TearDownTestSuite() { delete source_, delete judged_, delete bytes_; }

  static Sidecar open(const std::string& kernel = {}) {
    OpenOptions options;
    options.kernel = kernel;
    return std::move(*Sidecar::open_buffer(*bytes_, options));
  }
  static uint32_t count() { return static_cast<uint32_t>(source_->triangles.size()); }

  // Of `rays` segments, how many are clear; none may be wrong.
  template <class Key>
  static size_t clear_of(const Object& object, const FromTriangle& from, size_t rays, const Key& key) {
    FloatRandom random(11);
    size_t clear = 0;
    for (size_t i = 0; i < rays; ++i) {
      const uint32_t triangle = random.below(count());
      const Segment segment = from(triangle, random);
      if (object.classify_self(segment, key(triangle, random)) != Visibility::clear) continue;
      ++clear;
      EXPECT_FALSE(judged_->referee.occluded(segment));
    }
    return clear;
  }

  static inline SourceMesh* source_;
  static inline JudgedMesh* judged_;
  static inline std::vector<std::byte>* bytes_;
};

constexpr auto kOwn = [](uint32_t triangle, FloatRandom&) { return triangle; };

TEST_F(HorizonTest, S25_S27_TheKeyIsOfTheSourceAndClearIsNeverWrong) {
  const Sidecar sidecar = open();
  const Object object = sidecar.object(0);
  ASSERT_TRUE(object.has_horizons());
  const size_t rays = 20000 / kShare;
  for (const float height : {1e-4f, 1e-3f, 0.1f, 0.7f})
    EXPECT_GT(clear_of(object, {*source_, height}, rays, kOwn), rays / 2) << height;
}

TEST_F(HorizonTest, S26_S28_WhatDoesNotBeginAboveTheTriangleIsUnclassified) {
  const Sidecar sidecar = open();
  const Object object = sidecar.object(0);
  const size_t rays = 5000 / kShare;
  const auto another = [](uint32_t triangle, FloatRandom& random) {
    return (triangle + 1 + random.below(count() - 1)) % count();
  };
  EXPECT_EQ(clear_of(object, {*source_}, rays, another), 0u);
  EXPECT_EQ(clear_of(object, {*source_}, rays, [](uint32_t, FloatRandom& r) { return count() + r.below(1 << 20); }),
            0u);
  EXPECT_EQ(clear_of(object, {*source_, 1e-3f, 1.01f}, rays, kOwn), 0u);  // beside it
  EXPECT_EQ(clear_of(object, {*source_, 40.0f}, rays, kOwn), 0u);         // too high
  EXPECT_EQ(clear_of(object, {*source_, 0.0f}, rays, kOwn), 0u);          // on it
  EXPECT_EQ(clear_of(object, {*source_, -1e-3f}, rays, kOwn), 0u);        // below
}

TEST_F(HorizonTest, S26_TMinMovesTheBegin) {
  const Sidecar sidecar = open();
  const Object object = sidecar.object(0);
  FloatRandom random(5);
  const FromTriangle from{*source_, 0.0f};
  size_t clear = 0;
  for (int i = 0; i < 4000 / kShare; ++i) {
    const uint32_t triangle = random.below(count());
    Segment segment = from(triangle, random);
    segment.t_min = 1e-3f;
    if (object.classify_self(segment, triangle) != Visibility::clear) continue;
    ++clear;
    ASSERT_FALSE(judged_->referee.occluded(segment));
    segment.t_min = 0;
    ASSERT_EQ(object.classify_self(segment, triangle), Visibility::unclassified);
  }
  EXPECT_GT(clear, 1500u / kShare);
}

TEST_F(HorizonTest, RaysAlongTheRimOfTheHorizonAreNotWrong) {
  const Sidecar sidecar = open();
  const Object object = sidecar.object(0);
  FloatRandom random(6);
  const FromTriangle from{*source_, 2e-4f};
  for (int i = 0; i < 6000 / kShare; ++i) {
    const uint32_t triangle = random.below(count());
    const Segment start = from(triangle, random);
    // Halve the angle between a direction that is clear and one that is not.
    Segment clear = start, other = from(triangle, random);
    std::memcpy(other.origin, start.origin, sizeof start.origin);
    if (object.classify_self(clear, triangle) != Visibility::clear) std::swap(clear, other);
    if (object.classify_self(clear, triangle) != Visibility::clear ||
        object.classify_self(other, triangle) == Visibility::clear)
      continue;
    for (int halving = 0; halving < 24; ++halving) {
      Segment middle = clear;
      for (int a = 0; a < 3; ++a) middle.direction[a] = 0.5f * (clear.direction[a] + other.direction[a]);
      (object.classify_self(middle, triangle) == Visibility::clear ? clear : other) = middle;
    }
    ASSERT_FALSE(judged_->referee.occluded(clear));
  }
}

// Segments of any bits, and some that are sound.
std::vector<Segment> hostile(const FromTriangle& from, uint32_t triangles, std::vector<uint32_t>& primitives) {
  FloatRandom random(9);
  std::vector<Segment> segments;
  const float odd[] = {0, -0.0f, kInfinity, -kInfinity, std::numeric_limits<float>::quiet_NaN(), 1e-42f, 3e38f, 1e-20f};
  for (int i = 0; i < 3000; ++i) {
    const uint32_t triangle = random.below(triangles);
    Segment s = from(triangle, random);
    if (i % 3 == 0) reinterpret_cast<float*>(&s)[random.below(8)] = odd[random.below(8)];
    if (i % 5 == 0)
      for (float& x : s.direction) x *= std::ldexp(1.0f, static_cast<int>(random.below(200)) - 100);
    segments.push_back(s);
    primitives.push_back(i % 11 == 0 ? ~0u : triangle);
  }
  return segments;
}

TEST_F(HorizonTest, S29_WhatIsDoubtfulIsUnclassified) {
  const Sidecar sidecar = open();
  const Object object = sidecar.object(0);
  FloatRandom random(8);
  Segment sound = FromTriangle{*source_}(5, random);
  while (object.classify_self(sound, 5) != Visibility::clear) sound = FromTriangle{*source_}(5, random);
  for (const float odd : {std::numeric_limits<float>::quiet_NaN(), kInfinity, -kInfinity})
    for (int i = 0; i < 7; ++i) {  // all but t_max, which does not matter
      Segment s = sound;
      reinterpret_cast<float*>(&s)[i] = odd;
      EXPECT_EQ(object.classify_self(s, 5), Visibility::unclassified) << odd << " " << i;
    }
  for (const auto& [scale, expected] : {std::pair(0x1p-38f, Visibility::clear),
                                        {0x1p38f, Visibility::clear},
                                        {0.0f, Visibility::unclassified},
                                        {0x1p-44f, Visibility::unclassified},
                                        {0x1p44f, Visibility::unclassified}}) {
    Segment s = sound;
    for (float& x : s.direction) x *= scale;
    EXPECT_EQ(object.classify_self(s, 5), expected) << scale;
  }
}

TEST_F(HorizonTest, EveryKernelGivesTheAnswersOfTheRule) {
  std::vector<uint32_t> primitives;
  const std::vector<Segment> segments = hostile({*source_}, count(), primitives);
  const Sidecar reference = open("scalar");
  for (const std::string& kernel : kernels()) {
    const Sidecar sidecar = open(kernel);
    const Object object = sidecar.object(0);
    for (const size_t some : {segments.size(), size_t{1}, size_t{17}, size_t{256}, size_t{300}}) {
      std::vector<Visibility> answers(some);
      object.classify_self(std::span(segments).first(some), primitives, answers);
      for (size_t i = 0; i < some; ++i) {
        ASSERT_EQ(answers[i], reference.object(0).classify_self(segments[i], primitives[i])) << kernel << " " << i;
        ASSERT_EQ(answers[i], object.classify_self(segments[i], primitives[i])) << kernel << " " << i;
      }
    }
    std::vector<uint64_t> blocked((segments.size() + 63) / 64);
    object.occluded_self(segments, primitives, blocked);
    for (size_t i = 0; i < segments.size(); ++i) {
      ASSERT_EQ((blocked[i / 64] >> i % 64 & 1) != 0, judged_->referee.occluded(segments[i])) << kernel << " " << i;
      ASSERT_EQ(object.occluded_self(segments[i], primitives[i]), judged_->referee.occluded(segments[i]));
    }
    // No kernel may use MMX registers, as GCC 12 makes of some zeroed arrays: they are those of long doubles.
    volatile long double one = 1;
    EXPECT_EQ(one + one, 2);
  }
}

// Bundles of each kind from a point, with more segments than are answered at once.
class Lights {
 public:
  explicit Lights(FloatRandom& random) {
    for (int i = 0; i < 300; ++i) {
      u_.push_back(random.uniform()), v_.push_back(random.uniform());
      x_.push_back(random.between(-2, 2)), y_.push_back(random.between(-2, 2)), z_.push_back(random.between(-2, 2));
    }
  }
  template <class Check>
  void for_each(const float (&origin)[3], const Check& check) const {
    QuadBundle quad{{}, {3, 3, -1}, {-2, 1, 0}, {0, 1, 2}, u_, v_};
    SphereBundle sphere_light{{}, {0, 0, 0}, 4, x_, y_, z_};
    PointBundle points{{}, x_, y_, z_};
    for (float* from : {quad.origin, sphere_light.origin, points.origin}) std::copy_n(origin, 3, from);
    check(quad), check(sphere_light), check(points);
  }

 private:
  std::vector<float> u_, v_, x_, y_, z_;
};

bool bit(const std::vector<uint64_t>& words, size_t i) { return words[i / 64] >> i % 64 & 1; }

TEST_F(HorizonTest, BundlesGiveTheAnswersOfTheirSegments) {
  FloatRandom random(12);
  const Lights lights(random);
  for (const std::string& kernel : kernels()) {
    const Sidecar sidecar = open(kernel);
    const Object object = sidecar.object(0);
    size_t clear = 0;
    for (int k = 0; k < 40; ++k) {
      const uint32_t triangle = random.below(count());
      const Segment from = FromTriangle{*source_}(triangle, random);
      lights.for_each(from.origin, [&](const auto& bundle) {
        std::vector<uint64_t> left(5), blocked(5);
        object.classify_self(bundle, triangle, left);
        object.occluded_self(bundle, triangle, blocked);
        for (size_t i = 0; i < bundle.size(); ++i) {
          const Segment s = segment_of(bundle, i);
          ASSERT_EQ(bit(left, i), object.classify_self(s, triangle) != Visibility::clear) << kernel;
          ASSERT_EQ(bit(blocked, i), judged_->referee.occluded(s)) << kernel;
          clear += !bit(left, i);
        }
      });
    }
    EXPECT_GT(clear, 3000u);
  }
}

constexpr Transform kMirrored{{{-2, 0, 0, 3}, {0, 2, 0, 0}, {0, 0, 2, 0}}};
constexpr Transform kTurned{{{0, -1, 0, -3}, {1, 0, 0, 0}, {0, 0, 1, 0}}};
Segment placed(const Segment& own, const Transform& t) {
  Segment s = own;
  for (int a = 0; a < 3; ++a) {
    s.origin[a] = t.rows[a][3], s.direction[a] = 0;
    for (int b = 0; b < 3; ++b)
      s.origin[a] += t.rows[a][b] * own.origin[b], s.direction[a] += t.rows[a][b] * own.direction[b];
  }
  return s;
}

TEST_F(HorizonTest, S30_ScenesAskTheInstanceOfTheOriginMirroredOnesToo) {
  const Sidecar sidecar = open();
  const Object object = sidecar.object(0);
  const auto scene = Scene::build(std::array{SceneInstance::of(object, kMirrored), SceneInstance::of(object, kTurned)});
  ASSERT_TRUE(scene);
  FloatRandom random(13);
  std::vector<Segment> world;
  std::vector<uint32_t> origins, primitives;
  size_t asked = 0, asked_without = 0;
  for (int i = 0; i < 3000 / kShare; ++i) {
    const uint32_t triangle = random.below(count()), instance = random.below(2);
    const Segment s = placed(FromTriangle{*source_}(triangle, random), instance == 0 ? kMirrored : kTurned);
    world.push_back(s), origins.push_back(instance), primitives.push_back(triangle);
    const SceneQuery without{~0u, std::span(&origins.back(), 1)};
    const SceneQuery query{~0u, std::span(&origins.back(), 1), std::span(&primitives.back(), 1)};
    ASSERT_EQ(scene->occluded(s, query), scene->occluded(s, without));
    scene->occluded(
        s, [&](uint32_t k) { return asked += k == instance, false; }, query);
    scene->occluded(
        s, [&](uint32_t k) { return asked_without += k == instance, false; }, without);
    if (scene->classify(s, query) == Visibility::clear) {
      ASSERT_FALSE(scene->occluded(s, without));
    }
  }
  EXPECT_LT(2 * asked, asked_without);
  std::vector<uint64_t> with((world.size() + 63) / 64), without(with.size());
  scene->occluded(world, with, {~0u, origins, primitives});
  scene->occluded(world, without, {~0u, origins});
  EXPECT_EQ(with, without);
  std::vector<uint64_t> none(with.size());
  const auto traced = [&](std::span<const uint32_t> keys) {
    size_t count_self = 0;
    const auto trace = [&](const UnclassifiedSegments& left) {
      for (size_t i = 0; i < left.segments.count; ++i) count_self += origins[left.indices[i]] == left.instance;
    };
    scene->occluded(world, none, trace, {~0u, origins, keys});
    return count_self;
  };
  EXPECT_LT(2 * traced(primitives), traced({}));
}

TEST_F(HorizonTest, S30_BundlesInScenesAskOfTheirSegmentsWhatSingleOnesDo) {
  FloatRandom random(14);
  const Lights lights(random);
  for (const std::string& kernel : kernels()) {
    const Sidecar sidecar = open(kernel);
    const Object object = sidecar.object(0);
    const auto scene =
        Scene::build(std::array{SceneInstance::of(object, kMirrored), SceneInstance::of(object, kTurned)}, kernel);
    ASSERT_TRUE(scene);
    size_t asked = 0, of = 0;
    for (int k = 0; k < 40; ++k) {
      const uint32_t triangle = random.below(count()), instance = random.below(2);
      const Segment from = placed(FromTriangle{*source_}(triangle, random), instance == 0 ? kMirrored : kTurned);
      const SceneQuery query{~0u, std::span(&instance, 1), std::span(&triangle, 1)};
      lights.for_each(from.origin, [&](const auto& bundle) {
        std::vector<uint64_t> self(5), blocked(5), unused(5);
        scene->occluded(
            bundle, unused,
            [&](const UnclassifiedSegments& left) {
              for (size_t i = 0; i < left.segments.count; ++i)
                if (left.instance == instance) self[left.indices[i] / 64] |= uint64_t{1} << left.indices[i] % 64;
            },
            query);
        scene->occluded(bundle, blocked, query);
        for (size_t i = 0; i < bundle.size(); ++i) {
          const Segment s = segment_of(bundle, i);
          bool single = false;
          scene->occluded(
              s, [&](uint32_t other) { return single |= other == instance, false; }, query);
          ASSERT_EQ(bit(self, i), single) << kernel;
          ASSERT_EQ(bit(blocked, i), scene->occluded(s, {~0u, std::span(&instance, 1)})) << kernel;
          asked += single, ++of;
        }
      });
    }
    EXPECT_LT(asked, of - of / 5) << kernel;
  }
}

TEST_F(HorizonTest, SpeaksC) {
  vcd_error error{};
  error.size = sizeof error;
  const Sidecar sidecar = open();
  const Object object = sidecar.object(0);
  const vcd_sidecar* in_c = nullptr;
  ASSERT_EQ(vcd_open_buffer(bytes_->data(), bytes_->size(), nullptr, &in_c, &error), VCD_SUCCESS) << error.message;
  const vcd_object* const c_object = vcd_object_at(in_c, 0);
  EXPECT_EQ(vcd_object_has_horizons(c_object), 1);
  std::vector<uint32_t> primitives;
  const std::vector<Segment> segments = hostile({*source_}, count(), primitives);
  const auto* const c_segments = reinterpret_cast<const vcd_segment*>(segments.data());
  std::vector<uint8_t> answers(segments.size());
  std::vector<uint64_t> blocked((segments.size() + 63) / 64);
  vcd_classify_self_array(c_object, c_segments, primitives.data(), segments.size(), answers.data());
  vcd_occluded_self_array(c_object, c_segments, primitives.data(), segments.size(), blocked.data());
  for (size_t i = 0; i < segments.size(); ++i) {
    ASSERT_EQ(vcd_classify_self(c_object, c_segments + i, primitives[i]), answers[i]);
    ASSERT_EQ(answers[i], static_cast<uint8_t>(object.classify_self(segments[i], primitives[i])));
    ASSERT_EQ(vcd_occluded_self(c_object, c_segments + i, primitives[i]), (blocked[i / 64] >> i % 64 & 1) != 0);
  }
  vcd_close(in_c);
}

TEST_F(HorizonTest, QueriesDoNotAllocate) {
  const Sidecar sidecar = open();
  const Object object = sidecar.object(0);
  std::vector<uint32_t> primitives;
  const std::vector<Segment> segments = hostile({*source_}, count(), primitives);
  std::vector<Visibility> answers(segments.size());
  const auto before = allocation_count();
  object.classify_self(segments[0], primitives[0]);
  object.classify_self(segments, primitives, answers);
  EXPECT_EQ(allocation_count(), before);
}

TEST(Horizon, ObjectsWithoutHorizonsLeaveEverything) {
  const BakedObject baked = must_bake(cube(), quick(1));
  const std::vector<std::byte> bytes = sidecar_bytes({&baked});
  const auto sidecar = Sidecar::open_buffer(bytes);
  EXPECT_FALSE(sidecar->object(0).has_horizons());
  EXPECT_EQ(sidecar->object(0).classify_self({{0.5f, 0.5f, -0.1f}, 0, {0, 0, -1}, 1}, 0), Visibility::unclassified);
}

}  // namespace
}  // namespace vcd::test
