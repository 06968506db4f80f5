#include <vcd/library/light_demand.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>
#include <vector>

#include <vcd/recorder/recorder.h>
#include <vcd/writer/demand.h>

namespace vcd::library {
namespace {

using namespace baker;
using Vector = SceneLight::Vector;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr size_t kMostRounds = 64;     // of tries, where few segments meet an object
constexpr double kLeastHeight = 0.05;  // sine above the ground of what the sky sends: lower shadows go on for ever

Vector operator+(const Vector& a, const Vector& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Vector operator-(const Vector& a, const Vector& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Vector operator*(const Vector& a, double s) { return {a[0] * s, a[1] * s, a[2] * s}; }
double dot(const Vector& a, const Vector& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double length(const Vector& a) { return std::sqrt(dot(a, a)); }
Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

// SplitMix64 (Steele, Lea and Flood 2014).
class Random {
 public:
  double unit() { return static_cast<double>(next() >> 11) * 0x1p-53; }  // in [0, 1)
  size_t below(size_t count) { return std::min(count - 1, static_cast<size_t>(unit() * static_cast<double>(count))); }

 private:
  uint64_t next() {
    uint64_t x = state_ += 0x9E3779B97F4A7C15u;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
    return x ^ (x >> 31);
  }
  uint64_t state_ = 0;
};

struct Bounds {
  Vector low{kInfinity, kInfinity, kInfinity}, high{-kInfinity, -kInfinity, -kInfinity};

  void add(const Vector& p) {
    for (size_t a = 0; a < 3; ++a) low[a] = std::min(low[a], p[a]), high[a] = std::max(high[a], p[a]);
  }
  Vector corner(size_t i) const {
    return {i & 1 ? high[0] : low[0], i & 2 ? high[1] : low[1], i & 4 ? high[2] : low[2]};
  }
};

Vector moved(const std::array<double, 12>& to_scene, const Position& p) {
  Vector result;
  for (size_t row = 0; row < 3; ++row)
    result[row] = to_scene[4 * row] * double{p[0]} + to_scene[4 * row + 1] * double{p[1]} +
                  to_scene[4 * row + 2] * double{p[2]} + to_scene[4 * row + 3];
  return result;
}

// A point of a light: where it is, or the direction towards it.
struct LightPoint {
  bool far;
  Vector at;
};

class LightRays {
 public:
  LightRays(std::span<const LitInstance> instances, std::span<const SceneLight> lights, Axis up)
      : instances_(instances), lights_(lights), up_(static_cast<size_t>(up)) {
    Bounds all;
    double area = 0;
    for (const LitInstance& instance : instances) {
      Bounds& box = boxes_.emplace_back();
      for (const Position& p : instance.mesh->positions) box.add(moved(instance.to_scene, p));
      all.add(box.low), all.add(box.high);
      for (const TriangleIndices& triangle : instance.mesh->triangles) {
        const auto [a, b, c] = corners(instance, triangle);
        area += length(cross(b - a, c - a));
        areas_.push_back(area);
        instance_of_.push_back(static_cast<uint32_t>(boxes_.size() - 1));
      }
    }
    ground_ = all.low[up_];
    const double size = length(all.high - all.low);
    limits_.add(all.low - Vector{size, size, size}), limits_.add(all.high + Vector{size, size, size});
  }

  bool has_surfaces_for_others() const { return instances_.size() > 1; }

  // A segment to some light, if it reaches the point that was chosen.
  std::optional<Segment> from_ground() {
    const SceneLight& light = lights_[random_.below(lights_.size())];
    const LightPoint source = point_of(light);
    const auto start = shadowed_ground(boxes_[random_.below(boxes_.size())], source);
    const auto rising = start ? segment(light, *start, source) : std::nullopt;
    return rising && rising->direction[up_] > 0 ? rising : std::nullopt;
  }
  std::optional<Segment> from_surface(uint32_t& self) {
    const auto found = std::ranges::upper_bound(areas_, random_.unit() * areas_.back());
    const size_t at = std::min(static_cast<size_t>(found - areas_.begin()), areas_.size() - 1);
    self = instance_of_[at];
    const LitInstance& instance = instances_[self];
    size_t first = at;  // of the instance's triangles
    first = static_cast<size_t>(std::ranges::lower_bound(instance_of_, self) - instance_of_.begin());
    const auto [a, b, c] = corners(instance, instance.mesh->triangles[at - first]);
    double u = random_.unit(), v = random_.unit();
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const SceneLight& light = lights_[random_.below(lights_.size())];
    return segment(light, a + (b - a) * u + (c - a) * v, point_of(light));
  }

 private:
  static std::array<Vector, 3> corners(const LitInstance& instance, const TriangleIndices& t) {
    const auto at = [&](size_t i) { return moved(instance.to_scene, instance.mesh->positions[t[i]]); };
    return {at(0), at(1), at(2)};
  }

  LightPoint point_of(const SceneLight& light) {
    switch (light.shape) {
      case SceneLight::Shape::point: return {false, light.position};
      case SceneLight::Shape::directional: return {true, light.direction * -1};
      case SceneLight::Shape::rectangle:
        return {false, light.position + light.half_edges[0] * (2 * random_.unit() - 1) +
                           light.half_edges[1] * (2 * random_.unit() - 1)};
      case SceneLight::Shape::sky: break;
    }
    // By the cosine, as a level surface gathers it.
    const double height = std::sqrt(kLeastHeight * kLeastHeight + (1 - kLeastHeight * kLeastHeight) * random_.unit()),
                 angle = 2 * std::numbers::pi * random_.unit(), across = std::sqrt(1 - height * height);
    Vector d;
    d[up_] = height, d[(up_ + 1) % 3] = across * std::cos(angle), d[(up_ + 2) % 3] = across * std::sin(angle);
    return {true, d};
  }

  // A point of the rectangle on the ground that holds the box's shadow.
  std::optional<Vector> shadowed_ground(const Bounds& box, const LightPoint& source) {
    Bounds shadow;
    for (size_t i = 0; i < 8; ++i) {
      const Vector corner = box.corner(i), along = source.far ? source.at * -1 : corner - source.at;
      if (!(along[up_] < 0)) {  // it leaves the ground to the light: the shadow has no end
        shadow = limits_;
        break;
      }
      shadow.add(corner + along * ((ground_ - corner[up_]) / along[up_]));
    }
    Vector point;
    for (size_t a = 0; a < 3; ++a) {
      const double low = std::max(shadow.low[a], limits_.low[a]), high = std::min(shadow.high[a], limits_.high[a]);
      if (!(low <= high)) return std::nullopt;
      point[a] = a == up_ ? ground_ : low + (high - low) * random_.unit();
    }
    return point;
  }

  static std::optional<Segment> segment(const SceneLight& light, const Vector& start, const LightPoint& source) {
    const Vector to_light = source.far ? source.at : source.at - start;
    const double distance = length(to_light);
    if (!(distance > 0)) return std::nullopt;
    const double cosine = -dot(light.direction, to_light) / distance;
    if (light.shape == SceneLight::Shape::point && cosine < light.cone_cosine) return std::nullopt;
    if (light.shape == SceneLight::Shape::point && light.range > 0 && distance > light.range) return std::nullopt;
    if (light.shape == SceneLight::Shape::rectangle && cosine <= 0) return std::nullopt;
    Segment s{};
    for (size_t a = 0; a < 3; ++a)
      s.origin[a] = static_cast<float>(start[a]), s.direction[a] = static_cast<float>(to_light[a]);
    s.t_max = source.far ? std::numeric_limits<float>::infinity() : 1;
    return s;
  }

  std::span<const LitInstance> instances_;
  std::span<const SceneLight> lights_;
  size_t up_;
  Random random_;
  std::vector<Bounds> boxes_;          // of each instance, in the scene
  std::vector<double> areas_;          // twice those of all triangles of all instances up to this one
  std::vector<uint32_t> instance_of_;  // each of these
  double ground_ = 0;
  Bounds limits_;  // of shadows on the ground
};

std::vector<RecordedInstance> recorded(std::span<const LitInstance> instances) {
  std::vector<RecordedInstance> all;
  for (const LitInstance& instance : instances) {
    RecordedInstance& r = all.emplace_back();
    r.geometry_hash = instance.mesh->geometry_hash;
    std::ranges::copy(instance.mesh->box_min, r.place.box_min);
    std::ranges::copy(instance.mesh->box_max, r.place.box_max);
    for (size_t i = 0; i < 12; ++i) r.place.to_world.rows[i / 4][i % 4] = static_cast<float>(instance.to_scene[i]);
  }
  return all;
}

size_t count(const Demand& demand) {
  size_t sum = 0;
  for (const auto& [hash, segments] : demand) sum += segments.size();
  return sum;
}

}  // namespace

Result<Demand> demand_of_lights(std::span<const LitInstance> instances, std::span<const SceneLight> lights, Axis up,
                                size_t segments) {
  Demand demand;
  if (instances.empty() || lights.empty()) return demand;
  LightRays rays(instances, lights, up);
  const auto places = recorded(instances);
  for (size_t round = 0; round < kMostRounds && count(demand) < segments; ++round) {
    // Room for twice as many: all are kept, and each stands for one.
    auto recorder = Recorder::build(places, 2 * segments + 2);
    if (!recorder) return recorder.error();
    Recorder::Thread& thread = recorder->thread();
    for (size_t i = 0; i < segments; ++i) {
      uint32_t self = kNoInstance;
      const bool from_surface = i % 2 == 1 && rays.has_surfaces_for_others();
      if (const auto segment = from_surface ? rays.from_surface(self) : rays.from_ground())
        thread.asked(*segment, self);
    }
    const std::array<Demand, 2> both = {std::move(demand), recorder->demand()};
    demand = merge(both);
  }
  return thin(std::move(demand), segments);
}

Result<Demand> demand_from_above(const PreparedMesh& mesh, Axis up, size_t segments) {
  const LitInstance instance{&mesh};
  SceneLight sky;
  sky.shape = SceneLight::Shape::sky;
  return demand_of_lights(std::span(&instance, 1), std::span(&sky, 1), up, segments);
}

}  // namespace vcd::library
