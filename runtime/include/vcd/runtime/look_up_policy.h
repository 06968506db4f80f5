// Whether to look up at all: from what the first queries cost, or as the renderer says.
//
//   vcd::LookUpPolicy policy;                        // one for each object and thread, or for a whole scene
//   if (policy.look_up(vcd::From::outside)) …        // ask the sidecar first, or the BVH at once
//   policy.took(vcd::From::outside, looked_up, nanoseconds, segments);   // while it is undecided()
//
// A look-up that seldom answers only costs time. How often it answers depends on where segments begin, so that is
// decided for each kind by itself: the first batches go either way in turn, and then all go the cheaper one. Batches
// are a bundle, an array, or some hundred single rays: not less than the clock can measure.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace vcd {

// Where segments begin.
enum class From : uint8_t {
  outside,  // of the object's box
  inside,   // the box, but not on the object
  self,     // on the object itself
};

class LookUpPolicy {
 public:
  enum class Use : uint8_t { measured, always, never };

  // Look-ups have to take less than this share of the BVH's time: what is nearly equal is left as it would be without
  // them.
  static constexpr double kWorthwhile = 0.97;

  // Segments from the object itself are not looked up unless told otherwise: their line meets the object where it
  // begins, so that no cell of it is clear, and it does not pierce the box.
  explicit LookUpPolicy(Use outside = Use::measured, Use inside = Use::measured, Use self = Use::never)
      : kinds_{Kind{outside}, Kind{inside}, Kind{self}} {}

  void fix(From from, Use use) { kind(from) = Kind{use}; }

  // Whether to look the next batch up. The same until took() is told of it.
  bool look_up(From from) const {
    const Kind& k = kind(from);
    // In turn: yes, no, no, yes, …
    return k.use == Use::measured ? (k.batches & 1) == (k.batches >> 1 & 1) : k.use == Use::always;
  }
  bool undecided(From from) const { return kind(from).use == Use::measured; }

  // What a batch cost, tracing included. Does nothing once it is decided.
  void took(From from, bool looked_up, double nanoseconds, size_t segments) {
    Kind& k = kind(from);
    if (k.use != Use::measured || segments == 0) return;
    ++k.batches;
    Way& way = k.ways[looked_up];
    const auto n = static_cast<double>(segments);
    // A batch that the system interrupted must not decide.
    if (way.batches >= 8) nanoseconds = std::min(nanoseconds, 4 * way.nanoseconds / way.segments * n);
    way.nanoseconds += nanoseconds, way.segments += n, ++way.batches;
    if (k.ways[0].batches < kBatches || k.ways[1].batches < kBatches) return;
    k.use = k.ways[1].nanoseconds * k.ways[0].segments <= kWorthwhile * k.ways[0].nanoseconds * k.ways[1].segments
                ? Use::always
                : Use::never;
  }

 private:
  static constexpr uint32_t kBatches = 64;  // each way
  struct Way {
    double nanoseconds = 0, segments = 0;
    uint32_t batches = 0;
  };
  struct Kind {
    Use use;
    uint32_t batches = 0;
    std::array<Way, 2> ways = {};  // traced at once; looked up first
  };
  Kind& kind(From from) { return kinds_[static_cast<size_t>(from)]; }
  const Kind& kind(From from) const { return kinds_[static_cast<size_t>(from)]; }

  std::array<Kind, 3> kinds_;
};

}  // namespace vcd
