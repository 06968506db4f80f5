// Hierarchies against exact arithmetic: every kernel, one by one, in arrays and from one point.
#include <bit>
#include <cmath>
#include <sstream>
#include <string>

#include <gtest/gtest.h>

#include <vcd/baker/audit.h>

#include "hierarchy/fan.h"
#include "lookup/kernels.h"
#include "runtime/judged_mesh.h"
#include "support/hostile_meshes.h"
#include "support/meshes.h"
#include "support/random.h"
#include "support/special_floats.h"

namespace vcd::test {
using namespace baker;
namespace {

SourceMesh moved(SourceMesh mesh, float scale, Position shift) {
  for (Position& p : mesh.positions)
    for (size_t a = 0; a < 3; ++a) p[a] = p[a] * scale + shift[a];
  return mesh;
}

// Long and thin, and many at one vertex.
SourceMesh needles() {
  SourceMesh mesh{"needles", 0, {{0, 0, 0}}, {}};
  FloatRandom random(4);
  for (uint32_t i = 0; i < 200; ++i) {
    const Position p = {random.between(-1, 1), random.between(-1, 1), random.between(-1, 1)};
    mesh.positions.push_back(p);
    mesh.positions.push_back({p[0] + 1e-6f, p[1], p[2] - 1e-6f});
    mesh.triangles.push_back({0, 2 * i + 1, 2 * i + 2});
  }
  return mesh;
}

std::vector<SourceMesh> subjects() {
  return {triangle(),
          cube(),
          sphere(),
          leaves(300),
          folded(),
          needles(),
          moved(sphere(), 0x1p-24f, {}),
          moved(leaves(100), 0x1p30f, {}),
          moved(sphere(), 1, {4000, -3000, 7000}),
          moved(leaves(100), 1, {4096, 0, 0})};
}

std::string describe(const SourceMesh& mesh) {
  return mesh.name + " at " + std::to_string(mesh.positions[0][0]) + " of " + std::to_string(mesh.triangles.size());
}

// With the bits of its numbers.
std::string text_of(const Segment& s) {
  std::ostringstream text;
  for (float x :
       {s.origin[0], s.origin[1], s.origin[2], s.t_min, s.direction[0], s.direction[1], s.direction[2], s.t_max})
    text << ' ' << x << " (" << std::bit_cast<uint32_t>(x) << ')';
  return text.str();
}

void expect_exact(const JudgedMesh& subject, std::span<const Segment> segments) {
  for (size_t first = 0; first < segments.size(); first += kChunk) {
    const auto part = segments.subspan(first, std::min(kChunk, segments.size() - first));
    SampleBits expected{};
    for (size_t i = 0; i < part.size(); ++i) expected.set(i, subject.referee.occluded(part[i]));
    for (const Kernels* kernels : usable_kernels()) {
      const SampleBits all = SampleBits::first(part.size());
      const SampleBits found = kernels->trace.array(subject.traced, part.data(), all);
      for (size_t i = 0; i < part.size(); ++i) {
        const Segment& s = part[i];
        ASSERT_EQ(kernels->trace.one(subject.traced, s), (expected & SampleBits::just(i)).any())
            << kernels->name << text_of(s);
        ASSERT_EQ((found & SampleBits::just(i)).any(), (expected & SampleBits::just(i)).any())
            << kernels->name << text_of(s);
      }
    }
  }
}

TEST(Hierarchy, IsExactOnLinesThatAreAimedAndOnOthers) {
  for (SourceMesh& source : subjects()) {
    SCOPED_TRACE(describe(source));
    const JudgedMesh subject(std::move(source));
    for (size_t kind = 0; kind < kAuditKinds; ++kind) {
      std::vector<Segment> segments = audit_segments(subject.mesh, static_cast<AuditKind>(kind), 7, 1500 / kShare);
      for (size_t i = 0; i < segments.size(); i += 5) segments[i].t_min = -kInfinity, segments[i].t_max = kInfinity;
      expect_exact(subject, segments);
    }
  }
}

// Ends on the surface to the last bit, before it and behind it; and origins on vertices.
TEST(Hierarchy, IsExactAtTheEndsOfSegments) {
  FloatRandom random(5);
  for (SourceMesh& source : subjects()) {
    SCOPED_TRACE(describe(source));
    const JudgedMesh subject(std::move(source));
    std::vector<Segment> segments;
    for (int i = 0; i < 2000 / kShare; ++i) {
      const Position from = i % 3 ? subject.between(random, 0.5f) : subject.on_surface(random),
                     to = i % 4 ? subject.on_surface(random)
                                : subject.mesh
                                      .positions[random.below(static_cast<uint32_t>(subject.mesh.positions.size()))];
      Segment s{{from[0], from[1], from[2]}, 0, {to[0] - from[0], to[1] - from[1], to[2] - from[2]}, 1};
      const float ends[] = {1, std::nextafter(1.0f, 0.0f), std::nextafter(1.0f, 2.0f), 0.5f, 2, kInfinity};
      s.t_max = ends[random.below(6)];
      if (i % 7 == 0) s.t_min = std::min(s.t_max, ends[random.below(3)]);
      segments.push_back(s);
    }
    expect_exact(subject, segments);
  }
}

TEST(Hierarchy, IsExactFromFarAway) {
  FloatRandom random(6);
  for (SourceMesh& source : subjects()) {
    SCOPED_TRACE(describe(source));
    const JudgedMesh subject(std::move(source));
    std::vector<Segment> segments;
    for (int i = 0; i < 1000 / kShare; ++i) {
      const Position to = subject.on_surface(random);
      const float distance = subject.extent() * std::exp2(random.between(0, 60));
      Segment s{{}, 0, {}, 2};
      for (size_t a = 0; a < 3; ++a) {
        s.origin[a] = to[a] + distance * random.between(-1, 1);
        s.direction[a] = to[a] - s.origin[a];
      }
      const float scale = std::exp2(random.between(-60, 30));
      for (float& x : s.direction) x *= scale;
      s.t_max /= scale;
      segments.push_back(s);
    }
    expect_exact(subject, segments);
  }
}

// Whatever the bits say.
TEST(Hierarchy, AnswersAnySegmentLikeTheReferee) {
  const JudgedMesh subject(leaves(100));
  FloatRandom random(8);
  const auto any = [&] {
    constexpr float kOdd[] = {0,     -0.0f, 1,         -1,         0x1p-149f, -0x1p-130f, 1e-38f,
                              1e38f, kNaN,  kInfinity, -kInfinity, 0x1p-60f,  0x1p60f,    0.5f};
    return random.below(3) ? random.between(-2, 2) : kOdd[random.below(std::size(kOdd))];
  };
  std::vector<Segment> segments;
  for (int i = 0; i < 20000 / kShare; ++i)
    segments.push_back({{any(), any(), any()}, any(), {any(), any(), any()}, any()});
  expect_exact(subject, segments);
}

// A fan's segments with room for whole runs.
struct Directions {
  Position origin;
  alignas(64) float d[3][kChunk] = {};
  size_t count = 0;

  void add(const Position& direction) {
    for (size_t a = 0; a < 3; ++a) d[a][count] = direction[a];
    ++count;
  }
  Fan fan(const SampleBits& live) const { return {{origin[0], origin[1], origin[2]}, {d[0], d[1], d[2]}, count, live}; }
};

void expect_exact_fan(const JudgedMesh& subject, const Directions& directions, FloatRandom& random) {
  SampleBits live{}, expected{};
  const bool some = random.below(2) == 0;
  for (size_t i = 0; i < directions.count; ++i) {
    if (some && random.below(3) == 0) continue;
    live.set(i);
    expected.set(i, subject.referee.occluded(segment_of(directions.fan(live), i)));
  }
  for (const Kernels* kernels : usable_kernels()) {
    const SampleBits found = kernels->trace.fan(subject.traced, directions.fan(live));
    for (size_t i = 0; i < directions.count; ++i)
      ASSERT_EQ((found & SampleBits::just(i)).any(), (expected & SampleBits::just(i)).any())
          << kernels->name << ", sample " << i << " of " << directions.count << ": " << directions.origin[0] << ' '
          << directions.origin[1] << ' ' << directions.origin[2] << " to " << directions.d[0][i] << ' '
          << directions.d[1][i] << ' ' << directions.d[2][i];
  }
}

TEST(Hierarchy, IsExactFromOnePoint) {
  FloatRandom random(9);
  constexpr size_t kCounts[] = {1, 2, 15, 16, 17, 100, 128, 255, 256};
  for (SourceMesh& source : subjects()) {
    SCOPED_TRACE(describe(source));
    const JudgedMesh subject(std::move(source));
    for (int i = 0; i < 120 / kShare; ++i) {
      Directions directions;
      directions.origin = i % 4 == 0   ? subject.between(random, 2)
                          : i % 4 == 1 ? subject.between(random, 0)
                          : i % 4 == 2 ? subject.on_surface(random)
                                       : subject.between(random, 40);
      const Position corner = subject.between(random, 3);
      Position u, v;
      for (size_t a = 0; a < 3; ++a)
        u[a] = subject.extent() * random.between(-1, 1), v[a] = subject.extent() * random.between(-1, 1);
      const size_t count = kCounts[random.below(std::size(kCounts))];
      const uint32_t kind = random.below(5);
      for (size_t k = 0; k < count; ++k) {
        Position to = corner;
        const float x = random.uniform(), y = random.uniform();
        if (kind == 0)  // a quad
          for (size_t a = 0; a < 3; ++a) to[a] += x * u[a] + y * v[a];
        if (kind == 1) to = subject.mesh.positions[random.below(static_cast<uint32_t>(subject.mesh.positions.size()))];
        if (kind == 2) to = subject.between(random, 1);  // all around
        if (kind == 3)                                   // a line, and a point
          for (size_t a = 0; a < 3; ++a) to[a] += k % 2 ? x * u[a] : 0;
        const float beyond = kind == 1 ? random.between(0.9f, 1.5f) : 1;
        directions.add({(to[0] - directions.origin[0]) * beyond, (to[1] - directions.origin[1]) * beyond,
                        (to[2] - directions.origin[2]) * beyond});
      }
      if (kind == 4)
        for (size_t k = 0; k < count; k += 3) directions.d[random.below(3)][k] = k % 2 ? 0 : kNaN;
      if (i % 11 == 0) directions.d[0][0] = directions.d[1][0] = directions.d[2][0] = 0;
      expect_exact_fan(subject, directions, random);
    }
  }
}

}  // namespace
}  // namespace vcd::test
