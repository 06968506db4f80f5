#include <vcd/baker/audit_horizons.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <random>

#include <tbb/parallel_for.h>

#include <vcd/baker/referee.h>

#include "hierarchy/stop.h"

namespace vcd::baker {
namespace {

constexpr int kHalvings = 26;

class Asker {
 public:
  Asker(const HierarchyView& hierarchy, const HorizonView& horizon, uint64_t seed)
      : hierarchy_(hierarchy), horizon_(horizon), random_(seed) {}

  // A segment that is answered, if the next one is, and nearly not if `rim` is set.
  bool next(bool rim, Segment& segment) {
    const auto primitive = static_cast<uint32_t>(random_() % horizon_.header().entries);
    HorizonFrame frame;
    const uint32_t place = horizon_.entries()[primitive].place;
    if (place == 0 || !frame_at(hierarchy_, place, frame)) return false;
    segment = begin(frame);
    turn(frame, segment);
    const bool clear = ask(segment, primitive);
    if (!rim) return clear;
    Segment other = segment;
    turn(frame, other);
    if (ask(other, primitive) == clear) return clear;
    if (!clear) std::swap(segment, other);
    for (int i = 0; i < kHalvings; ++i) {
      Segment middle = segment;
      for (int a = 0; a < 3; ++a) middle.direction[a] = 0.5f * (segment.direction[a] + other.direction[a]);
      (ask(middle, primitive) ? segment : other) = middle;
    }
    return true;
  }

 private:
  float uniform() { return static_cast<float>(random_() >> 40) * 0x1p-24f; }
  bool ask(const Segment& segment, uint32_t primitive) const {
    return clear_of_horizon(horizon_, hierarchy_, segment, primitive);
  }

  // Above the triangle, mostly near to it, and at times near to an edge.
  Segment begin(const HorizonFrame& f) {
    float b = uniform(), c = uniform();
    if (b + c > 1) b = 1 - b, c = 1 - c;
    const uint64_t where = random_() % 4;
    if (where == 0) b *= 1e-3f;
    if (where == 1) c *= 1e-3f;
    const float u = b * f.u[1] + c * f.u[2], v = b * f.v[1] + c * f.v[2];
    const float w = f.top + f.size * std::ldexp(1 + uniform(), -static_cast<int>(random_() % 16));
    Segment s{{}, 0, {}, std::numeric_limits<float>::infinity()};
    for (int a = 0; a < 3; ++a) s.origin[a] = f.corner[a] + u * f.x[a] + v * f.y[a] + w * f.n[a];
    return s;
  }

  void turn(const HorizonFrame& f, Segment& s) {
    const float w = random_() % 2 ? uniform() : 0.2f * uniform(), flat = std::sqrt(1 - w * w);
    float x, y;
    do x = 2 * uniform() - 1, y = 2 * uniform() - 1;
    while (!(x * x + y * y <= 1) || x * x + y * y < 1e-4f);
    const float scale = flat / std::sqrt(x * x + y * y);
    for (int a = 0; a < 3; ++a) s.direction[a] = scale * x * f.x[a] + scale * y * f.y[a] + w * f.n[a];
  }

  const HierarchyView& hierarchy_;
  const HorizonView& horizon_;
  std::mt19937_64 random_;
};

}  // namespace

HorizonAudit audit_horizons(const PreparedMesh& mesh, const HierarchyView& hierarchy, const HorizonView& horizon,
                            uint64_t segments, const std::function<bool()>& ask) {
  if (horizon.header().entries == 0) return {};
  const Referee referee(mesh);
  Stop stop(ask);
  std::atomic<uint64_t> clear = 0, wrong = 0;
  constexpr uint64_t kTogether = 1024;  // segments that share a generator
  const uint64_t batches = (segments + kTogether - 1) / kTogether;
  tbb::parallel_for(uint64_t{0}, batches, [&](uint64_t batch) {
    if (stop.now()) return;
    Asker asker(hierarchy, horizon, batch + 1);
    for (uint64_t i = batch * kTogether; i < std::min(segments, (batch + 1) * kTogether); ++i) {
      Segment segment;
      if (!asker.next(i % 2 != 0, segment)) continue;
      ++clear, wrong += referee.occluded(segment);
    }
  });
  return {segments, clear, wrong, stop.stopped()};
}

}  // namespace vcd::baker
