// What is true of shadow rays in exact arithmetic, without asking it of each ray for each variant.
#pragma once

#include <cstdint>
#include <mutex>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include <vcd/baker/referee.h>
#include <vcd/runtime/scene.h>

#include "world.h"

namespace vcd::render {

// It judges all of Embree's answers once and remembers the wrong ones: from then on the truth is Embree's answer unless
// the ray is one of those. Of instances, the truth is that of the segment in the object's frame, as it is rounded there
// (spec/conventions.md, 23).
class Judge {
 public:
  // objects[i] stands for world.objects[i]: any sidecar of it.
  Judge(const World& world, std::span<const Object> objects);

  // The truth of one segment. Safe from any thread.
  bool blocked(const Segment& segment) const;

  // The first time: the truth of each segment, held against what Embree says. Safe from any thread.
  void learn(std::span<const Segment> segments, std::span<const uint8_t> embree, std::span<uint8_t> truth);

  // Later, of segments that were learnt, with the same way to ask Embree: answers become the truth. Safe from any
  // thread, but not beside learn().
  void correct(std::span<const Segment> segments, std::span<uint8_t> embree) const;

 private:
  struct SameBits {
    bool operator()(const Segment& a, const Segment& b) const;
    size_t operator()(const Segment& s) const;
  };

  const World& world_;
  std::vector<baker::Referee> referees_;  // of the world's objects
  std::optional<Scene> scene_;            // that moves segments, unless the world is a single object
  std::mutex learning_;
  std::unordered_map<Segment, uint8_t, SameBits, SameBits> wrong_;  // the truth of segments that Embree gets wrong
};

}  // namespace vcd::render
