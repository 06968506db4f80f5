#include <functional>

#include <gtest/gtest.h>

#include <vcd/format/tree.h>

#include "support/files.h"
#include "support/hostile_meshes.h"
#include "support/kernel_targets.h"
#include "support/shaft_lines.h"

namespace vcd::test {
using namespace baker;
namespace {

constexpr uint32_t kDepth = kSanitized ? 3 : 4;

BakeOptions options(Method method, uint32_t depth, unsigned threads = 2) {
  BakeOptions o;
  o.method = method;
  o.depth = depth;
  o.threads = threads;
  o.samples = 81;
  return o;
}

std::vector<uint8_t> classes(const TreeView& tree, uint32_t depth) {
  std::vector<uint8_t> out(size_t{kFacePairs} << (4 * depth));
  const uint32_t up = 8 - depth, mask = (1u << depth) - 1;
  for (uint32_t i = 0; i < out.size(); ++i) {
    LineCell line{};
    line.pair = i >> (4 * depth);
    line.s = (i >> (3 * depth) & mask) << up, line.t = (i >> (2 * depth) & mask) << up;
    line.u = (i >> depth & mask) << up, line.v = (i & mask) << up;
    out[i] = static_cast<uint8_t>(class_of(tree, line));
  }
  return out;
}

// A symmetry of the cube: axis a goes to axis `to[a]`, turned round where `mirror[a]`.
struct Symmetry {
  std::array<uint32_t, 3> to = {0, 1, 2};
  std::array<bool, 3> mirror = {};

  Position apply(const Position& p) const {
    Position q;
    for (size_t a = 0; a < 3; ++a) q[to[a]] = mirror[a] ? 256 - p[a] : p[a];
    return q;
  }
  // Index among all cells of a depth → that of the cell where its lines go.
  uint32_t apply(uint32_t index, uint32_t depth) const {
    const uint32_t mask = (1u << depth) - 1;
    const FacePair pair = kFacePair[index >> (4 * depth)];
    uint32_t face[2] = {pair.low, pair.high}, at[2][3] = {};
    for (int f = 0; f < 2; ++f) {
      const FaceAxes axes = face_axes(face[f]);
      const uint32_t first = index >> ((f == 0 ? 3 : 1) * depth) & mask;
      const uint32_t second = index >> ((f == 0 ? 2 : 0) * depth) & mask;
      at[f][to[axes.first]] = mirror[axes.first] ? mask - first : first;
      at[f][to[axes.second]] = mirror[axes.second] ? mask - second : second;
      face[f] = 2 * to[axes.normal] + (face[f] % 2 ^ (mirror[axes.normal] ? 1 : 0));
    }
    if (face[0] > face[1]) std::swap(face[0], face[1]), std::swap(at[0], at[1]);
    uint32_t mapped = 0;
    while (kFacePair[mapped].low != face[0] || kFacePair[mapped].high != face[1]) ++mapped;
    for (int f = 0; f < 2; ++f) {
      const FaceAxes axes = face_axes(face[f]);
      mapped = (mapped << depth | at[f][axes.first]) << depth | at[f][axes.second];
    }
    return mapped;
  }
};

struct Difference {
  uint64_t opposite = 0, clear = 0, blocked = 0;  // cells: clear against blocked; clear or blocked in one bake only
};

// A mesh that was baked, against what becomes of it, cell by cell.
class Baked {
 public:
  explicit Baked(SourceMesh mesh) : mesh_(std::move(mesh)), classes_(classes_of(mesh_)) {}

  const std::string& name() const { return mesh_.name; }
  Difference against(const Symmetry& symmetry, const std::function<void(SourceMesh&)>& change) const {
    SourceMesh changed = mesh_;
    for (Position& p : changed.positions) p = symmetry.apply(p);
    change(changed);
    const auto other = classes_of(changed);
    Difference d;
    for (uint32_t i = 0; i < classes_.size(); ++i) {
      const uint8_t x = classes_[i], y = other[symmetry.apply(i, kDepth)];
      d.opposite += std::max(x, y) == kBlocked && std::min(x, y) == kClear;
      d.clear += (x == kClear) != (y == kClear);
      d.blocked += (x == kBlocked) != (y == kBlocked);
    }
    return d;
  }

 private:
  static std::vector<uint8_t> classes_of(const SourceMesh& mesh) {
    return classes(bake(prepared_on_grid(SourceMesh(mesh)), options(Method::proven, kDepth))->tree(), kDepth);
  }

  SourceMesh mesh_;
  std::vector<uint8_t> classes_;
};

const auto kNoChange = [](SourceMesh&) {};
// Each is baked once, for all tests that ask.
const std::vector<Baked>& subjects() {
  static const std::vector<Baked> subjects = {Baked(on_grid(sphere(10, 14), 0x1p-8f)), Baked(on_grid(fins(), 0x1p-8f)),
                                              Baked(on_grid(leaves(60), 0x1p-8f)),
                                              Baked(on_grid(intersecting(), 0x1p-8f)), Baked(on_grid(cube(), 16))};
  return subjects;
}

TEST(ProvenBake, IsTheSameForMirroredAndPermutedMeshes) {
  const Symmetry symmetries[] = {{{0, 1, 2}, {true, false, false}},
                                 {{0, 1, 2}, {false, true, false}},
                                 {{0, 1, 2}, {false, false, true}},
                                 {{1, 2, 0}, {}},
                                 {{1, 0, 2}, {}},
                                 {{2, 1, 0}, {true, false, true}}};
  for (const Baked& mesh : subjects())
    for (const Symmetry& symmetry : symmetries) {
      const Difference d = mesh.against(symmetry, kNoChange);
      EXPECT_EQ(d.opposite, 0u);
      EXPECT_EQ(d.clear, 0u) << mesh.name() << " " << symmetry.to[0] << symmetry.mirror[0] << symmetry.mirror[1];
      EXPECT_EQ(d.blocked, 0u) << mesh.name() << " " << symmetry.to[0] << symmetry.mirror[0] << symmetry.mirror[1];
    }
}

TEST(ProvenBake, IsTheSameWhateverTheOrderAndWinding) {
  const std::function<void(SourceMesh&)> changes[] = {
      [](SourceMesh& m) { std::reverse(m.triangles.begin(), m.triangles.end()); },
      [](SourceMesh& m) { m = inverted(m); },
      [](SourceMesh& m) {
        for (auto& t : m.triangles) std::rotate(t.begin(), t.begin() + 1, t.end());
      },
      [](SourceMesh& m) {
        const auto n = static_cast<uint32_t>(m.positions.size());
        std::reverse(m.positions.begin(), m.positions.end());
        for (auto& t : m.triangles)
          for (auto& v : t) v = n - 1 - v;
      },
      [](SourceMesh& m) {
        for (size_t t = 0; t < m.triangles.size(); t += 2) std::swap(m.triangles[t][0], m.triangles[t][1]);
      }};
  for (const Baked& mesh : subjects())
    for (const auto& change : changes) {
      const Difference d = mesh.against({}, change);
      EXPECT_EQ(d.opposite + d.clear + d.blocked, 0u) << mesh.name() << " " << &change - changes;
    }
}

TEST(ProvenBake, GivesTheSameBytesForAnyNumberOfThreads) {
  for (Method method : {Method::proven, Method::hybrid})
    for (const SourceMesh& mesh : {sphere(12, 20), leaves(60), moebius()}) {
      const BakedObject one = must_bake(mesh, options(method, kDepth, 1)),
                        two = must_bake(mesh, options(method, kDepth, 2)),
                        many = must_bake(mesh, options(method, kDepth, 7));
      const auto bytes = sidecar_bytes({&one});
      EXPECT_EQ(bytes, sidecar_bytes({&two})) << mesh.name;
      EXPECT_EQ(bytes, sidecar_bytes({&many})) << mesh.name;
      EXPECT_EQ(one.rays, two.rays);
    }
}

TEST(ProvenBake, GivesTheSameBytesOnEveryProcessor) {
  for (Method method : {Method::hybrid, Method::proven}) {
    if (kSanitized && method == Method::proven) break;  // a hybrid bake proves as well
    for (const SourceMesh& mesh : {intersecting(), leaves(60)}) {
      std::vector<std::vector<std::byte>> bytes;
      with_every_target([&](const char*) {
        const BakedObject object = must_bake(mesh, options(method, kDepth));
        bytes.push_back(sidecar_bytes({&object}));
      });
      for (const auto& b : bytes) EXPECT_EQ(b, bytes[0]) << mesh.name;
    }
  }
}

TEST(HybridBake, AddsStatisticallyBlockedCellsAndChangesNoOther) {
  for (const SourceMesh& mesh : {sphere(12, 20), leaves(60)}) {
    const BakedObject proven = must_bake(mesh, options(Method::proven, kDepth));
    const BakedObject hybrid = must_bake(mesh, options(Method::hybrid, kDepth));
    const auto a = classes(proven.tree(), kDepth), b = classes(hybrid.tree(), kDepth);
    uint64_t statistical = 0;
    for (size_t i = 0; i < a.size(); ++i) {
      statistical += b[i] == kStatisticallyBlocked;
      ASSERT_EQ(a[i], b[i] == kStatisticallyBlocked ? kUnclassified : b[i]) << mesh.name;
    }
    if (!kSanitized) {  // at depth 3 there may be none
      EXPECT_GT(statistical, 0u);
    }
  }
}

TEST(HybridBake, DecidesBlockedByRaysAloneWhereProofsFail) {
  const auto bake_both = [](const SourceMesh& mesh) {
    BakeOptions automatic = options(Method::hybrid, kDepth);
    automatic.samples = 0;
    return std::pair{must_bake(mesh, options(Method::proven, kDepth)), must_bake(mesh, automatic)};
  };
  const auto [proven, hybrid] = bake_both(leaves(kSanitized ? 1000 : 4000));
  EXPECT_EQ(hybrid.record.method_parameters[0], 81u);
  EXPECT_EQ(hybrid.record.cells[kClear], proven.record.cells[kClear]);
  EXPECT_EQ(hybrid.record.cells[kBlocked], 0u);
  EXPECT_GT(hybrid.record.statistical_cells, 0u);
  EXPECT_EQ(bake_both(sphere(12, 20)).second.record.method_parameters[0], 256u);
}

TEST(ProvenBake, KeepsThePromisesOfAShallowerBake) {
  // What a cell of depth 3 promises, all cells inside it promise at depth 4.
  for (const SourceMesh& mesh : {sphere(12, 20), fins(), moebius(), leaves(60)}) {
    const BakedObject a = must_bake(mesh, options(Method::proven, 3)), b = must_bake(mesh, options(Method::proven, 4));
    const auto coarse = classes(a.tree(), 3), fine = classes(b.tree(), 4);
    uint64_t lost = 0;
    for (uint32_t i = 0; i < fine.size(); ++i) {
      const uint32_t above =
          (i >> 16) << 12 | (i >> 13 & 7) << 9 | (i >> 9 & 7) << 6 | (i >> 5 & 7) << 3 | (i >> 1 & 7);
      lost += coarse[above] != kUnclassified && fine[i] != coarse[above];
    }
    EXPECT_EQ(lost, 0u) << mesh.name;
  }
}

}  // namespace
}  // namespace vcd::test
