#include "classify/kernels.h"

#include <gtest/gtest.h>

#include "classify/crossings.h"
#include "classify/sheet.h"
#include "classify/triangle_groups.h"
#include "prepare/topology.h"
#include "support/hostile_meshes.h"
#include "support/kernel_targets.h"
#include "support/shaft_lines.h"

namespace vcd::test {
using namespace baker;
namespace {

// Plain twins of the kernels, one lane at a time.
float dot(const Shaft& s, uint32_t k, float x, float y, float z) {
  return (s.normal[0][k] * x + s.normal[1][k] * y) + s.normal[2][k] * z;
}
uint32_t plain_triangles_near(const Shaft& shaft, const TriangleCluster& cluster) {
  uint32_t near = 0;
  for (uint32_t i = 0; i < cluster.count; ++i) {
    bool separate = false;
    for (uint32_t k = 0; k < shaft.planes; ++k) {
      bool beyond = true;
      for (const auto& c : cluster.corner) beyond &= dot(shaft, k, c[0][i], c[1][i], c[2][i]) > shaft.offset[k];
      separate |= beyond;
    }
    near |= (separate ? 0u : 1u) << i;
  }
  return near;
}
uint32_t plain_select(const ClusterGroup& group, const Shaft& shaft, ClusterMask from) {
  for (uint32_t i = 0; i < kLanes; ++i)
    for (uint32_t k = 0; k < shaft.planes; ++k) {
      const auto nearest = [&](size_t a) { return (shaft.normal[a][k] > 0 ? group.min : group.max)[a][i]; };
      if (dot(shaft, k, nearest(0), nearest(1), nearest(2)) > shaft.offset[k]) from.lanes &= ~(1u << i);
    }
  return from.lanes;
}
uint32_t plain_triangles_around(const View& view, const TriangleCluster& cluster, float margin) {
  uint32_t around = 0;
  for (uint32_t i = 0; i < cluster.count; ++i) {
    bool near = true;
    for (int n = 0; n < 2; ++n) {
      const uint32_t axis = n == 0 ? view.first : view.second;
      float low = 1e30f, high = -1e30f;
      for (const auto& c : cluster.corner) {
        const float x = (c[axis][i] - view.from[axis]) - (c[view.main][i] - view.from[view.main]) * view.slope[n];
        low = std::min(low, x), high = std::max(high, x);
      }
      near &= low <= margin && high >= -margin;
    }
    around |= (near ? 1u : 0u) << i;
  }
  return around;
}

// Another flood: breadth first, edges cut by the planes one after the other in long double.
struct PlainFlood {
  const std::vector<Position>& vertices;
  const std::vector<TriangleIndices>& triangles;
  const std::vector<uint32_t>& neighbour;

  // Whether an edge has a point inside all planes, or is within `margin` of having one.
  bool meets(const Shaft& shaft, const Position& p, const Position& q, long double margin) const {
    long double enter = 0, leave = 1;
    for (uint32_t k = 0; k < shaft.planes; ++k) {
      const long double offset = shaft.offset[k] + margin;
      long double at[2] = {-offset, -offset};
      for (size_t a = 0; a < 3; ++a) {
        at[0] += static_cast<long double>(shaft.normal[a][k]) * p[a];
        at[1] += static_cast<long double>(shaft.normal[a][k]) * q[a];
      }
      if (at[0] > 0 && at[1] > 0) return false;
      if (at[0] > 0) enter = std::max(enter, at[0] / (at[0] - at[1]));
      if (at[1] > 0) leave = std::min(leave, at[0] / (at[0] - at[1]));
    }
    return enter <= leave;
  }
  // The triangles reached; nothing where the flood comes to a boundary.
  std::optional<std::vector<bool>> spread(const Shaft& shaft, uint32_t seed, long double margin) const {
    std::vector<bool> reached(triangles.size());
    std::vector<uint32_t> queue = {seed};
    reached[seed] = true;
    for (size_t i = 0; i < queue.size(); ++i)
      for (uint32_t e = 0; e < 3; ++e) {
        const TriangleIndices& t = triangles[queue[i]];
        if (!meets(shaft, vertices[t[e]], vertices[t[(e + 1) % 3]], margin)) continue;
        const uint32_t next = neighbour[3 * queue[i] + e];
        if (next == kBoundary) return std::nullopt;
        if (!reached[next]) reached[next] = true, queue.push_back(next);
      }
    return reached;
  }
};

uint32_t hash(uint32_t h, uint32_t x) { return (h ^ x) * 0x01000193u + (h >> 15); }

TEST(Kernels, GiveTheSameBitsAsTheirPlainTwinsOnEveryProcessor) {
  int variants = 0;
  std::vector<uint32_t> hashes;
  with_every_target([&](const char* name) {
    ++variants;
    Random random(1);
    uint32_t h = 0;
    for (const PreparedMesh& mesh : {*prepare(sphere(9, 13)), *prepare(leaves(300)), *prepare(slivers())}) {
      const TriangleGroups groups(positions_in_grid(mesh), mesh.triangles);
      for (int i = 0; i < 400; ++i) {
        const Cell cell = random_cell(random.below(9), random);
        const Shaft shaft = make_shaft(cell);
        ClusterGroup group{};
        for (size_t a = 0; a < 3; ++a)
          for (size_t k = 0; k < kLanes; ++k) {
            group.min[a][k] = static_cast<float>(random.between(0, 256));
            group.max[a][k] = group.min[a][k] + static_cast<float>(random.between(0, 40));
          }
        const ClusterMask mask{0, static_cast<uint32_t>(random.engine() & 0xFFFF)};
        ClusterMask selected{};
        const size_t count = select_clusters(&group, shaft, &mask, 1, &selected);
        const uint32_t expected = plain_select(group, shaft, mask);
        ASSERT_EQ(count, expected ? 1u : 0u) << name;
        if (count) {
          ASSERT_EQ(selected.lanes, expected) << name;
        }
        h = hash(h, count ? selected.lanes : 0);

        // Triangles on the shaft's planes, where a last bit decides.
        TriangleCluster touching{};
        touching.count = kLanes;
        for (size_t n = 0; shaft.planes > 0 && n < 3 * kLanes; ++n) {
          const uint32_t k = static_cast<uint32_t>(n / 3) % shaft.planes;
          const size_t x = std::abs(shaft.normal[0][k]) > 0.3f ? 0 : std::abs(shaft.normal[1][k]) > 0.3f ? 1 : 2;
          auto& corner = touching.corner[n % 3];
          double rest = shaft.offset[k];
          for (size_t a = 0; a < 3; ++a) {
            corner[a][n / 3] = static_cast<float>(random.between(0, 256));
            rest -= a == x ? 0 : static_cast<double>(shaft.normal[a][k]) * corner[a][n / 3];
          }
          corner[x][n / 3] = static_cast<float>(rest / shaft.normal[x][k]);
        }
        EXPECT_EQ(triangles_near(shaft, touching), plain_triangles_near(shaft, touching)) << name;

        View view{random.below(3), 0, 0, {}, {}};
        view.first = (view.main + 1) % 3, view.second = (view.main + 2) % 3;
        for (float& x : view.from) x = static_cast<float>(random.between(0, 256));
        for (float& x : view.slope) x = static_cast<float>(random.between(-1, 1));
        groups.for_each(groups.all(), [&](const TriangleCluster& cluster) {
          const uint32_t near = triangles_near(shaft, cluster), around = triangles_around(view, cluster, 1.5f);
          EXPECT_EQ(near, plain_triangles_near(shaft, cluster)) << name;
          EXPECT_EQ(around, plain_triangles_around(view, cluster, 1.5f)) << name;
          h = hash(hash(h, near), around);
          return true;
        });
      }
    }
    hashes.push_back(h);
  });
  for (uint32_t h : hashes) EXPECT_EQ(h, hashes[0]);
#if defined(__x86_64__)
  EXPECT_GE(variants, 2);
#endif
}

struct Flooded {
  std::vector<Position> vertices;
  std::vector<TriangleIndices> triangles;
  std::vector<uint32_t> neighbour;
  Surface surface;
  explicit Flooded(const PreparedMesh& mesh)
      : vertices(positions_in_grid(mesh)),
        triangles(mesh.triangles),
        neighbour(pair_edges(mesh.positions, mesh.triangles)),
        surface(vertices, triangles, neighbour) {}
};

TEST(Flood, ReachesWhatAPlainOneReachesOnEveryMeshAndProcessor) {
  std::vector<uint32_t> hashes;
  with_every_target([&](const char* name) {
    Random random(2);
    uint32_t h = 0;
    int whole = 0, failed = 0;
    for (const PreparedMesh& mesh : hostile_meshes()) {
      const Flooded f(mesh);
      const PlainFlood plain{f.vertices, f.triangles, f.neighbour};
      Surface::Flood flood;
      for (int i = 0; i < 40; ++i) {
        const auto seed = random.below(static_cast<uint32_t>(f.triangles.size()));
        Point x;
        for (size_t a = 0; a < 3; ++a) x[a] = f.vertices[f.triangles[seed][0]][a];
        const Shaft shaft = make_shaft(cell_of_line(x, random.below(8), random));
        flood.begin(f.triangles.size());
        const bool closed = f.surface.flood(shaft, seed, static_cast<uint32_t>(f.triangles.size()), flood);
        (closed ? whole : failed) += 1;
        // A plain flood of a shaft slightly smaller, or larger, brackets this one.
        const auto less = plain.spread(shaft, seed, -0x1p-12L), more = plain.spread(shaft, seed, 0x1p-12L);
        if (more) {
          EXPECT_TRUE(closed) << name;
        }
        if (closed) {
          EXPECT_TRUE(less) << name;
        }
        for (uint32_t t = 0; t < f.triangles.size(); ++t) {
          if (closed && less && (*less)[t]) {
            EXPECT_TRUE(flood.reached(t));
          }
          if (closed && more && flood.reached(t)) {
            EXPECT_TRUE((*more)[t]);
          }
          h = hash(h, flood.reached(t));
        }
      }
    }
    EXPECT_GT(whole, 50);
    EXPECT_GT(failed, 50);
    hashes.push_back(h);
  });
  for (uint32_t h : hashes) EXPECT_EQ(h, hashes[0]);
}

// Without the hair-fine hole of sphere() at its pole.
PreparedMesh closed_sphere() { return prepared_on_grid(on_grid(sphere(), 0x1p-8f)); }

// The central cell of level 3 from the low to the high face of an axis.
Cell central(uint32_t pair) { return {pair, 3, 4, 4, 4, 4}; }

struct Sheet {
  bool closed;
  size_t crossed;  // by the line through the middle of the cell
};
Sheet sheet_of(const PreparedMesh& mesh, const Cell& cell, size_t from_the_front = 0) {
  const TriangleGroups groups(positions_in_grid(mesh), mesh.triangles);
  const Flooded f(mesh);
  const auto [a, b] = squares(cell);
  Line line;
  std::vector<Crossing> found;
  int tries = 0;
  do {  // about the middle
    for (size_t i = 0; i < 3; ++i) {
      line.from[i] = a.min[i] + (a.max[i] - a.min[i]) * (0.48 + 0.01 * tries + 0.013 * static_cast<double>(i));
      line.to[i] = b.min[i] + (b.max[i] - b.min[i]) * (0.53 - 0.017 * tries);
    }
  } while (!crossings(groups, groups.all(), line, found) && ++tries < 5);
  if (found.size() <= from_the_front) return {false, 0};
  Surface::Flood flood;
  flood.begin(mesh.triangles.size());
  const auto limit = static_cast<uint32_t>(mesh.triangles.size());
  const bool closed = f.surface.flood(make_shaft(cell), found[from_the_front].triangle, limit, flood);
  size_t crossed = 0;
  for (const Crossing& c : found) crossed += flood.reached(c.triangle);
  return {closed, crossed};
}

TEST(Flood, FindsTheFrontOfASphereToBeCrossedOnce) {
  const Sheet front = sheet_of(closed_sphere(), central(0));
  EXPECT_TRUE(front.closed);
  EXPECT_EQ(front.crossed, 1u);
  EXPECT_EQ(sheet_of(closed_sphere(), central(0), 1).crossed, 1u);
}

TEST(Flood, FindsAWholeSphereToBeCrossedTwice) {
  const Sheet whole = sheet_of(closed_sphere(), {0, 0, 0, 0, 0, 0});
  EXPECT_TRUE(whole.closed);
  EXPECT_EQ(whole.crossed, 2u);
}

TEST(Flood, EndsAtTheRimOfAHemisphere) {
  EXPECT_FALSE(sheet_of(*prepare(hemisphere()), {9, 0, 0, 0, 0, 0}).closed);  // along y, the rim in view
  EXPECT_TRUE(sheet_of(*prepare(hemisphere()), {9, 3, 4, 4, 4, 4}).closed);
}

TEST(Flood, FollowsAFold) {
  // Lines across the Z at its fold meet three layers that are one sheet, if the shaft holds both folds.
  const Sheet z = sheet_of(*prepare(folded()), {14, 1, 0, 0, 0, 0});
  EXPECT_FALSE(z.closed);
  int three = 0;
  for (uint32_t s = 0; s < 8; ++s) {
    const PreparedMesh mesh = *prepare(folded());
    const TriangleGroups groups(positions_in_grid(mesh), mesh.triangles);
    std::vector<Crossing> found;
    const double x = 32 * s + 13.3;
    if (crossings(groups, groups.all(), {{x, 121.1, 0}, {x, 121.1, 256}}, found) && found.size() == 3) ++three;
    EXPECT_EQ(found.size() % 2, 1u);
  }
  EXPECT_GT(three, 0);
}

TEST(Flood, GivesUpBeyondItsLimitAndAtWhatAFailedOneReached) {
  const Flooded f(closed_sphere());
  const Shaft all = make_shaft({0, 0, 0, 0, 0, 0});
  const auto count = static_cast<uint32_t>(f.triangles.size());
  Surface::Flood flood;
  flood.begin(count);
  EXPECT_TRUE(f.surface.flood(all, 3, count, flood));
  flood.begin(count);
  EXPECT_FALSE(f.surface.flood(all, 3, count - 1, flood));
  uint32_t reached = 0, other = 0;
  for (uint32_t t = 0; t < count; ++t) {
    reached += flood.reached(t);
    if (!flood.reached(t)) other = t;
  }
  EXPECT_EQ(reached, count - 1);
  EXPECT_TRUE(flood.reached_before(3));
  EXPECT_FALSE(f.surface.flood(all, other, count, flood));
  flood.begin(count);
  EXPECT_FALSE(flood.reached_before(3));
  EXPECT_TRUE(f.surface.flood(all, other, count, flood));
}

}  // namespace
}  // namespace vcd::test
