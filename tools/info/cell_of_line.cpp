#include "cell_of_line.h"

#include <algorithm>
#include <limits>
#include <utility>

#include <vcd/format/tree.h>

namespace vcd::tools {

std::optional<CellOfLine> cell_of_line(const ObjectContents& object, const std::array<double, 3>& point,
                                       const std::array<double, 3>& direction) {
  const ObjectRecord& record = *object.record;
  // The way through the box. A look-up wants an origin that is not far from it.
  double entry = -std::numeric_limits<double>::infinity(), exit = -entry;
  for (size_t a = 0; a < 3; ++a) {
    if (direction[a] == 0) {
      if (!(point[a] > record.box_min[a] && point[a] < record.box_max[a])) return std::nullopt;
      continue;
    }
    double near = (record.box_min[a] - point[a]) / direction[a], far = (record.box_max[a] - point[a]) / direction[a];
    if (near > far) std::swap(near, far);
    entry = std::max(entry, near), exit = std::min(exit, far);
  }
  if (!(entry < exit)) return std::nullopt;
  Segment segment{{}, 0, {}, 1};  // from one length of the way before it to one behind it
  for (size_t a = 0; a < 3; ++a) {
    segment.origin[a] = static_cast<float>(point[a] + (2 * entry - exit) * direction[a]);
    segment.direction[a] = static_cast<float>(3 * (exit - entry) * direction[a]);
  }
  const LineCell line = locate(make_grid_frame(record.box_min, record.box_max), segment);
  if (!line.valid || !line.hits) return std::nullopt;
  CellClass cell = class_of(object.tree, line);
  if (cell == CellClass::statistically_blocked && record.method != static_cast<uint8_t>(Method::hybrid))
    cell = CellClass::unclassified;  // no reader believes it
  if (cell == CellClass::blocked && record.method == static_cast<uint8_t>(Method::sampled))
    cell = CellClass::statistically_blocked;
  return CellOfLine{line, cell};
}

}  // namespace vcd::tools
