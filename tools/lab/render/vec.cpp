#include "vec.h"

namespace vcd::render {

Affine affine(const std::array<float, 12>& m) {
  Affine a;
  a.column[0] = {m[0], m[4], m[8]};
  a.column[1] = {m[1], m[5], m[9]};
  a.column[2] = {m[2], m[6], m[10]};
  a.offset = {m[3], m[7], m[11]};
  return a;
}

// In double, which holds the products of three floats of any size.
Affine inverse(const Affine& a) {
  struct Wide {
    double x, y, z;
  };
  const auto wide = [](Vec3 v) { return Wide{v.x, v.y, v.z}; };
  const auto cross = [](Wide p, Wide q) {
    return Wide{p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x};
  };
  const auto dot = [](Wide p, Wide q) { return p.x * q.x + p.y * q.y + p.z * q.z; };
  const Wide x = wide(a.column[0]), y = wide(a.column[1]), z = wide(a.column[2]), offset = wide(a.offset);
  const Wide rows[3] = {cross(y, z), cross(z, x), cross(x, y)};
  const double scale = 1 / dot(x, rows[0]);
  const auto to_float = [&](double p, double q, double r) {
    return Vec3{static_cast<float>(p * scale), static_cast<float>(q * scale), static_cast<float>(r * scale)};
  };
  Affine inverted;
  inverted.column[0] = to_float(rows[0].x, rows[1].x, rows[2].x);
  inverted.column[1] = to_float(rows[0].y, rows[1].y, rows[2].y);
  inverted.column[2] = to_float(rows[0].z, rows[1].z, rows[2].z);
  inverted.offset = to_float(-dot(rows[0], offset), -dot(rows[1], offset), -dot(rows[2], offset));
  return inverted;
}

Box transformed(const Affine& a, const Box& box) {
  Box image;
  for (uint32_t corner = 0; corner < 8; ++corner)
    image.add(a.point({corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                       corner & 4 ? box.high.z : box.low.z}));
  return image;
}

}  // namespace vcd::render
