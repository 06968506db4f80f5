// What casts shadows in a world, in Embree's builds of high quality (RTC_BUILD_QUALITY_HIGH: spatial splits).
#pragma once

#include <vector>

#include "render/world.h"

namespace vcd::bench {

class HighQualityCasters {
 public:
  // Copies the triangles. Errors: runtime (out of memory).
  static Result<HighQualityCasters> build(const render::World& world);

  RTCScene scene() const { return instances_ ? instances_.get() : objects_[0].get(); }

 private:
  render::RTCDevicePointer device_;
  std::vector<render::RTCScenePointer> objects_;
  render::RTCScenePointer instances_;  // null where one object stands in one place
};

}  // namespace vcd::bench
