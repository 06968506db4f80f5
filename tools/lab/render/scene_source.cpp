#include "scene_source.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <utility>

#include "common/program.h"

namespace vcd::render {

using namespace tools;
namespace {

// Rows of 3 × 4, as in a Placement.
using Matrix = std::array<double, 12>;

struct Point {
  double x, y, z;
};

Point moved(const Matrix& m, const Point& p) {
  const auto row = [&](size_t r) { return m[r] * p.x + m[r + 1] * p.y + m[r + 2] * p.z + m[r + 3]; };
  return {row(0), row(4), row(8)};
}

struct Bounds {
  Point low{INFINITY, INFINITY, INFINITY}, high{-INFINITY, -INFINITY, -INFINITY};

  void add(const Point& p) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  Point middle() const { return {(low.x + high.x) / 2, (low.y + high.y) / 2, (low.z + high.z) / 2}; }
  double diagonal() const { return std::hypot(high.x - low.x, high.y - low.y, high.z - low.z); }
  double farthest() const {
    return std::max({-low.x, -low.y, -low.z, high.x, high.y, high.z});  // from the origin, along an axis
  }
};

// About all vertices where they stand.
Bounds bounds_of(const PlacedParts& placed) {
  Bounds bounds;
  for (const baker::Placement& placement : placed.placements)
    for (const baker::Position& p : placed.parts[placement.mesh].mesh.positions)
      bounds.add(moved(placement.transform, {p[0], p[1], p[2]}));
  return bounds;
}

// Moves, turns and scales all lengths alike, to what pictures show.
bool keeps_shape(const Matrix& m) {
  const auto dot = [&](size_t a, size_t b) { return m[a] * m[b] + m[a + 4] * m[b + 4] + m[a + 8] * m[b + 8]; };
  const double size2 = dot(0, 0), tolerance = 1e-4 * size2;
  const double volume =
      m[0] * (m[5] * m[10] - m[6] * m[9]) + m[4] * (m[9] * m[2] - m[10] * m[1]) + m[8] * (m[1] * m[6] - m[2] * m[5]);
  return volume > 0 && std::fabs(dot(1, 1) - size2) < tolerance && std::fabs(dot(2, 2) - size2) < tolerance &&
         std::fabs(dot(0, 1)) < tolerance && std::fabs(dot(1, 2)) < tolerance && std::fabs(dot(2, 0)) < tolerance;
}

// Where all stands together nothing is seen of; but 32-bit floats must tell the points of the picture apart. So what is
// far from the origin for its size, very small or very large, comes to the origin, in a size that is neither.
void bring_near(PlacedParts& placed) {
  constexpr double kFar = 64, kLargeChild = 1e6;
  const Bounds bounds = bounds_of(placed);
  const double size = bounds.diagonal();
  if (bounds.farthest() < kFar * size && size < kLargeChild && size > 1 / kLargeChild) return;
  const Point middle = bounds.middle();
  const double scale = size < kLargeChild && size > 1 / kLargeChild ? 1 : 1 / size;
  for (baker::Placement& placement : placed.placements) {
    Matrix& m = placement.transform;
    m[3] -= middle.x, m[7] -= middle.y, m[11] -= middle.z;
    for (double& number : m) number *= scale;
  }
}

scenes::Transform after(const scenes::Transform& outer, const Matrix& inner) {
  scenes::Transform product;
  for (size_t row = 0; row < 12; row += 4) {
    for (size_t column = 0; column < 4; ++column) {
      double sum = column == 3 ? outer[row + 3] : 0;
      for (size_t k = 0; k < 3; ++k) sum += double{outer[row + k]} * inner[4 * k + column];
      product[row + column] = static_cast<float>(sum);
    }
  }
  return product;
}

// The corners of the box about all that stands somewhere, all eight, so that they frame it however it is turned.
scenes::Mesh box_mesh(const Bounds& box) {
  scenes::Mesh mesh{"bounds", {}, {}, {}};
  for (const double x : {box.low.x, box.high.x})
    for (const double y : {box.low.y, box.high.y})
      for (const double z : {box.low.z, box.high.z})
        mesh.positions.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
  return mesh;
}

// One object in one place is drawn in its own frame, in which lights and camera must keep their shape.
void unbend_single(PlacedParts& placed, bool quiet) {
  Matrix& m = placed.placements[0].transform;
  const Matrix untouched = baker::Placement{}.transform;
  if (!keeps_shape(m)) {
    if (!quiet)
      print_note(placed.parts[0].source +
                 ": drawn without what its node does to its only mesh, which is to stretch or mirror it");
    m = untouched;
  }
  Matrix on_the_spot = m;  // where it stands is nothing to see
  on_the_spot[3] = on_the_spot[7] = on_the_spot[11] = 0;
  if (on_the_spot == untouched) m = untouched;
}

// One mesh stands as around() puts it; whatever else there is stands together as around() would put the box of it all.
Result<World> from_files(const std::vector<std::string>& paths, const SceneOptions& options, bool quiet) {
  auto placed = read_parts(paths, options.files, quiet);
  if (!placed) return placed.error();
  const bool is_single = placed->placements.size() == 1;
  if (is_single) unbend_single(*placed, quiet);
  scenes::Scene scene;
  if (is_single && placed->placements[0] == baker::Placement{}) {
    scene = scenes::around({"", placed->parts[0].mesh.positions, {}, {}}, options.up, options.turn_degrees);
  } else {
    bring_near(*placed);
    scene = scenes::around(box_mesh(bounds_of(*placed)), options.up, options.turn_degrees);
    const scenes::Transform turn = scene.instances[0].transform;
    scene.instances.clear();
    for (const baker::Placement& placement : placed->placements)
      scene.instances.push_back({static_cast<uint32_t>(placement.mesh), after(turn, placement.transform)});
  }
  scene.meshes.clear();
  scene.name = std::filesystem::path(paths[0]).stem().string();
  return build_world(scene, std::move(placed->parts));
}

}  // namespace

void add_scene_options(CLI::App& app, SceneOptions& options) {
  add_generated_scene_options(app, options.generated, "--scene-seed");
  app.add_option("--up", options.up, "The axis that points up (default: y)")
      ->check(CLI::IsMember({'x', 'y', 'z'}).description(""))
      ->type_name("x|y|z")
      ->group("Mesh files");
  app.add_option("--turn", options.turn_degrees, "Degrees to turn the object on the spot (default: 0)")
      ->check(NumberRange(-3600.0, 3600.0))
      ->group("Mesh files");
}

Result<World> load_world(const std::vector<std::string>& names, const SceneOptions& options, bool quiet) {
  if (!is_generated_scene(names[0])) return from_files(names, options, quiet);
  if (names.size() > 1) return Error{ErrorCode::usage, names[1] + ": a generated scene is drawn alone"};
  auto scene = generate_scene(names[0], options.generated);
  if (!scene) return scene.error();
  return build_world(std::move(*scene));
}

}  // namespace vcd::render
