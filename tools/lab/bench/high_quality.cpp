#include "high_quality.h"

#include <cstring>

#include "render/instructions.h"

namespace vcd::bench {

using namespace render;
namespace {

RTCScenePointer new_scene(RTCDevice device) {
  RTCScenePointer scene(rtcNewScene(device));
  rtcSetSceneBuildQuality(scene.get(), RTC_BUILD_QUALITY_HIGH);
  return scene;
}

template <class Item>
void fill(RTCGeometry geometry, RTCBufferType type, RTCFormat format, const std::vector<Item>& items) {
  if (void* buffer = rtcSetNewGeometryBuffer(geometry, type, 0, format, sizeof(Item), items.size()))
    std::memcpy(buffer, items.data(), items.size() * sizeof(Item));
}

RTCScenePointer build_object(RTCDevice device, const baker::PreparedMesh& mesh) {
  RTCScenePointer scene = new_scene(device);
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  fill(geometry, RTC_BUFFER_TYPE_VERTEX, RTC_FORMAT_FLOAT3, mesh.positions);
  fill(geometry, RTC_BUFFER_TYPE_INDEX, RTC_FORMAT_UINT3, mesh.triangles);
  rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_HIGH);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene.get(), geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene.get());
  return scene;
}

}  // namespace

Result<HighQualityCasters> HighQualityCasters::build(const World& world) {
  HighQualityCasters casters;
  casters.device_.reset(rtcNewDevice(embree_config()));
  if (!casters.device_) return Error{ErrorCode::runtime, "Embree gives no device"};
  std::vector<RTCScene> scenes;
  for (const WorldObject& object : world.objects) {
    casters.objects_.push_back(build_object(casters.device_.get(), object.mesh));
    scenes.push_back(casters.objects_.back().get());
  }
  if (!world.single()) {
    casters.instances_ = new_scene(casters.device_.get());
    attach_instances(world, scenes, casters.device_.get(), casters.instances_.get());
    rtcCommitScene(casters.instances_.get());
  }
  if (const RTCError code = rtcGetDeviceError(casters.device_.get()); code != RTC_ERROR_NONE)
    return Error{ErrorCode::runtime, world.name + ": Embree could not build its hierarchies of high quality (error " +
                                         std::to_string(code) + ")"};
  return casters;
}

}  // namespace vcd::bench
