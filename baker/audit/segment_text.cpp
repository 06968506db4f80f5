#include <cstdio>
#include <cstdlib>

#include <vcd/baker/audit.h>

namespace vcd::baker {

std::string replayable(const Segment& s) {
  char text[256];
  std::snprintf(text, sizeof text, "%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g,%.9g", s.origin[0], s.origin[1], s.origin[2],
                s.t_min, s.direction[0], s.direction[1], s.direction[2], s.t_max);
  return text;
}

bool parse_segment(const std::string& text, Segment& segment) {
  float* const targets[8] = {&segment.origin[0],    &segment.origin[1],    &segment.origin[2],    &segment.t_min,
                             &segment.direction[0], &segment.direction[1], &segment.direction[2], &segment.t_max};
  const char* at = text.c_str();
  for (int i = 0; i < 8; ++i) {
    char* end = nullptr;
    *targets[i] = std::strtof(at, &end);
    if (end == at || *end != (i < 7 ? ',' : '\0')) return false;
    at = end + 1;
  }
  return true;
}

}  // namespace vcd::baker
