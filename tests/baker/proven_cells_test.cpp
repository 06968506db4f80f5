// Proven classes against lines that are held against every triangle in extended precision.
#include <gtest/gtest.h>

#include "classify/crossings.h"
#include "classify/make_classifier.h"
#include "classify/proven.h"
#include "prepare/topology.h"
#include "support/files.h"
#include "support/hostile_meshes.h"
#include "support/shaft_lines.h"

namespace vcd::test {
using namespace baker;
namespace {

constexpr long double kGuard = 0.05L;
constexpr int kCells = 250;     // a mesh
constexpr int kCellLines = 40;  // a cell, of each kind

struct Tally {
  int cells[3] = {};
  uint64_t lines[2] = {}, aimed = 0;
};

class Judge {
 public:
  explicit Judge(const PreparedMesh& mesh) : triangles_(triangles_in_grid(mesh)) {}

  const std::vector<std::array<Point, 3>>& triangles() const { return triangles_; }

  // Holds a proven class against random lines of the grown cell, and lines aimed at corners, edges and beside them.
  void check(const Cell& cell, uint32_t value, Random& random, Tally& tally) const {
    ++tally.cells[value];
    if (value > kBlocked) return;
    const auto squares = grown_squares(cell, kGuard);
    const auto near = triangles_near_the(cell);
    const auto ask = [&](const SegmentOfCell& s) {
      const Meets answer = meets_any(s, near);
      ++tally.lines[value];
      EXPECT_NE(answer, value == kClear ? Meets::yes : Meets::no)
          << "pair " << cell.pair << " level " << cell.level << " at " << cell.s << " " << cell.t << " " << cell.u
          << " " << cell.v << ": " << static_cast<double>(s.from[0]) << " " << static_cast<double>(s.from[1]) << " "
          << static_cast<double>(s.from[2]) << " to " << static_cast<double>(s.to[0]) << " "
          << static_cast<double>(s.to[1]) << " " << static_cast<double>(s.to[2]);
    };
    for (int i = 0; i < kCellLines; ++i) ask(any_segment(squares, random));
    if (near.empty()) return;
    for (int i = 0; i < 3 * kCellLines; ++i) {
      const auto& t = near[random.below(static_cast<uint32_t>(near.size()))];
      const uint32_t corner = random.below(3), kind = random.below(3);
      const long double v = kind == 0 ? 0 : random.uniform(), w = kind == 2 ? (1 - v) * random.uniform() : 0;
      const long double beside = random.below(2) ? std::pow(2.0L, -1.0L * random.below(24)) : 0;
      Point x;
      for (size_t a = 0; a < 3; ++a)
        x[a] = t[corner][a] * (1 - v - w) + t[(corner + 1) % 3][a] * v + t[(corner + 2) % 3][a] * w +
               beside * random.between(-1, 1);
      const auto s = segment_through(x, squares, random);
      if (!s) continue;
      ++tally.aimed;
      ask(*s);
    }
  }

 private:
  std::vector<std::array<Point, 3>> triangles_near_the(const Cell& cell) const {
    const auto [a, b] = grown_squares(cell, 1);
    std::vector<std::array<Point, 3>> near;
    for (const auto& t : triangles_) {
      bool apart = false;
      for (size_t i = 0; i < 3; ++i) {
        const auto [low, high] = std::minmax({t[0][i], t[1][i], t[2][i]});
        apart |= high < std::min(a.min[i], b.min[i]) || low > std::max(a.max[i], b.max[i]);
      }
      if (!apart) near.push_back(t);
    }
    return near;
  }

  std::vector<std::array<Point, 3>> triangles_;
};

// Half of all cells are drawn by lines through the mesh.
Cell some_cell(const Judge& judge, Random& random) {
  const uint32_t level = 1 + random.below(6);
  if (random.below(2)) return random_cell(level, random);
  const auto& t = judge.triangles()[random.below(static_cast<uint32_t>(judge.triangles().size()))];
  Point x;
  for (size_t a = 0; a < 3; ++a) x[a] = (t[0][a] + t[1][a] + t[2][a]) / 3;
  return cell_of_line(x, level, random);
}

TEST(ProvenClassifier, IsNeverContradictedByALineOfTheGrownCell) {
  Random random(1);
  Tally all;
  for (const PreparedMesh& mesh : hostile_meshes()) {
    const GridMesh grid(mesh);
    const auto tracer = trace_in_grid(grid);
    const ProvenClassifier classifier(grid, *tracer, {});
    Workspace workspace;
    const Judge judge(mesh);
    for (int i = 0; i < kCells; ++i) {
      const Cell cell = some_cell(judge, random);
      judge.check(cell, classifier.classify(cell, true, workspace), random, all);
    }
  }
  EXPECT_GT(all.cells[kClear], 700);
  EXPECT_GT(all.cells[kBlocked], 500);
  EXPECT_GT(all.aimed, 5000u);
  RecordProperty("clear", all.cells[kClear]);
  RecordProperty("blocked", all.cells[kBlocked]);
  RecordProperty("lines", std::to_string(all.lines[0] + all.lines[1]));
}

// The proofs alone, without the sample lines that are traced before: nothing hides their mistakes.
TEST(Proofs, AreNeverContradictedByALineOfTheGrownCell) {
  Random random(2);
  Tally all;
  for (const PreparedMesh& mesh : hostile_meshes()) {
    const auto positions = positions_in_grid(mesh);
    const TriangleGroups groups(positions, mesh.triangles);
    const Surface surface(positions, mesh.triangles, pair_edges(mesh.positions, mesh.triangles));
    Surface::Flood flood;
    CandidatePath path;
    std::vector<Crossing> crossed;
    const Judge judge(mesh);
    for (int i = 0; i < kCells; ++i) {
      const Cell cell = some_cell(judge, random);
      const Shaft shaft = make_shaft(cell);
      uint32_t value = kUnclassified;
      const Candidates& candidates = path.of(groups, cell, shaft);
      if (!groups.any_meets(shaft, candidates)) value = kClear;
      const SegmentOfCell s = any_segment(grown_squares(cell, 0), random);  // any line will do to count crossings
      Line line;
      for (size_t a = 0; a < 3; ++a)
        line.from[a] = static_cast<double>(s.from[a]), line.to[a] = static_cast<double>(s.to[a]);
      flood.begin(mesh.triangles.size());
      if (value != kClear && crossings(groups, candidates, line, crossed))
        for (const Crossing& c : crossed) {
          if (flood.reached_before(c.triangle) || !surface.flood(shaft, c.triangle, 5000, flood)) continue;
          const auto odd = std::count_if(crossed.begin(), crossed.end(),
                                         [&](const Crossing& other) { return flood.reached(other.triangle); });
          if (odd % 2) value = kBlocked;
        }
      judge.check(cell, value, random, all);
    }
  }
  EXPECT_GT(all.cells[kClear], 700);
  EXPECT_GT(all.cells[kBlocked], 500);
}

TEST(ProvenClassifier, TakesAnotherLineWhereTheFirstPassesThroughAnEdge) {
  const PreparedMesh mesh = prepared_on_grid(on_grid(cube(), 16));
  const GridMesh grid(mesh);
  const auto tracer = trace_in_grid(grid);
  const ProvenClassifier classifier(grid, *tracer, {});
  Workspace workspace;
  for (uint32_t s = 2; s < 6; ++s)
    for (uint32_t u = 2; u < 6; ++u)  // their middles lie in the plane of two diagonals
      EXPECT_EQ(classifier.classify({0, 3, s, 7 - s, u, 7 - u}, true, workspace), kBlocked);
}

// What lines call clear beyond the margin is proven clear, and a convex body's shadow is proven blocked.
TEST(ProvenClassifier, ProvesNearlyAllThatLinesSuggest) {
  Random random(3);
  int suggested[2] = {}, proven[2] = {};
  for (const PreparedMesh& mesh : {*prepare(sphere(12, 20)), *prepare(cube()), *prepare(leaves(30))}) {
    const GridMesh grid(mesh);
    const auto tracer = trace_in_grid(grid);
    const ProvenClassifier classifier(grid, *tracer, {});
    Workspace workspace;
    const auto triangles = triangles_in_grid(mesh);
    for (int i = 0; i < (kSanitized ? 300 : 1500); ++i) {
      const Cell cell = random_cell(3 + random.below(3), random);
      const auto squares = grown_squares(cell, 0.25L);
      int hits = 0;
      for (int n = 0; n < 300 && (hits == 0 || hits == n); ++n)
        hits += meets_any(any_segment(squares, random), triangles) != Meets::no;
      if (hits != 0 && hits != 300) continue;
      const uint32_t expected = hits ? kBlocked : kClear;
      ++suggested[expected];
      const uint32_t value = classifier.classify(cell, true, workspace);
      proven[expected] += value == expected;
      EXPECT_NE(value, 1 - expected);
    }
  }
  EXPECT_GT(suggested[0], kSanitized ? 100 : 500);
  EXPECT_GT(suggested[1], kSanitized ? 100 : 500);
  EXPECT_GT(proven[0], 0.95 * suggested[0]);
  EXPECT_GT(proven[1], 0.95 * suggested[1]);
  RecordProperty("clear", std::to_string(proven[0]) + " of " + std::to_string(suggested[0]));
  RecordProperty("blocked", std::to_string(proven[1]) + " of " + std::to_string(suggested[1]));
}

}  // namespace
}  // namespace vcd::test
