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

Affine inverse(const Affine& a) {
  const Vec3 r0 = cross(a.column[1], a.column[2]), r1 = cross(a.column[2], a.column[0]),
             r2 = cross(a.column[0], a.column[1]);
  const float scale = 1 / dot(a.column[0], r0);
  Affine inverted;
  inverted.column[0] = Vec3{r0.x, r1.x, r2.x} * scale;
  inverted.column[1] = Vec3{r0.y, r1.y, r2.y} * scale;
  inverted.column[2] = Vec3{r0.z, r1.z, r2.z} * scale;
  inverted.offset = inverted.vector(a.offset) * -1;
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
