#include "beam/beam.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace vcd {
namespace {

using Vec = std::array<double, 3>;
Vec cross(const Vec& a, const Vec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// In the L1 norm of grid units: so far away rounding stays well below the guard band. 64 boxes.
constexpr float kFarthestBeam = 0x1p14f;

}  // namespace

BeamFrame beam_frame(const QuadBundle& b) {
  BeamFrame beam{};
  for (int a = 0; a < 3; ++a) {
    beam.origin[a] = b.origin[a];
    beam.corner[a] = b.corner[a] - b.origin[a];
    beam.edge_u[a] = b.edge_u[a], beam.edge_v[a] = b.edge_v[a];
  }
  beam.reach = 1, beam.rounding = 1;
  beam.usable = true;
  return beam;
}

// The square, perpendicular to the line to the centre, that lies just before the sphere and is as wide as it seems
// there.
BeamFrame beam_frame(const SphereBundle& b) {
  BeamFrame beam{};
  std::copy_n(b.origin, 3, beam.origin);
  Vec axis;
  for (size_t a = 0; a < 3; ++a) axis[a] = double{b.centre[a]} - double{b.origin[a]};
  const double distance = std::sqrt(dot(axis, axis)), radius = b.radius;
  if (!(distance > 1.01 * radius && radius >= 0)) return beam;
  for (double& x : axis) x /= distance;
  constexpr double kSlack = 0x1p-10;  // for rounding, and for samples that lie a little outside
  const double height = (distance - radius) * (1 - kSlack);
  const double half =
      height * radius / std::sqrt(distance * distance - radius * radius) * (1 + kSlack) + height * 0x1p-20;
  size_t thinnest = 0;
  for (size_t a = 1; a < 3; ++a)
    if (std::abs(axis[a]) < std::abs(axis[thinnest])) thinnest = a;
  Vec away{};
  away[thinnest] = 1;
  Vec first = cross(axis, away);
  const double length = std::sqrt(dot(first, first));
  for (double& x : first) x /= length;
  const Vec second = cross(axis, first);
  for (size_t a = 0; a < 3; ++a) {
    beam.corner[a] = static_cast<float>(height * axis[a] - half * (first[a] + second[a]));
    beam.edge_u[a] = static_cast<float>(2 * half * first[a]), beam.edge_v[a] = static_cast<float>(2 * half * second[a]);
    beam.axis[a] = static_cast<float>(axis[a]);
    beam.to_u[a] = static_cast<float>(first[a] * height / (2 * half)),
    beam.to_v[a] = static_cast<float>(second[a] * height / (2 * half));
  }
  beam.reach = (distance + radius) / height * (1 + kSlack);
  const double slope = 1 + half / height;
  beam.rounding = static_cast<float>(3 * slope * slope);
  beam.usable = true;
  return beam;
}

namespace {

void pad(BundleChunk& chunk) {
  for (size_t i = chunk.count; i % kRun != 0; ++i)
    chunk.own_u[i] = chunk.own_u[chunk.count - 1], chunk.own_v[i] = chunk.own_v[chunk.count - 1];
  chunk.u = chunk.own_u, chunk.v = chunk.own_v;
}

}  // namespace

void place(const QuadBundle& bundle, const BeamFrame&, BundleChunk& chunk) {
  chunk.u = bundle.u.data() + chunk.first, chunk.v = bundle.v.data() + chunk.first;
  if (chunk.count % kRun == 0) return;
  std::copy_n(chunk.u, chunk.count, chunk.own_u);
  std::copy_n(chunk.v, chunk.count, chunk.own_v);
  pad(chunk);
}

// Where the segments cross the square before the sphere.
void place(const SphereBundle& bundle, const BeamFrame& frame, BundleChunk& chunk) {
  for (size_t i = 0; i < chunk.count; ++i) {
    const size_t at = chunk.first + i;
    const float d[3] = {bundle.x[at] - bundle.origin[0], bundle.y[at] - bundle.origin[1],
                        bundle.z[at] - bundle.origin[2]};
    const auto along = [&](const float(&n)[3]) { return d[0] * n[0] + d[1] * n[1] + d[2] * n[2]; };
    const float scale = 1.0f / along(frame.axis);
    chunk.own_u[i] = along(frame.to_u) * scale + 0.5f;
    chunk.own_v[i] = along(frame.to_v) * scale + 0.5f;
  }
  pad(chunk);
}

bool near_enough(const GridFrame& frame, const BeamFrame& beam, const BundleChunk& chunk) {
  float distance = 0, size = 0;
  for (int a = 0; a < 3; ++a) {
    distance += std::abs(to_grid(frame, a, beam.origin[a]));
    size += chunk.size[a] * frame.scale[a];
  }
  constexpr float kMostRounding = 2.5f * kFarthestBeam;
  return distance <= kFarthestBeam && size <= kFarthestBeam &&
         size * beam.rounding * static_cast<float>(beam.reach) <= kMostRounding;
}

bool is_narrow(const BeamFrame& beam, const BundleChunk& chunk) {
  constexpr float kMost = 0.125f;  // width of the beam by its length, in the L1 norm
  const Extent u = chunk.u_extent, v = chunk.v_extent;
  float width = 0, length = 0;
  for (int a = 0; a < 3; ++a) {
    width += (u.high - u.low) * std::abs(beam.edge_u[a]) + (v.high - v.low) * std::abs(beam.edge_v[a]);
    length += std::abs(beam.corner[a] + 0.5f * ((u.low + u.high) * beam.edge_u[a] + (v.low + v.high) * beam.edge_v[a]));
  }
  return width <= kMost * length;
}

bool misses(const GridFrame& frame, const BeamFrame& beam, const BundleChunk& chunk) {
  const Extent u = chunk.u_extent, v = chunk.v_extent;
  constexpr double kSize = kGrid;
  Vec origin;
  std::array<Vec, 4> ray;  // round the parallelogram, in grid units
  for (size_t a = 0; a < 3; ++a) {
    const double scale = frame.scale[a];
    origin[a] = (double{beam.origin[a]} - double{frame.min[a]}) * scale;
    for (size_t c = 0; c < 4; ++c)
      ray[c][a] = scale * (beam.corner[a] + double{c == 1 || c == 2 ? u.high : u.low} * beam.edge_u[a] +
                           double{c >= 2 ? v.high : v.low} * beam.edge_v[a]);
  }
  // All on the outer side of one face of the box.
  for (size_t a = 0; a < 3; ++a) {
    double low = origin[a], high = origin[a];
    for (const Vec& r : ray) {
      const double end = origin[a] + std::max(r[a], r[a] * beam.reach),
                   near_end = origin[a] + std::min(r[a], r[a] * beam.reach);
      low = std::min(low, near_end), high = std::max(high, end);
    }
    if (high <= 0 || low >= kSize) return true;
  }
  // Or the box beyond a plane through the origin, and the beam not, but for kBeyond, which is well below the room about
  // the mesh. The planes of the beam's four sides are tried. What is true of them is checked, not taken for granted: of
  // rays that are nearly parallel, rounding makes any normal.
  constexpr double kBeyond = 0x1p-4;
  for (size_t c = 0; c < 4; ++c) {
    Vec normal = cross(ray[c], ray[(c + 1) % 4]);
    for (int side = 0; side < 2; ++side, normal = {-normal[0], -normal[1], -normal[2]}) {
      double nearest = 0, farthest = 0;
      for (size_t a = 0; a < 3; ++a) nearest += normal[a] * ((normal[a] > 0 ? 0 : kSize) - origin[a]);
      if (!(nearest > 0)) continue;
      for (const Vec& r : ray) farthest = std::max(farthest, dot(normal, r));
      const double length = std::abs(normal[0]) + std::abs(normal[1]) + std::abs(normal[2]);
      if (farthest * beam.reach <= kBeyond * length) return true;
    }
  }
  return false;
}

}  // namespace vcd
