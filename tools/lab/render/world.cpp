#include "world.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstring>
#include <numbers>

#include "common/memory.h"
#include "common/seconds_since.h"
#include "instructions.h"

namespace vcd::render {

using namespace baker;
using namespace tools;
namespace {

// Measured with Embree's default hierarchy: source, prepared mesh and hierarchy together, rounded up.
constexpr uint64_t kBytesPerTriangle = 400;

bool count_bytes(void* total, ssize_t bytes, bool) {
  *static_cast<std::atomic<int64_t>*>(total) += bytes;
  return true;
}

Quad make_quad(Vec3 corner, Vec3 edge_u, Vec3 edge_v) {
  const Vec3 normal = cross(edge_u, edge_v);
  return {corner, edge_u, edge_v, unit(normal), length(normal)};
}

Quad transformed(const Affine& a, const Quad& q) {
  return make_quad(a.point(q.corner), a.vector(q.edge_u), a.vector(q.edge_v));
}

View make_view(const scenes::Camera& camera, const Affine& a) {
  View view;
  view.position = a.point(vec3(camera.position));
  view.forward = unit(a.vector(vec3(camera.target) - vec3(camera.position)));
  view.right = unit(cross(view.forward, a.vector({0, 1, 0})));
  view.up = cross(view.right, view.forward);
  view.half_height = std::tan(camera.vertical_fov_degrees / 360 * std::numbers::pi_v<float>);
  return view;
}

Quad ground_quad(const scenes::Ground& g) {
  const float side = 2 * g.half_size;
  return make_quad({g.center_x - g.half_size, g.height, g.center_z - g.half_size}, {0, 0, side}, {side, 0, 0});
}

using Clock = std::chrono::steady_clock;

std::vector<uint32_t> primitives_of(const PreparedMesh& mesh) {
  std::vector<uint32_t> primitives(mesh.triangles.size());
  for (uint32_t i = 0; i < mesh.source_triangles.size(); ++i)
    if (mesh.source_triangles[i] != kNone) primitives[mesh.source_triangles[i]] = i;
  return primitives;
}

Result<WorldObject> make_object(WorldPart&& part, RTCDevice device, double& build_seconds) {
  const auto start = Clock::now();
  auto tracer = Tracer::build(part.mesh.positions, part.mesh.triangles, TraceMode::fast, device);
  build_seconds += seconds_since(start);
  if (!tracer) return Error{tracer.error().code, part.source + ": " + tracer.error().message};
  std::vector<uint32_t> primitives = primitives_of(part.mesh);
  return WorldObject{std::move(part.mesh), std::move(*tracer), part.colour, std::move(part.source),
                     std::move(primitives)};
}

// Asked before memory is used up.
std::optional<Error> check_triangles(const std::string& name, uint64_t triangles) {
  return check_memory(name, triangles * kBytesPerTriangle);
}

void attach_ground(const Quad& q, RTCDevice device, RTCScene scene) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_QUAD);
  const Vec3 corners[4] = {q.corner, q.corner + q.edge_u, q.corner + q.edge_u + q.edge_v, q.corner + q.edge_v};
  const uint32_t indices[4] = {0, 1, 2, 3};
  std::memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(Vec3), 4), corners,
              sizeof corners);
  std::memcpy(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT4, sizeof indices, 1), indices,
              sizeof indices);
  rtcCommitGeometry(geometry);
  rtcAttachGeometryByID(scene, geometry, 0);
  rtcReleaseGeometry(geometry);
}

// Above rounding, in the scene's frame and in those of the objects.
float shadow_offset(const World& world) {
  float step = step_at(world.bounds.farthest());
  for (const WorldInstance& instance : world.instances) {
    float scale = 1;
    if (!world.single())
      for (const Vec3 column : instance.to_world.column) scale = std::fmax(scale, length(column));
    step = std::fmax(step, scale * step_at(box_of(world.objects[instance.object].mesh).farthest()));
  }
  return std::fmax(2e-5f * world.bounds.diagonal(), 2 * step);
}

}  // namespace

Box box_of(const PreparedMesh& mesh) {
  Box box;
  box.add(vec3(mesh.box_min)), box.add(vec3(mesh.box_max));
  return box;
}

uint64_t World::triangles() const {
  uint64_t sum = 0;
  for (const WorldObject& object : objects) sum += object.mesh.triangles.size();
  return sum;
}

uint64_t World::placed_triangles() const {
  uint64_t sum = 0;
  for (const WorldInstance& instance : instances) sum += objects[instance.object].mesh.triangles.size();
  return sum;
}

void attach_instances(const World& world, std::span<const RTCScene> objects, RTCDevice device, RTCScene scene) {
  static_assert(sizeof(Affine) == 12 * sizeof(float), "Affine is Embree's column-major 3 × 4");
  for (const WorldInstance& instance : world.instances) {
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(geometry, objects[instance.object]);
    const Affine to_world = world.single() ? Affine{} : instance.to_world;
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, &to_world);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
  }
}

Result<World> build_world(scenes::Scene&& scene) {
  uint64_t triangles = 0;
  for (const scenes::Mesh& mesh : scene.meshes) triangles += mesh.triangles.size();
  if (auto error = check_triangles(scene.name, triangles)) return *error;
  std::vector<WorldPart> parts;
  for (scenes::Mesh& mesh : scene.meshes) {
    const auto index = static_cast<uint32_t>(parts.size());
    auto prepared =
        prepare({std::move(mesh.name), index, std::move(mesh.positions), std::move(mesh.triangles), {}, {}});
    if (!prepared) return Error{prepared.error().code, scene.name + ": " + prepared.error().message};
    parts.push_back({std::move(*prepared), vec3(mesh.colour), scene.name});
  }
  return build_world(scene, std::move(parts));
}

Result<World> build_world(const scenes::Scene& scene, std::vector<WorldPart>&& parts) {
  uint64_t triangles = 0;
  for (const WorldPart& part : parts) triangles += part.mesh.triangles.size();
  if (auto error = check_triangles(scene.name, triangles)) return *error;

  std::atomic<int64_t> bytes = 0;  // outlives the device, which counts in it
  RTCDevicePointer device(rtcNewDevice(embree_config()));
  if (!device) return Error{ErrorCode::runtime, "Embree gives no device"};
  rtcSetDeviceMemoryMonitorFunction(device.get(), count_bytes, &bytes);

  World world;
  world.name = scene.name;
  for (WorldPart& part : parts) {
    auto object = make_object(std::move(part), device.get(), world.cost.build_seconds);
    if (!object) return object.error();
    world.objects.push_back(std::move(*object));
  }
  for (const scenes::Instance& from : scene.instances) {
    const Affine to_world = affine(from.transform);
    world.instances.push_back(
        {from.mesh, to_world, inverse(to_world), transformed(to_world, box_of(world.objects[from.mesh].mesh))});
  }
  std::vector<RTCScene> scenes;
  for (const WorldObject& object : world.objects) scenes.push_back(object.tracer.scene());
  if (!world.single()) {
    const auto start = Clock::now();
    world.casters.reset(rtcNewScene(device.get()));
    attach_instances(world, scenes, device.get(), world.casters.get());
    rtcCommitScene(world.casters.get());
    world.cost.build_seconds += seconds_since(start);
  }
  rtcSetDeviceMemoryMonitorFunction(device.get(), nullptr, nullptr);
  world.cost.memory_bytes = bytes;

  const Affine frame = world.single() ? world.instances[0].to_object : Affine{};
  world.ground = transformed(frame, ground_quad(scene.ground));
  world.ground_colour = vec3(scene.ground.colour);
  world.view = make_view(scene.camera, frame);
  for (const scenes::AreaLight& light : scene.lights)
    world.lights.push_back({transformed(frame, make_quad(vec3(light.corner), vec3(light.edge_u), vec3(light.edge_v))),
                            vec3(light.radiance)});
  for (const WorldInstance& instance : world.instances)
    world.bounds.add(world.single() ? box_of(world.objects[0].mesh) : instance.box);
  world.shadow_offset = shadow_offset(world);

  world.visible.reset(rtcNewScene(device.get()));
  attach_ground(world.ground, device.get(), world.visible.get());
  attach_instances(world, scenes, device.get(), world.visible.get());
  rtcCommitScene(world.visible.get());
  if (const RTCError code = rtcGetDeviceError(device.get()); code != RTC_ERROR_NONE)
    return Error{ErrorCode::runtime,
                 world.name + ": Embree could not build its hierarchies (error " + std::to_string(code) + ")"};
  return world;
}

}  // namespace vcd::render
