// read_demand() on any bytes.
#include <algorithm>
#include <cstring>

#include <xxhash.h>

#include <vcd/format/demand.h>
#include <vcd/writer/demand.h>

#include "fuzz/fuzz.h"

namespace vcd::fuzz {
namespace {

template <class T>
T taken(const uint8_t* from) {
  T value;
  std::memcpy(&value, from, sizeof value);
  return value;
}

// Checksums, magic and size as they should be, as far as the file goes: else no mutation would get past them.
void seal(uint8_t* data, size_t size) {
  if (size < sizeof(DemandHeader)) return;
  auto header = taken<DemandHeader>(data);
  header.magic = kDemandMagic;
  header.file_size = size;
  const size_t objects = header.object_count, begin = sizeof header;
  if (objects > (size - begin) / sizeof(DemandObject)) return;
  size_t at = begin + objects * sizeof(DemandObject);
  for (size_t i = 0; i < objects; ++i) {
    uint8_t* const place = data + begin + i * sizeof(DemandObject);
    auto object = taken<DemandObject>(place);
    if (object.segment_count > (size - at) / sizeof(AskedSegment)) break;
    const size_t bytes = object.segment_count * sizeof(AskedSegment);
    object.segments_xxh3 = XXH3_64bits(data + at, bytes);
    std::memcpy(place, &object, sizeof object);
    at += bytes;
  }
  header.objects_xxh3 = XXH3_64bits(data + begin, objects * sizeof(DemandObject));
  header.header_xxh3 = XXH3_64bits(&header, offsetof(DemandHeader, header_xxh3));
  std::memcpy(data, &header, sizeof header);
}

bool same(const AskedSegment& a, const AskedSegment& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

void require_demand(const Demand& demand) {
  require(!demand.empty(), "a demand asks something");
  for (const auto& [hash, asked] : demand) {
    require(!asked.empty(), "each object is asked something");
    for (size_t i = 0; i < asked.size(); ++i) {
      require(usable_in_demand(asked[i].segment), "segments are usable");
      require(asked[i].weight > 0 && asked[i].weight <= kMostWeight, "weights are in their limits");
      require(i == 0 || comes_before(asked[i - 1].segment, asked[i].segment), "segments are in order, none twice");
    }
  }
  const Demand merged = merge(std::span(&demand, 1));
  require(std::ranges::equal(demand, merged,
                             [](const auto& a, const auto& b) {
                               return a.first == b.first && std::ranges::equal(a.second, b.second, same);
                             }),
          "merged with nothing a demand stays as it is");
  require(segment_count(thin(demand, 3)) <= 3, "a thinned demand has no more than it may");
}

void read(const uint8_t* data, size_t size) {
  const auto demand = read_demand(Bytes(reinterpret_cast<const std::byte*>(data), size), "input");
  if (!demand) return require(!demand.error().message.empty(), "an error says why");
  require_demand(*demand);
  planted_bug();
}

}  // namespace
}  // namespace vcd::fuzz

extern "C" size_t LLVMFuzzerCustomMutator(uint8_t* data, size_t size, size_t max_size, unsigned int seed) {
  size = LLVMFuzzerMutate(data, size, max_size);
  if (seed % 8 != 0) vcd::fuzz::seal(data, size);
  return size;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  vcd::fuzz::read(data, size);
  return 0;
}
