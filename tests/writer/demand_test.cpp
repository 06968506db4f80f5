#include <vcd/writer/demand.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

#include <gtest/gtest.h>

#include <vcd/format/checksum.h>

#include "support/files.h"
#include "support/random.h"
#include "support/special_floats.h"

namespace vcd::test {
namespace {

GeometryHash hash_of(uint8_t number) { return {number, 0xFF, number}; }

Segment random_segment(FloatRandom& random) {
  Segment s{};
  for (float& x : s.origin) x = random.between(-2, 2);
  for (float& x : s.direction) x = random.between(-1, 1);
  s.t_min = random.between(-1, 0);
  s.t_max = random.below(2) == 0 ? std::numeric_limits<float>::infinity() : 1;
  return s;
}

std::vector<AskedSegment> random_segments(uint64_t seed, size_t count) {
  FloatRandom random(seed);
  std::vector<AskedSegment> segments(count);
  for (AskedSegment& s : segments) s = {random_segment(random), 1.0 + random.below(5)};
  return in_order(std::move(segments));
}

Demand some_demand() { return {{hash_of(1), random_segments(1, 3)}, {hash_of(2), random_segments(2, 4)}}; }

bool equal(const Demand& a, const Demand& b) {
  return std::ranges::equal(a, b, [](const auto& x, const auto& y) {
    return x.first == y.first && x.second.size() == y.second.size() &&
           std::memcmp(x.second.data(), y.second.data(), x.second.size() * sizeof(AskedSegment)) == 0;
  });
}

double total_weight(const std::vector<AskedSegment>& segments, auto&& counts) {
  double sum = 0;
  for (const AskedSegment& s : segments) sum += counts(s) ? s.weight : 0;
  return sum;
}

class Demands : public ::testing::Test {
 protected:
  std::vector<std::byte> bytes_of(const Demand& demand) const {
    const auto size = write_demand(folder_ / "d", demand);
    EXPECT_TRUE(size.ok()) << size.error().message;
    const auto bytes = read_file(folder_ / "d");
    EXPECT_EQ(*size, bytes.size());
    return bytes;
  }
  // What is said of bytes; they lie in a block of exactly their size, so that sanitizers see each step beyond it.
  static std::string fault_of(const std::vector<std::byte>& bytes, ErrorCode code = ErrorCode::invalid_file) {
    const std::vector<std::byte> exact(bytes);
    const auto read = read_demand(exact, "d");
    if (read) return "";
    EXPECT_EQ(read.error().code, code) << read.error().message;
    return read.error().message;
  }
  TemporaryFolder folder_;
};

// A file's bytes with something changed in them, under checksums that match.
template <class T>
std::vector<std::byte> changed(std::vector<std::byte> bytes, size_t offset, const T& value) {
  std::memcpy(bytes.data() + offset, &value, sizeof value);
  DemandHeader header;
  std::memcpy(&header, bytes.data(), sizeof header);
  const size_t count = std::min<size_t>(header.object_count, 2);
  std::vector<DemandObject> objects(count);
  const std::span<std::byte> of_objects = std::as_writable_bytes(std::span(objects));
  std::copy_n(bytes.data() + sizeof header, of_objects.size(), of_objects.begin());
  size_t at = sizeof header + of_objects.size();
  for (DemandObject& object : objects) {
    const size_t size = std::min<size_t>(object.segment_count * sizeof(AskedSegment), bytes.size() - at);
    object.segments_xxh3 = checksum(Bytes(bytes).subspan(at, size));
    at += size;
  }
  std::ranges::copy(of_objects, bytes.data() + sizeof header);
  header.objects_xxh3 = checksum(std::as_bytes(std::span(objects)));
  header.header_xxh3 = checksum(std::as_bytes(std::span(&header, 1)).first(56));
  std::memcpy(bytes.data(), &header, sizeof header);
  return bytes;
}

constexpr size_t kFirstObject = sizeof(DemandHeader), kSecondObject = kFirstObject + sizeof(DemandObject);
constexpr size_t kFirstSegment = kSecondObject + sizeof(DemandObject);

TEST_F(Demands, AreReadAsTheyWereWritten) {
  const Demand demand = some_demand();
  const auto bytes = bytes_of(demand);
  const auto read = read_demand(folder_ / "d");
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_TRUE(equal(*read, demand));
  EXPECT_EQ(bytes, bytes_of(*read));
  EXPECT_TRUE(begins_like_demand(bytes));
  EXPECT_EQ(fault_of(changed(bytes, 10, uint16_t{1})), "") << "later minor versions are read";
}

TEST_F(Demands, EveryPrefixAndEachChangedByteIsNoticed) {
  const auto bytes = bytes_of(some_demand());
  for (size_t size = 0; size < bytes.size(); ++size)
    EXPECT_NE(fault_of({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)}), "") << size;
  for (size_t i = 0; i < bytes.size(); ++i)
    for (const unsigned char bit : {0x01, 0x80}) {
      auto damaged = bytes;
      damaged[i] ^= std::byte{bit};
      const auto read = read_demand(damaged, "d");
      EXPECT_FALSE(read.ok()) << i;
    }
  auto longer = bytes;
  longer.resize(longer.size() + 1);
  EXPECT_NE(fault_of(longer), "");
}

TEST_F(Demands, FaultsUnderRightChecksumsAreNamed) {
  const auto bytes = bytes_of(some_demand());
  const auto says = [&](const std::string& reason, size_t offset, const auto& value,
                        ErrorCode code = ErrorCode::invalid_file) {
    const std::string message = fault_of(changed(bytes, offset, value), code);
    EXPECT_NE(message.find(reason), std::string::npos) << reason << " | " << message;
    EXPECT_EQ(message.find("d: at byte "), 0u) << message;
  };
  says("only demands of version 1", 8, uint16_t{2}, ErrorCode::unsupported);
  says("reserved", 40, uint8_t{1});
  says("has 408 bytes", 16, uint64_t{1});
  says("asks nothing", 12, uint32_t{0});
  says("more than 65,536 objects", 12, uint32_t{65537}, ErrorCode::unsupported);
  says("do not fit", 12, uint32_t{1000});
  says("bytes follow", kSecondObject + 16, uint64_t{3});
  says("do not fit", kSecondObject + 16, uint64_t{5});
  says("do not fit", kSecondObject + 16, ~uint64_t{0});
  says("nothing is asked", kFirstObject + 16, uint64_t{0});
  says("order of their hashes", kFirstObject, hash_of(2));
  says("not finite", kFirstSegment, kNaN);
  says("not finite", kFirstSegment + 12, -std::numeric_limits<float>::infinity());
  says("no direction", kFirstSegment + 16, std::array<float, 3>{});
  says("no point", kFirstSegment + 12, 2.0e38f);
  says("weight", kFirstSegment + 32, 0.0);
  says("weight", kFirstSegment + 32, std::numeric_limits<double>::infinity());
  says("weight", kFirstSegment + 32, std::numeric_limits<double>::quiet_NaN());
  std::array<std::byte, 32> second;
  std::memcpy(second.data(), bytes.data() + kFirstSegment + sizeof(AskedSegment), second.size());
  says("twice", kFirstSegment, second);
}

TEST_F(Demands, WhatIsNoneSaysSo) {
  write_file(folder_ / "mesh.obj", std::as_bytes(std::span("v 0 0 0")));
  const auto read = read_demand(folder_ / "mesh.obj");
  ASSERT_FALSE(read.ok());
  EXPECT_NE(read.error().message.find("not a demand"), std::string::npos);
  EXPECT_EQ(read_demand(folder_ / "absent").error().code, ErrorCode::io);
  std::filesystem::resize_file(folder_ / "mesh.obj", uint64_t{1} << 40);  // a hole
  EXPECT_EQ(read_demand(folder_ / "mesh.obj").error().code, ErrorCode::unsupported);
}

TEST_F(Demands, ThatAskNothingOrTooMuchAreNotWritten) {
  EXPECT_EQ(write_demand(folder_ / "e", {}).error().code, ErrorCode::usage);
  Demand large;
  for (uint32_t i = 0; i <= kMostAskedObjects; ++i)
    large[{static_cast<uint8_t>(i >> 16), static_cast<uint8_t>(i >> 8), static_cast<uint8_t>(i)}];
  EXPECT_EQ(write_demand(folder_ / "e", large).error().code, ErrorCode::usage);
  // What the reader would refuse does not get the name.
  EXPECT_EQ(write_demand(folder_ / "e", {{hash_of(1), {}}}).error().code, ErrorCode::io);
  EXPECT_TRUE(std::filesystem::is_empty(folder_.path()));
}

TEST(DemandInOrder, SumsEqualSegmentsAndLeavesOutUnusableOnes) {
  FloatRandom random(3);
  const Segment a = random_segment(random);
  Segment nan = a, pointless = a;
  nan.direction[1] = kNaN, pointless.t_max = pointless.t_min;
  const auto ordered = in_order({{a, 1}, {nan, 1}, {a, 2}, {pointless, 1}, {a, -1}, {a, 0}});
  ASSERT_EQ(ordered.size(), 1u);
  EXPECT_EQ(ordered[0].weight, 3);
}

TEST(DemandMerge, DoesNotDependOnTheOrder) {
  std::vector<Demand> demands = {
      some_demand(), {{hash_of(2), random_segments(2, 9)}}, {{hash_of(3), random_segments(5, 2)}}};
  const Demand merged = merge(demands);
  std::ranges::reverse(demands);
  EXPECT_TRUE(equal(merged, merge(demands)));
  EXPECT_EQ(merged.size(), 3u);
  const auto any = [](const AskedSegment&) { return true; };
  double sum = 0, parts = 0;
  for (const auto& [hash, segments] : merged) sum += total_weight(segments, any);
  for (const Demand& d : demands)
    for (const auto& [hash, segments] : d) parts += total_weight(segments, any);
  EXPECT_EQ(sum, parts);
  EXPECT_LT(segment_count(merged), 18u) << "the first four of seed 2 are in two of them";
}

TEST(DemandThin, KeepsTheWeightOfEveryPartInTheMean) {
  Demand all = {{hash_of(1), random_segments(7, 20000)}, {hash_of(2), random_segments(8, 20000)}};
  all[hash_of(2)][0].weight = 1e6;  // what stands for much stays
  const Demand thinned = thin(all, 4000);
  EXPECT_EQ(segment_count(thinned), 4000u);
  EXPECT_TRUE(equal(thinned, thin(all, 4000)));
  EXPECT_TRUE(equal(all, thin(all, 40000)));
  const Demand again = thin(thinned, 1000);
  for (const auto& [hash, segments] : all)
    for (const float side : {-1.0f, 1.0f}) {
      const auto counts = [&](const AskedSegment& s) { return s.segment.origin[0] * side > 0 && s.weight < 1e5; };
      const double sum = total_weight(segments, counts);
      EXPECT_NEAR(total_weight(thinned.at(hash), counts) / sum, 1, 0.1);
      EXPECT_NEAR(total_weight(again.at(hash), counts) / sum, 1, 0.2);
    }
  const auto heavy = [](const AskedSegment& s) { return s.weight > 1e5; };
  EXPECT_EQ(total_weight(again.at(hash_of(2)), heavy), 1e6);
}

}  // namespace
}  // namespace vcd::test
