#include <utility>

#include <vcd/scenes/generate.h>

#include "setting.h"

namespace vcd::scenes {
namespace {

// Proper rotations, so that nothing is mirrored.
Transform turned_up(char up) {
  if (up == 'z') return {1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 0, 0};  // (x, y, z) -> (x, z, -y)
  if (up == 'x') return {0, -1, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0};  // (x, y, z) -> (-y, x, z)
  return kIdentity;
}

// The turn on the spot after another one: rows x and z are mixed.
Transform turned_on_the_spot(const Transform& t, double degrees) {
  const CosSin a = at_turn(degrees / 360);
  Transform turned = t;
  for (size_t column = 0; column < 3; ++column) {
    const double x = t[column], z = t[8 + column];
    turned[column] = static_cast<float>(a.cos * x + a.sin * z);
    turned[8 + column] = static_cast<float>(a.cos * z - a.sin * x);
  }
  return turned;
}

}  // namespace

Scene around(Mesh mesh, char up, double degrees) {
  Scene scene;
  scene.name = mesh.name;
  scene.meshes.push_back(std::move(mesh));
  scene.instances.push_back({0, turned_on_the_spot(turned_up(up), degrees)});
  put_in_setting(scene);
  return scene;
}

}  // namespace vcd::scenes
