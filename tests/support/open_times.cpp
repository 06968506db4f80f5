// open_times SIDECAR [ROUNDS]: how long Sidecar::open takes at each level, median of interleaved rounds, the file
// mapped and in the page cache.
#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include <vcd/runtime/sidecar.h>

int main(int argc, char** argv) {
  using namespace vcd;
  constexpr std::array kLevels = {CheckLevel::bounds, CheckLevel::checksums, CheckLevel::canonical};
  constexpr std::array kNames = {"bounds", "checksums", "canonical"};
  const int rounds = argc > 2 ? std::atoi(argv[2]) : 51;
  if (argc < 2 || rounds < 1) return std::fprintf(stderr, "open_times SIDECAR [ROUNDS]\n"), 1;
  std::array<std::vector<double>, 3> milliseconds;
  for (int round = 0; round < rounds; ++round)
    for (size_t i = 0; i < kLevels.size(); ++i) {
      const auto start = std::chrono::steady_clock::now();
      const auto sidecar = Sidecar::open(argv[1], {Load::map, kLevels[i]});
      const std::chrono::duration<double, std::milli> taken = std::chrono::steady_clock::now() - start;
      if (!sidecar) return std::fprintf(stderr, "%s\n", sidecar.error().message.c_str()), 3;
      milliseconds[i].push_back(taken.count());
    }
  for (size_t i = 0; i < kLevels.size(); ++i) {
    std::ranges::sort(milliseconds[i]);
    std::printf("%-9s %8.2f ms\n", kNames[i], milliseconds[i][milliseconds[i].size() / 2]);
  }
}
