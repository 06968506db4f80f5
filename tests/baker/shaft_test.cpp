#include "classify/shaft.h"

#include <gtest/gtest.h>

#include "classify/triangle_groups.h"
#include "support/shaft_lines.h"

namespace vcd::test {
using namespace baker;
namespace {

constexpr long double kGuard = 0.05L, kGrowth = kGuard + 0x1p-10L;  // with the slack; not the baker's constants

// How far outside the shaft's worst plane a point lies.
long double outside(const Shaft& shaft, const Point& x) {
  long double most = -1e9L;
  for (uint32_t k = 0; k < shaft.planes; ++k) {
    long double d = -static_cast<long double>(shaft.offset[k]);
    for (size_t a = 0; a < 3; ++a) d += static_cast<long double>(shaft.normal[a][k]) * x[a];
    most = std::max(most, d);
  }
  return most;
}

bool in_hull(const Point& x, const std::array<Square3, 2>& squares) {
  return steps_to(x, squares[0], squares[1]).has_value();
}
// The mesh never leaves the grid.
bool in_grid(const Point& x) {
  return std::all_of(x.begin(), x.end(), [](long double c) { return c >= 0 && c <= 256; });
}

TEST(Shaft, HasTheGuardBandThatTheSpecificationPromises) {
  EXPECT_EQ(kGuardBand, 0.05f);
  EXPECT_EQ(kProofSlack, 0x1p-10f);
}

TEST(Shaft, HasNormalsOfLengthOneAndAtMostTwelvePlanes) {
  Random random(1);
  for (uint32_t level = 0; level <= 9; ++level)
    for (int i = 0; i < 300; ++i) {
      const Shaft shaft = make_shaft(random_cell(level, random));
      ASSERT_LE(shaft.planes, kShaftPlanes);
      for (uint32_t k = 0; k < kLanes; ++k) {
        const float length = std::abs(shaft.normal[0][k]) + std::abs(shaft.normal[1][k]) + std::abs(shaft.normal[2][k]);
        EXPECT_NEAR(length, k < shaft.planes ? 1 : 0, 1e-6);
        if (k >= shaft.planes) {
          EXPECT_EQ(shaft.offset[k], 1);
        }
      }
    }
}

TEST(Shaft, HoldsEverySegmentBetweenTheGrownSquares) {
  Random random(2);
  for (uint32_t level = 0; level <= 9; ++level)
    for (uint32_t pair = 0; pair < kFacePairs; ++pair)
      for (int i = 0; i < 40; ++i) {
        Cell cell = random_cell(level, random);
        cell.pair = pair;
        const Shaft shaft = make_shaft(cell);
        const auto squares = grown_squares(cell, kGrowth);
        for (int n = 0; n < 40; ++n) {
          const SegmentOfCell s = any_segment(squares, random);
          const long double t = n % 4 == 0 ? n / 4 % 2 : random.uniform();
          Point x;
          for (size_t a = 0; a < 3; ++a) x[a] = s.from[a] + t * (s.to[a] - s.from[a]);
          ASSERT_LE(outside(shaft, x), 0x1p-13L) << level << " " << pair;
        }
      }
}

TEST(Shaft, HoldsNothingElseInsideTheGrid) {
  Random random(3);
  int near = 0, inside = 0;
  for (uint32_t level = 0; level <= 9; ++level)
    for (uint32_t pair = 0; pair < kFacePairs; ++pair)
      for (int i = 0; i < 20; ++i) {
        Cell cell = random_cell(level, random);
        cell.pair = pair;
        const Shaft shaft = make_shaft(cell);
        const auto squares = grown_squares(cell, kGrowth), larger = grown_squares(cell, kGrowth + 0x1p-12L);
        for (int n = 0; n < 60; ++n) {
          const SegmentOfCell s = any_segment(squares, random);
          const double t = random.uniform(), spread = 300 * std::pow(2.0, -1.0 * random.below(14));
          Point x;
          for (size_t a = 0; a < 3; ++a) x[a] = s.from[a] + t * (s.to[a] - s.from[a]) + random.between(-spread, spread);
          if (!in_grid(x)) continue;
          if (outside(shaft, x) <= 0) {
            EXPECT_TRUE(in_hull(x, larger)) << level << " " << pair << " " << static_cast<double>(outside(shaft, x));
            ++inside;
          } else {
            EXPECT_FALSE(in_hull(x, grown_squares(cell, kGrowth - 0x1p-12L)));
            ++near;
          }
        }
      }
  EXPECT_GT(near, 20000);
  EXPECT_GT(inside, 20000);
}

// A point of a triangle in a hull, found by walking to the hull's nearest point in the triangle's barycentric plane.
bool sampled_meets(const std::array<Point, 3>& t, const std::array<Square3, 2>& squares, int steps) {
  for (int i = 0; i <= steps; ++i)
    for (int j = 0; i + j <= steps; ++j) {
      const long double v = static_cast<long double>(i) / steps, w = static_cast<long double>(j) / steps;
      Point x;
      for (size_t a = 0; a < 3; ++a) x[a] = t[0][a] * (1 - v - w) + t[1][a] * v + t[2][a] * w;
      if (in_hull(x, squares)) return true;
    }
  return false;
}

TEST(TriangleMeets, IsNeverFalseForATriangleWithAPointInTheHull) {
  Random random(4);
  int touching = 0;
  for (int i = 0; i < 60000; ++i) {
    const Cell cell = random_cell(random.below(10), random);
    const Shaft shaft = make_shaft(cell);
    const auto squares = grown_squares(cell, kGuard);
    // A triangle through a point of the hull: that point is a corner, on an edge or within.
    const SegmentOfCell s = any_segment(squares, random);
    const double step = random.below(3) ? random.uniform() : random.below(2);
    const double size = 256 * std::pow(2.0, -1.0 * random.below(20));
    Point x;
    Position corner[3];
    for (size_t a = 0; a < 3; ++a) {
      x[a] = s.from[a] + step * (s.to[a] - s.from[a]);
      const double p = static_cast<double>(x[a]) + random.between(-size, size);
      const double q = static_cast<double>(x[a]) + random.between(-size, size);
      const uint32_t kind = static_cast<uint32_t>(i % 3);
      corner[0][a] = static_cast<float>(kind == 0 ? static_cast<double>(x[a]) : p);
      corner[1][a] = static_cast<float>(kind == 1 ? 2 * static_cast<double>(x[a]) - p : q);
      corner[2][a] = static_cast<float>(kind == 2 ? 3 * static_cast<double>(x[a]) - p - q : q + 1);
    }
    EXPECT_TRUE(triangle_meets(shaft, corner[0], corner[1], corner[2])) << i;
    ++touching;
  }
  EXPECT_EQ(touching, 60000);
}

TEST(TriangleMeets, SaysSoForNothingElse) {
  Random random(5);
  int apart = 0, meeting = 0, wrong = 0;
  for (int i = 0; i < 6000; ++i) {
    const Cell cell = random_cell(random.below(5), random);
    const Shaft shaft = make_shaft(cell);
    const auto larger = grown_squares(cell, kGrowth + 0.5L);
    const SegmentOfCell s = any_segment(larger, random);
    const double size = 100 * std::pow(2.0, -1.0 * random.below(5)), step = random.uniform();
    Position corner[3];
    std::array<Point, 3> exact;
    for (size_t a = 0; a < 3; ++a) {
      const double x = static_cast<double>(s.from[a] + step * (s.to[a] - s.from[a]));
      for (size_t c = 0; c < 3; ++c)
        exact[c][a] = corner[c][a] = std::clamp(static_cast<float>(x + random.between(-size, size)), 0.0f, 256.0f);
    }
    const bool says = triangle_meets(shaft, corner[0], corner[1], corner[2]);
    if (sampled_meets(exact, grown_squares(cell, kGuard), 12)) {
      EXPECT_TRUE(says);
      ++meeting;
    } else if (!sampled_meets(exact, larger, 100)) {  // apart by about half a unit, or nearly so
      ++apart;
      wrong += says;
    }
  }
  EXPECT_GT(meeting, 1000);
  EXPECT_GT(apart, 500);
  EXPECT_LT(wrong * 100, apart);
}

}  // namespace
}  // namespace vcd::test
