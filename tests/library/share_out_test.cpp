// Shares of a budget.
#include <vcd/library/share_out.h>

#include <numeric>

#include <gtest/gtest.h>

namespace vcd::test {
namespace {

using library::share_out;

TEST(ShareOut, BytesGoWhereTheyAreWorthMost) {
  // Of the first object 100 bytes are worth 5 each and 100 more 1; of the second, 300 are worth 6.
  const std::vector<library::WantedBytes> wanted = {{10, {{0, 5}, {100, 1}, {200, 0}}}, {20, {{50, 6}, {350, 0}}}};
  using Shares = std::vector<uint64_t>;
  EXPECT_EQ(share_out(29, wanted), std::nullopt);
  EXPECT_EQ(share_out(30, wanted), (Shares{10, 20}));
  EXPECT_EQ(share_out(110, wanted), (Shares{10, 100}));
  EXPECT_EQ(share_out(380, wanted), (Shares{60, 320}));
  EXPECT_EQ(share_out(480, wanted), (Shares{160, 320}));
  EXPECT_EQ(share_out(100000, wanted), (Shares{210, 320}));
}

TEST(ShareOut, WhatComesLaterIsNotWorthMoreThanWhatItNeedsBefore) {
  const std::vector<library::WantedBytes> wanted = {{0, {{0, 1}, {100, 9}, {200, 0}}}, {0, {{0, 3}, {100, 0}}}};
  EXPECT_EQ(share_out(150, wanted), (std::vector<uint64_t>{50, 100}));
}

TEST(ShareOut, WhoWantsNothingTakesWhatItMust) {
  const std::vector<library::WantedBytes> wanted = {{7}, {5, {{0, 1}, {1000, 0}}}};
  EXPECT_EQ(share_out(50, wanted), (std::vector<uint64_t>{7, 43}));
}

}  // namespace
}  // namespace vcd::test
