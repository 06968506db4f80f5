#include "demand/asked_lines.h"

#include <algorithm>
#include <limits>

#include <tbb/parallel_for.h>

#include <vcd/format/answer.h>

namespace vcd::baker {
namespace {

// The whole of the segment's line inside the box, in grid units.
Segment line_in_grid(const GridFrame& frame, const Segment& segment, const LineCell& line) {
  Segment whole{};
  for (int a = 0; a < 3; ++a) {
    whole.direction[a] = segment.direction[a] * frame.scale[a];
    whole.origin[a] = to_grid(frame, a, segment.origin[a]) + line.t_entry * whole.direction[a];
  }
  whole.t_max = line.t_exit - line.t_entry;
  return whole;
}

}  // namespace

std::vector<AskedLine> asked_lines(const GridMesh& mesh, const Tracer& tracer, const uint8_t* clearances,
                                   std::span<const AskedSegment> segments) {
  const GridFrame frame = make_grid_frame(mesh.source.box_min.data(), mesh.source.box_max.data());
  constexpr uint64_t kNoLine = std::numeric_limits<uint64_t>::max();
  std::vector<AskedLine> lines(segments.size());
  tbb::parallel_for(size_t{0}, segments.size(), [&](size_t i) {
    const auto& [segment, weight] = segments[i];
    const LineCell line = locate(frame, segment);
    const Place place =
        widened(place_of(line, segment.t_min, segment.t_max), clearances, line, segment.t_min, segment.t_max);
    const bool asks_a_cell = place == Place::pierces || place == Place::ends_inside;
    const bool hopeless =
        !asks_a_cell || (place == Place::ends_inside && tracer.occluded(line_in_grid(frame, segment, line)));
    lines[i] = {hopeless ? kNoLine : line_key(line), weight, place == Place::pierces};
  });
  std::erase_if(lines, [](const AskedLine& line) { return line.key == kNoLine; });
  std::ranges::stable_sort(lines, {}, &AskedLine::key);
  return lines;
}

}  // namespace vcd::baker
