// Bundles against single calls and, where a bake is proven, against exact arithmetic; ranges of cells against each
// cell.
#include <vcd/runtime/bundle.h>

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include <vcd/baker/referee.h>
#include <vcd/format/contents.h>
#include <vcd/runtime/sidecar.h>
#include <vcd/runtime/vcd.h>

#include "lookup/range_class.h"
#include "support/count_allocations.h"
#include "support/files.h"
#include "support/meshes.h"
#include "support/random.h"
#include "support/segments.h"

namespace vcd::test {
using namespace baker;
namespace {

struct Light {
  std::vector<float> u, v;     // of a quadrilateral
  std::vector<float> x, y, z;  // of a sphere
  QuadBundle quad;
  SphereBundle sphere;
};

// Points around a box, lights of all sizes beyond it, before it, in it and beside it; samples in sixteens.
Light any_light(const ObjectRecord& record, FloatRandom& random) {
  Light light;
  const auto size = [&](int a) { return record.box_max[a] - record.box_min[a]; };
  const auto middle = [&](int a) { return 0.5f * (record.box_min[a] + record.box_max[a]); };
  const float far = random.below(8) == 0 ? 20.0f : 1.0f, light_size = std::exp2(random.between(-9, 1)),
              spread = random.between(0.2f, 3);
  float target[3], axis[3];
  for (int a = 0; a < 3; ++a) {
    light.quad.origin[a] = middle(a) + far * random.between(-2, 2) * size(a);
    target[a] = random.below(3) == 0 ? middle(a) + random.between(-spread, spread) * size(a)
                                     : middle(a) + random.between(-0.4f, 0.4f) * size(a);
    if (random.below(3)) target[a] += 2 * (middle(a) - light.quad.origin[a]) * (a == 0 ? 1.0f : 0.9f);
    light.quad.edge_u[a] = light_size * random.between(-1, 1) * size(a),
    light.quad.edge_v[a] = light_size * random.between(-1, 1) * size(a);
    light.quad.corner[a] = target[a] - 0.5f * (light.quad.edge_u[a] + light.quad.edge_v[a]);
    axis[a] = target[a];
  }
  const size_t count = random.below(4) ? 128 : 1 + random.below(600);
  const uint32_t across = 1 + static_cast<uint32_t>(std::sqrt(static_cast<float>(count) / 16));
  for (size_t i = 0; i < count; ++i) {
    const uint32_t run = static_cast<uint32_t>(i / 16) % (across * across);
    light.u.push_back((static_cast<float>(run % across) + random.uniform()) / static_cast<float>(across));
    light.v.push_back((static_cast<float>(run / across) + random.uniform()) / static_cast<float>(across));
  }
  light.quad.u = light.u, light.quad.v = light.v;
  std::copy_n(light.quad.origin, 3, light.sphere.origin);
  std::copy_n(axis, 3, light.sphere.centre);
  light.sphere.radius = light_size * 0.5f * (size(0) + size(1) + size(2)) / 3;
  for (size_t i = 0; i < count; ++i) {
    const float phi = 6.2831853f * light.u[i], z = 2 * light.v[i] - 1, r = std::sqrt(1 - z * z) * light.sphere.radius;
    light.x.push_back(light.sphere.centre[0] + r * std::cos(phi));
    light.y.push_back(light.sphere.centre[1] + r * std::sin(phi));
    light.z.push_back(light.sphere.centre[2] + z * light.sphere.radius);
  }
  light.sphere.x = light.x, light.sphere.y = light.y, light.sphere.z = light.z;
  return light;
}

struct Tally {
  uint64_t samples = 0, answered = 0, more = 0, fewer = 0, opposite = 0;
};

Visibility answer_of(const std::vector<uint64_t>& blocked, const std::vector<uint64_t>& open, size_t i) {
  if (open[i / 64] >> (i % 64) & 1) return Visibility::unclassified;
  return blocked[i / 64] >> (i % 64) & 1 ? Visibility::blocked : Visibility::clear;
}

template <class Bundle, class Judge>
void compare(const Object& object, const Bundle& bundle, Tally& tally, const Judge& judge) {
  const size_t words = (bundle.size() + 63) / 64;
  std::vector<uint64_t> blocked(words + 1, 5), open(words + 1, 5);
  object.classify(bundle, std::span(blocked).first(words), std::span(open).first(words));
  ASSERT_TRUE(blocked[words] == 5 && open[words] == 5);
  if (bundle.size() % 64) {
    ASSERT_EQ((blocked[words - 1] | open[words - 1]) >> (bundle.size() % 64), 0u);
  }
  for (size_t i = 0; i < bundle.size(); ++i) {
    const Visibility together = answer_of(blocked, open, i), alone = object.classify(segment_of(bundle, i));
    ++tally.samples;
    tally.answered += together != Visibility::unclassified;
    tally.more += alone == Visibility::unclassified && together != alone;
    tally.fewer += together == Visibility::unclassified && together != alone;
    tally.opposite += together != alone && together != Visibility::unclassified && alone != Visibility::unclassified;
    judge(segment_of(bundle, i), together);
  }
}

template <class Judge>
void compare_many(const BakedObject& baked, int bundles, const Judge& judge) {
  const auto bytes = sidecar_bytes({&baked});
  for (const std::string& kernel : kernels()) {
    OpenOptions options;
    options.kernel = kernel;
    const auto sidecar = Sidecar::open_buffer(bytes, options);
    const Object object = sidecar->object(0);
    FloatRandom random(11);
    Tally quads, spheres;
    for (int k = 0; k < bundles; ++k) {
      const Light light = any_light(object.record(), random);
      compare(object, light.quad, quads, judge);
      compare(object, light.sphere, spheres, judge);
    }
    for (const Tally& t : {quads, spheres}) {
      EXPECT_EQ(t.opposite, 0u) << kernel;
      EXPECT_EQ(t.fewer, 0u) << kernel;
      EXPECT_LE(t.more, t.samples / 100000) << kernel;  // where a line is within rounding of a cell's border
      EXPECT_GT(t.answered, t.samples / 2) << kernel;
      EXPECT_LT(t.answered, t.samples) << kernel;
    }
  }
}

BakeOptions proven(uint32_t depth) {
  BakeOptions options;
  options.method = Method::proven;
  options.depth = depth;
  return options;
}

TEST(Bundle, SaysWhatSingleCallsSay) {
  const auto nobody = [](const Segment&, Visibility) {};
  compare_many(must_bake(sphere(), quick(5, 81)), kSanitized ? 100 : 1500, nobody);
  compare_many(must_bake(leaves(30), quick(4)), kSanitized ? 100 : 1500, nobody);
}

TEST(Bundle, KeepsWhatIsProven) {
  for (SourceMesh mesh : {sphere(), leaves(60)}) {
    for (Position& p : mesh.positions) p[1] = 3 * p[1] + 40;  // not a cube, and not about the origin
    const auto prepared = prepare(SourceMesh(mesh));
    const Referee referee(*prepared);
    uint64_t judged = 0;
    compare_many(must_bake(mesh, proven(kSanitized ? 3 : 5)), kSanitized ? 20 : 300,
                 [&](const Segment& s, Visibility answer) {
                   if (answer == Visibility::unclassified) return;
                   ++judged;
                   ASSERT_EQ(referee.occluded(s), answer == Visibility::blocked);
                 });
    EXPECT_GT(judged, 1000u);
  }
}

TEST(Bundle, TakesAnyFloats) {
  const BakedObject baked = must_bake(sphere(), quick(4));
  const auto bytes = sidecar_bytes({&baked});
  constexpr float kOdd[] = {0.0f,
                            -0.0f,
                            1e-45f,
                            1e30f,
                            -3e38f,
                            std::numeric_limits<float>::infinity(),
                            std::numeric_limits<float>::quiet_NaN()};
  for (const std::string& kernel : kernels()) {
    OpenOptions options;
    options.kernel = kernel;
    const auto sidecar = Sidecar::open_buffer(bytes, options);
    FloatRandom random(3);
    Tally quads, spheres;
    uint64_t not_finite = 0;
    const auto judge = [&](const Segment& s, Visibility answer) {
      if (is_finite(s)) return;
      ++not_finite;
      EXPECT_EQ(answer, Visibility::unclassified) << kernel;
    };
    for (int k = 0; k < 3000; ++k) {
      Light light = any_light(baked.record, random);
      const auto harm = [&](float& x) {
        if (random.below(6) == 0) x = kOdd[random.below(std::size(kOdd))];
      };
      if (random.below(2))
        for (float* three : {light.quad.origin, light.quad.corner, light.quad.edge_u, light.quad.edge_v})
          for (int a = 0; a < 3; ++a) harm(three[a]);
      for (auto* column : {&light.u, &light.v})
        for (int times = 0; times < 4; ++times) harm((*column)[random.below(static_cast<uint32_t>(column->size()))]);
      compare(sidecar->object(0), light.quad, quads, judge);
      // What is finite and outside of the sphere may get any answer.
      for (auto* column : {&light.x, &light.y, &light.z})
        if (random.below(2)) (*column)[random.below(static_cast<uint32_t>(column->size()))] = kOdd[5 + random.below(2)];
      compare(sidecar->object(0), light.sphere, spheres, judge);
    }
    EXPECT_EQ(quads.opposite + quads.fewer + spheres.opposite + spheres.fewer, 0u) << kernel;
    EXPECT_GT(not_finite, 1000u);
  }
}

TEST(Bundle, OfSegmentsTooShortToBeLookedUpIsClearBesideTheBoxAndOpenInIt) {
  const BakedObject baked = must_bake(sphere(), quick(2));
  const auto bytes = sidecar_bytes({&baked});
  const std::vector<float> samples(20, 0.5f);
  for (const std::string& kernel : kernels()) {
    OpenOptions options;
    options.kernel = kernel;
    const auto sidecar = Sidecar::open_buffer(bytes, options);
    for (const float x : {0.0f, 3.0f}) {
      const QuadBundle bundle{{x, 0, 0}, {x, 0, 0}, {}, {}, samples, samples};
      std::vector<uint64_t> blocked(1), open(1);
      sidecar->object(0).classify(bundle, blocked, open);
      const bool together = x > 1 && kernel != "scalar";  // which looks up each by itself
      EXPECT_EQ(blocked[0], 0u) << kernel;
      EXPECT_EQ(open[0], together ? 0u : (1u << 20) - 1) << kernel;
    }
  }
}

TEST(Bundle, DoesNotAllocate) {
  const BakedObject baked = must_bake(sphere(), quick(4));
  const auto bytes = sidecar_bytes({&baked});
  const auto sidecar = Sidecar::open_buffer(bytes);
  FloatRandom random(1);
  const Light light = any_light(baked.record, random);
  uint64_t blocked[16], open[16];
  const uint64_t before = allocation_count();
  sidecar->object(0).classify(light.quad, blocked, open);
  sidecar->object(0).classify(light.sphere, blocked, open);
  EXPECT_EQ(allocation_count(), before);
}

TEST(Bundle, InC) {
  const BakedObject baked = must_bake(sphere(), quick(4));
  const auto bytes = sidecar_bytes({&baked});
  const auto sidecar = Sidecar::open_buffer(bytes);
  const vcd_sidecar* in_c = nullptr;
  ASSERT_EQ(vcd_open_buffer(bytes.data(), bytes.size(), nullptr, &in_c, nullptr), VCD_SUCCESS);
  FloatRandom random(1);
  for (int k = 0; k < 100; ++k) {
    const Light light = any_light(baked.record, random);
    const auto& [origin, corner, edge_u, edge_v, u, v] = light.quad;
    const vcd_quad_bundle quad = {sizeof quad,
                                  {origin[0], origin[1], origin[2]},
                                  {corner[0], corner[1], corner[2]},
                                  {edge_u[0], edge_u[1], edge_u[2]},
                                  {edge_v[0], edge_v[1], edge_v[2]},
                                  u.data(),
                                  v.data(),
                                  u.size()};
    const auto& centre = light.sphere.centre;
    const vcd_sphere_bundle ball = {sizeof ball,
                                    {origin[0], origin[1], origin[2]},
                                    {centre[0], centre[1], centre[2]},
                                    light.sphere.radius,
                                    light.x.data(),
                                    light.y.data(),
                                    light.z.data(),
                                    light.x.size()};
    uint64_t blocked[2][16] = {}, open[2][16] = {};
    sidecar->object(0).classify(light.quad, blocked[0], open[0]);
    vcd_classify_quad(vcd_object_at(in_c, 0), &quad, blocked[1], open[1]);
    EXPECT_TRUE(std::equal(blocked[0], blocked[0] + 16, blocked[1]) && std::equal(open[0], open[0] + 16, open[1]));
    sidecar->object(0).classify(light.sphere, blocked[0], open[0]);
    vcd_classify_sphere(vcd_object_at(in_c, 0), &ball, blocked[1], open[1]);
    EXPECT_TRUE(std::equal(blocked[0], blocked[0] + 16, blocked[1]) && std::equal(open[0], open[0] + 16, open[1]));
  }
  vcd_close(in_c);
}

// Each cell by itself.
Visibility slow_range_class(const TreeView& tree, const CellRange& r) {
  bool clear = true, blocked = true;
  const uint32_t up = 8 - tree.shape.levels;
  for (uint32_t s = r.low[0]; s <= r.high[0]; ++s)
    for (uint32_t t = r.low[1]; t <= r.high[1]; ++t)
      for (uint32_t u = r.low[2]; u <= r.high[2]; ++u)
        for (uint32_t v = r.low[3]; v <= r.high[3]; ++v) {
          LineCell line{};
          line.pair = r.pair, line.s = s << up, line.t = t << up, line.u = u << up, line.v = v << up;
          const Visibility found = tree.answers(Place::pierces, class_of(tree, line));
          clear &= found == Visibility::clear;
          blocked &= found == Visibility::blocked;
        }
  return clear ? Visibility::clear : blocked ? Visibility::blocked : Visibility::unclassified;
}

TEST(RangeClass, IsThatOfEveryCell) {
  FloatRandom random(5);
  std::array<uint64_t, 3> seen{};
  uint64_t given_up = 0;
  for (uint32_t depth = 1; depth <= 8; ++depth) {
    std::vector<Finding> findings;
    const auto file = read_file(std::filesystem::path(VCD_GOLDEN_DIR) / ("depth" + std::to_string(depth) + ".vcd"));
    const auto contents = read_sidecar(file, CheckLevel::canonical, findings);
    ASSERT_TRUE(contents.has_value());
    TreeView tree = contents->objects[0].tree;
    for (const Trust trust : {Trust::proofs, Trust::statistics}) {
      tree.answers = answer_table(trust);
      const uint32_t width = 1u << tree.shape.levels;
      for (int i = 0; i < 20000; ++i) {
        CellRange range{random.below(kFacePairs), {}, {}};
        for (int d = 0; d < 4; ++d) {
          range.low[d] = random.below(width);
          range.high[d] = std::min(width - 1, range.low[d] + (random.below(3) ? random.below(2) : random.below(6)));
        }
        const Visibility fast = range_class(tree, range), slow = slow_range_class(tree, range);
        ++seen[static_cast<size_t>(slow)];
        given_up += fast != slow;
        ASSERT_TRUE(fast == slow || fast == Visibility::unclassified) << depth;
      }
    }
  }
  for (uint64_t n : seen) EXPECT_GT(n, 500u);
  EXPECT_LT(given_up, seen[0] / 20);
}

}  // namespace
}  // namespace vcd::test
