#include <vcd/library/schedule.h>

#include <gtest/gtest.h>

#include <list>
#include <set>

#include "support/random.h"

namespace vcd::library {
namespace {

constexpr uint64_t kMiB = uint64_t{1} << 20;

std::vector<Cost> costs(const std::vector<double>& seconds, uint64_t memory = kMiB) {
  std::vector<Cost> all;
  for (const double s : seconds) all.push_back({s, memory});
  return all;
}

TEST(Schedule, LongestFirstSideBySide) {
  Schedule schedule(costs({1, 5, 4, 5, 3, 3}), 2, 100 * kMiB);
  const auto first = schedule.next(), second = schedule.next();
  ASSERT_TRUE(first && second);
  EXPECT_EQ(first->job, 1u);
  EXPECT_EQ(second->job, 3u);
  EXPECT_EQ(first->threads, 1u);
  EXPECT_FALSE(schedule.next());
  schedule.ended(*second);
  EXPECT_EQ(schedule.next()->job, 2u);
}

TEST(Schedule, OneThatWouldOutlastAllOthersGetsMoreThreads) {
  EXPECT_EQ(Schedule(costs({7}), 4, kMiB).next()->threads, 4u);
  EXPECT_EQ(Schedule(costs({100, 1, 1, 1}), 2, kMiB).next()->threads, 2u);
  EXPECT_EQ(Schedule(costs({10, 10}), 2, 2 * kMiB).next()->threads, 1u);
  EXPECT_EQ(Schedule(costs({20, 10, 10}), 4, 2 * kMiB).next()->threads, 2u);
}

TEST(Schedule, MemoryIsNeverHandedOutTwice) {
  Schedule schedule({{9, 60 * kMiB}, {8, 60 * kMiB}, {7, 10 * kMiB}}, 2, 100 * kMiB);
  const auto first = schedule.next();
  ASSERT_TRUE(first);
  EXPECT_FALSE(schedule.next());  // nor is the small one let past, or the second might wait for ever
  schedule.ended(*first);
  EXPECT_EQ(schedule.next()->job, 1u);
  EXPECT_EQ(schedule.next()->job, 2u);
}

TEST(Schedule, WhatNeedsMoreThanThereIsRunsAlone) {
  Schedule schedule({{9, 500 * kMiB}, {1, kMiB}}, 2, 100 * kMiB);
  const auto large = schedule.next();
  ASSERT_TRUE(large);
  EXPECT_EQ(large->memory_bytes, 100 * kMiB);
  EXPECT_FALSE(schedule.next());
  schedule.ended(*large);
  EXPECT_FALSE(schedule.again(*large, 200 * kMiB));
  EXPECT_TRUE(schedule.next());
}

TEST(Schedule, AgainWithMoreMemory) {
  Schedule schedule({{1, 10 * kMiB}}, 1, 100 * kMiB);
  for (const uint64_t memory : {10, 40, 100}) {
    const auto grant = schedule.next();
    ASSERT_TRUE(grant);
    EXPECT_EQ(grant->memory_bytes, memory * kMiB);
    schedule.ended(*grant);
    EXPECT_EQ(schedule.idle(), true);
    EXPECT_EQ(schedule.again(*grant, 4 * grant->memory_bytes), memory < 100);
  }
  EXPECT_TRUE(schedule.idle());
}

TEST(Schedule, RandomRunsEndAndKeepTheBudgets) {
  test::FloatRandom random(7);
  for (int round = 0; round < 200; ++round) {
    std::vector<Cost> all(1 + random.below(40));
    for (Cost& cost : all) cost = {0.1 + static_cast<double>(random.below(100)), (1 + random.below(120)) * kMiB};
    const unsigned threads = 1 + static_cast<unsigned>(random.below(8));
    Schedule schedule(all, threads, 100 * kMiB);
    std::list<Grant> running;
    std::set<size_t> done;
    while (!schedule.idle()) {
      while (const auto grant = schedule.next()) running.push_back(*grant);
      unsigned used = 0;
      uint64_t memory = 0;
      for (const Grant& grant : running) used += grant.threads, memory += grant.memory_bytes;
      ASSERT_LE(used, threads);
      ASSERT_LE(memory, 100 * kMiB);
      ASSERT_FALSE(running.empty());
      auto one = running.begin();
      std::advance(one, random.below(static_cast<uint32_t>(running.size())));
      EXPECT_TRUE(done.insert(one->job).second);
      schedule.ended(*one);
      running.erase(one);
    }
    EXPECT_EQ(done.size(), all.size());
  }
}

}  // namespace
}  // namespace vcd::library
