// Arrays of segments through a hierarchy: many on their way at once, a step of each in turn, so that the memory for
// one's next step is on its way while the others are looked at.
#if defined(VCD_RUNTIME_HIERARCHY_ARRAY_INL_H) == defined(HWY_TARGET_TOGGLE)
#ifdef VCD_RUNTIME_HIERARCHY_ARRAY_INL_H
#undef VCD_RUNTIME_HIERARCHY_ARRAY_INL_H
#else
#define VCD_RUNTIME_HIERARCHY_ARRAY_INL_H
#endif

#include <array>
#include <bit>

#include "hierarchy/trace-inl.h"

HWY_BEFORE_NAMESPACE();
namespace vcd {
namespace HWY_NAMESPACE {

class ArrayTracer {
 public:
  ArrayTracer(const Traced& object, const Segment* segments) : object_(object), segments_(segments) {}

  SampleBits blocked(const SampleBits& live) {
    std::array<uint16_t, kChunk> waiting;
    size_t count = 0, next = 0;
    for (size_t i : live) waiting[count++] = static_cast<uint16_t>(i);
    Queue free, nodes, leaves;
    for (uint8_t k = 0; k < kTogether; ++k) free.add(k);
    for (;;) {
      while (!free.empty() && next < count) {
        const uint8_t k = free.take();
        if (begin(flights_[k], waiting[next++])) nodes.add(k);
        else free.add(k);
      }
      if (nodes.empty() && leaves.empty()) return blocked_;
      Queue later_nodes, later_leaves;
      const auto go_on = [&](uint8_t k) HWY_ATTR {
        const uint32_t child = step(flights_[k]);
        (child == kNoChild ? free : child & kLeafChild ? later_leaves : later_nodes).add(k);
      };
      for (uint8_t k : nodes) {
        Flight& f = flights_[k];
        const uint32_t met = children_met(object_.view.node(f.child), f.ray);
        f.rests[f.depth] = {f.child, met};
        f.depth += met != 0;
        go_on(k);
      }
      for (uint8_t k : leaves) {
        Flight& f = flights_[k];
        if (child_meets(object_.view, f.child, f.ray, segments_[f.index])) {
          blocked_.set(f.index);
          free.add(k);
        } else {
          go_on(k);
        }
      }
      nodes = later_nodes, leaves = later_leaves;
    }
  }

 private:
  static constexpr uint8_t kTogether = 24;

  struct Flight {
    NearRay ray;
    uint32_t index;  // of the segment
    uint32_t child;  // to look at next
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
    std::array<uint8_t, kTogether> items_;
    size_t count_ = 0;
  };

  // False if the segment is answered.
  HWY_INLINE bool begin(Flight& flight, uint32_t index) {
    const Segment& segment = segments_[index];
    flight.index = index, flight.child = kRootUnit, flight.depth = 0;
    const Nearness nearness = make_near_ray(object_, segment, flight.ray);
    if (nearness == Nearness::far) blocked_.set(index, occluded_scalar(object_, segment));
    return nearness == Nearness::near;
  }

  // The next child of a flight, on its way into the cache; kNoChild at its end.
  HWY_INLINE uint32_t step(Flight& flight) const {
    if (flight.depth == 0) return kNoChild;
    Flight::Rest& rest = flight.rests[flight.depth - 1];
    flight.child = object_.view.node(rest.node).child[std::countr_zero(rest.met)];
    rest.met &= rest.met - 1;
    flight.depth -= rest.met == 0;
    const std::byte* const bytes = object_.view.at(flight.child);
    for (size_t unit = 0; unit < units_of(kRootUnit); ++unit) hwy::Prefetch(bytes + unit * kUnitBytes);
    return flight.child;
  }

  const Traced& object_;
  const Segment* const segments_;
  SampleBits blocked_{};
  Flight flights_[kTogether];
};

SampleBits OccludedArray(const Traced& object, const Segment* segments, const SampleBits& live) noexcept {
  return ArrayTracer(object, segments).blocked(live);
}

}  // namespace HWY_NAMESPACE
}  // namespace vcd
HWY_AFTER_NAMESPACE();
#endif
