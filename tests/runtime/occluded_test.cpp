// occluded() without a fallback, of objects and scenes, in C++ and C: exact, whether look-ups come first or not.
#include <string>

#include <gtest/gtest.h>

#include <vcd/baker/audit.h>
#include <vcd/format/meets.h>
#include <vcd/runtime/scene.h>
#include <vcd/runtime/sidecar.h>
#include <vcd/runtime/vcd.h>

#include "runtime/judged_mesh.h"
#include "scene/scene_data.h"
#include "support/count_allocations.h"
#include "support/meshes.h"
#include "support/special_floats.h"

namespace vcd::test {
using namespace baker;
namespace {

struct Baked {
  JudgedMesh subject;
  BakedObject object;
  std::vector<std::byte> bytes;

  explicit Baked(const SourceMesh& source, const BakeOptions& options = proven(3))
      : subject(SourceMesh(source)), object(must_bake(source, options)), bytes(sidecar_bytes({&object})) {}
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
void expect_exact_bundle(const JudgedMesh& subject, const Object& object, const Bundle& bundle, From from) {
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
  static constexpr size_t kInstances = 60;

  explicit JudgedScene(LookUpFirst look_up) {
    for (const SourceMesh& source : {sphere(), leaves(60)}) baked.emplace_back(source);
    for (const Baked& b : baked) sidecars.push_back(b.open(look_up));
    FloatRandom random(12);
    for (size_t i = 0; i < kInstances; ++i) {
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
    const JudgedMesh& subject = baked[object_of[instance]].subject;
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

// Arrays and single segments of all kinds, with masks and origins.
void expect_exact_arrays(const Scene& scene, const JudgedScene& judged) {
  FloatRandom random(13);
  std::vector<Segment> segments;
  std::vector<uint32_t> origins;
  for (int i = 0; i < 500 / kShare; ++i) {
    Segment s{};
    for (int a = 0; a < 3; ++a) s.origin[a] = random.between(-9, 9), s.direction[a] = random.between(-9, 9);
    s.t_max = i % 50 == 0 ? kInfinity : 1;
    if (i % 60 == 1) s.origin[0] = 0x1p50f, s.direction[0] = -0x1p50f;  // beyond what a scene trusts
    segments.push_back(s);
    origins.push_back(i % 4 ? kNoInstance : random.below(JudgedScene::kInstances));
  }
  for (const uint32_t mask : {1u, 3u})
    for (const bool with_origins : {false, true}) {
      const SceneQuery query{mask, with_origins ? std::span<const uint32_t>(origins) : std::span<const uint32_t>()};
      std::vector<uint64_t> blocked((segments.size() + 63) / 64);
      scene.occluded(segments, blocked, query);
      for (size_t i = 0; i < segments.size(); ++i) {
        const bool expected = judged.blocked(scene, segments[i], mask);
        ASSERT_EQ((blocked[i / 64] >> i % 64 & 1) != 0, expected) << i;
        const SceneQuery one{mask, query.origins.empty() ? query.origins : query.origins.subspan(i, 1)};
        ASSERT_EQ(scene.occluded(segments[i], one), expected) << i;
      }
    }
}

TEST(SceneOccluded, IsExactInTheFramesOfItsObjects) {
  for (const LookUpFirst look_up : {LookUpFirst::always, LookUpFirst::never}) {
    const JudgedScene judged(look_up);
    for (const std::string& kernel : kernels()) {
      const auto scene = Scene::build(judged.instances, kernel);
      ASSERT_TRUE(scene.ok());
      ASSERT_TRUE(scene->has_hierarchies());
      expect_exact_arrays(*scene, judged);
      FloatRandom random(14);
      for (int i = 0; i < 24 / kShare; ++i) {
        const size_t count = 1 + random.below(i % 8 == 0 ? 300 : 60);
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
        // To points all around, or near to each other; from inside an instance, half of them beyond what a scene
        // trusts.
        const bool far = i % 4 == 1;
        const Transform& inside = judged.instances[random.below(JudgedScene::kInstances)].to_world;
        std::vector<float> x(count), y(count), z(count);
        const float spread = i % 3 == 0 ? 9 : 0.5f;
        for (size_t k = 0; k < count; ++k)
          x[k] = (far && k % 2 ? 0x1p50f : 4) + random.between(-spread, spread), y[k] = random.between(-spread, spread),
          z[k] = random.between(-spread, spread);
        PointBundle points{{bundle.origin[0], bundle.origin[1], bundle.origin[2]}, x, y, z};
        for (int a = 0; far && a < 3; ++a) points.origin[a] = inside.rows[a][3];
        const uint32_t self = i % 2 ? kNoInstance : random.below(JudgedScene::kInstances);
        scene->occluded(points, blocked, {~0u, std::span(&self, 1)});
        for (size_t k = 0; k < count; ++k)
          ASSERT_EQ((blocked[k / 64] >> k % 64 & 1) != 0, judged.blocked(*scene, segment_of(points, k), ~0u)) << k;
      }
    }
  }
}

// ---- In C

constexpr vcd_look_up_first kLookUps[] = {VCD_LOOK_UP_AS_BAKED, VCD_LOOK_UP_ALWAYS, VCD_LOOK_UP_NEVER};

TEST(OccludedInC, SaysWhatCppSaysOfAnObject) {
  const Baked baked(leaves(60));
  for (const vcd_look_up_first look_up : kLookUps) {
    vcd_open_options options{};
    options.look_up = look_up;
    const vcd_sidecar* sidecar = nullptr;
    ASSERT_EQ(vcd_open_buffer(baked.bytes.data(), baked.bytes.size(), &options, &sidecar, nullptr), VCD_SUCCESS);
    const vcd_object* const object = vcd_object_at(sidecar, 0);
    EXPECT_EQ(vcd_object_has_hierarchy(object), 1);
    const auto segments = audit_segments(baked.subject.mesh, AuditKind::inside, 3, 300);
    const auto* const in_c = reinterpret_cast<const vcd_segment*>(segments.data());
    uint64_t blocked[5];
    vcd_occluded_array(object, in_c, segments.size(), VCD_FROM_SELF, blocked);
    for (size_t i = 0; i < segments.size(); ++i) {
      const int expected = baked.subject.referee.occluded(segments[i]);
      ASSERT_EQ(vcd_occluded(object, &in_c[i], VCD_FROM_OUTSIDE), expected);
      ASSERT_EQ(static_cast<int>(blocked[i / 64] >> i % 64 & 1), expected);
    }
    FloatRandom random(14);
    std::vector<float> x(300), y(300), z(300);
    for (size_t i = 0; i < x.size(); ++i) x[i] = random.uniform(), y[i] = random.uniform(), z[i] = random.uniform();
    const auto expect = [&](const auto& bundle) {
      for (size_t i = 0; i < bundle.size(); ++i)
        ASSERT_EQ((blocked[i / 64] >> i % 64 & 1) != 0, baked.subject.referee.occluded(segment_of(bundle, i))) << i;
    };
    vcd_quad_bundle quad{0, {3, 3, 3}, {-3, -3, -3}, {1, 0, 0}, {0, 1, 0}, x.data(), y.data(), x.size()};
    vcd_occluded_quad(object, &quad, VCD_FROM_OUTSIDE, blocked);
    expect(QuadBundle{{3, 3, 3}, {-3, -3, -3}, {1, 0, 0}, {0, 1, 0}, x, y});
    vcd_sphere_bundle sphere{0, {-2, -2, -2}, {0.5f, 0.5f, 0.5f}, 1, x.data(), y.data(), z.data(), x.size()};
    vcd_occluded_sphere(object, &sphere, VCD_FROM_OUTSIDE, blocked);
    expect(SphereBundle{{-2, -2, -2}, {0.5f, 0.5f, 0.5f}, 1, x, y, z});
    vcd_point_bundle point{0, {-1, -1, -1}, x.data(), y.data(), z.data(), x.size()};
    vcd_occluded_point(object, &point, VCD_FROM_INSIDE, blocked);
    expect(PointBundle{{-1, -1, -1}, x, y, z});
    vcd_close(sidecar);
  }
  vcd_open_options wrong{};
  wrong.look_up = static_cast<vcd_look_up_first>(3);
  const vcd_sidecar* sidecar = nullptr;
  EXPECT_EQ(vcd_open_buffer(baked.bytes.data(), baked.bytes.size(), &wrong, &sidecar, nullptr), VCD_ERROR_USAGE);
}

TEST(OccludedInC, AsksHierarchiesWhereASceneHasNoTrace) {
  const Baked baked(sphere());
  const vcd_sidecar* sidecar = nullptr;
  ASSERT_EQ(vcd_open_buffer(baked.bytes.data(), baked.bytes.size(), nullptr, &sidecar, nullptr), VCD_SUCCESS);
  vcd_instance instances[2] = {};
  for (int i = 0; i < 2; ++i) {
    instances[i].object = vcd_object_at(sidecar, 0);
    for (int a = 0; a < 3; ++a) instances[i].to_world[5 * a] = 1;
    instances[i].to_world[3] = 5.0f * static_cast<float>(i);
  }
  vcd_scene* scene = nullptr;
  ASSERT_EQ(vcd_scene_build(instances, 2, nullptr, &scene, nullptr), VCD_SUCCESS);
  EXPECT_EQ(vcd_scene_has_hierarchies(scene), 1);
  const vcd_segment segments[3] = {
      {{0, 0, -3}, 0, {0, 0, 6}, 1}, {{5, 0, -3}, 0, {0, 0, 6}, 1}, {{2.5f, 0, -3}, 0, {0, 0, 6}, 1}};
  uint64_t blocked = ~uint64_t{0};
  vcd_scene_occluded(scene, segments, 3, nullptr, nullptr, nullptr, &blocked);
  EXPECT_EQ(blocked, 3u);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(vcd_scene_occluded_one(scene, &segments[i], 0, VCD_NO_INSTANCE), i < 2) << i;
  const float u[2] = {0, 1}, v[2] = {0, 0};
  const vcd_quad_bundle quad{0, {5, 0, -3}, {5, 0, 3}, {8, 0, 0}, {0, 8, 0}, u, v, 2};
  vcd_scene_occluded_quad(scene, &quad, nullptr, nullptr, nullptr, &blocked);
  EXPECT_EQ(blocked, 1u);
  const float x[2] = {0, 9}, y[2] = {0, 9}, z[2] = {3, 3};
  const vcd_sphere_bundle round{0, {0, 0, -3}, {4, 4, 3}, 9, x, y, z, 2};
  vcd_scene_occluded_sphere(scene, &round, nullptr, nullptr, nullptr, &blocked);
  EXPECT_EQ(blocked, 1u);
  const float dx[3] = {5, 0, -5}, dy[3] = {0, 0, 0}, dz[3] = {6, 6, 6};
  const vcd_point_bundle points{0, {0, 0, -3}, dx, dy, dz, 3};
  vcd_scene_occluded_point(scene, &points, nullptr, nullptr, nullptr, &blocked);
  EXPECT_EQ(blocked, 2u);
  vcd_scene_free(scene);
  vcd_close(sidecar);
}

}  // namespace
}  // namespace vcd::test
