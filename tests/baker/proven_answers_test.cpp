// What a proven tree answers to segments as users ask them, from near and from 512 boxes away, against a referee.
#include <gtest/gtest.h>

#include <vcd/format/tree.h>

#include "support/files.h"
#include "support/hostile_meshes.h"
#include "support/shaft_lines.h"

namespace vcd::test {
using namespace baker;
namespace {

constexpr int kShare = kSanitized ? 8 : 1;  // what sanitizers take of the lines
constexpr int kLines = 40000 / kShare;      // a mesh

// A segment that aims at a corner or edge of a triangle, or just beside it, in the object's frame.
Segment aimed(const PreparedMesh& mesh, const GridFrame& frame, Random& random) {
  const TriangleIndices& t = mesh.triangles[random.below(static_cast<uint32_t>(mesh.triangles.size()))];
  const Position &p = mesh.positions[t[random.below(3)]], &q = mesh.positions[t[random.below(3)]];
  const double along = random.below(2) ? random.uniform() : 0, beside = 0.2 * std::exp2(-1.0 * random.below(16));
  const bool farthest = random.below(2);
  const double away = farthest ? 0x1p17 * random.between(0.9, 0.999) : 256 * std::pow(10, random.between(0.5, 2.7));
  double aim[3], direction[3], length = 0;
  for (size_t a = 0; a < 3; ++a) {
    aim[a] = (p[a] + along * (static_cast<double>(q[a]) - p[a]) - frame.min[a]) * frame.scale[a];
    aim[a] += random.between(-beside, beside);
    direction[a] = random.between(-1, 1) * std::exp2(random.below(3) ? 0 : -1.0 * random.below(20));
    length += std::abs(direction[a]);
  }
  Segment s{};
  for (size_t a = 0; a < 3; ++a) {
    s.origin[a] = static_cast<float>((aim[a] - away * direction[a] / length) / frame.scale[a] + frame.min[a]);
    const double from = (static_cast<double>(s.origin[a]) - frame.min[a]) * frame.scale[a];
    s.direction[a] = static_cast<float>((aim[a] - from) / frame.scale[a]);
  }
  s.t_max = 2;
  return s;
}

// The piece of the true line from a little before the box to a little behind it.
SegmentOfCell across(const GridFrame& frame, const Segment& s, const LineCell& line) {
  SegmentOfCell piece;
  const long double more = 0.05L * (static_cast<long double>(line.t_exit) - line.t_entry) + 1e-9L;
  for (size_t a = 0; a < 3; ++a) {
    const long double p = (static_cast<long double>(s.origin[a]) - frame.min[a]) * frame.scale[a];
    const long double q = static_cast<long double>(s.direction[a]) * frame.scale[a];
    piece.from[a] = p + q * (line.t_entry - more);
    piece.to[a] = p + q * (line.t_exit + more);
  }
  return piece;
}

SourceMesh moved(SourceMesh mesh, float size, float shift) {
  for (Position& p : mesh.positions)
    for (float& x : p) x = x * size + shift;
  return mesh;
}

TEST(ProvenBake, NeverAnswersALineWrongly) {
  Random random(1);
  uint64_t answers[4] = {};
  for (const SourceMesh& source :
       {sphere(12, 20), fins(), moebius(), leaves(60), pierced(sphere(12, 20), 200), folded(),
        moved(intersecting(), 0.01f, 100), moved(cube(), 1e-3f, 1000), slivers()}) {
    const PreparedMesh mesh = *prepare(SourceMesh(source));
    BakeOptions options;
    options.method = Method::proven;
    options.depth = kSanitized ? 3 : 4;
    const auto baked = bake(mesh, options);
    ASSERT_TRUE(baked.ok());
    const TreeView tree = baked->tree();
    const GridFrame frame = make_grid_frame(mesh.box_min.data(), mesh.box_max.data());
    const auto triangles = triangles_in_grid(mesh);
    for (int i = 0; i < kLines; ++i) {
      const Segment s = aimed(mesh, frame, random);
      const LineCell line = locate(frame, s);
      if (!line.valid || !line.hits) continue;
      const auto value = static_cast<uint32_t>(class_of(tree, line));
      ++answers[value];
      if (value > kBlocked) continue;
      const Meets truth = meets_any(across(frame, s, line), triangles);
      EXPECT_NE(truth, value == kClear ? Meets::yes : Meets::no) << mesh.name << " " << i;
    }
  }
  EXPECT_GT(answers[kClear], kSanitized ? 0u : 20u);  // aimed at edges, few lines are
  EXPECT_GT(answers[kBlocked], 10000u / kShare);
}

}  // namespace
}  // namespace vcd::test
