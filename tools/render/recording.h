// The bundles of a picture, kept: to be timed again and again.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "renderer.h"

namespace vcd {

// Bundles one after the other in one array of segments.
class Recording {
 public:
  void append(const Bundle& bundle);
  size_t size() const { return places_.size(); }
  Bundle operator[](size_t i) const {
    const auto& [first, count, light, pixel, surface] = places_[i];
    return {std::span(segments_).subspan(first, count), std::span(u_).subspan(first, count), std::span(v_).subspan(first, count),
            light, pixel, surface};
  }
  uint64_t segment_count() const { return segments_.size(); }

 private:
  struct Place {
    size_t first, count;
    uint32_t light, pixel, surface;
  };
  std::vector<Segment> segments_;
  std::vector<float> u_, v_;
  std::vector<Place> places_;
};

// All bundles of a picture, in the order of its pixels.
Recording record(const World& world, RenderSettings settings);

// Which of these ways is the fastest for a caster: each is tried on the bundles of a small picture with a seed of its own, so
// that no ray of the picture itself is used.
Packets fastest_packets(const World& world, const RenderSettings& settings, const std::vector<Packets>& ways,
                        const std::function<std::unique_ptr<ShadowCaster>(Packets)>& make_caster);

}  // namespace vcd
