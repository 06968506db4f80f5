// Clearances against the mesh itself, and what segments that begin or end in them are answered.
#include "prepare/clearances.h"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include <vcd/baker/measure.h>
#include <vcd/baker/referee.h>
#include <vcd/format/line_cell.h>
#include <vcd/runtime/sidecar.h>

#include "support/files.h"
#include "support/meshes.h"
#include "support/random.h"

namespace vcd::test {
using namespace baker;
namespace {

// Points all over the mesh, in grid units.
std::vector<std::array<double, 3>> points_on(const PreparedMesh& mesh, int per_triangle) {
  FloatRandom random(3);
  const GridFrame frame = make_grid_frame(mesh.box_min.data(), mesh.box_max.data());
  std::vector<std::array<double, 3>> points;
  for (const auto& triangle : mesh.triangles)
    for (int i = 0; i < per_triangle; ++i) {
      double w[3] = {i == 0 ? 1.0 : random.uniform(), i == 1 ? 1.0 : random.uniform(), i == 2 ? 1.0 : random.uniform()};
      if (i < 3)
        for (int c = 0; c < 3; ++c) w[c] = c == i;
      const double sum = w[0] + w[1] + w[2];
      std::array<double, 3> p{};
      for (size_t c = 0; c < 3; ++c)
        for (size_t a = 0; a < 3; ++a)
          p[a] += w[c] / sum * (double{mesh.positions[triangle[c]][a]} - double{frame.min[a]}) * double{frame.scale[a]};
      points.push_back(p);
    }
  return points;
}

// From square (i, j) of a face, in the largest of the three coordinates.
double distance(uint32_t face, uint32_t i, uint32_t j, const std::array<double, 3>& p) {
  const auto [normal, first, second] = face_axes(face);
  const auto outside = [](double x, double low) { return std::max({low - x, x - (low + 16), 0.0}); };
  return std::max({face % 2 ? 256 - p[normal] : p[normal], outside(p[first], 16.0 * i), outside(p[second], 16.0 * j)});
}

TEST(Clearances, AreKeptByTheMeshAndNotMuchSmallerThanTheyCouldBe) {
  if (kSanitized) GTEST_SKIP() << kOnceIsEnough;
  for (SourceMesh source : {sphere(24, 48), leaves(60), triangle()}) {
    const auto mesh = prepare(std::move(source));
    ASSERT_TRUE(mesh.ok());
    const auto clearances = clearances_of(GridMesh(*mesh));
    const auto points = points_on(*mesh, mesh->triangles.size() < 10 ? 20000 : 200);
    uint64_t positive = 0;
    for (uint32_t face = 0; face < 6; ++face)
      for (uint32_t i = 0; i < kClearanceSquares; ++i)
        for (uint32_t j = 0; j < kClearanceSquares; ++j) {
          double nearest = 1e9;
          for (const auto& p : points) nearest = std::min(nearest, distance(face, i, j, p));
          const double clearance = clearances[clearance_square(face, 16 * i, 16 * j)];
          if (clearance > 0) {
            EXPECT_GT(nearest, clearance + 0.1) << face << " " << i << " " << j;
          }
          EXPECT_GT(clearance, std::min(nearest, 255.0) - 17) << face << " " << i << " " << j;
          positive += clearance > 0;
        }
    EXPECT_GT(positive, 200u) << mesh->name;
  }
}

TEST(Clearances, LetSegmentsBeginAndEndInThem) {
  BakeOptions options;
  options.method = Method::proven, options.depth = kSanitized ? 3 : 4;
  const BakedObject baked = must_bake(sphere(24, 48), options);
  const auto mesh = prepare(sphere(24, 48));
  const Referee referee(*mesh);
  const auto bytes = sidecar_bytes({&baked});
  const GridFrame frame = make_grid_frame(mesh->box_min.data(), mesh->box_max.data());
  FloatRandom random(4);
  std::vector<Segment> segments;
  while (segments.size() < (kSanitized ? 2000u : 40000u)) {
    Segment s{};
    for (size_t a = 0; a < 3; ++a) {
      s.origin[a] = mesh->box_min[a] + random.uniform() * (mesh->box_max[a] - mesh->box_min[a]);
      s.direction[a] = random.between(-1, 1);
    }
    s.t_min = -10, s.t_max = 10;
    const LineCell line = locate(frame, s);
    if (!line.hits) continue;
    const float way = line.t_exit - line.t_entry;
    // Parts of the way in the box that are left out: none, a hair, a lot.
    s.t_min = line.t_entry + way * std::exp2(random.between(-12, 0)),
    s.t_max = line.t_exit - way * std::exp2(random.between(-12, 0));
    if (random.below(3) == 0) s.t_min = -10;
    if (random.below(3) == 0) s.t_max = 10;
    segments.push_back(s);
  }
  std::vector<Visibility> first;
  for (const std::string& kernel : kernels()) {
    OpenOptions open;
    open.kernel = kernel;
    const auto sidecar = Sidecar::open_buffer(bytes, open);
    std::vector<Visibility> answers(segments.size());
    sidecar->object(0).classify(segments, answers);
    if (first.empty()) {
      first = answers;
      uint64_t wrong = 0, blocked_inside = 0;
      for (size_t i = 0; i < segments.size(); ++i) {
        EXPECT_EQ(answers[i], sidecar->object(0).classify(segments[i]));
        if (answers[i] == Visibility::unclassified) continue;
        wrong += (answers[i] == Visibility::blocked) != referee.occluded(segments[i]);
        blocked_inside += answers[i] == Visibility::blocked && (segments[i].t_min > -10 || segments[i].t_max < 10);
      }
      EXPECT_EQ(wrong, 0u);
      EXPECT_GT(blocked_inside, segments.size() / 20);
    }
    EXPECT_EQ(answers, first) << kernel;
  }
}

// As no mesh has them, but a file may.
TEST(Clearances, ThatOverlapNeverBlockAnEmptySegment) {
  const BakedObject baked = must_bake(sphere(), quick(3));
  const std::vector<uint8_t> margins(kClearanceBytes, 200);
  SidecarToWrite contents;
  contents.objects = {baked.to_write()};
  contents.objects[0].clearance = std::as_bytes(std::span(margins));
  const auto bytes = sidecar_bytes(contents);
  for (const std::string& kernel : kernels()) {
    OpenOptions open;
    open.kernel = kernel;
    const auto sidecar = Sidecar::open_buffer(Bytes{bytes->data.get(), bytes->size}, open);
    std::vector<Segment> segments(64, {{0.1f, 0.1f, -1}, 1, {0, 0, 1}, 1.001f});  // pierces the sphere's middle
    for (size_t i = 1; i < segments.size(); i += 2) segments[i].t_max = segments[i].t_min;
    std::vector<Visibility> answers(segments.size());
    sidecar->object(0).classify(segments, answers);
    for (size_t i = 0; i < segments.size(); ++i) {
      EXPECT_EQ(answers[i], i % 2 ? Visibility::unclassified : Visibility::blocked) << kernel;
      EXPECT_EQ(answers[i], sidecar->object(0).classify(segments[i])) << kernel;
    }
  }
}

TEST(Clearances, AreOnlyKeptWhereSomethingIsBlocked) {
  EXPECT_EQ(must_bake(sphere(), quick(3)).tree().clearances != nullptr, true);
  BakeOptions options;
  options.method = Method::none;
  EXPECT_EQ(must_bake(sphere(), options).tree().clearances, nullptr);
  EXPECT_EQ(make_unclassified_object(*prepare(sphere()), 3).tree().clearances, nullptr);
}

}  // namespace
}  // namespace vcd::test
