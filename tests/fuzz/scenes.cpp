// Objects, bundles and scenes at the limits of floats, against exact arithmetic: no answer is wrong, whatever the
// scale, and nothing that is met is kept from the caller.
#include <algorithm>
#include <cmath>
#include <vector>

#include <vcd/runtime/scene.h>

#include "fuzz/fuzz.h"
#include "fuzz/odd_places.h"
#include "fuzz/runtime_promises.h"
#include "support/exact_world.h"
#include "support/files.h"
#include "support/meshes.h"

namespace vcd::fuzz {
namespace {

using test::ExactInstance;
constexpr Transform kStill{{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};

// A mesh about [0, 1]^3 with its proven sidecar, by every kernel.
struct Baked {
  baker::SourceMesh mesh;
  std::vector<std::byte> bytes;
  std::vector<Sidecar> by_kernel;
  ExactInstance still;

  explicit Baked(baker::SourceMesh from) : mesh(std::move(from)), still(mesh, kStill) {
    const baker::BakedObject object = test::must_bake(mesh, test::proven(3));
    bytes = test::sidecar_bytes({&object});
    for (const std::string& kernel : kernels())
      by_kernel.push_back(std::move(*Sidecar::open_buffer(bytes, {.kernel = kernel})));
  }
};

// A triangle that hangs askew.
baker::SourceMesh leaf() { return {"leaf", 0, {{0, 0.1f, 0.3f}, {1, 0.4f, 0}, {0.2f, 1, 1}}, {{0, 1, 2}}}; }

const std::vector<Baked>& baked_meshes() {
  static const std::vector<Baked> all = [] {
    std::vector<Baked> made;
    made.reserve(2);
    made.emplace_back(test::cube()), made.emplace_back(leaf());
    return made;
  }();
  return all;
}

void require_true(Answer answer, bool blocked, const char* promise) {
  require(answer == Answer::unclassified || (answer == Answer::blocked) == blocked, promise);
}

template <class Bundle>
bool is_sample(const OddLights& lights, const Bundle&, size_t i) {
  if constexpr (std::is_same_v<Bundle, SphereBundle>) return lights.is_inside(i);
  else return true;
}

void query_object(const Baked& baked, OddPlaces& places) {
  const auto ask_bundle = [&](const auto& lights, const auto& bundle) {
    for (const Sidecar& sidecar : baked.by_kernel) {
      Bits bits(bundle.size());
      sidecar.object(0).classify(bundle, bits.blocked, bits.open);
      for (size_t i = 0; i < bundle.size(); ++i)
        if (bits[i] != Answer::unclassified && is_sample(lights, bundle, i))
          require_true(bits[i], baked.still.meets(segment_of(bundle, i)), "what a bundle says of an object is true");
    }
  };
  for (int i = 0; i < 20; ++i) {
    const Segment s = places.segment(kStill);
    const Answer answer = baked.by_kernel[0].object(0).classify(s);
    if (answer != Answer::unclassified) require_true(answer, baked.still.meets(s), "what is said of an object is true");
  }
  for (int i = 0; i < 8; ++i) {
    const OddLights lights(places, kStill);
    ask_bundle(lights, lights.quad), ask_bundle(lights, lights.sphere);
  }
}

// All NaNs count as one.
bool is_same(const Segment& a, const Segment& b) {
  const auto same = [](float x, float y) { return x == y || (std::isnan(x) && std::isnan(y)); };
  return std::equal(a.origin, a.origin + 3, b.origin, same) && same(a.t_min, b.t_min) &&
         std::equal(a.direction, a.direction + 3, b.direction, same) && same(a.t_max, b.t_max);
}

bool is_finite(const Transform& t) {
  return std::all_of(&t.rows[0][0], &t.rows[0][0] + 12, [](float x) { return std::isfinite(x); });
}

// Some instances and what is true of them.
class World {
 public:
  explicit World(OddPlaces& places) {
    const float scale = places.factor();
    for (size_t i = 0, count = 1 + places.below(4); i < count; ++i) {
      const Baked& baked = baked_meshes()[places.below(2)];
      const Transform t = places.transform(places.one_in(4) ? places.factor() : scale);
      baked_.push_back(&baked);
      instances_.push_back(SceneInstance::of(baked.by_kernel[0].object(0), t));
      if (places.one_in(6)) instances_.back().object.reset();
      exact_.push_back(is_finite(t) ? std::optional(ExactInstance(baked.mesh, t)) : std::nullopt);
    }
    for (const std::string& kernel : kernels()) {
      auto scene = Scene::build(instances_, kernel);
      require(scene.ok(), "no instance keeps a scene from being built");
      scenes_.push_back(std::move(*scene));
    }
  }

  const std::vector<Scene>& scenes() const { return scenes_; }
  const Transform& transform(uint32_t i) const { return instances_[i].to_world; }
  uint32_t size() const { return static_cast<uint32_t>(instances_.size()); }

  // Where something is not finite nothing is true: the caller may say anything.
  bool meets(uint32_t i, const Segment& s) const {
    return exact_[i] && scenes_[0].use(i) != InstanceUse::absent && exact_[i]->meets(s);
  }

 private:
  std::vector<const Baked*> baked_;
  std::vector<SceneInstance> instances_;
  std::vector<std::optional<ExactInstance>> exact_;
  std::vector<Scene> scenes_;
};

// Segments in a world, and what is true of them.
class Truth {
 public:
  explicit Truth(const World& world) : world_(world), by_instance_(world.size()) {}

  // matters: false for samples that are not on their light, of which anything may be said.
  void add(const Segment& s, bool matters = true) {
    segments_.push_back(s), matters_.push_back(matters), any_.push_back(false);
    for (uint32_t i = 0; i < world_.size(); ++i) {
      by_instance_[i].push_back(matters && world_.meets(i, s));
      any_.back() = any_.back() || by_instance_[i].back();
    }
  }
  const std::vector<Segment>& segments() const { return segments_; }

  void require_answer(size_t i, Answer answer, const char* promise) const {
    require(!matters_[i] || answer == Answer::unclassified || (answer == Answer::blocked) == any_[i], promise);
  }
  void require_one(const Scene& scene, size_t i) const {
    const bool blocked = scene.occluded(segments_[i], [&](uint32_t k) { return by_instance_[k][i]; });
    require(blocked == any_[i], "with the caller's help one segment is told truly");
  }
  // occluded(scene, blocked, trace) asks for all segments.
  template <class Occluded>
  void require_occluded(const Scene& scene, const Occluded& occluded) const {
    std::vector<uint64_t> blocked((segments_.size() + 63) / 64);
    occluded(blocked, [&](const UnclassifiedSegments& left) { trace(scene, left); });
    for (size_t i = 0; i < segments_.size(); ++i)
      require(!matters_[i] || (blocked[i / 64] >> (i % 64) & 1) == any_[i], "with the caller's help all is told truly");
  }

 private:
  void trace(const Scene& scene, const UnclassifiedSegments& left) const {
    require(left.instance < world_.size() && scene.use(left.instance) != InstanceUse::absent,
            "nobody is asked of what is absent");
    for (size_t k = 0; k < left.segments.count; ++k) {
      const Segment& s = segments_[left.indices[k]];
      const auto in_object = scene.in_object(left.instance, s);
      require(left.in_world == !in_object, "what the object's frame cannot hold stays in the world's");
      const Segment expected = in_object.value_or(s), given = segment_at(left.segments, k);
      require(is_same(given, expected), "segments are handed over in the frame that is named");
      left.blocked[k] = by_instance_[left.instance][left.indices[k]];
    }
  }

  const World& world_;
  std::vector<Segment> segments_;
  std::vector<bool> matters_, any_;
  std::vector<std::vector<bool>> by_instance_;
};

template <class Bundle>
void query_bundle(const World& world, const OddLights& lights, const Bundle& bundle) {
  Truth truth(world);
  for (size_t i = 0; i < bundle.size(); ++i) truth.add(segment_of(bundle, i), is_sample(lights, bundle, i));
  for (const Scene& scene : world.scenes()) {
    Bits bits(bundle.size());
    scene.classify(bundle, bits.blocked, bits.open);
    for (size_t i = 0; i < bundle.size(); ++i)
      truth.require_answer(i, bits[i], "what a bundle says of a scene is true");
    truth.require_occluded(scene,
                           [&](std::span<uint64_t> blocked, auto&& trace) { scene.occluded(bundle, blocked, trace); });
  }
}

void query_scene(OddPlaces& places) {
  const World world(places);
  Truth truth(world);
  const bool coherent = places.one_in(2);
  for (int i = 0; i < 40; ++i) {
    Segment s =
        coherent && i % 16 != 0 ? truth.segments().back() : places.segment(world.transform(places.below(world.size())));
    if (coherent && i % 16 != 0)
      for (float& d : s.direction) d *= places.between(0.95f, 1.05f);
    truth.add(s);
  }
  const std::vector<Segment>& segments = truth.segments();
  for (const Scene& scene : world.scenes()) {
    std::vector<Answer> answers(segments.size());
    scene.classify(segments, answers);
    for (size_t i = 0; i < segments.size(); ++i) {
      truth.require_answer(i, answers[i], "what is said of a scene is true");
      truth.require_one(scene, i);
    }
    truth.require_occluded(
        scene, [&](std::span<uint64_t> blocked, auto&& trace) { scene.occluded(segments, blocked, trace); });
  }
  for (int i = 0; i < 3; ++i) {
    const OddLights lights(places, world.transform(places.below(world.size())));
    query_bundle(world, lights, lights.quad), query_bundle(world, lights, lights.sphere);
  }
}

}  // namespace
}  // namespace vcd::fuzz

// Baking takes longer than an input may.
extern "C" int LLVMFuzzerInitialize(int*, char***) {
  vcd::fuzz::baked_meshes();
  return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace vcd::fuzz;
  OddPlaces places({data, size});
  query_object(baked_meshes()[places.below(2)], places);
  query_scene(places);
  planted_bug();
  return 0;
}
