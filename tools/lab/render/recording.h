// The bundles of a picture, kept: to be timed again and again.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "renderer.h"

namespace vcd::render {

// Bundles one after the other in one array of segments.
class Recording {
 public:
  void append(const Bundle& bundle);
  size_t size() const { return places_.size(); }
  Bundle operator[](size_t i) const {
    const auto& [first, count, light, pixel, surface, primitive] = places_[i];
    return {std::span(segments_).subspan(first, count),
            std::span(u_).subspan(first, count),
            std::span(v_).subspan(first, count),
            light,
            pixel,
            surface,
            primitive};
  }
  uint64_t segment_count() const { return segments_.size(); }

 private:
  struct Place {
    size_t first, count;
    uint32_t light, pixel, surface, primitive;
  };
  std::vector<Segment> segments_;
  std::vector<float> u_, v_;
  std::vector<Place> places_;
};

// All bundles of a picture, in the order of its pixels.
Recording record(const World& world, RenderSettings settings);

using MakeCasterWith = std::function<std::unique_ptr<ShadowCaster>(const ShadowWays&)>;

// The fastest ways for a caster, by where bundles begin: each is tried on the bundles of a small picture with a seed of
// its own, so that no ray of the picture itself is used. looks_up: whether the caster can look up; the policy then says
// whether that paid.
ShadowWays fastest_ways(const World& world, const RenderSettings& settings, bool looks_up,
                        const MakeCasterWith& make_caster);

// "outside: look-up, rtcOccluded16; own: rtcOccluded16, coherent"
std::string text_of(const ShadowWays& ways);

}  // namespace vcd::render
