// Tiny meshes, degenerate ones above all, baked, and every proven answer held against exact arithmetic.
#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include <fuzzer/FuzzedDataProvider.h>

#include <vcd/baker/audit.h>
#include <vcd/baker/bake.h>
#include <vcd/baker/prepare.h>
#include <vcd/baker/referee.h>
#include <vcd/runtime/sidecar.h>

#include "fuzz/fuzz.h"
#include "fuzz/mesh_promises.h"
#include "fuzz/tiny_lines.h"
#include "support/files.h"

namespace vcd::fuzz {
using namespace baker;
namespace {

constexpr uint32_t kMostTriangles = 24;

// Vertices on a small grid, on one that is bent a hair, or any floats; triangles of any of them.
SourceMesh tiny_mesh(FuzzedDataProvider& input) {
  SourceMesh mesh{"tiny", 0, {}, {}};
  const auto kind = input.ConsumeIntegralInRange<int>(0, 3);
  const float unit = std::exp2(static_cast<float>(kind == 0 ? 0 : input.ConsumeIntegralInRange<int>(-40, 40)));
  const size_t vertices = input.ConsumeIntegralInRange<size_t>(3, 24);
  for (size_t i = 0; i < vertices; ++i) {
    Position p;
    for (float& x : p) {
      if (kind == 3) {
        const auto bits = input.ConsumeIntegral<uint32_t>();
        std::memcpy(&x, &bits, sizeof x);
        if (!std::isfinite(x)) x = 1;
        continue;
      }
      const auto byte = input.ConsumeIntegral<uint8_t>();
      x = static_cast<float>(byte % 8) * unit;
      for (int ulps = kind == 2 ? byte / 8 % 4 : 0; ulps > 0; --ulps)
        x = std::nextafter(x, byte & 128 ? 9 * unit : -9 * unit);
    }
    mesh.positions.push_back(p);
  }
  for (size_t n = input.ConsumeIntegralInRange<size_t>(1, kMostTriangles); n > 0; --n) {
    TriangleIndices t;
    for (uint32_t& corner : t) corner = input.ConsumeIntegralInRange<uint32_t>(0, static_cast<uint32_t>(vertices - 1));
    mesh.triangles.push_back(t);
  }
  return mesh;
}

[[noreturn]] void report(const PreparedMesh& mesh, const BakeOptions& options, const Segment& s, Visibility answer) {
  std::string text = "a proven answer is wrong: " + std::string(answer == Visibility::blocked ? "blocked" : "clear");
  const auto add = [&](const char* format, auto... values) {
    char line[256];
    std::snprintf(line, sizeof line, format, values...);
    text += line;
  };
  add("\n  method %d, depth %u, seed %llu", static_cast<int>(options.method), options.depth,
      static_cast<unsigned long long>(options.seed));
  add("\n  segment {{%a, %a, %a}, %a, {%a, %a, %a}, %a}", s.origin[0], s.origin[1], s.origin[2], s.t_min,
      s.direction[0], s.direction[1], s.direction[2], s.t_max);
  for (const Position& p : mesh.positions) add("\n  v %a %a %a", p[0], p[1], p[2]);
  for (const TriangleIndices& t : mesh.triangles) add("\n  f %u %u %u", t[0] + 1, t[1] + 1, t[2] + 1);
  broken(text);
}

void judge(const PreparedMesh& mesh, const BakeOptions& options, const std::vector<std::byte>& file, uint64_t seed) {
  const auto all = Sidecar::open_buffer(file), proofs = Sidecar::open_buffer(file, {.proven_only = true});
  require(all.ok() && proofs.ok(), "what is written can be read");
  const Referee referee(mesh);
  for (const Segment& s : tiny_lines(mesh, options.depth, seed)) {
    const Visibility proven = proofs->object(0).classify(s), answer = all->object(0).classify(s);
    require(proven == Visibility::unclassified || proven == answer, "what is proven is among all answers");
    if (options.method == Method::proven) require(proven == answer, "method proven has proofs alone");
    if (proven != Visibility::unclassified && referee.occluded(s) != (proven == Visibility::blocked))
      report(mesh, options, s, proven);
  }
}

void bake_and_judge(FuzzedDataProvider& input) {
  BakeOptions options;
  options.method = input.ConsumeBool() ? Method::proven : Method::hybrid;
  const auto depth = input.ConsumeIntegralInRange<uint32_t>(0, 15);
  options.depth = depth == 0 ? 3 : depth < 6 ? 2 : 1;
  options.samples = options.method == Method::hybrid ? 81 : 0;
  options.threads = 1;
  options.seed = input.ConsumeIntegral<uint16_t>();
  const Result<PreparedMesh> mesh = prepare(tiny_mesh(input));
  if (!mesh) return;
  require_prepared(*mesh);
  const auto baked = bake(*mesh, options);
  if (!baked) broken("a tiny mesh can be baked: " + baked.error().message);
  judge(*mesh, options, test::sidecar_bytes({&*baked}), options.seed);
  planted_bug();
}

}  // namespace
}  // namespace vcd::fuzz

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  FuzzedDataProvider input(data, size);
  vcd::fuzz::bake_and_judge(input);
  return 0;
}
