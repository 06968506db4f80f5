// "Line to cell" of spec/vcd-format.md, step by step and one axis at a time: the plain twin of vcd::locate.
#pragma once

#include <cmath>

#include <vcd/format/line_cell.h>

namespace vcd::test {

inline LineCell reference_locate(const float box_min[3], const float box_max[3], const Segment& segment) {
  float p[3], q[3], near[3], far[3];
  for (int a = 0; a < 3; ++a) {
    const float extent = box_max[a] - box_min[a];
    const float scale = 256.0f / extent;
    p[a] = (segment.origin[a] - box_min[a]) * scale;
    q[a] = segment.direction[a] * scale;
  }
  const float distance = (std::fabs(p[0]) + std::fabs(p[1])) + std::fabs(p[2]);
  const float length = (std::fabs(q[0]) + std::fabs(q[1])) + std::fabs(q[2]);
  LineCell cell{};
  cell.valid = distance <= 0x1p17f && length >= 0x1p-40f && length <= 0x1p100f;
  for (int a = 0; a < 3; ++a) {
    const float size = std::fabs(q[a]) > 0x1p-100f ? std::fabs(q[a]) : 0x1p-100f;
    q[a] = std::signbit(q[a]) ? -size : size;
    const float r = 1.0f / q[a];
    const float low = (0.0f - p[a]) * r, high = (256.0f - p[a]) * r;
    near[a] = low < high ? low : high;
    far[a] = low < high ? high : low;
  }
  int entry_axis = 0, exit_axis = 0;
  for (int a = 1; a < 3; ++a) {
    if (near[a] > near[entry_axis]) entry_axis = a;
    if (far[a] < far[exit_axis]) exit_axis = a;
  }
  cell.t_entry = near[entry_axis];
  cell.t_exit = far[exit_axis];
  cell.hits = cell.t_entry < cell.t_exit;
  const int entry_face = 2 * entry_axis + (q[entry_axis] < 0 ? 1 : 0);
  const int exit_face = 2 * exit_axis + (q[exit_axis] < 0 ? 0 : 1);

  uint32_t at[2][3];  // entry, exit
  for (int a = 0; a < 3; ++a)
    for (int end = 0; end < 2; ++end) {
      const float product = q[a] * (end == 0 ? cell.t_entry : cell.t_exit);
      const float x = product + p[a];
      at[end][a] = x > 0 ? static_cast<uint32_t>(x < 255.0f ? x : 255.0f) : 0;
    }
  const bool entry_first = entry_face < exit_face;
  const int low_face = entry_first ? entry_face : exit_face, high_face = entry_first ? exit_face : entry_face;
  const uint32_t* on_low = at[entry_first ? 0 : 1];
  const uint32_t* on_high = at[entry_first ? 1 : 0];
  uint32_t pair = 0;
  for (int i = 0; i < 6; ++i)
    for (int j = i + 1; j < 6; ++j) {
      if (i == low_face && j == high_face) cell.pair = pair;
      ++pair;
    }
  const int first_axis[3] = {1, 0, 0}, second_axis[3] = {2, 2, 1};
  cell.s = on_low[first_axis[low_face / 2]];
  cell.t = on_low[second_axis[low_face / 2]];
  cell.u = on_high[first_axis[high_face / 2]];
  cell.v = on_high[second_axis[high_face / 2]];
  return cell;
}

}  // namespace vcd::test
