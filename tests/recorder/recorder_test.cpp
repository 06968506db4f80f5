#include <vcd/recorder/recorder.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <thread>

#include <gtest/gtest.h>

#include <vcd/recorder/vcd_recorder.h>
#include <vcd/writer/demand.h>

#include "support/files.h"
#include "support/random.h"
#include "support/special_floats.h"

namespace vcd::test {
namespace {

constexpr GeometryHash kHash = {1, 2, 3}, kOther = {9};
constexpr Transform kIdentity = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};

RecordedInstance cube_at(float x, const GeometryHash& hash = kHash, float scale = 1) {
  RecordedInstance instance{hash, {std::nullopt, {0, 0, 0}, {1, 1, 1}, kIdentity}};
  for (int a = 0; a < 3; ++a) instance.place.to_world.rows[a][a] = scale;
  instance.place.to_world.rows[0][3] = x;
  return instance;
}

Recorder must_build(std::vector<RecordedInstance> instances, size_t most = Recorder::kDefaultMost) {
  auto recorder = Recorder::build(instances, most);
  if (!recorder) throw std::runtime_error(recorder.error().message);
  return std::move(*recorder);
}

// Downwards through the cube at `x`.
Segment through(FloatRandom& random, float x) {
  return {{x + random.between(0.1f, 0.9f), 3, random.between(0.1f, 0.9f)}, 0, {0, -4, 0}, 1};
}

std::vector<AskedSegment> weighing_one(std::span<const Segment> segments) {
  std::vector<AskedSegment> all;
  for (const Segment& s : segments) all.push_back({s, 1});
  return in_order(std::move(all));
}

// But for the rounding of transforms.
bool equal(const std::vector<AskedSegment>& a, const std::vector<AskedSegment>& b) {
  const auto near = [](float x, float y) { return std::abs(x - y) < 1e-6f; };
  return std::ranges::equal(a, b, [&](const AskedSegment& x, const AskedSegment& y) {
    return std::ranges::equal(x.segment.origin, y.segment.origin, near) &&
           std::ranges::equal(x.segment.direction, y.segment.direction, near) && x.segment.t_min == y.segment.t_min &&
           x.segment.t_max == y.segment.t_max && x.weight == y.weight;
  });
}

double weight_of(const std::vector<AskedSegment>& segments) {
  double sum = 0;
  for (const AskedSegment& s : segments) sum += s.weight;
  return sum;
}

TEST(Recorder, KeepsAllThatFitsHoweverItIsAsked) {
  Recorder recorder = must_build({cube_at(0)});
  Recorder::Thread& mine = recorder.thread();
  FloatRandom random(1);
  std::vector<Segment> all;
  for (int i = 0; i < 5; ++i) mine.asked(all.emplace_back(through(random, 0)));
  std::vector<Segment> some;
  for (int i = 0; i < 7; ++i) some.push_back(through(random, 0));
  mine.asked(std::span<const Segment>(some));
  all.insert(all.end(), some.begin(), some.end());

  const float x[] = {0.25f, 0.5f}, y[] = {2, 3}, z[] = {0.5f, 0.75f}, down[] = {-1, -2}, zero[] = {0, 0},
              far[] = {9, 8};
  const SegmentArrays arrays{{x, y, z}, zero, {zero, down, zero}, far, 2};
  mine.asked(arrays);
  for (size_t i = 0; i < 2; ++i) all.push_back(segment_at(arrays, i));

  const QuadBundle quad{{0.5f, -1, 0.5f}, {0, 5, 0}, {1, 0, 0}, {0, 0, 1}, x, z};
  const SphereBundle sphere{{0.5f, -1, 0.5f}, {0.5f, 3, 0.5f}, 2, x, y, z};
  const PointBundle points{{0.5f, -1, 0.5f}, x, y, z};
  mine.asked(quad), mine.asked(sphere), mine.asked(points);
  for (size_t i = 0; i < 2; ++i) {
    all.push_back(segment_of(quad, i));
    all.push_back(segment_of(sphere, i));
    all.push_back(segment_of(points, i));
  }
  EXPECT_EQ(mine.seen(), all.size());
  const Demand demand = recorder.demand();
  ASSERT_EQ(demand.size(), 1u);
  EXPECT_TRUE(equal(demand.at(kHash), weighing_one(all)));
}

TEST(Recorder, KeepsAnEvenSampleOfMore) {
  constexpr size_t kMost = 2000, kAsked = 300'000;
  Recorder recorder = must_build({cube_at(0)}, kMost);
  Recorder::Thread& mine = recorder.thread();
  FloatRandom random(2);
  std::vector<Segment> block;
  for (size_t i = 0; i < kAsked;) {  // one by one, and in arrays of any size
    block.clear();
    for (size_t n = 1 + random.below(300); n > 0 && i < kAsked; --n, ++i) {
      Segment s = through(random, 0);
      s.t_max = 1 + static_cast<float>(i) / kAsked;  // when it was asked
      block.push_back(s);
    }
    if (block.size() < 20) std::ranges::for_each(block, [&](const Segment& s) { mine.asked(s); });
    else mine.asked(std::span<const Segment>(block));
  }
  EXPECT_EQ(mine.seen(), kAsked);
  const auto kept = recorder.demand().at(kHash);
  EXPECT_LE(kept.size(), kMost);
  EXPECT_GE(kept.size(), kMost / 2);
  EXPECT_NEAR(weight_of(kept), kAsked, 1);
  std::array<int, 10> tenths{};
  for (const AskedSegment& s : kept) ++tenths[std::min(static_cast<size_t>((s.segment.t_max - 1) * 10), size_t{9})];
  for (const int count : tenths) EXPECT_NEAR(count, static_cast<double>(kept.size()) / 10, 2) << "one of each so many";
  std::array<int, 4> quarters{};
  for (const AskedSegment& s : kept) {
    const auto when = static_cast<size_t>(std::lround((s.segment.t_max - 1) * kAsked));
    ++quarters[when % 256 / 64];  // one of each 256 was kept
  }
  for (const int count : quarters)
    EXPECT_NEAR(count, static_cast<double>(kept.size()) / 4, 75);  // five standard deviations
}

TEST(Recorder, RecordsInTheFrameOfEachObjectWhoseBoxIsMet) {
  Recorder recorder = must_build({cube_at(0), cube_at(10, kHash, 2), cube_at(20, kOther)});
  Recorder::Thread& mine = recorder.thread();
  const Segment second{{11, 8, 1}, 0, {0, -8, 0}, 2};
  mine.asked(second);
  const Segment along_all{{-5, 0.5f, 0.5f}, 0, {30, 0, 0}, 1};
  mine.asked(along_all, 2);                          // begins on the last
  mine.asked(Segment{{5, 8, 1}, 0, {0, -8, 0}, 1});  // meets none
  const Demand demand = recorder.demand();
  ASSERT_EQ(demand.size(), 1u);
  const Segment second_inside{{0.5f, 4, 0.5f}, 0, {0, -4, 0}, 2}, first{{-5, 0.5f, 0.5f}, 0, {30, 0, 0}, 1},
      through_second{{-7.5f, 0.25f, 0.25f}, 0, {15, 0, 0}, 1};
  EXPECT_TRUE(equal(demand.at(kHash), weighing_one(std::array{second_inside, first, through_second})));
}

TEST(Recorder, ThreadsRecordBesideEachOther) {
  Recorder recorder = must_build({cube_at(0)}, 5000);
  constexpr int kThreads = 4, kEach = 20000;
  std::vector<std::thread> threads;
  for (int t = 0; t < kThreads; ++t)
    threads.emplace_back([&recorder, t] {
      Recorder::Thread& mine = recorder.thread();
      FloatRandom random(100 + static_cast<uint64_t>(t));
      for (int i = 0; i < kEach; ++i) mine.asked(through(random, 0));
    });
  for (std::thread& thread : threads) thread.join();
  const Demand demand = recorder.demand();
  EXPECT_NEAR(weight_of(demand.at(kHash)), kThreads * kEach, 1);
  EXPECT_LE(demand.at(kHash).size(), size_t{kThreads} * 5000);
  EXPECT_GE(demand.at(kHash).size(), size_t{kThreads} * 2500);
}

TEST(Recorder, LeavesOutWhatNoDemandMayHold) {
  Recorder recorder = must_build({cube_at(0)});
  Recorder::Thread& mine = recorder.thread();
  for (const float bad : {kNaN, kInfinity})
    for (int i = 0; i < 8; ++i) {
      Segment s{{0.5f, 3, 0.5f}, 0, {0, -4, 0}, 1};
      std::array<float, 8> floats;
      std::memcpy(floats.data(), &s, sizeof s);
      floats[static_cast<size_t>(i)] = bad;
      std::memcpy(&s, floats.data(), sizeof s);
      if (i != 7 || std::isnan(bad)) mine.asked(s);
    }
  mine.asked(Segment{{0.5f, 3, 0.5f}, 0, {0, 0, 0}, 1});
  EXPECT_TRUE(recorder.demand().empty());
  mine.asked(Segment{{0.5f, 3, 0.5f}, 0, {0, -4, 0}, kInfinity});
  EXPECT_EQ(recorder.demand().at(kHash).size(), 1u);
}

TEST(Recorder, InCWritesTheSameDemand) {
  TemporaryFolder folder;
  FloatRandom random(3);
  std::vector<Segment> segments;
  for (int i = 0; i < 1000; ++i) segments.push_back(through(random, 0));
  Recorder recorder = must_build({cube_at(0)}, 100);
  recorder.thread().asked(std::span<const Segment>(segments));
  ASSERT_TRUE(write_demand(folder / "cpp", recorder.demand()).ok());

  vcd_recorded_instance instance{};
  std::memcpy(instance.geometry_hash, kHash.data(), kHash.size());
  for (int a = 0; a < 3; ++a) instance.box_max[a] = 1;
  std::memcpy(instance.to_world, &kIdentity, sizeof kIdentity);
  vcd_recorder* in_c = nullptr;
  ASSERT_EQ(vcd_recorder_build(&instance, 1, 100, &in_c, nullptr), VCD_SUCCESS);
  vcd_recorder_thread* thread = vcd_recorder_new_thread(in_c);
  vcd_recorder_asked(thread, reinterpret_cast<const vcd_segment*>(segments.data()), segments.size(), VCD_NO_INSTANCE);
  ASSERT_EQ(vcd_recorder_write(in_c, (folder / "c").c_str(), nullptr), VCD_SUCCESS);
  EXPECT_EQ(read_file(folder / "c"), read_file(folder / "cpp"));

  vcd_error error{};
  EXPECT_EQ(vcd_recorder_write(in_c, (folder / "absent/c").c_str(), &error), VCD_ERROR_IO);
  EXPECT_NE(std::string(error.message), "");
  vcd_recorder_free(in_c);
  instance.size = 4;
  EXPECT_EQ(vcd_recorder_build(&instance, 1, 0, &in_c, &error), VCD_ERROR_USAGE);
  EXPECT_EQ(vcd_recorder_build(nullptr, 1, 0, &in_c, &error), VCD_ERROR_USAGE);
  EXPECT_EQ(vcd_recorder_build(nullptr, 0, 0, nullptr, &error), VCD_ERROR_USAGE);
  ASSERT_EQ(vcd_recorder_build(nullptr, 0, 0, &in_c, &error), VCD_SUCCESS);
  EXPECT_EQ(vcd_recorder_write(in_c, (folder / "nothing").c_str(), &error), VCD_ERROR_USAGE);
  vcd_recorder_free(in_c);
  vcd_recorder_free(nullptr);
}

}  // namespace
}  // namespace vcd::test
