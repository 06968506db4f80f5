// Horizons: levels, codes, what a triangle raises, and the section as a whole.
#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <random>
#include <vector>

#include <gtest/gtest.h>

#include <vcd/baker/audit_horizons.h>
#include <vcd/baker/horizon.h>
#include <vcd/baker/threads.h>
#include <vcd/format/layout.h>

#include "horizon/level_codes.h"
#include "horizon/trace_horizon.h"
#include "horizon/viewpoint.h"
#include "support/files.h"
#include "support/kernel_targets.h"
#include "support/meshes.h"
#include "support/random.h"

namespace vcd::test {
using namespace baker;
namespace {

struct Subject {
  PreparedMesh mesh;
  HierarchySection section;
  explicit Subject(SourceMesh source) : mesh(*prepare(std::move(source))), section(*build_hierarchy(mesh)) {}
  Horizons horizons(unsigned threads = 0) const {
    return with_threads(threads, [&] { return std::move(*build_horizons(mesh, view_of(section))); });
  }
};

Bytes bytes_of(const Horizons& horizons) { return {horizons.section.data.get(), horizons.section.size}; }

// A floor with walls on its four sides that lean outwards, so high above it and below.
SourceMesh floor_with_walls(float h) {
  SourceMesh mesh{"floor", 0, {}, {{0, 1, 2}, {0, 2, 3}}};
  for (const float z : {0.0f, h, -h})
    for (const auto& [x, y] : {std::pair(0, 0), {1, 0}, {1, 1}, {0, 1}}) {
      const float out = z == 0 ? 0.0f : 0.5f;
      mesh.positions.push_back({x ? 1 + out : -out, y ? 1 + out : -out, z});
    }
  for (uint32_t i = 0; i < 4; ++i) {
    const uint32_t j = (i + 1) % 4;
    mesh.triangles.push_back({i + 8, j + 8, j + 4}), mesh.triangles.push_back({i + 8, j + 4, i + 4});
  }
  return mesh;
}

TEST(HorizonLevels, AreAboveTheirSlopes) {
  EXPECT_EQ(level_above(0), 0);
  for (uint32_t level = 0; level < kLevels; ++level) {
    const auto slope = double{slope_of(static_cast<uint8_t>(level))};
    EXPECT_EQ(level_above(slope), level);
    if (level > 0) {
      EXPECT_EQ(level_above(slope * 0.999999), level);
    }
    EXPECT_NEAR(slope / std::sqrt(1 + slope * slope), sine_of(level), 1e-6);
  }
  EXPECT_EQ(level_above(4), kNever);
  EXPECT_EQ(level_above(std::numeric_limits<double>::infinity()), kNever);
}

TEST(HorizonLevels, CodesAreNeverBelowThem) {
  FloatRandom random(1);
  std::vector<Levels> all(3000);
  std::vector<WeightedLevels> weighted;
  for (Levels& levels : all) {
    for (uint8_t& level : levels) level = random.below(9) == 0 ? kNever : static_cast<uint8_t>(random.below(kLevels));
    weighted.push_back({&levels, 1});
  }
  const LevelTables tables = choose_tables(weighted);
  for (const LevelTable& table : tables) {
    EXPECT_TRUE(std::ranges::is_sorted(table));
    EXPECT_EQ(table[kHorizonNever], kNever);
  }
  double exact = 0, coded = 0;
  for (const Levels& levels : all) {
    const Encoded encoded = encode(levels, tables);
    for (uint32_t s = 0; s < kHorizonSectors; ++s)
      ASSERT_GE(tables[encoded.table][horizon_code(encoded.codes, s)], levels[s]);
    exact += mean(levels).worth(), coded += encoded.answered.worth();
  }
  EXPECT_GT(coded, 0.93 * exact);
}

TEST(HorizonTables, AnObjectOfFewLevelsIsCodedWithoutLoss) {
  std::vector<Levels> all(8);
  std::vector<WeightedLevels> weighted;
  for (size_t i = 0; i < all.size(); ++i) all[i].fill(static_cast<uint8_t>(10 * i)), weighted.push_back({&all[i], 1});
  const LevelTables tables = choose_tables(weighted);
  for (const Levels& levels : all) EXPECT_DOUBLE_EQ(encode(levels, tables).answered.worth(), mean(levels).worth());
}

// All points of a triangle, as any place above the other sees them, are below the levels.
TEST(HorizonViewpoint, NothingOfAnOccluderIsAboveItsLevels) {
  FloatRandom random(2);
  size_t finite = 0;
  for (int i = 0; i < 3000; ++i) {
    const auto corner = [&](float size) {
      return std::array{random.between(-size, size), random.between(-size, size), random.between(-size, size)};
    };
    const Triangle own{corner(1), corner(1), corner(1)}, occluder{corner(3), corner(3), corner(3)};
    float p[3], q[3], r[3];
    std::ranges::copy(own[0], p), std::ranges::copy(own[1], q), std::ranges::copy(own[2], r);
    HorizonFrame frame;
    if (!make_horizon_frame(p, q, r, frame)) continue;
    const Viewpoint viewpoint(frame, own, 3);
    Levels levels{};
    viewpoint.raise(occluder, (1u << kHorizonSectors) - 1, levels);
    for (const uint8_t level : levels) finite += level != 0 && level != kNever;
    for (int k = 0; k < 300; ++k) {
      float a = random.uniform(), b = random.uniform() * (1 - a), c = random.uniform(), d = random.uniform() * (1 - c);
      if (k % 3 == 0) b = k % 2 ? 0 : 1 - a, d = k % 4 < 2 ? 0 : 1 - c;  // edges
      Segment way{{}, 0, {}, 1};
      for (size_t x = 0; x < 3; ++x) {
        way.origin[x] = own[0][x] + a * (own[1][x] - own[0][x]) + b * (own[2][x] - own[0][x]) +
                        frame.n[x] * frame.size * 2 * static_cast<float>(kLowestBegin);
        way.direction[x] = occluder[0][x] + c * (occluder[1][x] - occluder[0][x]) +
                           d * (occluder[2][x] - occluder[0][x]) - way.origin[x];
      }
      const float u = horizon::along(frame.x, way.direction), v = horizon::along(frame.y, way.direction),
                  w = horizon::along(frame.n, way.direction);
      if (w <= 1e-4f) continue;
      const uint8_t level = levels[horizon_sector(u, v)];
      ASSERT_TRUE(level == kNever || w <= (slope_of(level) + 1e-4f) * std::sqrt(u * u + v * v) * 1.0001f + 1e-5f) << i;
    }
  }
  EXPECT_GT(finite, 5000u);
}

// The triangles of a node's leaves and of all below it, as places.
void add_places(const HierarchyView& hierarchy, uint32_t unit, std::vector<uint32_t>& places) {
  const HierarchyNode& node = hierarchy.node(unit);
  for (uint32_t i = 0; i < kNodeWidth && node.child[i] != kNoChild; ++i) {
    const uint32_t child = node.child[i];
    if (!(child & kLeafChild)) {
      add_places(hierarchy, child, places);
      continue;
    }
    const auto count = with_leaf(hierarchy, child, [](const auto& leaf) { return std::popcount(leaf.present); });
    for (uint32_t t = 0; t < static_cast<uint32_t>(count); ++t)
      places.push_back((child & kUnitMask) | (child & kLargeChild ? kPlaceLarge : 0) | t << kPlaceTriangleShift);
  }
}

// The floor with walls under a roof that no edge of is near.
SourceMesh hall() {
  SourceMesh mesh = floor_with_walls(0.5f);
  const auto first = static_cast<uint32_t>(mesh.positions.size());
  mesh.positions.insert(mesh.positions.end(), {{-30, -30, 1}, {30, -30, 1}, {0, 60, 1}});
  mesh.triangles.push_back({first, first + 1, first + 2});
  return mesh;
}

// What is passed over would change nothing, whatever the processor and whatever is tried first.
TEST(HorizonTrace, FindsWhatALookAtEveryTriangleFinds) {
  for (const SourceMesh& source : {floor_with_walls(0.3f), hall(), leaves(kSanitized ? 40 : 100), sphere(10, 20)}) {
    const Subject subject{SourceMesh(source)};
    const HierarchyView hierarchy = view_of(subject.section);
    const HierarchyHeader& header = hierarchy.header();
    std::vector<uint32_t> places;
    add_places(hierarchy, kRootUnit, places);
    for (const uint32_t place : places)
      for (const uint32_t turned : {0u, 1u}) {
        HorizonFrame frame;
        if (!frame_at(hierarchy, place | (turned ? kPlaceTurned : 0), frame)) continue;
        const auto in_leaf = [](uint32_t at) { return InLeaf{leaf_of(at), triangle_of(at)}; };
        const Viewpoint from(frame, corners_at(hierarchy, in_leaf(place)),
                             greatest_coordinate(header.box_min, header.box_max));
        if (!from.usable()) continue;
        Levels expected{}, most{};
        Setters first{};  // the steepest but for what is overhead, which must be found nevertheless
        for (const uint32_t other : places) {
          Levels levels{};
          from.raise(corners_at(hierarchy, in_leaf(other)), 0xFFFF, levels);
          for (uint32_t s = 0; s < kHorizonSectors; ++s) {
            expected[s] = std::max(expected[s], levels[s]);
            if (levels[s] > most[s] && levels[s] != kNever) most[s] = levels[s], first[s] = in_leaf(other);
          }
        }
        with_every_target([&](const char* target) {
          Setters setters = first;
          ASSERT_EQ(trace_horizon(hierarchy, from, setters), expected) << target;
        });
      }
  }
}

TEST(Horizons, ConvexObjectsAnswerAllButTheGrazing) {
  for (SourceMesh source : {cube(), sphere()}) {
    const Horizons horizons = Subject(std::move(source)).horizons();
    ASSERT_TRUE(horizons.section.data);
    EXPECT_GT(horizons.share.uniform, 0.98);
    EXPECT_GT(horizons.share.cosine, 0.999);
  }
}

TEST(Horizons, AreLeftOutWhereTheyAnswerLittle) {
  EXPECT_FALSE(Subject(leaves(3000)).horizons().section.data);
  BakeOptions options;
  options.horizons = true, options.method = Method::none;
  const BakedObject baked = must_bake(leaves(3000), options);
  EXPECT_TRUE(baked.to_write().horizon.empty());
  EXPECT_FALSE(baked.without_horizons.empty());
  ASSERT_TRUE(baked.horizon_share);
  EXPECT_LT(baked.horizon_share->cosine, kLeastHorizonShare);
  options.hierarchy = false;
  EXPECT_EQ(must_bake(cube(), options).without_horizons, "it has no hierarchy");
  options.horizons = false, options.hierarchy = true;
  EXPECT_TRUE(must_bake(cube(), options).to_write().horizon.empty());
}

TEST(Horizons, HigherWallsLeaveLess) {
  float before = 0;
  for (const float height : {0.05f, 0.2f, 0.4f, 0.7f}) {
    const Horizons horizons = Subject(floor_with_walls(height)).horizons();
    ASSERT_TRUE(horizons.section.data);
    const HorizonView view{horizons.section.data.get()};
    const HorizonEntry& floor = view.entries()[0];
    float slopes = 0;
    for (uint32_t s = 0; s < kHorizonSectors; ++s)
      slopes += std::min(view.header().slope[table_of(floor.place)][horizon_code(codes_of(floor), s)], 16.0f);
    EXPECT_GT(slopes, before) << height;
    before = slopes;
  }
}

TEST(Horizons, DependOnNeitherThreadsNorWinding) {
  const SourceMesh source = sphere(12, 20);
  const Subject subject{SourceMesh(source)};
  const Horizons one = subject.horizons(1), four = subject.horizons(4);
  EXPECT_TRUE(std::ranges::equal(bytes_of(one), bytes_of(four)));
  SourceMesh turned = source;
  for (TriangleIndices& t : turned.triangles) std::swap(t[0], t[2]);
  EXPECT_TRUE(std::ranges::equal(bytes_of(one), bytes_of(Subject(std::move(turned)).horizons())));
}

TEST(Horizons, StandInTheOrderOfTheSource) {
  SourceMesh source = sphere(12, 20);
  source.triangles.push_back(source.triangles[5]);  // twice
  source.triangles.push_back({0, 0, 1});            // no area
  SourceMesh shuffled = source;
  std::vector<uint32_t> order(source.triangles.size());
  for (uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  std::shuffle(order.begin(), order.end(), std::mt19937(4));
  for (uint32_t i = 0; i < order.size(); ++i) shuffled.triangles[i] = source.triangles[order[i]];
  const Subject first{SourceMesh(source)}, second{std::move(shuffled)};
  const Horizons of_first = first.horizons(), of_second = second.horizons();
  const HorizonView a{of_first.section.data.get()}, b{of_second.section.data.get()};
  ASSERT_EQ(a.header().entries, source.triangles.size());
  EXPECT_NE(a.header().order_xxh3, b.header().order_xxh3);
  EXPECT_EQ(first.mesh.geometry_hash, second.mesh.geometry_hash);
  for (uint32_t i = 0; i < order.size(); ++i)
    ASSERT_EQ(std::memcmp(&b.entries()[i], &a.entries()[order[i]], sizeof(HorizonEntry)), 0) << i;
  const uint32_t count = a.header().entries;
  EXPECT_EQ(std::memcmp(&a.entries()[count - 2], &a.entries()[5], sizeof(HorizonEntry)), 0);
  EXPECT_EQ(a.entries()[count - 1].place, 0u);
}

TEST(Horizons, AreCanonical) {
  const Subject subject(sphere(12, 20));
  const Horizons horizons = subject.horizons();
  EXPECT_FALSE(check_horizon(bytes_of(horizons), view_of(subject.section), CheckLevel::canonical));
}

TEST(Horizons, AreAudited) {
  const Subject subject(floor_with_walls(0.3f));
  Horizons horizons = subject.horizons();
  ASSERT_TRUE(horizons.section.data);
  const HorizonView view{horizons.section.data.get()};
  const auto audit = [&] {
    return audit_horizons(subject.mesh, view_of(subject.section), view, 20000 / (kSanitized ? 5 : 1));
  };
  const HorizonAudit sound = audit();
  EXPECT_EQ(sound.wrong, 0u);
  EXPECT_GT(sound.clear, sound.segments / 5);
  // With lower slopes than those that are true.
  auto& header = *reinterpret_cast<HorizonHeader*>(horizons.section.data.get());
  for (auto& table : header.slope)
    for (float& slope : table) slope *= 0.3f;
  EXPECT_GT(audit().wrong, 10u);
  EXPECT_TRUE(audit_horizons(subject.mesh, view_of(subject.section), view, 100, [] { return true; }).stopped);
}

TEST(Horizons, StopAndForecast) {
  const Subject subject(sphere());
  EXPECT_FALSE(build_horizons(subject.mesh, view_of(subject.section), [] { return true; }));
  const auto forecast = forecast_horizons(subject.mesh, view_of(subject.section));
  ASSERT_TRUE(forecast);
  EXPECT_NEAR(forecast->share.cosine, subject.horizons().share.cosine, 0.02);
  EXPECT_EQ(forecast->bytes, subject.horizons().section.size);
  const Subject hair(leaves(3000));
  EXPECT_EQ(forecast_horizons(hair.mesh, view_of(hair.section))->bytes, 0u);
}

}  // namespace
}  // namespace vcd::test
