// array_times SIDECAR SEGMENTS: nanoseconds a segment of classify() and of occluded() for one array of 32-byte
// segments, the least of five calls each.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <vector>

#include <vcd/format/file_bytes.h>
#include <vcd/runtime/sidecar.h>

namespace {

template <class Call>
double least_nanoseconds(Call&& call) {
  double least = 1e300;
  for (int i = 0; i < 5; ++i) {
    const auto begun = std::chrono::steady_clock::now();
    call();
    least = std::min(least, std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - begun).count());
  }
  return least;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 1;
  const auto sidecar = vcd::Sidecar::open(argv[1]);
  const auto bytes = vcd::FileBytes::copy(argv[2]);
  if (!sidecar || !bytes) return 2;
  const vcd::Object object = sidecar->object(0);
  const std::span segments(reinterpret_cast<const vcd::Segment*>(bytes->bytes().data()),
                           bytes->bytes().size() / sizeof(vcd::Segment));
  std::vector<vcd::Visibility> answers(segments.size());
  std::vector<uint64_t> blocked((segments.size() + 63) / 64);
  const double count = static_cast<double>(segments.size());
  std::printf("%.2f %.2f\n", least_nanoseconds([&] { object.classify(segments, answers); }) / count,
              least_nanoseconds([&] { object.occluded(segments, blocked); }) / count);
}
