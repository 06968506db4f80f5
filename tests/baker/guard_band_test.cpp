// How far line -> cell strays from the line that was asked, against the guard band that the proofs leave.
#include <cstring>

#include <gtest/gtest.h>

#include <vcd/format/line_cell.h>

#include "classify/shaft.h"
#include "support/hostile_meshes.h"
#include "support/shaft_lines.h"

namespace vcd::test {
using namespace baker;
namespace {

struct Asked {
  float box_min[3], box_max[3];
  Segment segment;
};

// How far the true line, at the two parameters that locate() gives, lies from the two squares of its cell: the distance
// that the squares have to be grown by. Nothing for a line without a cell. Double is exact to 2^-30 here.
std::optional<double> stray(const Asked& asked) {
  const GridFrame frame = make_grid_frame(asked.box_min, asked.box_max);
  const LineCell cell = locate(frame, asked.segment);
  if (!cell.valid || !cell.hits) return std::nullopt;
  double worst = 0;
  for (int end = 0; end < 2; ++end) {
    double at[3];
    for (int a = 0; a < 3; ++a)
      at[a] =
          (static_cast<double>(asked.segment.origin[a]) - frame.min[a]) * frame.scale[a] +
          static_cast<double>(asked.segment.direction[a]) * frame.scale[a] * (end == 0 ? cell.t_entry : cell.t_exit);
    const auto from_square = [&](uint32_t face, uint32_t first, uint32_t second) {
      const FaceAxes axes = face_axes(face);
      const auto beyond = [](double x, double low) { return std::max({low - x, x - (low + 1), 0.0}); };
      return std::max({std::abs(at[axes.normal] - (face % 2 ? 256 : 0)), beyond(at[axes.first], first),
                       beyond(at[axes.second], second)});
    };
    const FacePair pair = kFacePair[cell.pair];
    const bool low_is_entry = (pair.low % 2 == 1) == std::signbit(asked.segment.direction[pair.low / 2]);
    const bool low = low_is_entry == (end == 0);
    worst = std::max(worst, low ? from_square(pair.low, cell.s, cell.t) : from_square(pair.high, cell.u, cell.v));
  }
  return worst;
}

// Boxes of any size and aspect, some far from the coordinates' origin.
void random_box(Random& random, Asked& asked) {
  const double size = std::exp2(random.between(-60, 60));
  const double away = random.below(2) ? size * std::pow(10, random.between(0, 6)) : 0;
  for (int a = 0; a < 3; ++a) {
    const double low = away * random.between(-1, 1) + size * random.between(-1, 1);
    asked.box_min[a] = static_cast<float>(low);
    asked.box_max[a] = static_cast<float>(low + size * (random.below(2) ? 1 : std::pow(10, random.between(-3, 0))));
  }
}

// A line through a hostile place of the box, from 1e-3 to 512 boxes away.
void random_line(Random& random, Asked& asked) {
  double through[3], direction[3], length = 0;
  const uint32_t main = random.below(3), kind = random.below(5);
  for (uint32_t a = 0; a < 3; ++a) {
    through[a] = random.below(3) ? random.between(0, 256) : random.below(257);
    direction[a] = a == main ? 256 : random.between(-256, 256);
    if (a != main && kind == 1) direction[a] *= std::exp2(-1.0 * random.below(60));  // nearly along an axis
    if (a != main && kind == 2 && random.below(2)) direction[a] = 0;
    if (a != main && kind == 3) direction[a] *= std::exp2(-1.0 * random.below(12));
    length += std::abs(direction[a]);
  }
  through[random.below(3)] = random.below(2) ? 256 : 0;
  const bool farthest = random.below(2);
  const double limit = random.below(4) ? 0x1p17 : 0x1p18;  // beyond 2^17 no line is valid
  const double far = farthest ? limit * (1 - 0.01 * random.uniform()) : 256 * std::pow(10, random.between(-3, 2.7));
  const double from = random.below(2) ? far : -far;
  const double scaled = std::exp2(random.below(2) ? random.between(-10, 10) : random.between(-40, 92));
  for (int a = 0; a < 3; ++a) {
    const double unit = 256.0 / (static_cast<double>(asked.box_max[a]) - asked.box_min[a]);
    asked.segment.origin[a] = static_cast<float>((through[a] - from * direction[a] / length) / unit + asked.box_min[a]);
    const double rounded = (asked.segment.origin[a] - static_cast<double>(asked.box_min[a])) * unit;
    const double aim = random.below(2) || direction[a] == 0 ? direction[a] / length : (through[a] - rounded) / from;
    asked.segment.direction[a] = static_cast<float>(aim * scaled / unit);
  }
  asked.segment.t_min = 0, asked.segment.t_max = 1;
}

TEST(GuardBand, HoldsTheTrueLineOfEverySegment) {
  Random random(1);
  Asked asked{};
  double worst = 0;
  int lines = 0;
  for (int i = 0; i < 1500000; ++i) {
    if (i % 64 == 0) random_box(random, asked);
    random_line(random, asked);
    const auto s = stray(asked);
    if (!s) continue;
    ++lines;
    ASSERT_LT(*s, kGuardBand);
    worst = std::max(worst, *s);
  }
  EXPECT_GT(lines, 500000);
  EXPECT_GT(worst, 0.02);  // the lines are hostile enough to tell
}

// Found by climbing uphill from random lines at the limit of the distance.
TEST(GuardBand, HoldsTheWorstLinesKnown) {
  const Asked worst[] = {
      {{0x1.4c071ap-9f, -0x1.f18e06p-2f, -0x1.c61326p-1f},
       {0x1.d78282p-7f, 0x1.ddbc56p+1f, 0x1.fc53b8p-4f},
       {{0x1.ddbcacp-9f, -0x1.d24b04p-4f, -0x1.032276p+9f}, 0, {0x1.2179f6p-25f, -0x1.c910ecp-21f, 0x1.03187ap-7f}, 1}},
      {{0x1.9e0f72p-4f, -0x1.3ed066p-6f, -0x1.6cb002p-3f},
       {0x1.6f51bp+18f, 0x1.568cfcp+2f, 0x1.b47618p-1f},
       {{0x1.cca526p-8f, -0x1.c28924p-8f, -0x1.07c51ep+9f}, 0, {0x1.09f2f2p-18f, -0x1.9513cap-25f, 0x1.0632e2p-7f}, 1}},
      {{-0x1.9a613p+1f, -0x1.b00a1ep-1f, 0x1.55f4p-1f},
       {-0x1.0d2112p-3f, 0x1.88ea32p+2f, 0x1.b4d078p+0f},
       {{-0x1.74693p+1f, 0x1.435c12p+0f, -0x1.0908e4p+9f}, 0, {-0x1.bca46cp-30f, 0x1.e8a4cap-39f, 0x1.07ebaap-7f}, 1}},
  };
  for (const Asked& asked : worst) {
    ASSERT_TRUE(stray(asked));
    EXPECT_GT(*stray(asked), 0.035);
    EXPECT_LT(*stray(asked), kGuardBand);
  }
}

// A line that locate() lets miss the box, or meets outside of [t_entry, t_exit], keeps off the mesh's part of the box.
TEST(GuardBand, KeepsTheRestOfEveryLineOffTheMesh) {
  Random random(2);
  Asked asked{};
  int missed = 0;
  for (int i = 0; i < 600000; ++i) {
    if (i % 64 == 0) random_box(random, asked);
    random_line(random, asked);
    const GridFrame frame = make_grid_frame(asked.box_min, asked.box_max);
    const LineCell cell = locate(frame, asked.segment);
    if (!cell.valid) continue;
    const double kRoom = 0.0625;  // half of the padding that the format demands
    double enter = -1e300, leave = 1e300;
    for (int a = 0; a < 3; ++a) {
      const double p = (static_cast<double>(asked.segment.origin[a]) - frame.min[a]) * frame.scale[a];
      const double q = static_cast<double>(asked.segment.direction[a]) * frame.scale[a];
      if (q == 0 && (p <= kRoom || p >= 256 - kRoom)) leave = -1e300;
      if (q == 0) continue;
      const double x = (kRoom - p) / q, y = (256 - kRoom - p) / q;
      enter = std::max(enter, std::min(x, y)), leave = std::min(leave, std::max(x, y));
    }
    if (enter >= leave) continue;
    EXPECT_TRUE(cell.hits);
    EXPECT_LE(cell.t_entry, enter);
    EXPECT_GE(cell.t_exit, leave);
    ++missed;
  }
  EXPECT_GT(missed, 200000);
}

TEST(GuardBand, RoundsTheMeshByLessThanASixteenthOfTheSlack) {
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    SourceMesh mesh = leaves(20, random.below(1u << 30));
    const float size = std::ldexp(1.0f, static_cast<int>(random.below(100)) - 50);
    const float shift = random.below(2) ? 0 : size * std::ldexp(1.0f, static_cast<int>(random.below(20)));
    for (Position& p : mesh.positions)
      for (float& x : p) x = x * size + shift;
    const auto prepared = prepare(std::move(mesh));
    if (!prepared) continue;
    const auto rounded = positions_in_grid(*prepared);
    const GridFrame frame = make_grid_frame(prepared->box_min.data(), prepared->box_max.data());
    for (size_t v = 0; v < rounded.size(); ++v)
      for (int a = 0; a < 3; ++a) {
        const auto x = static_cast<size_t>(a);
        const double exact = (static_cast<double>(prepared->positions[v][x]) - frame.min[a]) * frame.scale[a];
        EXPECT_NEAR(rounded[v][x], exact, kProofSlack / 16);
        EXPECT_GT(rounded[v][x], 0.124);
        EXPECT_LT(rounded[v][x], 255.876);
      }
  }
}

}  // namespace
}  // namespace vcd::test
