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

#include "hierarchy/box_lanes-inl.h"
#include "hierarchy/trace-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vcd {
namespace HWY_NAMESPACE {

constexpr uint8_t kFlights = 24;  // segments that are on their way together

// Source says which hierarchies a segment is to be asked of:
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
    Queue free, nodes, leaves;
    for (uint8_t k = 0; k < kFlights; ++k) free.add(k);
    for (;;) {
      while (!free.empty() && next < count) {
        const uint8_t k = free.take();
        (begin(k, waiting[next++]) ? nodes : free).add(k);
      }
      if (nodes.empty() && leaves.empty()) return blocked_;
      Queue later_nodes, later_leaves;
      for (uint8_t k : nodes) {
        Flight& f = flights_[k];
        const uint32_t met = children_met(f.object->view.node(f.child), f.ray);
        f.rests[f.depth] = {f.child, met};
        f.depth += met != 0;
        go_on(k, later_nodes, later_leaves, free);
      }
      for (uint8_t k : leaves) {
        Flight& f = flights_[k];
        if (child_meets(f.object->view, f.child, f.ray, f.segment)) {
          blocked_.set(f.index);
          free.add(k);
        } else {
          go_on(k, later_nodes, later_leaves, free);
        }
      }
      nodes = later_nodes, leaves = later_leaves;
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
    void add(uint8_t k) { items_[count_++] = k; }
    uint8_t take() { return items_[--count_]; }
    const uint8_t* begin() const { return items_.data(); }
    const uint8_t* end() const { return items_.data() + count_; }

   private:
    std::array<uint8_t, kFlights> items_;
    size_t count_ = 0;
  };

  // False if the segment is answered; likewise enter().
  HWY_INLINE bool begin(uint8_t k, uint32_t index) {
    flights_[k].index = index;
    if (source_.begin(k, index)) return enter(k);
    blocked_.set(index);
    return false;
  }

  // On to the root of the next hierarchy that the flight's segment comes near.
  HWY_INLINE bool enter(uint8_t k) {
    Flight& f = flights_[k];
    for (;;) {
      const Next next = source_.next(k, f.segment);
      if (!next.object) return blocked_.set(f.index, next.blocked), false;
      const Nearness nearness = make_near_ray(*next.object, f.segment, f.ray);
      if (nearness == Nearness::misses) continue;
      if (nearness == Nearness::far) {
        if (!occluded_scalar(*next.object, f.segment)) continue;
        return blocked_.set(f.index), false;
      }
      f.object = next.object, f.child = kRootUnit, f.depth = 0;
      return true;
    }
  }

  HWY_INLINE void go_on(uint8_t k, Queue& nodes, Queue& leaves, Queue& free) {
    const uint32_t child = step(flights_[k]);
    if (child == kNoChild) (enter(k) ? nodes : free).add(k);
    else (child & kLeafChild ? leaves : nodes).add(k);
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
};

// All segments are asked of one hierarchy, in its own frame.
class OneHierarchy {
 public:
  OneHierarchy(const Traced& object, const Segment* segments) : object_(object), segments_(segments) {}

  HWY_INLINE bool begin(uint8_t k, uint32_t index) { return from_[k] = segments_ + index, true; }
  HWY_INLINE Next next(uint8_t k, Segment& segment) {
    if (!from_[k]) return {nullptr, false};
    segment = *from_[k];
    from_[k] = nullptr;
    return {&object_, false};
  }

 private:
  const Traced& object_;
  const Segment* const segments_;
  const Segment* from_[kFlights];  // null once it was asked
};

SampleBits OccludedArray(const Traced& object, const Segment* segments, const SampleBits& live) noexcept {
  OneHierarchy source(object, segments);
  return Stream(source).blocked(WithoutPassing(object, segments, live));
}

}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif
