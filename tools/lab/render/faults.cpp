#include "faults.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>

#include "common/describe.h"

namespace vcd::render {

using namespace tools;
namespace {

// Below so many steps of floats in an object, their rounding is seen.
constexpr float kLeastSteps = 4096;

bool is_rough(const Box& box) { return box.diagonal() < kLeastSteps * step_at(box.farthest()); }

std::string text_of(double number) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", number);
  return text;
}

std::array<double, 3> middle_of(const Box& box) {
  return {(double{box.low.x} + box.high.x) / 2, (double{box.low.y} + box.high.y) / 2,
          (double{box.low.z} + box.high.z) / 2};
}

// "--shift X,Y,Z" in whole numbers.
std::string shift_of(const WorldObject& object, const Box& box) {
  std::string text = "--shift ";
  const auto middle = middle_of(box);
  for (size_t axis = 0; axis < 3; ++axis) {
    char number[64];
    std::snprintf(number, sizeof number, "%s%.0f", axis ? "," : "", object.mesh.shift[axis] + middle[axis]);
    text += number;
  }
  return text;
}

// "is 3 units large and 1e+06 units from the origin, where …"
std::string standing_of(const Box& box) {
  return "is " + text_of(box.diagonal()) + " units large and " + text_of(box.farthest()) +
         " units from the origin of its frame, where 32-bit floats are " + text_of(step_at(box.farthest())) + " apart";
}

std::string far_object(const World& world) {
  for (const WorldObject& object : world.objects) {
    const Box box = box_of(object.mesh);
    if (!is_rough(box)) continue;
    return object.source + ": mesh " + std::to_string(object.mesh.source_index) + " " + printable(object.mesh.name) +
           " " + standing_of(box) +
           ": its points and shadow rays are rounded to that, which is seen; bake and draw it with " +
           shift_of(object, box);
  }
  return {};
}

std::string why_nothing(const World& world) {
  if (is_rough(world.bounds)) return "it " + standing_of(world.bounds);
  float largest = 0;
  for (const WorldInstance& instance : world.instances) largest = std::max(largest, instance.box.diagonal());
  const double share = largest / world.bounds.diagonal();
  if (!world.single() && share < 0.01)
    return "its meshes stand far apart, so that the largest is " + text_of(share) + " of the size of it all";
  return "camera rays pass between its triangles";
}

}  // namespace

std::vector<std::string> faults_of(const World& world, const RenderSettings& settings, const Rendered& rendered) {
  std::vector<std::string> faults;
  if (std::string far = far_object(world); !far.empty()) faults.push_back(std::move(far));
  const uint64_t rays = uint64_t{settings.width} * settings.height * settings.pixel_samples;
  if (rendered.object_samples * 10000 < rays)
    faults.push_back(world.name + ": " + (rendered.object_samples == 0 ? "nothing" : "next to nothing") +
                     " of it is seen in the picture: " + why_nothing(world));
  const auto pixels = std::ranges::count_if(rendered.image.pixels, [](const Vec3& p) {
    return !std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z);
  });
  if (pixels > 0)
    faults.push_back(world.name + ": " + std::to_string(pixels) + " pixels are not finite: " + why_nothing(world));
  return faults;
}

}  // namespace vcd::render
