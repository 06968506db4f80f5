// Hierarchies against exact arithmetic: every kernel, one by one, in arrays and from one point.
#include <vcd/baker/hierarchy.h>

#include <bit>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include <vcd/baker/audit.h>
#include <vcd/baker/referee.h>
#include <vcd/runtime/scene.h>
#include <vcd/runtime/sidecar.h>

#include "hierarchy/fan.h"
#include "lookup/kernels.h"
#include "support/count_allocations.h"
#include "support/files.h"
#include "support/hostile_meshes.h"
#include "support/meshes.h"
#include "support/random.h"

namespace vcd::test {
using namespace baker;
namespace {

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr int kShare = kSanitized ? 6 : 1;  // of each test's segments

// A mesh with its hierarchy and its judge.
struct Subject {
  PreparedMesh mesh;
  HierarchySection section;
  Traced traced;
  Referee referee;

  explicit Subject(SourceMesh source)
      : mesh(*prepare(std::move(source))),
        section(*build_hierarchy(mesh)),
        traced(vcd::traced(view_of(section))),
        referee(mesh) {}

  float extent() const {
    float longest = 0;
    for (size_t a = 0; a < 3; ++a) longest = std::max(longest, mesh.box_max[a] - mesh.box_min[a]);
    return longest;
  }
  Position between(FloatRandom& random, float grow) const {
    Position p;
    for (size_t a = 0; a < 3; ++a) {
      const float room = grow * (mesh.box_max[a] - mesh.box_min[a]);
      p[a] = random.between(mesh.box_min[a] - room, mesh.box_max[a] + room);
    }
    return p;
  }
  Position on_surface(FloatRandom& random) const {
    const TriangleIndices& t = mesh.triangles[random.below(static_cast<uint32_t>(mesh.triangles.size()))];
    const float u = random.uniform(), v = random.uniform() * (1 - u);
    Position p;
    for (size_t a = 0; a < 3; ++a) {
      const float corner = mesh.positions[t[0]][a];
      p[a] = corner + u * (mesh.positions[t[1]][a] - corner) + v * (mesh.positions[t[2]][a] - corner);
    }
    return p;
  }
};

SourceMesh moved(SourceMesh mesh, float scale, Position shift) {
  for (Position& p : mesh.positions)
    for (size_t a = 0; a < 3; ++a) p[a] = p[a] * scale + shift[a];
  return mesh;
}

// Long and thin, and many at one vertex.
SourceMesh needles() {
  SourceMesh mesh{"needles", 0, {{0, 0, 0}}, {}};
  FloatRandom random(4);
  for (uint32_t i = 0; i < 200; ++i) {
    const Position p = {random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)};
    mesh.positions.push_back(p);
    mesh.positions.push_back({p[0] + 1e-6f, p[1], p[2] - 1e-6f});
    mesh.triangles.push_back({0, 2 * i + 1, 2 * i + 2});
  }
  return mesh;
}

std::vector<SourceMesh> subjects() {
  return {triangle(),
          cube(),
          sphere(),
          leaves(300),
          folded(),
          needles(),
          moved(sphere(), 0x1p-24f, {}),
          moved(leaves(100), 0x1p30f, {}),
          moved(sphere(), 1, {4000, -3000, 7000}),
          moved(leaves(100), 1, {4096, 0, 0})};
}

std::string describe(const SourceMesh& mesh) {
  return mesh.name + " at " + std::to_string(mesh.positions[0][0]) + " of " + std::to_string(mesh.triangles.size());
}

// With the bits of its numbers.
std::string text_of(const Segment& s) {
  std::ostringstream text;
  for (float x :
       {s.origin[0], s.origin[1], s.origin[2], s.t_min, s.direction[0], s.direction[1], s.direction[2], s.t_max})
    text << ' ' << x << " (" << std::bit_cast<uint32_t>(x) << ')';
  return text.str();
}

void expect_exact(const Subject& subject, std::span<const Segment> segments) {
  for (size_t first = 0; first < segments.size(); first += kChunk) {
    const auto part = segments.subspan(first, std::min(kChunk, segments.size() - first));
    SampleBits expected{};
    for (size_t i = 0; i < part.size(); ++i) expected.set(i, subject.referee.occluded(part[i]));
    for (const Kernels* kernels : usable_kernels()) {
      const SampleBits all = SampleBits::first(part.size());
      const SampleBits found = kernels->trace.array(subject.traced, part.data(), all);
      for (size_t i = 0; i < part.size(); ++i) {
        const Segment& s = part[i];
        ASSERT_EQ(kernels->trace.one(subject.traced, s), (expected & SampleBits::just(i)).any())
            << kernels->name << text_of(s);
        ASSERT_EQ((found & SampleBits::just(i)).any(), (expected & SampleBits::just(i)).any())
            << kernels->name << text_of(s);
      }
    }
  }
}

TEST(Hierarchy, IsExactOnLinesThatAreAimedAndOnOthers) {
  for (SourceMesh& source : subjects()) {
    SCOPED_TRACE(describe(source));
    const Subject subject(std::move(source));
    for (size_t kind = 0; kind < kAuditKinds; ++kind) {
      std::vector<Segment> segments = audit_segments(subject.mesh, static_cast<AuditKind>(kind), 7, 1500 / kShare);
      for (size_t i = 0; i < segments.size(); i += 5) segments[i].t_min = -kInfinity, segments[i].t_max = kInfinity;
      expect_exact(subject, segments);
    }
  }
}

// Ends on the surface to the last bit, before it and behind it; and origins on vertices.
TEST(Hierarchy, IsExactAtTheEndsOfSegments) {
  FloatRandom random(5);
  for (SourceMesh& source : subjects()) {
    SCOPED_TRACE(describe(source));
    const Subject subject(std::move(source));
    std::vector<Segment> segments;
    for (int i = 0; i < 2000 / kShare; ++i) {
      const Position from = i % 3 ? subject.between(random, 0.5f) : subject.on_surface(random),
                     to = i % 4 ? subject.on_surface(random)
                                : subject.mesh
                                      .positions[random.below(static_cast<uint32_t>(subject.mesh.positions.size()))];
      Segment s{{from[0], from[1], from[2]}, 0, {to[0] - from[0], to[1] - from[1], to[2] - from[2]}, 1};
      const float ends[] = {1, std::nextafter(1.0f, 0.0f), std::nextafter(1.0f, 2.0f), 0.5f, 2, kInfinity};
      s.t_max = ends[random.below(6)];
      if (i % 7 == 0) s.t_min = std::min(s.t_max, ends[random.below(3)]);
      segments.push_back(s);
    }
    expect_exact(subject, segments);
  }
}

TEST(Hierarchy, IsExactFromFarAway) {
  FloatRandom random(6);
  for (SourceMesh& source : subjects()) {
    SCOPED_TRACE(describe(source));
    const Subject subject(std::move(source));
    std::vector<Segment> segments;
    for (int i = 0; i < 1000 / kShare; ++i) {
      const Position to = subject.on_surface(random);
      const float distance = subject.extent() * std::exp2(random.between(0, 60));
      Segment s{{}, 0, {}, 2};
      for (size_t a = 0; a < 3; ++a) {
        s.origin[a] = to[a] + distance * random.between(-1, 1);
        s.direction[a] = to[a] - s.origin[a];
      }
      const float scale = std::exp2(random.between(-60, 30));
      for (float& x : s.direction) x *= scale;
      s.t_max /= scale;
      segments.push_back(s);
    }
    expect_exact(subject, segments);
  }
}

// Whatever the bits say.
TEST(Hierarchy, AnswersAnySegmentLikeTheReferee) {
  const Subject subject(leaves(100));
  FloatRandom random(8);
  const auto any = [&] {
    constexpr float kOdd[] = {0,     -0.0f, 1,         -1,         0x1p-149f, -0x1p-130f, 1e-38f,
                              1e38f, kNaN,  kInfinity, -kInfinity, 0x1p-60f,  0x1p60f,    0.5f};
    return random.below(3) ? random.between(-2, 2) : kOdd[random.below(std::size(kOdd))];
  };
  std::vector<Segment> segments;
  for (int i = 0; i < 20000 / kShare; ++i)
    segments.push_back({{any(), any(), any()}, any(), {any(), any(), any()}, any()});
  expect_exact(subject, segments);
}

// A fan's segments with room for whole runs.
struct Directions {
  Position origin;
  alignas(64) float d[3][kChunk] = {};
  size_t count = 0;

  void add(const Position& direction) {
    for (size_t a = 0; a < 3; ++a) d[a][count] = direction[a];
    ++count;
  }
  Fan fan(const SampleBits& live) const { return {{origin[0], origin[1], origin[2]}, {d[0], d[1], d[2]}, count, live}; }
};

void expect_exact_fan(const Subject& subject, const Directions& directions, FloatRandom& random) {
  SampleBits live{}, expected{};
  const bool some = random.below(2) == 0;
  for (size_t i = 0; i < directions.count; ++i) {
    if (some && random.below(3) == 0) continue;
    live.set(i);
    expected.set(i, subject.referee.occluded(segment_of(directions.fan(live), i)));
  }
  for (const Kernels* kernels : usable_kernels()) {
    const SampleBits found = kernels->trace.fan(subject.traced, directions.fan(live));
    for (size_t i = 0; i < directions.count; ++i)
      ASSERT_EQ((found & SampleBits::just(i)).any(), (expected & SampleBits::just(i)).any())
          << kernels->name << ", sample " << i << " of " << directions.count << ": " << directions.origin[0] << ' '
          << directions.origin[1] << ' ' << directions.origin[2] << " to " << directions.d[0][i] << ' '
          << directions.d[1][i] << ' ' << directions.d[2][i];
  }
}

TEST(Hierarchy, IsExactFromOnePoint) {
  FloatRandom random(9);
  constexpr size_t kCounts[] = {1, 2, 15, 16, 17, 100, 128, 255, 256};
  for (SourceMesh& source : subjects()) {
    SCOPED_TRACE(describe(source));
    const Subject subject(std::move(source));
    for (int i = 0; i < 120 / kShare; ++i) {
      Directions directions;
      directions.origin = i % 4 == 0   ? subject.between(random, 2)
                          : i % 4 == 1 ? subject.between(random, 0)
                          : i % 4 == 2 ? subject.on_surface(random)
                                       : subject.between(random, 40);
      const Position corner = subject.between(random, 3);
      Position u, v;
      for (size_t a = 0; a < 3; ++a)
        u[a] = subject.extent() * random.between(-1, 1), v[a] = subject.extent() * random.between(-1, 1);
      const size_t count = kCounts[random.below(std::size(kCounts))];
      const uint32_t kind = random.below(5);
      for (size_t k = 0; k < count; ++k) {
        Position to = corner;
        const float x = random.uniform(), y = random.uniform();
        if (kind == 0)  // a quad
          for (size_t a = 0; a < 3; ++a) to[a] += x * u[a] + y * v[a];
        if (kind == 1) to = subject.mesh.positions[random.below(static_cast<uint32_t>(subject.mesh.positions.size()))];
        if (kind == 2) to = subject.between(random, 1);  // all around
        if (kind == 3)                                   // a line, and a point
          for (size_t a = 0; a < 3; ++a) to[a] += k % 2 ? x * u[a] : 0;
        const float beyond = kind == 1 ? random.between(0.9f, 1.5f) : 1;
        directions.add({(to[0] - directions.origin[0]) * beyond, (to[1] - directions.origin[1]) * beyond,
                        (to[2] - directions.origin[2]) * beyond});
      }
      if (kind == 4)
        for (size_t k = 0; k < count; k += 3) directions.d[random.below(3)][k] = k % 2 ? 0 : kNaN;
      if (i % 11 == 0) directions.d[0][0] = directions.d[1][0] = directions.d[2][0] = 0;
      expect_exact_fan(subject, directions, random);
    }
  }
}

// ---- Through the interface

struct Baked {
  Subject subject;
  BakedObject object;
  std::vector<std::byte> bytes;

  explicit Baked(const SourceMesh& source)
      : subject(SourceMesh(source)), object(must_bake(source, proven(3))), bytes(sidecar_bytes({&object})) {}
  Sidecar open(LookUpFirst look_up, const std::string& kernel = {}) const {
    OpenOptions options;
    options.look_up = look_up, options.kernel = kernel;
    return std::move(*Sidecar::open_buffer(bytes, options));
  }
};

TEST(Occluded, IsExactWhetherItLooksUpOrNot) {
  for (const SourceMesh& source : {sphere(), leaves(60), cube()}) {
    const Baked baked(source);
    FloatRandom random(10);
    for (const LookUpFirst look_up : {LookUpFirst::as_baked, LookUpFirst::always, LookUpFirst::never})
      for (const std::string& kernel : kernels()) {
        const Sidecar sidecar = baked.open(look_up, kernel);
        const Object object = sidecar.object(0);
        ASSERT_TRUE(object.has_hierarchy());
        for (size_t kind = 0; kind < kAuditKinds; ++kind) {
          const auto segments = audit_segments(baked.subject.mesh, static_cast<AuditKind>(kind), 3, 700 / kShare);
          for (const From from : {From::outside, From::inside, From::self}) {
            std::vector<uint64_t> blocked((segments.size() + 63) / 64);
            object.occluded(segments, blocked, from);
            for (size_t i = 0; i < segments.size(); ++i) {
              const bool expected = baked.subject.referee.occluded(segments[i]);
              ASSERT_EQ(object.occluded(segments[i], from), expected);
              ASSERT_EQ((blocked[i / 64] >> i % 64 & 1) != 0, expected);
            }
          }
        }
      }
  }
}

template <class Bundle>
void expect_exact_bundle(const Subject& subject, const Object& object, const Bundle& bundle, From from) {
  std::vector<uint64_t> blocked((bundle.size() + 63) / 64, ~uint64_t{0});
  object.occluded(bundle, blocked, from);
  for (size_t i = 0; i < bundle.size(); ++i)
    ASSERT_EQ((blocked[i / 64] >> i % 64 & 1) != 0, subject.referee.occluded(segment_of(bundle, i))) << i;
  if (bundle.size() % 64 != 0) {
    EXPECT_EQ(blocked.back() >> bundle.size() % 64, 0u);
  }
}

TEST(Occluded, IsExactForEveryKindOfBundle) {
  for (const SourceMesh& source : {sphere(), leaves(60)}) {
    const Baked baked(source);
    for (const LookUpFirst look_up : {LookUpFirst::always, LookUpFirst::never}) {
      const Sidecar sidecar = baked.open(look_up);
      FloatRandom random(11);
      for (int i = 0; i < 60 / kShare; ++i) {
        const size_t count = i % 3 == 0 ? 700 : 1 + random.below(200);
        const Position from = i % 2 ? baked.subject.between(random, 1) : baked.subject.on_surface(random),
                       light = baked.subject.between(random, 3);
        std::vector<float> x(count), y(count), z(count);
        for (size_t k = 0; k < count; ++k) x[k] = random.uniform(), y[k] = random.uniform();
        const From kind = i % 2 ? From::outside : From::self;
        const float size = baked.subject.extent();
        expect_exact_bundle(baked.subject, sidecar.object(0),
                            QuadBundle{{from[0], from[1], from[2]},
                                       {light[0], light[1], light[2]},
                                       {size, 0, 0},
                                       {0, 0.5f * size, random.between(-size, size)},
                                       x,
                                       y},
                            kind);
        for (size_t k = 0; k < count; ++k) {
          const float radius = 0.5f * size;
          x[k] = light[0] + random.between(-radius, radius), y[k] = light[1] + random.between(-radius, radius),
          z[k] = light[2] + random.between(-radius, radius);
        }
        expect_exact_bundle(baked.subject, sidecar.object(0),
                            SphereBundle{{from[0], from[1], from[2]}, {light[0], light[1], light[2]}, size, x, y, z},
                            kind);
        for (size_t k = 0; k < count; ++k)
          x[k] = random.between(-9, 9), y[k] = random.between(-9, 9), z[k] = random.between(-9, 9);
        expect_exact_bundle(baked.subject, sidecar.object(0), PointBundle{{from[0], from[1], from[2]}, x, y, z}, kind);
      }
    }
  }
}

TEST(Occluded, NeverAllocates) {
  const Baked baked(leaves(60));
  const Sidecar sidecar = baked.open(LookUpFirst::always);
  const Object object = sidecar.object(0);
  const auto segments = audit_segments(baked.subject.mesh, AuditKind::inside, 3, 1000);
  std::vector<uint64_t> blocked(16);
  const std::vector<float> u(300, 0.25f), v(300, 0.75f);
  const uint64_t before = allocation_count();
  object.occluded(segments, blocked);
  object.occluded(QuadBundle{{9, 9, 9}, {-1, -1, -1}, {1, 0, 0}, {0, 1, 0}, u, v}, blocked);
  object.occluded(PointBundle{{9, 9, 9}, u, v, v}, blocked);
  for (const Segment& s : segments) blocked[0] += object.occluded(s);
  EXPECT_EQ(allocation_count(), before);
}

TEST(OccludedDeathTest, OfAnObjectWithoutAHierarchyEndsTheProgram) {
  BakeOptions options = proven(2);
  options.hierarchy = false;
  const BakedObject baked = must_bake(cube(), options);
  const auto bytes = sidecar_bytes({&baked});
  const auto sidecar = Sidecar::open_buffer(bytes);
  ASSERT_TRUE(sidecar.ok());
  EXPECT_FALSE(sidecar->object(0).has_hierarchy());
  EXPECT_DEATH((void)sidecar->object(0).occluded(Segment{{5, 5, 5}, 0, {-9, -9, -9}, 1}), "without a hierarchy");
}

// ---- Scenes

// Each segment in each object's frame, as the scene says, judged there.
struct JudgedScene {
  std::vector<Baked> baked;
  std::vector<Sidecar> sidecars;
  std::vector<SceneInstance> instances;
  std::vector<size_t> object_of;

  explicit JudgedScene(LookUpFirst look_up) {
    for (const SourceMesh& source : {sphere(), leaves(60)}) baked.emplace_back(source);
    for (const Baked& b : baked) sidecars.push_back(b.open(look_up));
    FloatRandom random(12);
    for (size_t i = 0; i < 60; ++i) {
      Transform t{};
      for (auto& row : t.rows) {
        for (int a = 0; a < 3; ++a) row[a] = random.between(-1, 1);
        row[3] = random.between(-8, 8);
      }
      if (i == 7)
        for (auto& row : t.rows) row[2] = 0;  // flat
      object_of.push_back(random.below(2));
      instances.push_back(SceneInstance::of(sidecars[object_of[i]].object(0), t));
      if (i == 9) instances[i].mask = 2;
    }
  }
  bool blocked(const Scene& scene, uint32_t instance, const Segment& segment) const {
    const Subject& subject = baked[object_of[instance]].subject;
    if (const auto moved = scene.in_object(instance, segment)) return subject.referee.occluded(*moved);
    for (const TriangleIndices& t : subject.mesh.triangles) {
      Triangle triangle;
      for (size_t k = 0; k < 3; ++k)
        for (size_t a = 0; a < 3; ++a) {
          const float(&row)[4] = instances[instance].to_world.rows[a];
          const Position& p = subject.mesh.positions[t[k]];
          triangle[k][a] = ((row[0] * p[0] + row[1] * p[1]) + row[2] * p[2]) + row[3];
        }
      if (meets(segment, triangle)) return true;
    }
    return false;
  }
  bool blocked(const Scene& scene, const Segment& segment, uint32_t mask) const {
    for (uint32_t i = 0; i < instances.size(); ++i)
      if ((instances[i].mask & mask) && blocked(scene, i, segment)) return true;
    return false;
  }
};

TEST(SceneOccluded, IsExactInTheFramesOfItsObjects) {
  for (const LookUpFirst look_up : {LookUpFirst::always, LookUpFirst::never}) {
    const JudgedScene judged(look_up);
    for (const std::string& kernel : kernels()) {
      const auto scene = Scene::build(judged.instances, kernel);
      ASSERT_TRUE(scene.ok());
      ASSERT_TRUE(scene->has_hierarchies());
      FloatRandom random(13);
      std::vector<Segment> segments;
      std::vector<uint32_t> origins;
      for (int i = 0; i < 500 / kShare; ++i) {
        Segment s{};
        for (int a = 0; a < 3; ++a) s.origin[a] = random.between(-9, 9), s.direction[a] = random.between(-9, 9);
        s.t_max = i % 50 == 0 ? kInfinity : 1;
        if (i % 60 == 1) s.origin[0] = 0x1p50f, s.direction[0] = -0x1p50f;  // beyond what a scene trusts
        segments.push_back(s);
        origins.push_back(i % 4 ? kNoInstance : random.below(60));
      }
      for (const uint32_t mask : {1u, 3u})
        for (const bool with_origins : {false, true}) {
          const SceneQuery query{mask, with_origins ? std::span<const uint32_t>(origins) : std::span<const uint32_t>()};
          std::vector<uint64_t> blocked((segments.size() + 63) / 64);
          scene->occluded(segments, blocked, query);
          for (size_t i = 0; i < segments.size(); ++i) {
            const bool expected = judged.blocked(*scene, segments[i], mask);
            ASSERT_EQ((blocked[i / 64] >> i % 64 & 1) != 0, expected) << i;
            const SceneQuery one{mask, query.origins.empty() ? query.origins : query.origins.subspan(i, 1)};
            ASSERT_EQ(scene->occluded(segments[i], one), expected) << i;
          }
        }
      for (int i = 0; i < 40 / kShare; ++i) {
        const size_t count = 1 + random.below(300);
        std::vector<float> u(count), v(count);
        for (size_t k = 0; k < count; ++k) u[k] = random.uniform(), v[k] = random.uniform();
        QuadBundle bundle{{}, {}, {}, {}, u, v};
        for (int a = 0; a < 3; ++a)
          bundle.origin[a] = random.between(-9, 9), bundle.corner[a] = random.between(-9, 9),
          bundle.edge_u[a] = random.between(-2, 2), bundle.edge_v[a] = random.between(-2, 2);
        std::vector<uint64_t> blocked((count + 63) / 64);
        scene->occluded(bundle, blocked);
        for (size_t k = 0; k < count; ++k)
          ASSERT_EQ((blocked[k / 64] >> k % 64 & 1) != 0, judged.blocked(*scene, segment_of(bundle, k), ~0u)) << k;
      }
    }
  }
}

}  // namespace
}  // namespace vcd::test
