#include "classify/crossings.h"

#include <gtest/gtest.h>

#include "support/hostile_meshes.h"
#include "support/shaft_lines.h"

namespace vcd::test {
using namespace baker;
namespace {

Line line_of(const SegmentOfCell& s) {
  Line line;
  for (size_t a = 0; a < 3; ++a)
    line.from[a] = static_cast<double>(s.from[a]), line.to[a] = static_cast<double>(s.to[a]);
  return line;
}
SegmentOfCell segment_of(const Line& line) {
  return {{line.from[0], line.from[1], line.from[2]}, {line.to[0], line.to[1], line.to[2]}};
}

struct Counts {
  uint64_t sure = 0, unsure = 0, crossed = 0;
};

// Compares the crossings of a line with the referee's.
void compare(const TriangleGroups& groups, const std::vector<std::array<Point, 3>>& triangles, const Line& line,
             Counts& counts) {
  std::vector<Crossing> found;
  const bool sure = crossings(groups, groups.all(), line, found);
  (sure ? counts.sure : counts.unsure) += 1;
  if (!sure) return;
  std::vector<bool> crossed(triangles.size());
  for (size_t i = 0; i < found.size(); ++i) {
    if (i > 0) {
      EXPECT_LE(found[i - 1].at, found[i].at);
    }
    EXPECT_GT(found[i].at, 0);
    EXPECT_LT(found[i].at, 1);
    EXPECT_FALSE(crossed[found[i].triangle]);
    crossed[found[i].triangle] = true;
    ++counts.crossed;
  }
  for (uint32_t t = 0; t < triangles.size(); ++t) {
    const Meets answer = meets(segment_of(line), triangles[t]);
    EXPECT_NE(answer, crossed[t] ? Meets::no : Meets::yes);
    if (answer == Meets::unsure) {  // in the plane of a triangle, and beside it
      EXPECT_FALSE(crossed[t]);
    }
  }
}

// The triangles as the baker sees them: rounded to float.
std::vector<std::array<Point, 3>> rounded_triangles(const PreparedMesh& mesh) {
  const auto positions = positions_in_grid(mesh);
  std::vector<std::array<Point, 3>> out;
  for (const TriangleIndices& t : mesh.triangles) {
    auto& triangle = out.emplace_back();
    for (size_t c = 0; c < 3; ++c)
      for (size_t a = 0; a < 3; ++a) triangle[c][a] = positions[t[c]][a];
  }
  return out;
}

TEST(Crossings, AreThoseOfTheReferee) {
  Random random(1);
  Counts counts;
  for (const PreparedMesh& mesh : hostile_meshes()) {
    const TriangleGroups groups(positions_in_grid(mesh), mesh.triangles);
    const auto triangles = rounded_triangles(mesh);
    for (int i = 0; i < 150; ++i) {
      const Cell cell = random_cell(random.below(7), random);
      compare(groups, triangles, line_of(any_segment(grown_squares(cell, 0), random)), counts);
      // Through a triangle, or close by its corner.
      const auto& t = triangles[random.below(static_cast<uint32_t>(triangles.size()))];
      Point x = t[0];
      const double v = random.uniform(), off = random.below(2) ? std::pow(2.0, -1.0 * random.below(40)) : 0;
      for (size_t a = 0; a < 3; ++a)
        x[a] += random.below(2) ? v * (t[1][a] - t[0][a]) * 0.5 + v * (t[2][a] - t[0][a]) * 0.4 : off;
      const auto squares = grown_squares(cell_of_line(x, random.below(7), random), 0);
      if (const auto s = segment_through(x, squares, random)) compare(groups, triangles, line_of(*s), counts);
    }
  }
  EXPECT_GT(counts.sure, 5000u);
  EXPECT_GT(counts.crossed, 3000u);
}

TEST(Crossings, AreUnsureOnlyCloseToAnEdge) {
  const PreparedMesh mesh = prepared_on_grid(on_grid(cube(), 16));  // the faces are x, y or z = 16 and 240
  const TriangleGroups groups(positions_in_grid(mesh), mesh.triangles);
  std::vector<Crossing> found;
  const auto across = [&](double y, double z) {
    return crossings(groups, groups.all(), {{0, y, z}, {256, y, z}}, found);
  };
  Random random(2);
  for (int i = 0; i < 2000; ++i) {
    const double y = random.between(0, 256), z = random.between(0, 256);
    double near = std::min(std::abs(y - z), std::abs(y + z - 256));
    for (double c : {y, z}) near = std::min({near, std::abs(c - 16), std::abs(c - 240)});
    const bool sure = across(y, z);
    if (near > 1e-9) {
      EXPECT_TRUE(sure) << y << " " << z;
    }
    const bool through = std::min(y, z) > 16 && std::max(y, z) < 240;
    if (sure) {
      EXPECT_EQ(found.size(), through ? 2u : 0u);
    }
  }
  EXPECT_FALSE(across(16, 100));
  EXPECT_FALSE(across(240, 240));
  EXPECT_TRUE(across(16 - 1e-6, 100));
  EXPECT_TRUE(found.empty());
  EXPECT_TRUE(across(16 + 1e-6, 100));
  EXPECT_EQ(found.size(), 2u);
}

}  // namespace
}  // namespace vcd::test
