// What an object is asked.
#include <algorithm>
#include <cassert>

#include <vcd/runtime/sidecar.h>

#include "beam/beam.h"
#include "hierarchy/fan.h"
#include "lookup/object_data.h"
#include "lookup/sample_bits.h"

namespace vcd {
namespace {

// Of an object that answers nothing.
void leave_all(size_t count, uint64_t* blocked, uint64_t* unclassified) {
  for (size_t first = 0; first < count; first += kChunk) {
    const size_t some = std::min(kChunk, count - first);
    SampleBits{}.store(some, blocked + first / 64);
    SampleBits::first(some).store(some, unclassified + first / 64);
  }
}

// Looks up those in `live` of at most kChunk segments: what is blocked goes to `blocked`, and what is unclassified
// stays.
void look_up(const Object& object, std::span<const Segment> segments, SampleBits& live, SampleBits& blocked) {
  Segment asked[kChunk];
  uint32_t number[kChunk];
  size_t count = 0;
  for (size_t i : live) asked[count] = segments[i], number[count++] = static_cast<uint32_t>(i);
  Visibility answers[kChunk];
  object.classify(std::span(asked).first(count), answers);
  live = {};
  for (size_t k = 0; k < count; ++k) {
    live.set(number[k], answers[k] == Visibility::unclassified);
    blocked.set(number[k], answers[k] == Visibility::blocked);
  }
}

// Bundles, a chunk at a time.
template <class Bundle>
Bundle part_of(const Bundle& bundle, size_t first, size_t count) {
  Bundle part = bundle;
  part.x = bundle.x.subspan(first, count), part.y = bundle.y.subspan(first, count),
  part.z = bundle.z.subspan(first, count);
  return part;
}
QuadBundle part_of(const QuadBundle& bundle, size_t first, size_t count) {
  QuadBundle part = bundle;
  part.u = bundle.u.subspan(first, count), part.v = bundle.v.subspan(first, count);
  return part;
}

// Directions of a part of a bundle, padded to whole runs.
struct Directions {
  alignas(64) float of[3][kChunk];

  template <class Bundle>
  explicit Directions(const Bundle& part) {
    const size_t padded = (part.size() + kRun - 1) / kRun * kRun;
    for (size_t a = 0; a < 3; ++a) {
      for (size_t i = 0; i < part.size(); ++i) of[a][i] = direction_of(part, i, a);
      std::fill(of[a] + part.size(), of[a] + padded, of[a][part.size() - 1]);
    }
  }
};

template <class Bundle>
Fan fan_of(const Bundle& part, const Directions& directions, const SampleBits& live) {
  return {{part.origin[0], part.origin[1], part.origin[2]},
          {directions.of[0], directions.of[1], directions.of[2]},
          part.size(),
          live};
}

// decide(fan) of each chunk is stored.
template <class Bundle, class Decide>
void by_fans(const Bundle& bundle, uint64_t* words, const Decide& decide) {
  for (size_t first = 0; first < bundle.size(); first += kChunk) {
    const Bundle part = part_of(bundle, first, std::min(kChunk, bundle.size() - first));
    const Directions directions(part);
    decide(fan_of(part, directions, SampleBits::first(part.size()))).store(part.size(), words + first / 64);
  }
}

template <class Bundle, class Classify>
void occluded_bundle(const ObjectData& object, const Bundle& bundle, uint64_t* blocked, bool look_up,
                     const Classify& classify) {
  for (size_t first = 0; first < bundle.size(); first += kChunk) {
    const Bundle part = part_of(bundle, first, std::min(kChunk, bundle.size() - first));
    SampleBits live = SampleBits::first(part.size()), hit{};
    if (look_up) {
      uint64_t words[2][words_for(kChunk)] = {};
      const auto some = words_for(part.size());
      classify(part, std::span(words[0]).first(some), std::span(words[1]).first(some));
      hit = SampleBits::of(words[0]), live = SampleBits::of(words[1]);
    }
    if (live.any()) hit |= object.trace->fan(object.traced, fan_of(part, Directions(part), live));
    hit.store(part.size(), blocked + first / 64);
  }
}

}  // namespace

Visibility Object::classify(const Segment& segment) const noexcept {
  return data_->classify_one(data_->frame, data_->tree, segment);
}

void Object::classify(std::span<const Segment> segments, std::span<Visibility> answers) const noexcept {
  assert(answers.size() >= segments.size());
  if (!this->answers()) return void(std::fill_n(answers.data(), segments.size(), Visibility::unclassified));
  const LookUp at = data_->look_up();
  at.kernels->segments(data_->frame, *at.tree, segments, answers.data());
}

void Object::classify(const SegmentArrays& segments, std::span<Visibility> answers) const noexcept {
  assert(answers.size() >= segments.count);
  if (!this->answers()) return void(std::fill_n(answers.data(), segments.count, Visibility::unclassified));
  const LookUp at = data_->look_up();
  at.kernels->arrays(data_->frame, *at.tree, segments, answers.data());
}

void Object::classify(const QuadBundle& bundle, std::span<uint64_t> blocked,
                      std::span<uint64_t> unclassified) const noexcept {
  assert(fits(bundle, blocked) && fits(bundle, unclassified));
  if (!answers()) return leave_all(bundle.size(), blocked.data(), unclassified.data());
  data_->kernels->quad(data_->frame, data_->look_up(), bundle, blocked.data(), unclassified.data());
}

void Object::classify(const SphereBundle& bundle, std::span<uint64_t> blocked,
                      std::span<uint64_t> unclassified) const noexcept {
  assert(fits(bundle, blocked) && fits(bundle, unclassified));
  if (!answers()) return leave_all(bundle.size(), blocked.data(), unclassified.data());
  data_->kernels->sphere(data_->frame, data_->look_up(), bundle, blocked.data(), unclassified.data());
}

bool Object::occluded(const Segment& segment, From from) const noexcept {
  if (!data_->look_up_one[static_cast<size_t>(from)]) return data_->trace->one(data_->traced, segment);
  if (data_->box_first)
    return data_->trace->one_looked_up(data_->traced, {data_->frame, data_->tree, data_->classify_one}, segment);
  const Visibility answer = classify(segment);
  return answer == Visibility::unclassified ? data_->trace->one(data_->traced, segment) : answer == Visibility::blocked;
}

void Object::occluded(std::span<const Segment> segments, std::span<uint64_t> blocked, From from) const noexcept {
  assert(has_words_for(segments.size(), blocked));
  for (size_t first = 0; first < segments.size(); first += kChunk) {
    const auto part = segments.subspan(first, std::min(kChunk, segments.size() - first));
    SampleBits live = SampleBits::first(part.size()), hit{};
    if (data_->look_up_arrays[static_cast<size_t>(from)]) {
      live = data_->trace->without_passing(data_->box, part.data(), live);
      look_up(*this, part, live, hit);
    }
    if (live.any()) hit |= data_->trace->array(data_->traced, part.data(), live);
    hit.store(part.size(), blocked.data() + first / 64);
  }
}

void Object::occluded(const QuadBundle& bundle, std::span<uint64_t> blocked, From from) const noexcept {
  assert(fits(bundle, blocked));
  occluded_bundle(*data_, bundle, blocked.data(), data_->look_up_bundles[static_cast<size_t>(from)],
                  [&](const QuadBundle& part, auto b, auto u) { classify(part, b, u); });
}
void Object::occluded(const SphereBundle& bundle, std::span<uint64_t> blocked, From from) const noexcept {
  assert(fits(bundle, blocked));
  occluded_bundle(*data_, bundle, blocked.data(), data_->look_up_bundles[static_cast<size_t>(from)],
                  [&](const SphereBundle& part, auto b, auto u) { classify(part, b, u); });
}
// There is no light whose lines could be looked up together.
void Object::occluded(const PointBundle& bundle, std::span<uint64_t> blocked, From) const noexcept {
  assert(fits(bundle, blocked));
  occluded_bundle(*data_, bundle, blocked.data(), false, [](const PointBundle&, auto, auto) {});
}
bool Object::has_hierarchy() const noexcept { return static_cast<bool>(data_->traced.view); }

bool Object::has_horizons() const noexcept { return static_cast<bool>(data_->horizons.view); }

Visibility Object::classify_self(const Segment& segment, uint32_t primitive) const noexcept {
  return data_->horizon->one(data_->horizons, segment, primitive) ? Visibility::clear : Visibility::unclassified;
}

bool Object::occluded_self(const Segment& segment, uint32_t primitive) const noexcept {
  return classify_self(segment, primitive) != Visibility::clear && data_->trace->one(data_->traced, segment);
}

void Object::classify_self(std::span<const Segment> segments, std::span<const uint32_t> primitives,
                           std::span<Visibility> answers) const noexcept {
  assert(answers.size() >= segments.size() && primitives.size() >= segments.size());
  std::fill_n(answers.data(), segments.size(), Visibility::unclassified);
  for (size_t first = 0; has_horizons() && first < segments.size(); first += kChunk)
    for (size_t i : data_->horizon->array(data_->horizons, segments.data() + first, primitives.data() + first,
                                          std::min(kChunk, segments.size() - first)))
      answers[first + i] = Visibility::clear;
}

void Object::occluded_self(std::span<const Segment> segments, std::span<const uint32_t> primitives,
                           std::span<uint64_t> blocked) const noexcept {
  assert(has_words_for(segments.size(), blocked) && primitives.size() >= segments.size());
  for (size_t first = 0; first < segments.size(); first += kChunk) {
    const size_t count = std::min(kChunk, segments.size() - first);
    const Segment* const part = segments.data() + first;
    SampleBits left = SampleBits::first(count);
    if (has_horizons())
      left = left.without(data_->horizon->array(data_->horizons, part, primitives.data() + first, count));
    const SampleBits met = left.any() ? data_->trace->array(data_->traced, part, left) : SampleBits{};
    met.store(count, blocked.data() + first / 64);
  }
}

namespace {

template <class Bundle>
void classify_self_bundle(const ObjectData& object, const Bundle& bundle, uint32_t primitive, uint64_t* unclassified) {
  by_fans(bundle, unclassified, [&](const Fan& fan) {
    return object.horizons.view ? fan.live.without(object.horizon->fan(object.horizons, fan, primitive)) : fan.live;
  });
}

template <class Bundle>
void occluded_self_bundle(const ObjectData& object, const Bundle& bundle, uint32_t primitive, uint64_t* blocked) {
  by_fans(bundle, blocked, [&](Fan fan) {
    if (object.horizons.view) fan.live = fan.live.without(object.horizon->fan(object.horizons, fan, primitive));
    return fan.live.any() ? object.trace->fan(object.traced, fan) : SampleBits{};
  });
}

}  // namespace

void Object::classify_self(const QuadBundle& bundle, uint32_t primitive,
                           std::span<uint64_t> unclassified) const noexcept {
  assert(fits(bundle, unclassified));
  classify_self_bundle(*data_, bundle, primitive, unclassified.data());
}
void Object::classify_self(const SphereBundle& bundle, uint32_t primitive,
                           std::span<uint64_t> unclassified) const noexcept {
  assert(fits(bundle, unclassified));
  classify_self_bundle(*data_, bundle, primitive, unclassified.data());
}
void Object::classify_self(const PointBundle& bundle, uint32_t primitive,
                           std::span<uint64_t> unclassified) const noexcept {
  assert(fits(bundle, unclassified));
  classify_self_bundle(*data_, bundle, primitive, unclassified.data());
}
void Object::occluded_self(const QuadBundle& bundle, uint32_t primitive, std::span<uint64_t> blocked) const noexcept {
  assert(fits(bundle, blocked));
  occluded_self_bundle(*data_, bundle, primitive, blocked.data());
}
void Object::occluded_self(const SphereBundle& bundle, uint32_t primitive, std::span<uint64_t> blocked) const noexcept {
  assert(fits(bundle, blocked));
  occluded_self_bundle(*data_, bundle, primitive, blocked.data());
}
void Object::occluded_self(const PointBundle& bundle, uint32_t primitive, std::span<uint64_t> blocked) const noexcept {
  assert(fits(bundle, blocked));
  occluded_self_bundle(*data_, bundle, primitive, blocked.data());
}

std::string_view Object::name() const noexcept { return data_->name; }
const ObjectRecord& Object::record() const noexcept { return *data_->record; }
bool Object::answers() const noexcept { return data_->kernels != nullptr; }

}  // namespace vcd
