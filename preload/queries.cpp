// Embree's shadow rays: the view of the scene is asked first, Embree for what is left. No locks.
#include <algorithm>
#include <array>
#include <bit>
#include <chrono>
#include <cstring>
#include <limits>

#include "counts.h"
#include "next.h"
#include "view.h"

namespace {

using vcd::From;
using vcd::Segment;
using vcd::Visibility;
using vcd::preload::Choice;
using vcd::preload::Count;
using vcd::preload::View;

constexpr float kBlocked = -std::numeric_limits<float>::infinity();  // as Embree says it, in tfar
constexpr size_t kMost = View::kMost;

// One ray of any of Embree's layouts: member m of RTCRay is at first[m * step].
struct Lane {
  float* first;
  size_t step;

  float& member(size_t m) const { return first[m * step]; }
  float& tfar() const { return member(8); }
  uint32_t mask() const { return std::bit_cast<uint32_t>(member(9)); }
  Segment segment() const {
    return {{member(0), member(1), member(2)}, member(3), {member(4), member(5), member(6)}, tfar()};
  }
  RTCRay copy() const {
    RTCRay ray;
    float members[12];
    for (size_t m = 0; m < 12; ++m) std::memcpy(&members[m], &member(m), sizeof(float));
    static_assert(sizeof ray == sizeof members);
    std::memcpy(&ray, members, sizeof ray);
    return ray;
  }
};

template <class Rays>
Lane lane_of(Rays& rays, size_t i) {
  return {rays.org_x + i, sizeof rays.tfar / sizeof(float)};
}
Lane lane_of(RTCRay& ray) { return {&ray.org_x, 1}; }

void tally(Count which, size_t rays) { vcd::preload::thread_counts().add(which, rays); }

// What is to be traced yet, a bit for each ray.
struct Left {
  uint64_t everywhere = 0;  // through the program's scene
  uint64_t rest = 0;        // through View::rest()
};

// What becomes of a ray; tfar says so if it is blocked.
Count finish(const View& view, const RTCIntersectContext* context, Lane lane, Visibility answer) {
  if (answer == Visibility::clear) return view.rest() ? Count::clear_but_rest : Count::clear;
  if (answer == Visibility::unclassified) return Count::unclassified;
  if ((context && context->filter) || !view.may_block(lane.mask())) return Count::held_back;
  lane.tfar() = kBlocked;
  return Count::blocked;
}

// Answers those of the rays lane(0) … lane(count - 1) that `asked` has a bit for.
template <class GetLane>
Left answer(const View& view, const RTCIntersectContext* context, size_t count, uint64_t asked, const GetLane& lane) {
  std::array<Segment, kMost> segments;
  std::array<Visibility, kMost> answers;
  std::array<uint8_t, kMost> indices;
  size_t size = 0;
  for (size_t i = 0; i < count; ++i) {
    if ((asked >> i & 1) == 0) continue;
    segments[size] = lane(i).segment();
    if (segments[size].t_min > segments[size].t_max) continue;  // empty: Embree leaves it as it is
    indices[size++] = static_cast<uint8_t>(i);
  }
  view.classify(std::span(segments).first(size), std::span(answers).first(size));
  std::array<uint32_t, static_cast<size_t>(Count::kCount)> counts = {};
  Left left;
  for (size_t k = 0; k < size; ++k) {
    if (!(segments[k].t_min >= 0)) answers[k] = Visibility::unclassified;  // Embree does not allow it
    const Count became = finish(view, context, lane(indices[k]), answers[k]);
    ++counts[static_cast<size_t>(became)];
    left.everywhere |= uint64_t{became == Count::unclassified || became == Count::held_back} << indices[k];
    left.rest |= uint64_t{became == Count::clear_but_rest} << indices[k];
  }
  for (size_t i = 0; i < counts.size(); ++i)
    if (counts[i] > 0) tally(static_cast<Count>(i), counts[i]);
  return left;
}

// Asks, and finds out what it costs as long as that is not known.
template <class Ask>
void timed(Choice& choice, From from, bool looked_up, size_t rays, const Ask& ask) {
  if (!choice.undecided(from)) return ask();
  const auto begin = std::chrono::steady_clock::now();
  ask();
  choice.took(from, looked_up,
              std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - begin).count(), rays);
}

// look_up() asks the view first, trace() asks Embree at once.
template <class LookUp, class Trace>
void cheaper(const View& view, From from, size_t rays, const LookUp& look_up, const Trace& trace) {
  Choice& choice = vcd::preload::choice_of(view.id());
  if (choice.look_up(from)) return timed(choice, from, true, rays, look_up);
  tally(Count::not_looked_up, rays);
  timed(choice, from, false, rays, trace);
}

// The same for a stream of `count` items of `width` rays each; look_up(first, size) and trace(first, size) ask a part.
template <class LookUp, class Trace>
void cheaper_stream(const View& view, size_t count, size_t width, const LookUp& look_up, const Trace& trace) {
  constexpr size_t kBatch = 1024;  // rays, as long as the cheaper way is not known
  for (size_t first = 0, size = 0; first < count; first += size) {
    size = count - first;
    if (vcd::preload::choice_of(view.id()).undecided(From::outside))
      size = std::min(size, (kBatch + width - 1) / width);
    cheaper(
        view, From::outside, size * width, [&] { look_up(first, size); }, [&] { trace(first, size); });
  }
}

uint64_t first_bits(size_t count) { return count == 64 ? ~uint64_t{0} : (uint64_t{1} << count) - 1; }

template <size_t kWidth, class Rays, class Trace>
void trace_packet(Trace trace, uint64_t left, RTCScene scene, RTCIntersectContext* context, Rays* rays) {
  if (left == 0) return;
  alignas(64) int valid[kWidth];
  for (size_t i = 0; i < kWidth; ++i) valid[i] = (left >> i & 1) != 0 ? -1 : 0;
  trace(valid, scene, context, rays);
}

template <size_t kWidth, class Rays, class Trace>
void occluded_packet(Trace trace, const int* valid, RTCScene scene, RTCIntersectContext* context, Rays* rays) {
  uint64_t asked = 0;
  for (size_t i = 0; i < kWidth; ++i) asked |= uint64_t{valid[i] == -1} << i;
  const View* view = vcd::preload::view_of(scene);
  if (!view)
    return tally(Count::other_scenes, static_cast<size_t>(std::popcount(asked))), trace(valid, scene, context, rays);
  const auto look_up = [&] {
    const Left left = answer(*view, context, kWidth, asked, [&](size_t i) { return lane_of(*rays, i); });
    trace_packet<kWidth>(trace, left.everywhere, scene, context, rays);
    trace_packet<kWidth>(trace, left.rest, view->rest(), context, rays);
  };
  cheaper(*view, From::outside, static_cast<size_t>(std::popcount(asked)), look_up,
          [&] { trace(valid, scene, context, rays); });
}

// Those of up to kMost rays that are left, as a stream of copies.
template <class GetLane>
void trace_left(RTCScene scene, RTCIntersectContext* context, uint64_t left, const GetLane& lane) {
  std::array<RTCRay, kMost> rays;
  unsigned count = 0;
  for (uint64_t bits = left; bits; bits &= bits - 1) rays[count++] = lane(std::countr_zero(bits)).copy();
  if (count == 0) return;
  VCD_NEXT(rtcOccluded1M)(scene, context, rays.data(), count, sizeof(RTCRay));
  count = 0;
  for (uint64_t bits = left; bits; bits &= bits - 1) lane(std::countr_zero(bits)).tfar() = rays[count++].tfar;
}

template <class GetLane>
void occluded_stream(const View& view, RTCScene scene, RTCIntersectContext* context, size_t count,
                     const GetLane& lane) {
  for (size_t first = 0; first < count; first += kMost) {
    const size_t size = std::min(kMost, count - first);
    const auto of_chunk = [&](size_t i) { return lane(first + i); };
    const Left left = answer(view, context, size, first_bits(size), of_chunk);
    trace_left(scene, context, left.everywhere, of_chunk);
    trace_left(view.rest(), context, left.rest, of_chunk);
  }
}

void occluded_one(const View& view, RTCScene scene, RTCIntersectContext* context, RTCRay& ray) {
  const Lane lane = lane_of(ray);
  const Visibility answer = ray.tnear >= 0 ? view.classify(lane.segment()) : Visibility::unclassified;
  const Count became = finish(view, context, lane, answer);
  tally(became, 1);
  if (became == Count::clear || became == Count::blocked) return;
  VCD_NEXT(rtcOccluded1)(became == Count::clear_but_rest ? view.rest() : scene, context, &ray);
}

}  // namespace

extern "C" {

void rtcOccluded1(RTCScene scene, RTCIntersectContext* context, RTCRay* ray) {
  const View* view = vcd::preload::view_of(scene);
  if (!view) return tally(Count::other_scenes, 1), VCD_NEXT(rtcOccluded1)(scene, context, ray);
  if (ray->tnear > ray->tfar) return;  // empty: Embree leaves it as it is
  cheaper(
      *view, view->from(&ray->org_x), 1, [&] { occluded_one(*view, scene, context, *ray); },
      [&] {
        VCD_NEXT(rtcOccluded1)
        (scene, context, ray);
      });
}
void rtcOccluded4(const int* valid, RTCScene scene, RTCIntersectContext* context, RTCRay4* rays) {
  occluded_packet<4>(VCD_NEXT(rtcOccluded4), valid, scene, context, rays);
}
void rtcOccluded8(const int* valid, RTCScene scene, RTCIntersectContext* context, RTCRay8* rays) {
  occluded_packet<8>(VCD_NEXT(rtcOccluded8), valid, scene, context, rays);
}
void rtcOccluded16(const int* valid, RTCScene scene, RTCIntersectContext* context, RTCRay16* rays) {
  occluded_packet<16>(VCD_NEXT(rtcOccluded16), valid, scene, context, rays);
}
void rtcOccluded1M(RTCScene scene, RTCIntersectContext* context, RTCRay* rays, unsigned count, size_t stride) {
  const View* view = vcd::preload::view_of(scene);
  if (!view) return tally(Count::other_scenes, count), VCD_NEXT(rtcOccluded1M)(scene, context, rays, count, stride);
  const auto at = [=](size_t i) { return reinterpret_cast<RTCRay*>(reinterpret_cast<std::byte*>(rays) + i * stride); };
  cheaper_stream(
      *view, count, 1,
      [&](size_t first, size_t size) {
        occluded_stream(*view, scene, context, size, [&](size_t i) { return lane_of(*at(first + i)); });
      },
      [&](size_t first, size_t size) {
        VCD_NEXT(rtcOccluded1M)(scene, context, at(first), static_cast<unsigned>(size), stride);
      });
}
void rtcOccluded1Mp(RTCScene scene, RTCIntersectContext* context, RTCRay** rays, unsigned count) {
  const View* view = vcd::preload::view_of(scene);
  if (!view) return tally(Count::other_scenes, count), VCD_NEXT(rtcOccluded1Mp)(scene, context, rays, count);
  cheaper_stream(
      *view, count, 1,
      [&](size_t first, size_t size) {
        occluded_stream(*view, scene, context, size, [&](size_t i) { return lane_of(*rays[first + i]); });
      },
      [&](size_t first, size_t size) {
        VCD_NEXT(rtcOccluded1Mp)(scene, context, rays + first, static_cast<unsigned>(size));
      });
}
void rtcOccludedNM(RTCScene scene, RTCIntersectContext* context, RTCRayN* rays, unsigned width, unsigned count,
                   size_t stride) {
  const View* view = vcd::preload::view_of(scene);
  if (!view || width == 0)
    return tally(Count::other_scenes, size_t{width} * count),
           VCD_NEXT(rtcOccludedNM)(scene, context, rays, width, count, stride);
  const auto packet = [=](size_t i) {
    return reinterpret_cast<float*>(reinterpret_cast<std::byte*>(rays) + i * stride);
  };
  cheaper_stream(
      *view, count, width,
      [&](size_t first, size_t size) {
        occluded_stream(*view, scene, context, size * width, [&](size_t i) {
          return Lane{packet(first + i / width) + i % width, width};
        });
      },
      [&](size_t first, size_t size) {
        VCD_NEXT(rtcOccludedNM)
        (scene, context, reinterpret_cast<RTCRayN*>(packet(first)), width, static_cast<unsigned>(size), stride);
      });
}
void rtcOccludedNp(RTCScene scene, RTCIntersectContext* context, const RTCRayNp* rays, unsigned count) {
  tally(Count::other_scenes, count);  // members lie anywhere: left to Embree
  VCD_NEXT(rtcOccludedNp)(scene, context, rays, count);
}

}  // extern "C"
