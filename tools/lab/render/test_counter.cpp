#include "test_counter.h"

#include <limits>

#include "instructions.h"
#include "packets.h"

namespace vcd::render {

using namespace baker;
namespace {

struct CountingContext {
  RTCIntersectContext embree;  // first, so that a callback finds the counter behind it
  uint64_t tests;
};

void bounds(const RTCBoundsFunctionArguments* arguments) {
  const auto& mesh = *static_cast<const PreparedMesh*>(arguments->geometryUserPtr);
  Box box;
  for (uint32_t corner : mesh.triangles[arguments->primID]) box.add(vec3(mesh.positions[corner]));
  *arguments->bounds_o = {box.low.x, box.low.y, box.low.z, 0, box.high.x, box.high.y, box.high.z, 0};
}

// Möller and Trumbore, Fast, Minimum Storage Ray/Triangle Intersection, 1997.
bool meets(const RTCRay& ray, Vec3 a, Vec3 b, Vec3 c) {
  const Vec3 origin{ray.org_x, ray.org_y, ray.org_z}, direction{ray.dir_x, ray.dir_y, ray.dir_z};
  const Vec3 ab = b - a, ac = c - a, p = cross(direction, ac);
  const float determinant = dot(ab, p);
  if (determinant == 0) return false;
  const Vec3 s = origin - a, q = cross(s, ab);
  const float u = dot(s, p) / determinant, v = dot(direction, q) / determinant, t = dot(ac, q) / determinant;
  return u >= 0 && v >= 0 && u + v <= 1 && t > ray.tnear && t < ray.tfar;
}

void occluded(const RTCOccludedFunctionNArguments* arguments) {
  if (arguments->valid[0] != -1) return;
  const auto& mesh = *static_cast<const PreparedMesh*>(arguments->geometryUserPtr);
  const auto& [a, b, c] = mesh.triangles[arguments->primID];
  RTCRay& ray = *reinterpret_cast<RTCRay*>(arguments->ray);  // rays come one at a time: N is 1
  ++reinterpret_cast<CountingContext*>(arguments->context)->tests;
  if (meets(ray, vec3(mesh.positions[a]), vec3(mesh.positions[b]), vec3(mesh.positions[c])))
    ray.tfar = -std::numeric_limits<float>::infinity();
}

RTCScenePointer object_scene(RTCDevice device, const PreparedMesh& mesh) {
  RTCScenePointer scene(rtcNewScene(device));
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
  rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(mesh.triangles.size()));
  rtcSetGeometryUserData(geometry, const_cast<PreparedMesh*>(&mesh));
  rtcSetGeometryBoundsFunction(geometry, bounds, nullptr);
  rtcSetGeometryOccludedFunction(geometry, occluded);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene.get(), geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene.get());
  return scene;
}

}  // namespace

Result<TestCounter> TestCounter::build(const World& world) {
  TestCounter counter;
  RTCDevicePointer device(rtcNewDevice(embree_config()));
  if (!device) return Error{ErrorCode::runtime, "Embree gives no device"};
  std::vector<RTCScene> scenes;
  for (const WorldObject& object : world.objects) {
    counter.objects_.push_back(object_scene(device.get(), object.mesh));
    scenes.push_back(counter.objects_.back().get());
  }
  if (!world.single()) {
    counter.instances_.reset(rtcNewScene(device.get()));
    attach_instances(world, scenes, device.get(), counter.instances_.get());
    rtcCommitScene(counter.instances_.get());
  }
  if (rtcGetDeviceError(device.get()) != RTC_ERROR_NONE)
    return Error{ErrorCode::runtime, world.name + ": Embree could not build its counting hierarchy"};
  return counter;
}

TestCounter::Count TestCounter::count(const Segment& segment) const {
  CountingContext context{{}, 0};
  rtcInitIntersectContext(&context.embree);
  RTCRay ray = to_ray(segment);
  rtcOccluded1(instances_ ? instances_.get() : objects_[0].get(), &context.embree, &ray);
  return {context.tests, ray.tfar < 0};
}

}  // namespace vcd::render
