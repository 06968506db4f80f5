#include <vcd/format/line_cell.h>

#include <bit>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "format/reference_line_cell.h"
#include "support/special_floats.h"

namespace vcd::test {
namespace {

struct Box {
  float min[3], max[3];
};
constexpr Box kBoxes[] = {{{0, 0, 0}, {256, 256, 256}},
                          {{-36.2f, -246.5f, -140.8f}, {36.4f, 151.7f, 42.5f}},
                          {{1e6f, -1e6f, 5}, {1000002, -999998, 5.01f}},
                          {{-1e-20f, -2e-20f, 0}, {1e-20f, 2e-20f, 3e-20f}}};

void expect_same(const Box& box, const Segment& segment) {
  const LineCell expected = reference_locate(box.min, box.max, segment);
  const LineCell actual = locate(make_grid_frame(box.min, box.max), segment);
  ASSERT_EQ(actual.valid, expected.valid);
  if (!expected.valid) return;
  ASSERT_EQ(actual.hits, expected.hits);
  if (!expected.hits) return;
  ASSERT_EQ(std::bit_cast<uint32_t>(actual.t_entry + 0.0f), std::bit_cast<uint32_t>(expected.t_entry + 0.0f));
  ASSERT_EQ(std::bit_cast<uint32_t>(actual.t_exit + 0.0f), std::bit_cast<uint32_t>(expected.t_exit + 0.0f));
  ASSERT_EQ(actual.pair, expected.pair);
  ASSERT_EQ(actual.s, expected.s);
  ASSERT_EQ(actual.t, expected.t);
  ASSERT_EQ(actual.u, expected.u);
  ASSERT_EQ(actual.v, expected.v);
}

TEST(LineCell, EqualsItsPlainTwinOnRandomLines) {
  std::mt19937 random(1);
  const auto uniform = [&](float low, float high) {
    return low + (high - low) * static_cast<float>(random() >> 8) * 0x1p-24f;
  };
  for (const Box& box : kBoxes)
    for (int i = 0; i < 100000 && !HasFatalFailure(); ++i) {
      Segment segment{};
      for (int a = 0; a < 3; ++a) {
        const float extent = box.max[a] - box.min[a];
        segment.origin[a] = box.min[a] + uniform(-3, 4) * extent;
        segment.direction[a] = box.min[a] + uniform(0, 1) * extent - segment.origin[a];
        if (random() % 16 == 0) segment.direction[a] = random() % 2 ? 0.0f : -0.0f;
        if (random() % 16 == 0) segment.origin[a] = random() % 2 ? box.min[a] : box.max[a];
      }
      expect_same(box, segment);
    }
}

TEST(LineCell, EqualsItsPlainTwinOnAnyBits) {
  std::mt19937 random(2);
  constexpr float kSpecial[] = {0.0f,   -0.0f, 1.0f,     kInfinity, -kInfinity, std::numeric_limits<float>::quiet_NaN(),
                                1e-40f, 3e38f, 0x1p-100f};
  for (int i = 0; i < 200000 && !HasFatalFailure(); ++i) {
    Segment segment;
    for (float* x : {segment.origin, segment.direction})
      for (int a = 0; a < 3; ++a)
        x[a] = random() % 3 ? std::bit_cast<float>(static_cast<uint32_t>(random()))
                            : kSpecial[random() % std::size(kSpecial)];
    segment.t_min = std::bit_cast<float>(static_cast<uint32_t>(random()));
    segment.t_max = std::bit_cast<float>(static_cast<uint32_t>(random()));
    expect_same(kBoxes[i % std::size(kBoxes)], segment);
  }
}

TEST(LineCell, FindsTheCellThatALineWasMadeFrom) {
  std::mt19937 random(3);
  const GridFrame frame = make_grid_frame(kBoxes[0].min, kBoxes[0].max);
  for (uint32_t pair = 0; pair < kFacePairs; ++pair)
    for (int i = 0; i < 2000; ++i) {
      const uint32_t cell[4] = {static_cast<uint32_t>(random() & 255), static_cast<uint32_t>(random() & 255),
                                static_cast<uint32_t>(random() & 255), static_cast<uint32_t>(random() & 255)};
      float ends[2][3];
      const uint32_t faces[2] = {kFacePair[pair].low, kFacePair[pair].high};
      for (int end = 0; end < 2; ++end) {
        const FaceAxes axes = face_axes(faces[end]);
        ends[end][axes.normal] = faces[end] % 2 ? 256.0f : 0.0f;
        ends[end][axes.first] = static_cast<float>(cell[2 * end]) + 0.5f;
        ends[end][axes.second] = static_cast<float>(cell[2 * end + 1]) + 0.5f;
      }
      for (int reversed = 0; reversed < 2; ++reversed) {
        Segment segment{};
        for (int a = 0; a < 3; ++a) {
          const float from = ends[reversed][a], to = ends[1 - reversed][a];
          segment.direction[a] = (to - from) * 2;
          segment.origin[a] = from - (to - from) * 0.5f;
        }
        const LineCell line = locate(frame, segment);
        ASSERT_TRUE(line.valid && line.hits);
        ASSERT_EQ(line.pair, pair);
        ASSERT_EQ((std::array{line.s, line.t, line.u, line.v}), (std::array{cell[0], cell[1], cell[2], cell[3]}));
      }
    }
}

}  // namespace
}  // namespace vcd::test
