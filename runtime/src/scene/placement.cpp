#include "scene/placement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace vcd {
namespace {

using Vec = std::array<double, 3>;

float down(double x) { return std::nextafter(static_cast<float>(x), -std::numeric_limits<float>::infinity()); }
float up(double x) { return std::nextafter(static_cast<float>(x), std::numeric_limits<float>::infinity()); }

}  // namespace

std::optional<Placed> place(const SceneInstance& instance, const Transform& to_world) {
  double m[3][3], t[3];
  for (size_t i = 0; i < 3; ++i) {
    for (size_t j = 0; j < 3; ++j) m[i][j] = to_world.rows[i][j];
    t[i] = to_world.rows[i][3];
  }
  const auto cofactor = [&](size_t i, size_t j) {
    const size_t a = (i + 1) % 3, b = (i + 2) % 3, c = (j + 1) % 3, d = (j + 2) % 3;
    return m[a][c] * m[b][d] - m[a][d] * m[b][c];
  };
  const double determinant = m[0][0] * cofactor(0, 0) + m[0][1] * cofactor(0, 1) + m[0][2] * cofactor(0, 2);
  double size = 1;  // Hadamard: of a matrix with such rows the determinant is at most this
  for (const auto& row : m) size *= std::sqrt(row[0] * row[0] + row[1] * row[1] + row[2] * row[2]);
  constexpr double kFlattest = 1e-6;
  if (!(std::abs(determinant) > kFlattest * size) || !std::isfinite(size + t[0] + t[1] + t[2])) return std::nullopt;

  Placed placed{};
  Vec middle;
  for (size_t a = 0; a < 3; ++a) {
    const double low = instance.box_min[a], high = instance.box_max[a];
    if (!(low < high) || !usable_extent(instance.box_max[a] - instance.box_min[a])) return std::nullopt;
    middle[a] = 0.5 * (low + high);
  }
  for (size_t i = 0; i < 3; ++i) {
    double centre = t[i], reach = 0;
    for (size_t j = 0; j < 3; ++j) {
      centre += m[i][j] * middle[j];
      reach += std::abs(m[i][j]) * 0.5 * (double{instance.box_max[j]} - double{instance.box_min[j]});
    }
    placed.to_grid.centre[i] = static_cast<float>(centre);
    placed.low[i] = down(centre - reach), placed.high[i] = up(centre + reach);
  }
  const GridFrame frame = make_grid_frame(instance.box_min, instance.box_max);
  for (size_t i = 0; i < 3; ++i) {
    // The centre's own rounding goes into the offset: the object's point that stands exactly there.
    double offset = -double{frame.min[i]};
    for (size_t j = 0; j < 3; ++j) {
      const double inverse = cofactor(j, i) / determinant;
      placed.to_grid.column[j][i] = static_cast<float>(inverse * double{frame.scale[i]});
      offset += inverse * (double{placed.to_grid.centre[j]} - t[j]);
    }
    placed.to_grid.offset[i] = static_cast<float>(offset * double{frame.scale[i]});
  }
  bool finite = true;
  for (size_t j = 0; j < 3; ++j) {
    auto& column = placed.to_grid.column[j];
    for (size_t i = 0; i < 3; ++i) column[3] += std::abs(column[i]);
    finite &=
        std::isfinite(column[3] + placed.to_grid.centre[j] + placed.to_grid.offset[j] + placed.low[j] + placed.high[j]);
  }
  return finite ? std::optional(placed) : std::nullopt;
}

void pad_box(SceneInstance& instance) {
  float longest = 0;
  for (int a = 0; a < 3; ++a) longest = std::max(longest, instance.box_max[a] - instance.box_min[a]);
  for (int a = 0; a < 3; ++a) {
    const float pad = std::max(instance.box_max[a] - instance.box_min[a], longest * 0x1p-6f) * 0x1p-10f;
    const float size = std::max(std::abs(instance.box_min[a]), std::abs(instance.box_max[a])) * 0x1p-22f;
    instance.box_min[a] -= pad + size, instance.box_max[a] += pad + size;
  }
}

}  // namespace vcd
