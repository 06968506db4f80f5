// Scenes of instances against every instance by itself, in exact arithmetic.
#include <vcd/runtime/scene.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <set>

#include <gtest/gtest.h>

#include <vcd/baker/referee.h>
#include <vcd/runtime/vcd.h>

#include "support/count_allocations.h"
#include "support/files.h"
#include "support/meshes.h"
#include "support/random.h"
#include "support/segments.h"

namespace vcd::test {
using namespace baker;
namespace {

// Turned, stretched along its axes by up to four, mirrored now and then.
Transform any_transform(FloatRandom& random, float spread) {
  double q[4], length = 0;
  for (double& x : q) x = random.between(-1, 1), length += x * x;
  for (double& x : q) x /= std::sqrt(length);
  const double w = q[0], x = q[1], y = q[2], z = q[3];
  const double turn[3][3] = {{1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)},
                             {2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)},
                             {2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)}};
  Transform t;
  for (int j = 0; j < 3; ++j) {
    const float scale = std::exp2(random.between(-1, 1)) * (random.below(4) == 0 ? -1.0f : 1.0f);
    for (int i = 0; i < 3; ++i) t.rows[i][j] = static_cast<float>(turn[i][j]) * scale;
  }
  for (auto& row : t.rows) row[3] = random.between(-spread, spread);
  return t;
}

struct Forest {
  std::vector<BakedObject> baked;
  std::vector<std::vector<std::byte>> bytes;
  std::vector<Sidecar> sidecars;
  std::vector<SourceMesh> meshes;
  std::vector<SceneInstance> instances;
  std::vector<size_t> object_of;
  std::vector<Referee> referees;  // of each instance's mesh in the world, rounded to float

  Forest(size_t count, float spread, float offset, uint32_t depth) {
    FloatRandom random(count);
    for (SourceMesh mesh : {sphere(12, 20), leaves(60)}) {
      BakeOptions options;
      options.method = Method::proven, options.depth = depth;
      baked.push_back(must_bake(mesh, options));
      bytes.push_back(sidecar_bytes({&baked.back()}));
      meshes.push_back(std::move(mesh));
    }
    for (const auto& b : bytes) sidecars.push_back(std::move(*Sidecar::open_buffer(b)));
    for (size_t i = 0; i < count; ++i) {
      const size_t object = random.below(2);
      Transform t = any_transform(random, spread);
      for (auto& row : t.rows) row[3] += offset;
      instances.push_back(SceneInstance::of(sidecars[object].object(0), t));
      object_of.push_back(object);
      SourceMesh world = meshes[object];
      for (Position& p : world.positions) {
        const Position q = p;
        for (int a = 0; a < 3; ++a)
          p[a] = static_cast<float>(double{t.rows[a][0]} * q[0] + double{t.rows[a][1]} * q[1] +
                                    double{t.rows[a][2]} * q[2] + double{t.rows[a][3]});
      }
      referees.emplace_back(*prepare(std::move(world)));
    }
  }
  bool blocked(const Segment& s, uint32_t instance) const { return referees[instance].occluded(s); }
  // Segments between two places among the instances, some of them from far away.
  std::vector<Segment> segments(size_t count, float spread, float offset) const {
    FloatRandom random(99);
    std::vector<Segment> all;
    for (size_t i = 0; i < count; ++i) {
      Segment s{};
      const float far = random.below(8) == 0 ? 30.0f : 1.0f;
      const auto& towards = instances[random.below(static_cast<uint32_t>(instances.size()))].to_world;
      for (int a = 0; a < 3; ++a) {
        s.origin[a] = offset + far * random.between(-1.5f * spread, 1.5f * spread);
        const float target = random.below(2) ? towards.rows[a][3] + random.between(-1, 1)
                                             : offset + random.between(-1.5f * spread, 1.5f * spread);
        s.direction[a] = target - s.origin[a];
      }
      s.t_max = random.below(3) ? 1.0f : 2.5f;
      if (random.below(16) == 0) s.direction[random.below(3)] = 0;
      all.push_back(s);
    }
    return all;
  }
};

// Vertices in the world are rounded to float for the referee: a hair of a mesh that stands far from the origin. Where
// that could decide, the answers may differ.
constexpr float kSpread = 8;

TEST(Scene, AnswersForAllInstancesAndNamesWhatIsOpen) {
  const Forest forest(kSanitized ? 12 : 40, kSpread, 0, kSanitized ? 3 : 4);
  const auto segments = forest.segments(kSanitized ? 300 : 4000, kSpread, 0);
  std::vector<Visibility> first;
  std::vector<UnclassifiedPair> first_open;
  for (const std::string& kernel : kernels()) {
    const auto scene = Scene::build(forest.instances, kernel);
    ASSERT_TRUE(scene.ok()) << scene.error().message;
    EXPECT_EQ(scene->size(), forest.instances.size());
    std::vector<Visibility> answers(segments.size());
    std::vector<UnclassifiedPair> open(segments.size() * 8);
    const auto [count, complete] = scene->classify(segments, answers, open);
    EXPECT_TRUE(complete);
    open.resize(count);
    if (first.empty()) {
      first = answers, first_open = open;
      uint64_t seen[3] = {}, wrong = 0, missing = 0;
      size_t at = 0;
      for (uint32_t i = 0; i < segments.size(); ++i) {
        ++seen[static_cast<int>(answers[i])];
        std::vector<uint32_t> listed;
        float before = std::numeric_limits<float>::infinity();
        for (; at < open.size() && open[at].segment == i; ++at) {
          listed.push_back(open[at].instance);
          EXPECT_LE(open[at].length, before);
          before = open[at].length;
        }
        EXPECT_EQ(listed.empty(), answers[i] != Visibility::unclassified);
        bool blocked = false;
        for (uint32_t k = 0; k < forest.instances.size(); ++k) {
          if (!forest.blocked(segments[i], k)) continue;
          blocked = true;
          missing +=
              answers[i] == Visibility::unclassified && std::find(listed.begin(), listed.end(), k) == listed.end();
        }
        wrong += answers[i] == (blocked ? Visibility::clear : Visibility::blocked);
        const bool by_fallback =
            scene->occluded(segments[i], [&](uint32_t k) { return forest.blocked(segments[i], k); });
        wrong += by_fallback != blocked;
      }
      EXPECT_EQ(at, open.size());
      EXPECT_EQ(wrong, 0u);
      EXPECT_EQ(missing, 0u);
      for (uint64_t n : seen) EXPECT_GT(n, segments.size() / 50);
    }
    EXPECT_EQ(answers, first) << kernel;
    ASSERT_EQ(open.size(), first_open.size()) << kernel;
    for (size_t i = 0; i < open.size(); ++i)
      EXPECT_TRUE(open[i].segment == first_open[i].segment && open[i].instance == first_open[i].instance) << kernel;
    for (size_t i = 0; i < segments.size(); i += 7) EXPECT_EQ(scene->classify(segments[i]), answers[i]) << kernel;
  }
}

TEST(Scene, AnswersFarFromTheWorldsOriginToo) {
  const float offset = 2e4f;
  const Forest forest(10, kSpread, offset, 4);
  const auto scene = Scene::build(forest.instances);
  const auto segments = forest.segments(1000, kSpread, offset);
  uint64_t answered = 0, wrong = 0;
  for (const Segment& s : segments) {
    const Visibility answer = scene->classify(s);
    answered += answer != Visibility::unclassified;
    bool blocked = false;
    for (uint32_t k = 0; k < forest.instances.size(); ++k) blocked |= forest.blocked(s, k);
    wrong += answer == (blocked ? Visibility::clear : Visibility::blocked);
  }
  EXPECT_GT(answered, segments.size() / 3);
  EXPECT_LE(wrong, 2u);  // the referee's own meshes are rounded to a thousandth here
}

TEST(Scene, DoesNotPromiseBeyondItsReach) {
  const Forest forest(1, 0, 0, 3);
  const auto scene = Scene::build(forest.instances);
  Segment s{{0, 0, 0}, 0, {0, 0, 0}, 1};
  for (int a = 0; a < 3; ++a) {
    s.origin[a] = forest.instances[0].to_world.rows[a][3] + (a == 0 ? 1e6f : 0.0f);
    s.direction[a] = a == 0 ? -2e6f : 0.0f;
  }
  EXPECT_EQ(scene->classify(s), Visibility::unclassified);
}

TEST(Scene, HeedsMasksOriginsAndInstancesWithoutSidecars) {
  Forest forest(20, kSpread, 0, 3);
  for (size_t i = 0; i < forest.instances.size(); ++i) forest.instances[i].mask = 1u << (i % 3);
  for (size_t i = 0; i < 5; ++i) forest.instances[i].object.reset();
  const auto scene = Scene::build(forest.instances);
  const auto segments = forest.segments(600, kSpread, 0);
  uint64_t open_boxes = 0;
  for (const Segment& s : segments)
    for (uint32_t mask : {1u, 5u, 0u}) {
      SceneQuery query;
      query.mask = mask;
      bool blocked = false;
      for (uint32_t k = 0; k < forest.instances.size(); ++k)
        blocked |= (forest.instances[k].mask & mask) != 0 && forest.blocked(s, k);
      EXPECT_EQ(scene->occluded(
                    s,
                    [&](uint32_t k) {
                      EXPECT_NE(forest.instances[k].mask & mask, 0u);
                      open_boxes += k < 5;
                      return forest.blocked(s, k);
                    },
                    query),
                blocked);
    }
  EXPECT_GT(open_boxes, 0u);
  // The origin's instance is not looked up: always open where the segment could meet it.
  for (uint32_t k = 5; k < forest.instances.size(); ++k) {
    Segment s = segments[k];
    const SceneInstance& own = forest.instances[k];
    for (int a = 0; a < 3; ++a) {
      s.origin[a] = own.to_world.rows[a][3];
      for (int j = 0; j < 3; ++j) s.origin[a] += own.to_world.rows[a][j] * 0.5f * (own.box_min[j] + own.box_max[j]);
    }
    std::array<UnclassifiedPair, 64> open;
    Visibility answer;
    SceneQuery query;
    query.origins = std::span(&k, 1);
    const size_t count = scene->classify(std::span(&s, 1), std::span(&answer, 1), open, query).count;
    bool listed = answer == Visibility::blocked;
    for (size_t i = 0; i < count; ++i) listed |= open[i].instance == k;
    EXPECT_TRUE(listed);
  }
}

TEST(Scene, MovesItsInstances) {
  const Forest before(15, kSpread, 0, 3), after(15, kSpread, 0, 3);
  auto moved = Scene::build(before.instances);
  std::vector<Transform> transforms;
  FloatRandom random(4);
  auto instances = before.instances;
  for (SceneInstance& instance : instances) {
    instance.to_world = any_transform(random, kSpread);
    transforms.push_back(instance.to_world);
  }
  EXPECT_FALSE(moved->set_transforms(transforms).has_value());
  const auto fresh = Scene::build(instances);
  const auto segments = before.segments(2000, kSpread, 0);
  std::vector<Visibility> a(segments.size()), b(segments.size());
  moved->classify(segments, a);
  fresh->classify(segments, b);
  EXPECT_EQ(a, b);
  EXPECT_TRUE(moved->set_transforms(std::span(transforms).first(3)).has_value());
  moved->classify(segments, b);
  EXPECT_EQ(a, b);  // nothing has changed
}

TEST(Scene, RefusesKernelsThatThereAreNotAndMayBeEmpty) {
  const Forest forest(2, kSpread, 0, 3);
  const auto refused = Scene::build(forest.instances, "abacus");
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::usage);
  const auto empty = Scene::build({});
  ASSERT_TRUE(empty.ok());
  EXPECT_EQ(empty->classify(forest.segments(1, 1, 0)[0]), Visibility::clear);
}

TEST(Scene, TakesAnyFloatsAndManyOpenInstances) {
  // A hundred boxes without sidecars in one place: more than a single call can list.
  std::vector<SceneInstance> instances(100);
  for (SceneInstance& i : instances)
    i = {std::nullopt, {-1, -1, -1}, {1, 1, 1}, {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}}};
  const auto scene = Scene::build(instances);
  const Segment through{{-3, 0, 0}, 0, {6, 0.1f, 0.2f}, 1}, beside{{-3, 5, 0}, 0, {6, 0.1f, 0.2f}, 1};
  for (uint32_t wanted : {0u, 63u, 64u, 99u}) {
    EXPECT_TRUE(scene->occluded(through, [&](uint32_t k) { return k == wanted; }));
    EXPECT_FALSE(scene->occluded(beside, [&](uint32_t) { return true; }));
  }
  EXPECT_FALSE(scene->occluded(through, [&](uint32_t) { return false; }));
  for (int k = 0; k < 8; ++k)
    for (float odd :
         {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 3e38f, -1e-45f}) {
      float values[8];
      std::memcpy(values, &through, sizeof through);
      values[k] = odd;
      Segment s;
      std::memcpy(&s, values, sizeof s);
      const Visibility answer = scene->classify(s);
      if (std::isnan(odd)) {
        EXPECT_EQ(answer, Visibility::unclassified);
        EXPECT_TRUE(scene->occluded(s, [&](uint32_t i) { return i == 99; }));
      }
      EXPECT_NE(answer, Visibility::blocked);
    }
}

// What a query of many segments answers, with a caller that knows the truth, against the truth; and what it asked for.
struct Asked {
  uint64_t segments = 0, wrong = 0, calls = 0;
};

template <class Ask>
Asked ask(const Forest& forest, const Scene& scene, const std::vector<Segment>& segments, const Ask& occluded,
          const SceneQuery& query, std::vector<uint64_t>& blocked) {
  Asked asked;
  std::set<std::pair<uint32_t, uint32_t>> pairs;
  blocked.assign((segments.size() + 63) / 64, 7);
  occluded(blocked, [&](const UnclassifiedSegments& open) {
    ++asked.calls;
    for (size_t k = 0; k < open.segments.count; ++k) {
      const Segment& s = segments[open.indices[k]];
      EXPECT_EQ(open.blocked[k], 0);
      EXPECT_TRUE(pairs.insert({open.indices[k], open.instance}).second);  // nothing is asked twice
      EXPECT_NE(forest.instances[open.instance].mask & query.mask, 0u);
      const Segment inside = *scene.in_object(open.instance, s), given = segment_at(open.segments, k);
      EXPECT_EQ(std::memcmp(&inside, &given, sizeof inside), 0);
      open.blocked[k] = forest.blocked(s, open.instance);
      ++asked.segments;
    }
    // Whole packets can be read.
    const Segment last = segment_at(open.segments, open.segments.count - 1);
    for (size_t k = open.segments.count; k % 16 != 0; ++k) {
      const Segment copy = segment_at(open.segments, k);
      EXPECT_EQ(std::memcmp(&last, &copy, sizeof last), 0);
    }
  });
  for (size_t i = 0; i < segments.size(); ++i) {
    bool truth = false;
    for (uint32_t k = 0; k < forest.instances.size(); ++k)
      truth |= (forest.instances[k].mask & query.mask) != 0 && forest.blocked(segments[i], k);
    asked.wrong += truth != (blocked[i / 64] >> (i % 64) & 1);
  }
  if (segments.size() % 64) {
    EXPECT_EQ(blocked.back() >> (segments.size() % 64), 0u);
  }
  return asked;
}

// Neighbours that have much in common, as a renderer's packets have.
std::vector<Segment> in_sixteens(const std::vector<Segment>& from, FloatRandom& random) {
  std::vector<Segment> all;
  for (const Segment& s : from) {
    const float spread = random.below(2) ? 0.05f : 1.0f;
    for (int k = 0; k < 16; ++k) {
      Segment near = s;
      for (int a = 0; a < 3; ++a)
        near.origin[a] += random.between(-spread, spread), near.direction[a] += random.between(-0.2f, 0.2f);
      all.push_back(near);
    }
  }
  return all;
}

TEST(Scene, AnswersArraysWithTheCallersHelp) {
  Forest forest(kSanitized ? 12 : 40, kSpread, 0, kSanitized ? 3 : 4);
  for (size_t i = 0; i < forest.instances.size(); ++i) forest.instances[i].mask = i % 5 == 0 ? 2 : 1;
  forest.instances[1].object.reset();
  FloatRandom random(5);
  const auto scattered = forest.segments(kSanitized ? 150 : 2000, kSpread, 0);
  const auto coherent = in_sixteens(forest.segments(kSanitized ? 20 : 200, kSpread, 0), random);
  for (const auto* segments : {&scattered, &coherent}) {
    std::vector<uint32_t> origins;
    for (size_t i = 0; i < segments->size(); ++i)
      origins.push_back(random.below(3) ? kNoInstance : random.below(static_cast<uint32_t>(forest.instances.size())));
    for (const SceneQuery& query : {SceneQuery{}, SceneQuery{1, origins}, SceneQuery{0, {}}}) {
      std::vector<uint64_t> first;
      uint64_t first_asked = 0;
      for (const std::string& kernel : kernels()) {
        const auto scene = Scene::build(forest.instances, kernel);
        std::vector<uint64_t> blocked;
        const Asked asked = ask(
            forest, *scene, *segments,
            [&](std::span<uint64_t> b, auto&& trace) { scene->occluded(*segments, b, trace, query); }, query, blocked);
        EXPECT_EQ(asked.wrong, 0u) << kernel;
        EXPECT_LT(asked.segments, 3 * segments->size()) << kernel;
        if (first.empty()) first = blocked, first_asked = asked.segments;
        EXPECT_EQ(blocked, first) << kernel;
        EXPECT_EQ(asked.segments, first_asked) << kernel;
        // Packets are short arrays.
        for (size_t width : {1u, 8u, 16u})
          for (size_t at = 0; at + width <= segments->size() && at < 320; at += width) {
            const std::vector<Segment> packet(segments->begin() + static_cast<std::ptrdiff_t>(at),
                                              segments->begin() + static_cast<std::ptrdiff_t>(at + width));
            const SceneQuery own{query.mask, query.origins.empty() ? query.origins : query.origins.subspan(at, width)};
            std::vector<uint64_t> bits;
            EXPECT_EQ(
                ask(
                    forest, *scene, packet,
                    [&](std::span<uint64_t> b, auto&& trace) { scene->occluded(packet, b, trace, own); }, own, bits)
                    .wrong,
                0u);
          }
      }
    }
  }
}

// A light somewhere, and its samples.
struct SceneLight {
  std::vector<float> u, v, x, y, z;
  QuadBundle quad{};
  SphereBundle sphere{};

  SceneLight(FloatRandom& random, size_t count, float spread) {
    const float size = std::exp2(random.between(-6, 2));
    const uint32_t across = 1 + static_cast<uint32_t>(std::sqrt(static_cast<float>(count) / 16));
    for (int a = 0; a < 3; ++a) {
      sphere.origin[a] = quad.origin[a] = random.between(-1.5f * spread, 1.5f * spread);
      sphere.centre[a] = random.between(-1.5f * spread, 1.5f * spread);
      quad.edge_u[a] = random.between(-size, size), quad.edge_v[a] = random.between(-size, size);
      quad.corner[a] = sphere.centre[a] - 0.5f * (quad.edge_u[a] + quad.edge_v[a]);
    }
    sphere.radius = random.below(8) ? size : 2 * spread;
    for (size_t i = 0; i < count; ++i) {
      const uint32_t run = static_cast<uint32_t>(i / 16) % (across * across);
      u.push_back((static_cast<float>(run % across) + random.uniform()) / static_cast<float>(across));
      v.push_back((static_cast<float>(run / across) + random.uniform()) / static_cast<float>(across));
      const float phi = 6.2831853f * u[i], height = 2 * v[i] - 1, r = std::sqrt(1 - height * height) * sphere.radius;
      x.push_back(sphere.centre[0] + r * std::cos(phi));
      y.push_back(sphere.centre[1] + r * std::sin(phi));
      z.push_back(sphere.centre[2] + height * sphere.radius);
    }
    quad.u = u, quad.v = v, sphere.x = x, sphere.y = y, sphere.z = z;
  }
};

TEST(Scene, AnswersBundlesWithTheCallersHelp) {
  Forest forest(kSanitized ? 12 : 40, kSpread, 0, kSanitized ? 3 : 4);
  forest.instances[2].object.reset();
  for (const std::string& kernel : kernels()) {
    const auto scene = Scene::build(forest.instances, kernel);
    FloatRandom random(17);
    uint64_t segments_asked = 0, all = 0, looked_up = 0;
    const auto one = [&](const auto& bundle) {
      std::vector<Segment> segments;
      for (size_t i = 0; i < bundle.size(); ++i) segments.push_back(segment_of(bundle, i));
      const uint32_t own = random.below(3) ? kNoInstance : random.below(static_cast<uint32_t>(forest.instances.size()));
      const SceneQuery query{0xFFFFFFFF, std::span(&own, 1)};
      std::vector<uint64_t> blocked, known((segments.size() + 63) / 64), open(known);
      const Asked asked = ask(
          forest, *scene, segments,
          [&](std::span<uint64_t> b, auto&& trace) { scene->occluded(bundle, b, trace, query); }, query, blocked);
      EXPECT_EQ(asked.wrong, 0u) << kernel;
      segments_asked += asked.segments, all += segments.size();
      scene->classify(bundle, known, open, query);
      for (size_t w = 0; w < known.size(); ++w) {
        EXPECT_EQ(known[w] & open[w], 0u);
        EXPECT_EQ((known[w] ^ blocked[w]) & ~open[w], 0u);
        looked_up += segments.size() ? static_cast<uint64_t>(std::popcount(~open[w])) : 0;
      }
    };
    for (int k = 0; k < (kSanitized ? 20 : 200); ++k) {
      const SceneLight light(random, random.below(4) ? 128 : 1 + random.below(600), kSpread);
      one(light.quad);
      one(light.sphere);
    }
    EXPECT_LT(segments_asked, 2 * all);
    EXPECT_GT(looked_up, all / 3);
  }
}

// One sample that is none, or is far out, harms none of the others.
TEST(Scene, TakesBundlesOfAnyFloats) {
  const Forest forest(12, kSpread, 0, 3);
  constexpr float kOdd[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 1e38f,
                            -3e38f};
  for (const std::string& kernel : kernels()) {
    const auto scene = Scene::build(forest.instances, kernel);
    FloatRandom random(23);
    uint64_t answered = 0, not_finite = 0;
    for (int k = 0; k < (kSanitized ? 20 : 300); ++k) {
      SceneLight light(random, 128, kSpread);
      light.u[random.below(128)] = kOdd[random.below(4)], light.v[random.below(128)] = kOdd[random.below(4)];
      if (random.below(8) == 0) light.quad.origin[random.below(3)] = kOdd[random.below(2)];
      std::vector<uint64_t> blocked(2), open(2);
      scene->classify(light.quad, blocked, open);
      for (size_t i = 0; i < 128; ++i) {
        const Segment segment = segment_of(light.quad, i);
        const Visibility alone = scene->classify(segment);
        const bool is_open = open[i / 64] >> i % 64 & 1, is_blocked = blocked[i / 64] >> i % 64 & 1;
        if (!is_finite(segment)) {
          ++not_finite;
          EXPECT_TRUE(is_open) << kernel;
        } else if (!is_open && alone != Visibility::unclassified) {
          ++answered;
          EXPECT_EQ(is_blocked, alone == Visibility::blocked) << kernel;
        }
      }
    }
    EXPECT_GT(not_finite, kSanitized ? 20u : 300u);
    EXPECT_GT(answered, kSanitized ? 100u : 3000u);
  }
}

// Blocks every third segment, and counts.
void trace_in_c(void* context, const vcd_unclassified_segments* open) {
  for (size_t k = 0; k < open->segments.count; ++k) open->blocked[k] = open->indices[k] % 3 == 0;
  *static_cast<uint64_t*>(context) += open->segments.count;
}

TEST(Scene, InC) {
  const Forest forest(12, kSpread, 0, 3);
  const auto scene = Scene::build(forest.instances);
  std::vector<const vcd_sidecar*> files(2);
  for (size_t i = 0; i < 2; ++i)
    ASSERT_EQ(vcd_open_buffer(forest.bytes[i].data(), forest.bytes[i].size(), nullptr, &files[i], nullptr),
              VCD_SUCCESS);
  std::vector<vcd_instance> instances;
  std::vector<float> transforms;
  for (size_t i = 0; i < forest.instances.size(); ++i) {
    vcd_instance instance{};
    instance.object = vcd_object_at(files[forest.object_of[i]], 0);
    std::memcpy(instance.to_world, &forest.instances[i].to_world, sizeof instance.to_world);
    transforms.insert(transforms.end(), instance.to_world, instance.to_world + 12);
    instances.push_back(instance);
  }
  vcd_scene* in_c = nullptr;
  ASSERT_EQ(vcd_scene_build(instances.data(), instances.size(), nullptr, &in_c, nullptr), VCD_SUCCESS);
  EXPECT_EQ(vcd_scene_set_transforms(in_c, transforms.data(), nullptr), VCD_SUCCESS);

  FloatRandom random(8);
  uint64_t asked[2] = {}, blocked[2][16] = {};
  const auto trace = [&](const UnclassifiedSegments& open) {
    for (size_t k = 0; k < open.segments.count; ++k) open.blocked[k] = open.indices[k] % 3 == 0;
    asked[0] += open.segments.count;
  };
  const auto same = [&] { return std::equal(blocked[0], blocked[0] + 16, blocked[1]) && asked[0] == asked[1]; };
  const auto segments = forest.segments(1000, kSpread, 0);
  const auto* array = reinterpret_cast<const vcd_segment*>(segments.data());
  std::vector<uint32_t> origins(segments.size(), kNoInstance);
  for (size_t i = 0; i < origins.size(); i += 5) origins[i] = static_cast<uint32_t>(i % 12);
  const vcd_scene_query query = {sizeof query, 3, origins.data(), nullptr};
  scene->occluded(segments, blocked[0], trace, {3, origins});
  vcd_scene_occluded(in_c, array, segments.size(), &query, trace_in_c, &asked[1], blocked[1]);
  EXPECT_TRUE(same());
  for (size_t i = 0; i < segments.size(); ++i)
    EXPECT_EQ(static_cast<uint8_t>(vcd_scene_classify(in_c, &array[i], 3, origins[i])),
              static_cast<uint8_t>(scene->classify(segments[i], {3, std::span(origins).subspan(i, 1)})));
  for (int k = 0; k < 50; ++k) {
    const SceneLight light(random, 300, kSpread);
    const auto& [origin, corner, edge_u, edge_v, u, v] = light.quad;
    const vcd_quad_bundle quad = {0,
                                  {origin[0], origin[1], origin[2]},
                                  {corner[0], corner[1], corner[2]},
                                  {edge_u[0], edge_u[1], edge_u[2]},
                                  {edge_v[0], edge_v[1], edge_v[2]},
                                  u.data(),
                                  v.data(),
                                  u.size()};
    const auto& centre = light.sphere.centre;
    const vcd_sphere_bundle ball = {0,
                                    {origin[0], origin[1], origin[2]},
                                    {centre[0], centre[1], centre[2]},
                                    light.sphere.radius,
                                    light.x.data(),
                                    light.y.data(),
                                    light.z.data(),
                                    light.x.size()};
    scene->occluded(light.quad, blocked[0], trace);
    vcd_scene_occluded_quad(in_c, &quad, nullptr, trace_in_c, &asked[1], blocked[1]);
    EXPECT_TRUE(same());
    scene->occluded(light.sphere, blocked[0], trace);
    vcd_scene_occluded_sphere(in_c, &ball, nullptr, trace_in_c, &asked[1], blocked[1]);
    EXPECT_TRUE(same());
  }
  EXPECT_GT(asked[0], 1000u);
  vcd_scene_free(in_c);

  vcd_error error = {sizeof error, ""};
  EXPECT_EQ(vcd_scene_build(instances.data(), 2, "abacus", &in_c, &error), VCD_ERROR_USAGE);
  EXPECT_NE(std::string(error.message).find("abacus"), std::string::npos);
  EXPECT_EQ(in_c, nullptr);
  for (const vcd_sidecar* file : files) vcd_close(file);
}

TEST(Scene, HandsOverMoreInstancesThanItCanList) {
  std::vector<SceneInstance> instances(200);
  for (SceneInstance& i : instances)
    i = {std::nullopt, {-1, -1, -1}, {1, 1, 1}, {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}}};
  const auto scene = Scene::build(instances);
  FloatRandom random(7);
  std::vector<Segment> coherent, scattered;
  for (int i = 0; i < 300; ++i) {
    coherent.push_back({{-3, random.between(-0.2f, 0.2f), 0}, 0, {6, 0.1f, 0.2f}, 1});
    scattered.push_back({{random.between(-3, 3), random.between(-3, 3), -3}, 0, {0.1f, 0.2f, 6}, 1});
  }
  for (const auto* segments : {&coherent, &scattered})
    for (uint32_t wanted : {0u, 63u, 64u, 65u, 199u}) {
      std::vector<uint64_t> blocked(5);
      uint64_t meeting = 0;
      scene->occluded(*segments, blocked, [&](const UnclassifiedSegments& open) {
        for (size_t k = 0; k < open.segments.count; ++k) open.blocked[k] = open.instance == wanted;
        meeting += open.instance == wanted ? open.segments.count : 0;
      });
      uint64_t found = 0;
      for (uint64_t word : blocked) found += static_cast<uint64_t>(std::popcount(word));
      EXPECT_EQ(found, meeting);
      EXPECT_GT(found, 20u);
    }
}

TEST(Scene, DoesNotAllocate) {
  const Forest forest(20, kSpread, 0, 3);
  const auto scene = Scene::build(forest.instances);
  const auto segments = forest.segments(500, kSpread, 0);
  std::vector<Visibility> answers(segments.size());
  std::vector<UnclassifiedPair> open(5000);
  FloatRandom random(3);
  const SceneLight light(random, 300, kSpread);
  std::vector<uint64_t> blocked((segments.size() + 63) / 64), left(blocked);
  const uint64_t before = allocation_count();
  scene->classify(segments, answers, open);
  for (const Segment& s : segments) (void)scene->occluded(s, [](uint32_t) { return false; });
  scene->occluded(segments, blocked, [](const UnclassifiedSegments&) {});
  scene->occluded(light.quad, blocked, [](const UnclassifiedSegments&) {});
  scene->classify(light.sphere, blocked, left);
  EXPECT_EQ(allocation_count(), before);
}

}  // namespace
}  // namespace vcd::test
