// Embree's adapter against Embree itself: packets, and scenes of instances.
#include <embree3/rtcore.h>

#include <vcd/runtime/embree.h>

#include <cmath>

#include <gtest/gtest.h>

#include <vcd/baker/audit.h>
#include <vcd/baker/tracer.h>

#include "support/files.h"
#include "support/meshes.h"
#include "support/random.h"

namespace vcd::test {
using namespace baker;
namespace {

Tracer trace(const SourceMesh& mesh) { return std::move(*Tracer::build(mesh.positions, mesh.triangles)); }

BakedObject proven(SourceMesh mesh) {
  BakeOptions options;
  options.method = Method::proven, options.depth = kSanitized ? 3 : 4;
  return must_bake(std::move(mesh), options);
}

template <class Rays>
constexpr size_t kWidthOf = sizeof(Rays::tfar) / sizeof(float);

template <class Rays>
Rays packet(const std::vector<Segment>& segments, size_t first) {
  Rays rays{};
  for (size_t k = 0; k < kWidthOf<Rays>; ++k) {
    const Segment& s = segments[first + k];
    rays.org_x[k] = s.origin[0], rays.org_y[k] = s.origin[1], rays.org_z[k] = s.origin[2], rays.tnear[k] = s.t_min;
    rays.dir_x[k] = s.direction[0], rays.dir_y[k] = s.direction[1], rays.dir_z[k] = s.direction[2],
    rays.tfar[k] = s.t_max;
    rays.mask[k] = 0xFFFFFFFF;
  }
  return rays;
}

template <class Rays>
void packets_of_one_object(const Object& object, const Tracer& tracer, const std::vector<Segment>& segments) {
  FloatRandom random(2);
  size_t traced = 0, open = 0, wrong = 0;
  for (size_t first = 0; first + kWidthOf<Rays> <= segments.size(); first += kWidthOf<Rays>) {
    Rays rays = packet<Rays>(segments, first);
    alignas(64) int valid[kWidthOf<Rays>];
    for (int& v : valid) v = random.below(4) ? -1 : 0;
    traced += occluded_packet(object, valid, tracer.scene(), &rays);
    for (size_t k = 0; k < kWidthOf<Rays>; ++k) {
      const Segment& s = segments[first + k];
      if (!valid[k]) {
        EXPECT_EQ(rays.tfar[k], s.t_max);
        continue;
      }
      open += object.classify(s) == Visibility::unclassified;
      wrong += (rays.tfar[k] < 0) != tracer.occluded(s);
    }
  }
  EXPECT_EQ(traced, open);
  EXPECT_GT(open, 100u);
  EXPECT_LE(wrong, segments.size() / 5000);  // a line at an edge can go either way in Embree
}

TEST(Embree, PacketsOfOneObject) {
  const BakedObject baked = proven(sphere());
  const auto bytes = sidecar_bytes({&baked});
  const auto sidecar = Sidecar::open_buffer(bytes);
  const Tracer tracer = trace(sphere());
  const auto segments = audit_segments(*prepare(sphere()), AuditKind::chords, 3, 20000);
  packets_of_one_object<RTCRay8>(sidecar->object(0), tracer, segments);
  packets_of_one_object<RTCRay16>(sidecar->object(0), tracer, segments);
}

TEST(Embree, EveryWayThroughAHierarchyGivesTheSameAnswers) {
  const Tracer tracer = trace(leaves(200));
  for (size_t count : {0u, 1u, 3u, 15u, 16u, 18u, 100u}) {
    const auto segments = audit_segments(*prepare(leaves(200)), AuditKind::chords, count, count);
    std::vector<uint8_t> expected(count);
    for (size_t i = 0; i < count; ++i) expected[i] = tracer.occluded(segments[i]);
    for (unsigned width : {1u, 8u, 16u})
      for (bool coherent : {false, true}) {
        std::vector<uint8_t> answers(count, 7);
        occluded(tracer.scene(), {width, coherent}, segments, answers.data());
        EXPECT_EQ(answers, expected) << width;
      }
  }
}

class EmbreeScene : public testing::Test {
 protected:
  EmbreeScene() {
    FloatRandom random(6);
    for (uint32_t i = 0; i < 20; ++i) {
      Transform t{};
      const float angle = random.between(0, 6), c = std::cos(angle), s = std::sin(angle),
                  scale = random.between(0.5f, 2);
      t.rows[0][0] = c * scale, t.rows[0][2] = s * scale, t.rows[1][1] = scale, t.rows[2][0] = -s * scale,
      t.rows[2][2] = c * scale;
      for (auto& row : t.rows) row[3] = random.between(-6, 6);
      instances_.push_back(SceneInstance::of(sidecars_[i % 2].object(0), t));
      hierarchies_.push_back(tracers_[i % 2].scene());
    }
    scene_.emplace(std::move(*Scene::build(instances_)));
    while (segments_.size() < (kSanitized ? 320u : 16000u)) {
      Segment s{};
      for (int a = 0; a < 3; ++a)
        s.origin[a] = random.between(-9, 9), s.direction[a] = random.between(-9, 9) - s.origin[a];
      s.t_max = 1;
      for (int k = 0; k < 16; ++k) {
        for (float& d : s.direction) d += random.between(-0.3f, 0.3f);
        segments_.push_back(s);
        origins_.push_back(random.below(3) ? kNoInstance : random.below(20));
      }
    }
    for (const Segment& s : segments_) {
      bool blocked = false;
      for (uint32_t i = 0; i < instances_.size(); ++i) blocked |= tracers_[i % 2].occluded(*scene_->in_object(i, s));
      truth_.push_back(blocked);
    }
  }

  std::array<BakedObject, 2> baked_ = {proven(sphere()), proven(leaves(100))};
  std::array<std::vector<std::byte>, 2> bytes_ = {sidecar_bytes({&baked_[0]}), sidecar_bytes({&baked_[1]})};
  std::array<Sidecar, 2> sidecars_ = {std::move(*Sidecar::open_buffer(bytes_[0])),
                                      std::move(*Sidecar::open_buffer(bytes_[1]))};
  std::array<Tracer, 2> tracers_ = {trace(sphere()), trace(leaves(100))};
  std::vector<SceneInstance> instances_;
  std::vector<RTCScene> hierarchies_;
  std::optional<Scene> scene_;
  std::vector<Segment> segments_;
  std::vector<uint32_t> origins_;
  std::vector<bool> truth_;
};

TEST_F(EmbreeScene, SingleRays) {
  const EmbreeInstances instances{hierarchies_};
  size_t wrong = 0, blocked = 0;
  for (size_t i = 0; i < segments_.size(); ++i) {
    RTCRay ray = to_ray(segments_[i]);
    SceneQuery query;
    query.origins = std::span(origins_).subspan(i, 1);
    occluded1(*scene_, instances, &ray, query);
    EXPECT_TRUE(ray.tfar < 0 || ray.tfar == segments_[i].t_max);
    wrong += (ray.tfar < 0) != truth_[i], blocked += ray.tfar < 0;
  }
  EXPECT_LE(wrong, segments_.size() / 5000);
  EXPECT_GT(blocked, segments_.size() / 10);
}

// A tree that is flattened to its picture on the ground casts a shadow where the caller has a hierarchy for it.
TEST_F(EmbreeScene, FlatInstancesAreTracedInTheWorld) {
  for (auto& instance : instances_) instance.mask = 1;
  for (float& x : instances_[0].to_world.rows[1]) x = 0;
  instances_[0].mask = 2;
  const auto scene = Scene::build(instances_);
  SourceMesh flat = sphere();
  for (auto& p : flat.positions) {
    const auto q = p;
    for (size_t a = 0; a < 3; ++a) {
      const auto& row = instances_[0].to_world.rows[a];
      p[a] = row[0] * q[0] + row[1] * q[1] + row[2] * q[2] + row[3];
    }
  }
  const Tracer tracer = trace(flat);
  std::vector<RTCScene> in_world(instances_.size());
  in_world[0] = tracer.scene();
  const SceneQuery query{2, {}};
  const EmbreeInstances without{hierarchies_}, with{hierarchies_, {}, in_world};
  const std::span<const Segment> segments = std::span(segments_).first(kSanitized ? 320 : 3200);
  std::vector<uint64_t> none(segments.size() / 64), blocked(none);
  scene->occluded(segments, none, without, query);
  scene->occluded(segments, blocked, with, query);
  size_t wrong = 0, shadowed = 0;
  for (size_t i = 0; i < segments.size(); ++i) {
    EXPECT_EQ(none[i / 64] >> (i % 64) & 1, 0u);
    const bool truth = tracer.occluded(segments[i]);
    RTCRay ray = to_ray(segments[i]);
    occluded1(*scene, with, &ray, query);
    wrong += truth != (blocked[i / 64] >> (i % 64) & 1);
    wrong += truth != (ray.tfar < 0);
    shadowed += truth;
  }
  EXPECT_LE(wrong, segments.size() / 1000);
  EXPECT_GT(shadowed, 10u);
}

TEST_F(EmbreeScene, Packets) {
  FloatRandom random(9);
  const auto all = [&]<class Rays>(const Rays&) {
    size_t wrong = 0;
    for (size_t first = 0; first < segments_.size(); first += kWidthOf<Rays>) {
      Rays rays = packet<Rays>(segments_, first);
      alignas(64) int valid[kWidthOf<Rays>];
      for (int& v : valid) v = random.below(4) ? -1 : 0;
      SceneQuery query;
      if (random.below(2)) query.origins = std::span(origins_).subspan(first, kWidthOf<Rays>);
      occluded_packet(*scene_, EmbreeInstances{hierarchies_, {8}}, valid, &rays, query);
      for (size_t k = 0; k < kWidthOf<Rays>; ++k) {
        if (!valid[k]) EXPECT_EQ(rays.tfar[k], segments_[first + k].t_max);
        else wrong += (rays.tfar[k] < 0) != truth_[first + k];
      }
    }
    EXPECT_LE(wrong, segments_.size() / 5000);
  };
  all(RTCRay8{});
  all(RTCRay16{});
}

TEST_F(EmbreeScene, Arrays) {
  for (unsigned width : {1u, 8u, 16u}) {
    std::vector<uint64_t> blocked((segments_.size() + 63) / 64);
    SceneQuery query;
    query.origins = origins_;
    scene_->occluded(segments_, blocked, EmbreeInstances{hierarchies_, {width}}, query);
    size_t wrong = 0;
    for (size_t i = 0; i < segments_.size(); ++i) wrong += truth_[i] != (blocked[i / 64] >> (i % 64) & 1);
    EXPECT_LE(wrong, segments_.size() / 5000);
  }
}

}  // namespace
}  // namespace vcd::test
