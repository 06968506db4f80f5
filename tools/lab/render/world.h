// A scene made ready to be traced: prepared meshes, Embree's hierarchies over them, and where everything stands.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <vector>

#include <embree3/rtcore.h>

#include <vcd/baker/prepare.h>
#include <vcd/baker/tracer.h>
#include <vcd/format/error.h>
#include <vcd/scenes/scene.h>

#include "packets.h"
#include "vec.h"

namespace vcd::render {

struct WorldObject {
  baker::PreparedMesh mesh;
  baker::Tracer tracer;  // the hierarchy over the mesh, in the object's frame
  Vec3 colour;
  std::string source;                // the file it came from, or the scene's name: for messages
  std::vector<uint32_t> primitives;  // of the source mesh: one that became each triangle
};

struct WorldInstance {
  uint32_t object;
  Affine to_world, to_object;
  Box box;  // of the object's padded box, in the world
};

struct Quad {
  Vec3 corner, edge_u, edge_v, normal;  // unit normal, to the side of edge_u × edge_v
  float area;
};
struct Light {
  Quad quad;
  Vec3 radiance;
};
struct View {
  Vec3 position, forward, right, up;  // orthonormal
  float half_height;                  // of the image plane at distance 1
};

struct ReleaseDevice {
  void operator()(RTCDevice d) const { rtcReleaseDevice(d); }
};
struct ReleaseScene {
  void operator()(RTCScene s) const { rtcReleaseScene(s); }
};
using RTCDevicePointer = std::unique_ptr<std::remove_pointer_t<RTCDevice>, ReleaseDevice>;
using RTCScenePointer = std::unique_ptr<std::remove_pointer_t<RTCScene>, ReleaseScene>;

// What the hierarchies that answer shadow rays cost: those of all objects, and the one over the instances.
struct HierarchyCost {
  double build_seconds = 0;
  int64_t memory_bytes = 0;  // all that Embree allocated, its copy of the triangles included
};

inline constexpr uint32_t kGroundSurface = 0xFFFFFFFF;
inline constexpr Vec3 kSky = {0.55f, 0.65f, 0.8f};  // radiance: what a ray sees that meets nothing

// One object in one place is drawn in the object's own frame, whatever its transform: camera, lights and ground are
// moved instead, so that neither variant pays for a transform. With more, segments are in the scene's frame.
//
// The ground is seen but casts no shadow: everything stands on it and the lights hang above, so it could not.
struct World {
  std::string name;
  std::vector<WorldObject> objects;
  std::vector<WorldInstance> instances;
  Quad ground;
  Vec3 ground_colour;
  View view;
  std::vector<Light> lights;
  Box bounds;           // of the padded boxes of all that casts shadows
  float shadow_offset;  // how far shadow rays start above the surface
  HierarchyCost cost;

  RTCScenePointer casters;  // all instances; null where one object stands in one place
  RTCScenePointer visible;  // what the camera sees. Geometry 0: the ground; geometry k + 1: instance k

  bool single() const { return instances.size() == 1; }
  RTCScene shadow_casters() const { return single() ? objects[0].tracer.scene() : casters.get(); }
  std::vector<EmbreeQuery> ways_to_trace() const { return all_packets(!single()); }  // all that casts shadows
  uint64_t triangles() const;                                                        // of all objects
  uint64_t placed_triangles() const;                                                 // of all instances
};

Box box_of(const baker::PreparedMesh& mesh);  // padded

// A mesh that a world is made of.
struct WorldPart {
  baker::PreparedMesh mesh;
  Vec3 colour = {0.7f, 0.7f, 0.7f};
  std::string source;  // as in WorldObject
};

// The parts in the scene's setting; instances[i].mesh is an index into them, the scene's own meshes are not looked at.
// Errors: runtime (not enough memory, said before it is used up).
Result<World> build_world(const scenes::Scene& scene, std::vector<WorldPart>&& parts);

// The scene's own meshes, which are taken apart. Errors: and those of prepare().
Result<World> build_world(scenes::Scene&& scene);

// Adds all instances to a scene, in order; objects[i] stands for world.objects[i].
void attach_instances(const World& world, std::span<const RTCScene> objects, RTCDevice device, RTCScene scene);

}  // namespace vcd::render
