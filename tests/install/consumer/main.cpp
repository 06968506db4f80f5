// A renderer in miniature, outside the project: opens a sidecar and asks one segment through its middle.
#include <cstdio>

#include <vcd/runtime/sidecar.h>

int main(int argc, char** argv) {
  const auto sidecar = vcd::Sidecar::open(argc > 1 ? argv[1] : "");
  if (!sidecar) return std::fprintf(stderr, "%s\n", sidecar.error().message.c_str()), 1;
  const vcd::Object object = sidecar->object(0);
  const vcd::ObjectRecord& r = object.record();
  vcd::Segment segment{};
  for (int a = 0; a < 3; ++a) segment.origin[a] = (r.box_min[a] + r.box_max[a]) / 2;
  segment.origin[0] = r.box_min[0] - 1;
  segment.direction[0] = r.box_max[0] - r.box_min[0] + 2;
  segment.t_max = 1;
  const bool blocked = object.occluded(segment, [] { return false; });
  std::printf("%zu objects, %s\n", sidecar->object_count(), blocked ? "blocked" : "not blocked");
}
