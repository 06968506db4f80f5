#include <vcd/recorder/recorder.h>

#include <algorithm>
#include <mutex>
#include <new>
#include <utility>

#include <vcd/writer/demand.h>

namespace vcd {
namespace {

constexpr uint64_t kGolden = 0x9E3779B97F4A7C15u;

// SplitMix64's output function (Steele, Lea and Flood 2014).
uint64_t mix(uint64_t x) {
  x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
  x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
  return x ^ (x >> 31);
}

constexpr size_t kAtOnce = 256;    // segments that are placed together
constexpr size_t kMostBoxes = 64;  // that one of them is listed with, in the mean

}  // namespace

struct Recorder::State {
  Scene scene;  // of the instances' boxes alone
  std::vector<GeometryHash> hashes;
  size_t most;
  std::mutex mutex;  // of `threads`
  std::vector<std::unique_ptr<Thread>> threads;
};

RecordedInstance RecordedInstance::of(const Object& object, const Transform& to_world) {
  return {object.record().geometry_hash, SceneInstance::of(object, to_world)};
}

Recorder::Recorder(std::unique_ptr<State> state) : state_(std::move(state)) {}
Recorder::Recorder(Recorder&&) noexcept = default;
Recorder& Recorder::operator=(Recorder&&) noexcept = default;
Recorder::~Recorder() = default;

Recorder::Thread::Thread(uint64_t seed, size_t most) : most_(std::max<size_t>(most / 2, 1) * 2), random_(mix(seed)) {
  kept_.reserve(most_);
}

uint64_t Recorder::Thread::random() { return mix(random_ += kGolden); }

void Recorder::Thread::keep(const Segment& segment, uint32_t self) {
  kept_.push_back({segment, self});
  const uint64_t rest = gap_ - 1 - place_;
  if (kept_.size() == most_) halve();
  place_ = random() & (gap_ - 1);
  skip_ = rest + place_;
}

void Recorder::Thread::halve() {
  uint64_t bits = 0;
  for (size_t i = 0; i < kept_.size() / 2; ++i, bits >>= 1) {
    if (i % 64 == 0) bits = random();
    kept_[i] = kept_[2 * i + (bits & 1)];
  }
  kept_.resize(kept_.size() / 2);
  gap_ *= 2;
}

Result<Recorder> Recorder::build(std::span<const RecordedInstance> instances, size_t most) try {
  std::vector<SceneInstance> places;
  std::vector<GeometryHash> hashes;
  for (const RecordedInstance& instance : instances) {
    places.push_back(instance.place);
    places.back().object.reset();  // so that every segment that could meet the box is listed
    places.back().mask = 0xFFFFFFFF;
    hashes.push_back(instance.geometry_hash);
  }
  auto scene = Scene::build(places);
  if (!scene) return scene.error();
  return Recorder(std::unique_ptr<State>(new State{std::move(*scene), std::move(hashes), most, {}, {}}));
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::runtime, "out of memory"};
}

Recorder::Thread& Recorder::thread() {
  const std::lock_guard lock(state_->mutex);
  state_->threads.emplace_back(new Thread(state_->threads.size(), state_->most));
  return *state_->threads.back();
}

Demand Recorder::demand() const {
  Demand demand;
  std::vector<Segment> segments;
  std::vector<Visibility> answers(kAtOnce);
  std::vector<UnclassifiedPair> list(kAtOnce * kMostBoxes);
  for (const auto& thread : state_->threads) {
    const auto& kept = thread->kept_;
    for (size_t first = 0; first < kept.size(); first += kAtOnce) {
      const size_t count = std::min(kAtOnce, kept.size() - first);
      segments.clear();
      for (size_t i = 0; i < count; ++i) segments.push_back(kept[first + i].segment);
      // Where there are more boxes than room, the last ones are missing: a sample can do without.
      const auto listed = state_->scene.classify(segments, std::span(answers).first(count), list);
      for (const auto& [segment, instance, length] : std::span(list).first(listed.count)) {
        if (kept[first + segment].self == instance) continue;
        if (const auto inside = state_->scene.in_object(instance, segments[segment]))
          demand[state_->hashes[instance]].push_back(
              {*inside, static_cast<double>(thread->seen_) / static_cast<double>(kept.size())});
      }
    }
  }
  for (auto& [hash, of_object] : demand) of_object = in_order(std::move(of_object));
  std::erase_if(demand, [](const auto& object) { return object.second.empty(); });
  return thin(std::move(demand), kMostAskedSegments);
}

}  // namespace vcd
