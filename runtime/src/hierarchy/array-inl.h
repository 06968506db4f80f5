// Arrays of segments through hierarchies: many on their way at once, a step of each in turn, so that the memory for
// one's next step is on its way while the others are looked at.
#if defined(VCD_RUNTIME_HIERARCHY_ARRAY_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VCD_RUNTIME_HIERARCHY_ARRAY_INL_H
#undef VCD_RUNTIME_HIERARCHY_ARRAY_INL_H
#else
#define VCD_RUNTIME_HIERARCHY_ARRAY_INL_H
#endif

#include <array>
#include <bit>
#include <utility>

#include "hierarchy/near_rays-inl.h"
#include "hierarchy/trace-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vcd {
namespace HWY_NAMESPACE {

constexpr uint8_t kFlights = 32;  // segments that are on their way together

// Source says which hierarchies a segment is to be asked of:
//   kOneObject: one, the same for all.
//   bool begin(flight, index): the flight takes this segment; false if it is blocked, as is known already.
//   Next next(flight, segment): the next hierarchy for the flight's segment, which it puts in that hierarchy's frame.
struct Next {
  const Traced* object;  // null: no more, and `blocked` is the segment's answer
  bool blocked;
};

template <class Source>
class Stream {
 public:
  explicit Stream(Source& source) : source_(source) {}

  // Those of `live` that are blocked.
  SampleBits blocked(const SampleBits& live) {
    std::array<uint16_t, kChunk> waiting;
    size_t count = 0, next = 0;
    for (size_t i : live) waiting[count++] = static_cast<uint16_t>(i);
    for (uint8_t k = 0; k < kFlights; ++k) free_.add(k);
    for (;;) {
      while (!free_.empty() && next < count) begin(free_.take(), waiting[next++]);
      if (entering_.count() >= kWidth || (nodes_.empty() && leaves_.empty())) {
        if (entering_.empty()) return blocked_;
        enter();
      }
      const Queue nodes = std::exchange(nodes_, {}), leaves = std::exchange(leaves_, {});
      for (uint8_t k : nodes) {
        Flight& f = flights_[k];
        const uint32_t met = children_met(f.object->view.node(f.child), f.ray);
        f.rests[f.depth] = {f.child, met};
        f.depth += met != 0;
        go_on(k);
      }
      for (uint8_t k : leaves) {
        Flight& f = flights_[k];
        if (!child_meets(f.object->view, f.child, f.ray, f.segment)) go_on(k);
        else end(k, true);
      }
    }
  }

 private:
  struct Flight {
    NearRay ray;
    const Traced* object;  // where it is
    Segment segment;       // in that object's frame
    uint32_t index;        // of the segment
    uint32_t child;        // to look at next
    uint32_t depth;
    struct Rest {
      uint32_t node, met;
    } rests[kMostLevels];
  };

  class Queue {
   public:
    bool empty() const { return count_ == 0; }
    size_t count() const { return count_; }
    void add(uint8_t k) { items_[count_++] = k; }
    uint8_t take() { return items_[--count_]; }
    const uint8_t* begin() const { return items_.data(); }
    const uint8_t* end() const { return items_.data() + count_; }

   private:
    std::array<uint8_t, kFlights> items_;
    size_t count_ = 0;
  };

  HWY_INLINE void begin(uint8_t k, uint32_t index) {
    flights_[k].index = index;
    if (source_.begin(k, index)) entering_.add(k);
    else end(k, true);
  }
  HWY_INLINE void end(uint8_t k, bool blocked) {
    blocked_.set(flights_[k].index, blocked);
    free_.add(k);
  }

  // On to the roots of the next hierarchies that the flights' segments come near.
  HWY_INLINE void enter() {
    HWY_ALIGN Segment segments[kWidth];
    const Traced* objects[kWidth];
    uint8_t flight[kWidth];
    size_t count = 0;
    while (count < kWidth && !entering_.empty()) {
      const uint8_t k = entering_.take();
      const Next next = source_.next(k, segments[count]);
      if (next.object) objects[count] = next.object, flight[count++] = k;
      else end(k, next.blocked);
    }
    if (count == 0) return;
    for (size_t i = count; i < kWidth; ++i) objects[i] = objects[0], segments[i] = segments[0];
    const NearRays rays(boxes_of(objects), load(segments));
    for (size_t i = 0; i < count; ++i) {
      const uint8_t k = flight[i];
      Flight& f = flights_[k];
      Nearness nearness = Nearness::near;
      if (HWY_LIKELY(rays.near() >> i & 1)) rays.store(i, f.ray);
      else if (rays.misses() >> i & 1) nearness = Nearness::misses;
      else nearness = make_near_ray(*objects[i], segments[i], f.ray);
      if (nearness == Nearness::near) {
        f.segment = segments[i], f.object = objects[i], f.child = kRootUnit, f.depth = 0;
        nodes_.add(k);
      } else if (nearness == Nearness::far && occluded_scalar(*objects[i], segments[i])) {
        end(k, true);
      } else {
        leave(k);
      }
    }
  }

  // The flight's segment is not blocked by where it is.
  HWY_INLINE void leave(uint8_t k) {
    if constexpr (Source::kOneObject) end(k, false);
    else entering_.add(k);
  }

  HWY_INLINE BoxLanes boxes_of(const Traced* const (&objects)[kWidth]) const {
    if constexpr (Source::kOneObject) return all(*objects[0]);
    const hn::FixedTag<float, 4> four;
    HWY_ALIGN float min[4 * kWidth];
    HWY_ALIGN float max[4 * kWidth];
    HWY_ALIGN float reach[kWidth];
    for (size_t i = 0; i < kWidth; ++i) {
      hn::Store(hn::LoadU(four, objects[i]->min), four, min + 4 * i);
      hn::Store(hn::LoadU(four, objects[i]->max), four, max + 4 * i);
      reach[i] = objects[i]->reach;
    }
    BoxLanes boxes;
    Floats none;
    hn::LoadInterleaved4(F(), min, boxes.min[0], boxes.min[1], boxes.min[2], none);
    hn::LoadInterleaved4(F(), max, boxes.max[0], boxes.max[1], boxes.max[2], none);
    boxes.reach = hn::Load(F(), reach);
    return boxes;
  }

  HWY_INLINE void go_on(uint8_t k) {
    const uint32_t child = step(flights_[k]);
    if (child == kNoChild) leave(k);
    else (child & kLeafChild ? leaves_ : nodes_).add(k);
  }

  // The next child of a flight, on its way into the cache; kNoChild at its end.
  HWY_INLINE uint32_t step(Flight& flight) const {
    if (flight.depth == 0) return kNoChild;
    typename Flight::Rest& rest = flight.rests[flight.depth - 1];
    flight.child = flight.object->view.node(rest.node).child[std::countr_zero(rest.met)];
    rest.met &= rest.met - 1;
    flight.depth -= rest.met == 0;
    const std::byte* const bytes = flight.object->view.at(flight.child);
    for (size_t unit = 0; unit < units_of(kRootUnit); ++unit) hwy::Prefetch(bytes + unit * kUnitBytes);
    return flight.child;
  }

  Source& source_;
  SampleBits blocked_{};
  Flight flights_[kFlights];
  Queue free_, entering_, nodes_, leaves_;
};

// All segments are asked of one hierarchy, in its own frame.
class OneHierarchy {
 public:
  static constexpr bool kOneObject = true;

  OneHierarchy(const Traced& object, const Segment* segments) : object_(object), segments_(segments) {}

  HWY_INLINE bool begin(uint8_t k, uint32_t index) { return from_[k] = segments_ + index, true; }
  HWY_INLINE Next next(uint8_t k, Segment& segment) const { return segment = *from_[k], Next{&object_, false}; }

 private:
  const Traced& object_;
  const Segment* const segments_;
  const Segment* from_[kFlights];
};

SampleBits OccludedArray(const Traced& object, const Segment* segments, const SampleBits& live) noexcept {
  OneHierarchy source(object, segments);
  return Stream(source).blocked(WithoutPassing(object, segments, live));
}

}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif
