// What the runtime promises of segments that begin on the object, whatever the sections say: the answers of the rule,
// by every kernel and way to ask.
#pragma once

#include <algorithm>
#include <vector>

#include <vcd/format/contents.h>
#include <vcd/runtime/sidecar.h>

#include "fuzz/fuzz.h"
#include "fuzz/hostile_floats.h"
#include "support/segments.h"

namespace vcd::fuzz {

// A segment with the triangle that it is said to begin on.
struct KeyedSegments {
  std::vector<Segment> segments;
  std::vector<uint32_t> keys;

  // Half of them begin above the triangle, if floats can say where that is.
  KeyedSegments(HostileFloats floats, const ObjectContents& object)
      : segments(hostile_segments(floats, *object.record)) {
    for (Segment& s : segments) {
      const uint32_t entries = object.horizon ? object.horizon.header().entries : 0;
      keys.push_back(floats.below(entries + 2));
      HorizonFrame f;
      if (keys.back() >= entries || floats.below(2) ||
          !frame_at(object.hierarchy, object.horizon.entries()[keys.back()].place, f))
        continue;
      for (int a = 0; a < 3; ++a)
        s.origin[a] =
            f.corner[a] + (f.u[1] + f.u[2]) / 3 * f.x[a] + (f.v[1] + f.v[2]) / 3 * f.y[a] + f.size * 0.1f * f.n[a];
      s.t_min = 0;
    }
  }
};

inline void require_horizons_as_the_rule(const std::vector<Sidecar>& by_kernel, size_t index,
                                         std::span<const uint8_t> bytes) {
  const ObjectContents& contents = by_kernel[0].contents().objects[index];
  const KeyedSegments keyed(HostileFloats(bytes), contents);
  const auto& [segments, keys] = keyed;
  std::vector<Visibility> rule;
  for (size_t i = 0; i < segments.size(); ++i) {
    const bool clear = contents.horizon && clear_of_horizon(contents.horizon, contents.hierarchy, segments[i], keys[i]);
    require(!clear || test::is_finite(segments[i]), "29: what is not finite is unclassified");
    rule.push_back(clear ? Visibility::clear : Visibility::unclassified);
  }
  for (const Sidecar& sidecar : by_kernel) {
    const Object object = sidecar.object(index);
    std::vector<Visibility> array(segments.size(), Visibility::blocked);
    object.classify_self(segments, keys, array);
    require(array == rule, "horizons answer by the rule, by every kernel");
    std::vector<float> columns[3];
    for (const Segment& s : segments)
      for (int a = 0; a < 3; ++a) columns[a].push_back(s.direction[a]);
    PointBundle bundle{{}, columns[0], columns[1], columns[2]};
    std::copy_n(segments[0].origin, 3, bundle.origin);
    std::vector<uint64_t> open((segments.size() + 63) / 64);
    object.classify_self(bundle, keys[0], open);
    for (size_t i = 0; i < segments.size(); ++i)
      require(
          (open[i / 64] >> i % 64 & 1) == (object.classify_self(segment_of(bundle, i), keys[0]) != Visibility::clear),
          "horizons answer bundles as their segments");
  }
}

}  // namespace vcd::fuzz
