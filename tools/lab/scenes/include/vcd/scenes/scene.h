// What is drawn: meshes, where they stand, the ground, the camera and the lights. The setting of Billen and Dutré 2016,
// section 4: objects on a ground plane under area lights.
//
// One world frame for all: y points up, units are the scene's own (about a metre), right-handed, colours are linear
// RGB.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace vcd::scenes {

using Vec3 = std::array<float, 3>;

struct Mesh {
  std::string name;                                // unique in its scene, ASCII
  std::vector<Vec3> positions;                     // in the mesh's own frame
  std::vector<std::array<uint32_t, 3>> triangles;  // into positions, counter-clockwise seen from outside
  Vec3 colour{0.7f, 0.7f, 0.7f};                   // diffuse reflectance, 0 … 1
};

// Row-major 3 × 4: world = rotation and scale (columns 0 … 2) · mesh + translation (column 3).
using Transform = std::array<float, 12>;
inline constexpr Transform kIdentity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

struct Instance {
  uint32_t mesh = 0;  // index into Scene::meshes
  Transform transform = kIdentity;
};

// A parallelogram corner + a · edge_u + b · edge_v with a, b in 0 … 1 that sends light to the side of edge_u × edge_v.
struct AreaLight {
  Vec3 corner, edge_u, edge_v;
  Vec3 radiance;
};

struct Camera {
  Vec3 position, target;  // looks from one to the other, y up
  float vertical_fov_degrees = 35;
};

// A square in the plane y = height about (center_x, center_z). Everything else stands on it or above.
struct Ground {
  float height = 0, center_x = 0, center_z = 0, half_size = 10;
  Vec3 colour{0.6f, 0.6f, 0.6f};
};

struct Scene {
  std::string name;
  std::vector<Mesh> meshes;
  std::vector<Instance> instances;
  Ground ground;
  Camera camera;
  std::vector<AreaLight> lights;  // at least one
};

}  // namespace vcd::scenes
