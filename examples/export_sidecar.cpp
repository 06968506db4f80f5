// What an exporter of a modelling program does: the arrays of a mesh → its sidecar, with progress, and Ctrl-C to
// cancel.
//
//   find_package(vcd REQUIRED COMPONENTS baker), target vcd::baker; or c++ -std=c++20 … $(pkg-config --cflags --libs
//   vcd-baker)
#include <atomic>
#include <csignal>
#include <cstdio>

#include <vcd/baker/bake_sidecar.h>

std::atomic<bool> cancelled = false;

int main(int argc, char** argv) {
  const float positions[][3] = {{-1, 0, -1}, {1, 0, -1}, {1, 0, 1}, {-1, 0, 1}, {0, 1, 0}};
  const uint16_t faces[][3] = {{0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}, {0, 2, 1}, {0, 3, 2}};
  const vcd::baker::MeshToBake pyramid{"pyramid", {positions, 5}, {.first = faces, .count = 6, .index_size = 2}};

  std::signal(SIGINT, [](int) { cancelled = true; });
  vcd::baker::SidecarOptions options{.method = vcd::Method::proven};
  options.progress = [](size_t, std::string_view pass, double done) {
    std::fprintf(stderr, "\r%-12.*s %3.0f %%", static_cast<int>(pass.size()), pass.data(), 100 * done);
  };
  options.stop = [] { return cancelled.load(); };
  const auto size = vcd::baker::bake_sidecar(argc > 1 ? argv[1] : "pyramid.vcd", {&pyramid, 1}, options);
  if (!size) return std::fprintf(stderr, "\n%s\n", size.error().message.c_str()), 1;
  std::printf("\n%llu bytes\n", static_cast<unsigned long long>(*size));
}
