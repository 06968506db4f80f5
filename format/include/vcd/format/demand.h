// A demand: which segments a scene asks of its objects. A bake looks there first; no answer depends on it.
// Normative text: spec/demand.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string_view>
#include <vector>

#include <vcd/format/bytes.h>
#include <vcd/format/error.h>
#include <vcd/format/geometry_hash.h>
#include <vcd/format/segment.h>

namespace vcd {

// One segment of a sample of those that were asked.
struct AskedSegment {
  Segment segment;  // in the object's frame; usable_in_demand()
  double weight;    // how many of those that were asked it stands for: greater than 0, at most kMostWeight
};
static_assert(sizeof(AskedSegment) == 40 && offsetof(AskedSegment, weight) == 32);

// Of each object that is asked: at least one segment, in the order of comes_before(), none twice.
using Demand = std::map<GeometryHash, std::vector<AskedSegment>>;

// Limits of a file, so that reading one takes at most 1.3 GB.
inline constexpr uint64_t kMostAskedSegments = uint64_t{1} << 24;
inline constexpr uint32_t kMostAskedObjects = uint32_t{1} << 16;
inline constexpr double kMostWeight = 0x1p60;

inline constexpr std::array<uint8_t, 8> kDemandMagic = {0x89, 'V', 'C', 'A', '\r', '\n', 0x1A, '\n'};
inline constexpr std::string_view kDemandBegin = "\x89VCA\r\n\x1A\n";  // the same bytes as a text
inline constexpr uint16_t kDemandVersionMajor = 1;
inline constexpr uint16_t kDemandVersionMinor = 0;

// A file is this header, its objects, and their segments, an object's behind the other's.
struct DemandHeader {
  std::array<uint8_t, 8> magic;
  uint16_t version_major;
  uint16_t version_minor;
  uint32_t object_count;
  uint64_t file_size;     // of the whole file, bytes
  uint64_t objects_xxh3;  // XXH3-64 of the objects that follow
  uint8_t reserved[24];   // zero
  uint64_t header_xxh3;   // XXH3-64 of the 56 bytes above
};
static_assert(sizeof(DemandHeader) == 64 && offsetof(DemandHeader, object_count) == 12 &&
              offsetof(DemandHeader, objects_xxh3) == 24 && offsetof(DemandHeader, header_xxh3) == 56);

struct DemandObject {
  GeometryHash geometry_hash;
  uint64_t segment_count;
  uint64_t segments_xxh3;  // XXH3-64 of the object's segments
};
static_assert(sizeof(DemandObject) == 32 && offsetof(DemandObject, segment_count) == 16);

// All numbers are finite but t_max, which may be +infinity; the direction is not zero, and t_min < t_max.
bool usable_in_demand(const Segment& segment);

// The order of segments in a demand: by their 32 bytes as eight unsigned numbers.
bool comes_before(const Segment& a, const Segment& b);

bool begins_like_demand(Bytes file);

// Safe on any bytes: every count is bounded by the bytes behind it before it is used. Errors: invalid_file and
// unsupported, naming the file, the byte and the reason; runtime (out of memory). name: of the file, for messages.
Result<Demand> read_demand(Bytes file, std::string_view name);

// Reads a file. Errors: io too.
Result<Demand> read_demand(const std::filesystem::path& path);

}  // namespace vcd
