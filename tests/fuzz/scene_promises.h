// A scene of a sidecar's objects in hostile places: what <vcd/runtime/scene.h> promises of any scene.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <vcd/runtime/scene.h>

#include "fuzz/hostile_floats.h"
#include "fuzz/runtime_promises.h"

namespace vcd::fuzz {

// Where most objects stand as they are; some are turned into anything that bytes say, flattened or hidden.
inline std::vector<SceneInstance> hostile_instances(const Sidecar& sidecar, HostileFloats& floats) {
  std::vector<SceneInstance> instances;
  const size_t objects = std::min<size_t>(sidecar.object_count(), 3);
  for (size_t i = 0; objects > 0 && i < 1 + floats.below(12); ++i) {
    Transform place{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};
    if (i > 0)
      for (auto& row : place.rows) row[3] = 4 * floats.next();
    if (floats.below(4) == 0)
      for (auto& row : place.rows)
        for (float& x : row) x = floats.next();
    if (const uint32_t axis = floats.below(16); axis < 4)
      for (auto& row : place.rows) axis < 3 ? row[axis] = 0 : row[0] = row[1] = row[2] = 0;
    instances.push_back(SceneInstance::of(sidecar.object(floats.below(static_cast<uint32_t>(objects))), place));
    instances.back().mask = 1u << floats.below(2) | 4u;
    if (floats.below(6) == 0) instances.back().object.reset();
  }
  return instances;
}

class SceneQueries {
 public:
  // sizes: of the instances' boxes in the world.
  SceneQueries(std::vector<Scene> by_kernel, std::vector<float> sizes, std::vector<Segment> segments, SceneQuery query)
      : scenes_(std::move(by_kernel)), sizes_(std::move(sizes)), segments_(std::move(segments)), query_(query) {}

  void ask() const {
    const auto answers = listed_answers(scenes_[0]);
    for (const Scene& scene : scenes_) {
      std::vector<Answer> again(segments_.size(), Answer::blocked);
      scene.classify(segments_, again, query_);
      require(again == answers && listed_answers(scene) == answers, "scenes answer alike by every kernel");
      require_traced(scene, answers);
    }
  }

  // A bundle: traced segments are those of an instance and in range, and what is not traced or blocked stays as it was.
  template <class Bundle>
  void ask(const Bundle& bundle) const {
    SceneQuery query = query_;
    query.origins = query.origins.first(std::min<size_t>(query.origins.size(), 1));
    Bits first(bundle.size());
    for (const Scene& scene : scenes_) {
      Bits bits(bundle.size());
      scene.classify(bundle, bits.blocked, bits.open, query);
      bits.require_well_formed();
      require_as_alone(scene, bundle, bits, query);
      if (&scene == &scenes_[0]) first = bits;
      // The last kernel is the scalar one, which takes no samples together.
      require(bits == first || &scene == &scenes_.back(),
              "bundles are answered alike by every kernel that takes them together");
      for (const bool hits : {false, true}) {
        std::vector<uint64_t> blocked(bits.blocked.size(), ~uint64_t{0});
        scene.occluded(
            bundle, blocked, [&](const UnclassifiedSegments& open) { trace(scene, open, bundle.size(), hits); }, query);
        if (bundle.size() % 64) require(blocked.back() >> (bundle.size() % 64) == 0, "bits past the last sample are 0");
      }
    }
  }

 private:
  // No sample is told the opposite of what it is told alone, whatever its neighbours are.
  void require_as_alone(const Scene& scene, const QuadBundle& bundle, const Bits& bits, const SceneQuery& query) const {
    for (size_t i = 0; i < bundle.size(); ++i) {
      const Segment s = segment_of(bundle, i);
      const Answer together = bits[i];
      require(together != Answer::blocked || test::is_finite(s), "what is not finite is not blocked");
      if (together == Answer::unclassified) continue;
      const Answer alone = scene.classify(s, query);
      require(together == alone || alone == Answer::unclassified || neighbour_says(scene, s, query, together),
              "a bundle says of no sample the opposite of what is said of it alone");
    }
  }
  // Samples may lie outside of the sphere.
  void require_as_alone(const Scene&, const SphereBundle&, const Bits&, const SceneQuery&) const {}

  // Whether a line so close to the segment's that rounding may take one for the other is answered so.
  bool neighbour_says(const Scene& scene, const Segment& s, const SceneQuery& query, Answer answer) const {
    std::vector<float> sizes = sizes_;
    sizes.push_back(std::max({std::abs(s.direction[0]), std::abs(s.direction[1]), std::abs(s.direction[2])}));
    for (const float size : sizes)
      for (int shift = 0; shift < 27; ++shift) {
        Segment near = s;
        for (int a = 0, digits = shift; a < 3; ++a, digits /= 3)
          near.direction[a] += static_cast<float>(digits % 3 - 1) * 0x1p-12f * size;
        if (scene.classify(near, query) == answer) return true;
      }
    return false;
  }

  // The answers of the call that lists what is open, and what it says of its list.
  std::vector<Answer> listed_answers(const Scene& scene) const {
    std::vector<Answer> answers(segments_.size(), Answer::blocked);
    std::vector<UnclassifiedPair> open(64);
    const auto [count, complete] = scene.classify(segments_, answers, open, query_);
    require(count <= open.size(), "no more is listed than there is room for");
    std::vector<bool> listed(segments_.size());
    for (size_t i = 0; i < count; ++i) {
      require(open[i].segment < segments_.size() && open[i].instance < scene.size(), "what is listed is there");
      require(i == 0 || open[i - 1].segment <= open[i].segment, "the list is by segment");
      listed[open[i].segment] = true;
    }
    for (size_t i = 0; i < segments_.size(); ++i) {
      require(!listed[i] || answers[i] == Answer::unclassified, "only unclassified segments are listed");
      require(!complete || listed[i] == (answers[i] == Answer::unclassified),
              "a complete list has every unclassified segment");
    }
    return answers;
  }

  static void trace(const Scene& scene, const UnclassifiedSegments& open, size_t size, bool hits) {
    require(open.instance < scene.size() && open.segments.count > 0 && open.segments.count <= 256 &&
                scene.use(open.instance) != InstanceUse::absent,
            "open segments are of an instance that is there");
    volatile float sum = 0;
    for (size_t k = 0; k < (open.segments.count + 15) / 16 * 16; ++k) sum = sum + segment_at(open.segments, k).t_max;
    for (size_t k = 0; k < open.segments.count; ++k) {
      require(open.indices[k] < size && open.blocked[k] == 0, "open segments are of the query, and not blocked");
      open.blocked[k] = hits;
    }
  }

  void require_traced(const Scene& scene, const std::vector<Answer>& answers) const {
    for (const bool hits : {false, true}) {
      std::vector<uint64_t> blocked((segments_.size() + 63) / 64, ~uint64_t{0});
      scene.occluded(
          segments_, blocked, [&](const UnclassifiedSegments& open) { trace(scene, open, segments_.size(), hits); },
          query_);
      for (size_t i = 0; i < segments_.size(); ++i) {
        const bool bit = blocked[i / 64] >> (i % 64) & 1;
        if (answers[i] == Answer::blocked) require(bit, "what a sidecar blocks is blocked");
        if (!hits) require(bit == (answers[i] == Answer::blocked), "what nothing blocks is not blocked");
        // What is clear may be traced all the same where sixteen neighbours go as one beam.
      }
    }
  }

  std::vector<Scene> scenes_;
  std::vector<float> sizes_;
  std::vector<Segment> segments_;
  SceneQuery query_;
};

inline void query_scene(const Sidecar& sidecar, std::span<const uint8_t> tail) {
  HostileFloats floats(tail);
  const auto instances = hostile_instances(sidecar, floats);
  std::vector<Scene> scenes;
  for (const std::string& kernel : kernels()) {
    auto scene = Scene::build(instances, kernel);
    require(scene.ok(), "no instance keeps a scene from being built");
    scenes.push_back(std::move(*scene));
  }
  if (instances.empty()) return;
  const ObjectRecord& record = sidecar.object(0).record();
  const auto segments = hostile_segments(floats, record);
  std::vector<uint32_t> origins;
  for (size_t i = 0; i < segments.size(); ++i)
    origins.push_back(floats.below(3) ? kNoInstance : floats.below(static_cast<uint32_t>(instances.size())));
  const SceneQuery query{floats.below(2) ? 0xFFFFFFFF : floats.below(4),
                         floats.below(2) ? std::span<const uint32_t>(origins) : std::span<const uint32_t>()};
  std::vector<float> sizes;
  for (const SceneInstance& instance : instances) {
    float size = 0;
    for (const auto& row : instance.to_world.rows)
      for (int a = 0; a < 3; ++a) size += std::abs(row[a]) * (instance.box_max[a] - instance.box_min[a]);
    sizes.push_back(size);
  }
  const SceneQueries queries(std::move(scenes), std::move(sizes), segments, query);
  queries.ask();
  const HostileBundles bundles(floats, record);
  queries.ask(bundles.quad);
  queries.ask(bundles.sphere);
}

}  // namespace vcd::fuzz
