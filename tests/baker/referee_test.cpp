#include <vcd/baker/referee.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

#include <gtest/gtest.h>
#include <boost/multiprecision/cpp_int.hpp>

#include <vcd/baker/audit.h>
#include <vcd/baker/tracer.h>

#include "support/meshes.h"
#include "support/special_floats.h"

namespace vcd::test {
using namespace baker;
namespace {

// Another way to the exact answer, by rationals: Cramer's rule for the line and the plane; for lines in the plane,
// crossings with the edges in the projection that shows the triangle largest.
using Rational = boost::multiprecision::cpp_rational;
using RationalVec = std::array<Rational, 3>;

RationalVec exact(const float* v) { return {Rational(v[0]), Rational(v[1]), Rational(v[2])}; }
RationalVec difference(const RationalVec& a, const RationalVec& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
Rational determinant(const RationalVec& a, const RationalVec& b, const RationalVec& c) {
  return a[0] * (b[1] * c[2] - b[2] * c[1]) - a[1] * (b[0] * c[2] - b[2] * c[0]) + a[2] * (b[0] * c[1] - b[1] * c[0]);
}

bool in_interval(const Rational& t, const Segment& s) {
  return (std::isinf(s.t_min) || Rational(s.t_min) < t) && (std::isinf(s.t_max) || t < Rational(s.t_max));
}

bool crosses_in_plane(const RationalVec& o, const RationalVec& d, const std::array<RationalVec, 3>& corners,
                      const Segment& s) {
  int x = 0, y = 1;
  Rational best = 0;
  const auto twice_area = [](const RationalVec& a, const RationalVec& b, const RationalVec& c, int i, int j) {
    return Rational((b[i] - a[i]) * (c[j] - a[j]) - (b[j] - a[j]) * (c[i] - a[i]));
  };
  for (const auto& [i, j] : {std::pair(0, 1), std::pair(1, 2), std::pair(2, 0)}) {
    const Rational area = abs(twice_area(corners[0], corners[1], corners[2], i, j));
    if (area > best) best = area, x = i, y = j;
  }
  // The point in the middle of what the parameters of all crossings cut the interval into, and the crossings.
  const auto inside = [&](const Rational& t) {
    RationalVec p;
    for (int a = 0; a < 3; ++a) p[a] = o[a] + t * d[a];
    int positive = 0, negative = 0;
    for (int e = 0; e < 3; ++e) {
      const Rational side = twice_area(corners[e], corners[(e + 1) % 3], p, x, y);
      positive += side > 0, negative += side < 0;
    }
    return positive == 0 || negative == 0;
  };
  std::vector<Rational> cuts;
  for (int e = 0; e < 3; ++e) {
    const RationalVec edge = difference(corners[(e + 1) % 3], corners[e]), to = difference(corners[e], o);
    const Rational across = d[x] * edge[y] - d[y] * edge[x];
    if (across != 0) cuts.push_back((to[x] * edge[y] - to[y] * edge[x]) / across);
  }
  std::vector<Rational> ends;
  for (float t : {s.t_min, s.t_max})
    if (!std::isinf(t)) ends.push_back(Rational(t));
  if (cuts.empty()) return inside(ends.empty() ? Rational(0) : ends[0]);  // a point: all parameters are alike
  std::vector<Rational> points = cuts;
  points.insert(points.end(), ends.begin(), ends.end());
  std::sort(points.begin(), points.end());
  std::vector<Rational> candidates = cuts;
  for (size_t i = 0; i + 1 < points.size(); ++i) candidates.push_back((points[i] + points[i + 1]) / 2);
  return std::any_of(candidates.begin(), candidates.end(),
                     [&](const Rational& t) { return in_interval(t, s) && inside(t); });
}

bool meets_by_rationals(const Segment& s, const Triangle& triangle) {
  const RationalVec o = exact(s.origin), d = exact(s.direction);
  const std::array<RationalVec, 3> corners = {exact(triangle[0].data()), exact(triangle[1].data()),
                                              exact(triangle[2].data())};
  const RationalVec u = difference(corners[1], corners[0]), v = difference(corners[2], corners[0]),
                    w = difference(o, corners[0]);
  // w + t d = beta u + gamma v
  const Rational whole = determinant(d, u, v);
  if (whole == 0) return determinant(w, u, v) == 0 && crosses_in_plane(o, d, corners, s);
  const Rational t = -determinant(w, u, v) / whole;
  const Rational beta = determinant(d, w, v) / whole, gamma = determinant(d, u, w) / whole;
  return beta >= 0 && gamma >= 0 && beta + gamma <= 1 && in_interval(t, s);
}

bool meets_by_rationals(const Segment& s, const PreparedMesh& mesh) {
  if (!(s.t_min < s.t_max)) return false;
  return std::any_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const TriangleIndices& t) {
    return meets_by_rationals(s, {mesh.positions[t[0]], mesh.positions[t[1]], mesh.positions[t[2]]});
  });
}

// One triangle in the plane z = 0.
const Triangle kFlat = {{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}}};
const PreparedMesh& flat_mesh() {
  static const PreparedMesh mesh = *prepare({"flat", 0, {kFlat[0], kFlat[1], kFlat[2]}, {{0, 1, 2}}});
  return mesh;
}

struct Case {
  const char* what;
  Segment segment;
  bool meets;
};
const Case kCases[] = {
    {"through the middle", {{1, 1, 1}, 0, {0, 0, -2}, 1}, true},
    {"beside it", {{3, 3, 1}, 0, {0, 0, -2}, 1}, false},
    {"a vertex", {{0, 0, 1}, 0, {0, 0, -2}, 1}, true},
    {"a vertex, slanting", {{5, 1, 3}, 0, {-1, -1, -3}, 2}, true},
    {"just beside a vertex", {{-0x1p-149f, 0, 1}, 0, {0, 0, -2}, 1}, false},
    {"an edge", {{2, 0, 1}, 0, {0, 0, -2}, 1}, true},
    {"the long edge", {{2, 2, 1}, 0, {0, 0, -2}, 1}, true},
    {"just beside the long edge", {{2, 2.0000002f, 1}, 0, {0, 0, -2}, 1}, false},
    {"in the plane, across", {{-1, 1, 0}, 0, {9, 0, 0}, 1}, true},
    {"in the plane, along an edge", {{-1, 0, 0}, 0, {9, 0, 0}, 1}, true},
    {"in the plane, through a corner only", {{-1, 1, 0}, 0, {2, -2, 0}, 1}, true},
    {"in the plane, past it", {{-1, 5, 0}, 0, {9, 0, 0}, 1}, false},
    {"in the plane, wholly inside", {{1, 1, 0}, 0, {0.5f, 0.25f, 0}, 1}, true},
    {"in the plane, before it", {{-2, 1, 0}, 0, {1, 0, 0}, 1}, false},
    {"in the plane, up to it", {{-2, 1, 0}, 0, {2, 0, 0}, 1}, false},
    {"in the plane, a little further", {{-2, 1, 0}, 0, {2, 0, 0}, 1.0000001f}, true},
    {"parallel to it", {{1, 1, 0x1p-149f}, 0, {1, 0, 0}, 1}, false},
    {"ends on it", {{1, 1, 1}, 0, {0, 0, -1}, 1}, false},
    {"ends beyond it", {{1, 1, 1}, 0, {0, 0, -1}, 1.0000001f}, true},
    {"begins on it", {{1, 1, 1}, 1, {0, 0, -1}, 2}, false},
    {"begins before it", {{1, 1, 1}, 0.99999994f, {0, 0, -1}, 2}, true},
    {"origin on it", {{1, 1, 0}, 0, {0, 0, -1}, 2}, false},
    {"origin on it, from before", {{1, 1, 0}, -1, {0, 0, -1}, 2}, true},
    {"negative parameters", {{1, 1, 1}, -2, {0, 0, 1}, 0}, true},
    {"infinite", {{1, 1, 1}, -kInfinity, {0, 0, 1}, kInfinity}, true},
    {"infinite, away from it", {{1, 1, 1}, 0, {0, 0, 1}, kInfinity}, false},
    {"infinite, in the plane", {{1, 1, 0}, -kInfinity, {1, 0, 0}, kInfinity}, true},
    {"empty", {{1, 1, 1}, 2, {0, 0, -1}, 0}, false},
    {"empty, a point", {{1, 1, 1}, 1, {0, 0, -1}, 1}, false},
    {"no length, on it", {{1, 1, 0}, 0, {0, 0, 0}, 1}, true},
    {"no length, on a corner", {{4, 0, 0}, 0, {0, -0.0f, 0}, 1}, true},
    {"no length, beside it", {{1, 1, 1}, 0, {0, 0, 0}, 1}, false},
    {"no length, beside it in its plane", {{3, 3, 0}, -kInfinity, {0, 0, 0}, kInfinity}, false},
};

TEST(Referee, DecidesEdgesVerticesPlanesAndEndsAtEveryScale) {
  for (const Case& c : kCases) {
    EXPECT_EQ(Referee(flat_mesh()).occluded(c.segment), c.meets) << c.what;
    EXPECT_EQ(meets_by_rationals(c.segment, flat_mesh()), c.meets) << c.what;
    EXPECT_EQ(meets(c.segment, kFlat), c.meets) << c.what;
  }
  // Powers of two, so that the cases stay what they are; those of 2^-149 only where there is room.
  for (int exponent : {-80, -30, 30, 80}) {
    SourceMesh scaled{"scaled", 0, {kFlat[0], kFlat[1], kFlat[2]}, {{0, 1, 2}}};
    for (Position& p : scaled.positions)
      for (float& x : p) x = std::ldexp(x, exponent);
    const Referee referee(*prepare(std::move(scaled)));
    for (const Case& c : kCases) {
      Segment s = c.segment;
      bool exact_scaling = true;
      for (int a = 0; a < 3; ++a) {
        exact_scaling &= std::ldexp(std::ldexp(s.origin[a], exponent), -exponent) == s.origin[a];
        s.origin[a] = std::ldexp(s.origin[a], exponent);
        s.direction[a] = std::ldexp(s.direction[a], exponent);
      }
      if (!exact_scaling) continue;
      EXPECT_EQ(referee.occluded(s), c.meets) << c.what << " times 2^" << exponent;
    }
  }
}

TEST(Referee, TakesNoNumbersForNo) {
  const Referee referee(flat_mesh());
  const Segment hit{{1, 1, 1}, 0, {0, 0, -2}, 1};
  ASSERT_TRUE(referee.occluded(hit));
  for (float bad : {kNaN, kInfinity, -kInfinity})
    for (int a = 0; a < 3; ++a) {
      Segment origin = hit, direction = hit;
      origin.origin[a] = bad, direction.direction[a] = bad;
      EXPECT_FALSE(referee.occluded(origin));
      EXPECT_FALSE(referee.occluded(direction));
    }
  for (int end = 0; end < 2; ++end) {
    Segment s = hit;
    (end ? s.t_max : s.t_min) = kNaN;
    EXPECT_FALSE(referee.occluded(s));
  }
}

// Segments whose numbers are few and small, so that touching, grazing and lying in a plane are the rule.
Segment on_a_lattice(std::mt19937& random) {
  const auto coordinate = [&] { return static_cast<float>(static_cast<int>(random() % 9) - 2); };
  constexpr float kBegins[] = {-kInfinity, -2, -1, -0.5f, 0, 0.25f}, kEnds[] = {0.25f, 0.5f, 1, 2, 4, kInfinity};
  return {{coordinate(), coordinate(), coordinate()},
          kBegins[random() % 6],
          {coordinate() - 2, coordinate() - 2, coordinate() - 2},
          kEnds[random() % 6]};
}

TEST(Referee, AgreesWithRationalsOnALattice) {
  std::mt19937 random(1);
  int met = 0, all = 0;
  while (all < 400) {
    SourceMesh source{"lattice", 0, {}, {}};
    for (uint32_t i = 0; i < 9; ++i)
      source.positions.push_back(
          {static_cast<float>(random() % 5), static_cast<float>(random() % 5), static_cast<float>(random() % 5)});
    source.triangles = {{0, 1, 2}, {3, 4, 5}, {6, 7, 8}};
    const auto mesh = prepare(std::move(source));
    if (!mesh) continue;
    ++all;
    const Referee referee(*mesh);
    for (int i = 0; i < 50; ++i) {
      const Segment s = on_a_lattice(random);
      const bool expected = meets_by_rationals(s, *mesh);
      met += expected;
      ASSERT_EQ(referee.occluded(s), expected)
          << s.origin[0] << ' ' << s.origin[1] << ' ' << s.origin[2] << ' ' << s.t_min << ' ' << s.direction[0] << ' '
          << s.direction[1] << ' ' << s.direction[2] << ' ' << s.t_max;
    }
  }
  EXPECT_GT(met, 1000);
}

// Aimed lines, near and far, at small meshes of every size and far from the origin, some ends moved onto the surface.
TEST(Referee, AgreesWithRationalsOnAimedLines) {
  std::mt19937 random(2);
  for (int exponent : {-80, 0, 80})
    for (float shift : {0.0f, 1000.0f}) {
      for (SourceMesh source : {cube(), sphere(3, 5), leaves(12)}) {
        for (Position& p : source.positions)
          for (float& x : p) x = std::ldexp(x + shift, exponent);
        const PreparedMesh mesh = *prepare(std::move(source));
        const Referee referee(mesh);
        for (size_t k = 0; k < kAuditKinds; ++k)
          for (Segment s : audit_segments(mesh, static_cast<AuditKind>(k), random(), 40)) {
            if (random() % 4 == 0) s.t_min = -kInfinity;
            if (random() % 4 == 0) s.t_max = kInfinity;
            ASSERT_EQ(referee.occluded(s), meets_by_rationals(s, mesh)) << exponent << ' ' << shift << ' ' << k;
          }
      }
    }
}

// Through a vertex, an edge or the inside, to the last bit, from origins a few steps of a float away from where the
// line meets it exactly, at ends a few steps from the surface: what the filter must not take for certain.
TEST(Referee, AgreesWithRationalsWithinAFewStepsOfAFloat) {
  std::mt19937 random(3);
  int met = 0;
  const auto nudge = [&](float x) {
    for (uint32_t steps = random() % 3; steps > 0; --steps) x = std::nextafter(x, random() % 2 ? 1e38f : -1e38f);
    return x;
  };
  const auto uniform = [&] { return static_cast<float>(random() >> 8) * 0x1p-23f - 1; };
  constexpr int kCount = 20000;
  for (int i = 0; i < kCount; ++i) {
    Triangle t;
    for (Position& p : t) p = {uniform(), uniform(), uniform()};
    if (i % 3 == 0) t[2][2] = t[1][2] = t[0][2];
    const float u = i % 2 ? 0 : static_cast<float>(random() % 5) / 4,
                v = static_cast<float>(random() % 5) / 4 * (1 - u);
    Segment s{};
    for (int a = 0; a < 3; ++a) {
      const float p = t[0][a] + u * (t[1][a] - t[0][a]) + v * (t[2][a] - t[0][a]);
      const float away = random() % 4 ? 4 * uniform() : 0;
      s.origin[a] = nudge(p + away);
      s.direction[a] = p - s.origin[a];
    }
    s.t_min = random() % 2 ? 0 : nudge(1);
    s.t_max = random() % 2 ? 2 : nudge(1);
    if (!(s.t_min < s.t_max)) continue;
    const bool expected = meets_by_rationals(s, t);
    met += expected;
    ASSERT_EQ(meets(s, t), expected);
  }
  EXPECT_GT(met, 1000);
}

TEST(Referee, AgreesWithEmbreeOnGenericLines) {
  for (const SourceMesh& source : {cube(), sphere(), leaves(500)}) {
    const PreparedMesh mesh = *prepare(SourceMesh(source));
    const Referee referee(mesh);
    const auto tracer = Tracer::build(mesh.positions, mesh.triangles);
    ASSERT_TRUE(tracer.ok());
    const std::vector<Segment> segments = audit_segments(mesh, AuditKind::chords, 3, 50000);
    std::vector<uint8_t> blocked(segments.size());
    referee.occluded(segments, blocked);
    int differ = 0, hit = 0;
    for (size_t i = 0; i < segments.size(); ++i) {
      differ += tracer->occluded(segments[i]) != (blocked[i] != 0);
      hit += blocked[i];
    }
    EXPECT_LE(differ, 5) << source.name;
    EXPECT_GT(hit, 5000) << source.name;
  }
}

}  // namespace
}  // namespace vcd::test
