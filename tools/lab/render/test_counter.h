// How many ray–triangle tests a shadow ray takes. Embree's own leaves test four triangles at once and do not count;
// here it builds its hierarchy over single triangles, whose tests are ours and are counted.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "world.h"

namespace vcd::render {

// Safe from any thread. Not for timing.
class TestCounter {
 public:
  // The world must outlive it. Errors: runtime (out of memory).
  static Result<TestCounter> build(const World& world);

  struct Count {
    uint64_t tests = 0;
    bool occluded = false;
  };
  Count count(const Segment& segment) const;  // against all that casts shadows

 private:
  std::vector<RTCScenePointer> objects_;
  RTCScenePointer instances_;
};

}  // namespace vcd::render
