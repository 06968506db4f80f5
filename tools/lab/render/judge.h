// What is true of shadow rays in exact arithmetic, without asking it of each ray for each variant.
#pragma once

#include <cstdint>
#include <mutex>
#include <span>
#include <unordered_map>

#include <vcd/baker/referee.h>

#include "world.h"

namespace vcd::render {

// Of one object in one place. It judges all of Embree's answers once and remembers the wrong ones: from then on the
// truth is Embree's answer unless the ray is one of those.
class Judge {
 public:
  // world.single().
  explicit Judge(const World& world) : referee_(world.objects[0].mesh) {}

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

  baker::Referee referee_;
  std::mutex learning_;
  std::unordered_map<Segment, uint8_t, SameBits, SameBits> wrong_;  // the truth of segments that Embree gets wrong
};

}  // namespace vcd::render
