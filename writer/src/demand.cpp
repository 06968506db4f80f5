#include <vcd/writer/demand.h>

#include <algorithm>
#include <functional>
#include <new>
#include <string>
#include <utility>

#include <vcd/format/checksum.h>
#include <vcd/writer/atomic_file.h>

namespace vcd {
namespace {

template <class T>
Bytes bytes_of(const std::vector<T>& values) {
  return std::as_bytes(std::span(values));
}

// In (0, 1], of a segment and a seed.
double share_of(const Segment& segment, uint64_t seed) {
  const Bytes pieces[] = {std::as_bytes(std::span(&seed, 1)), std::as_bytes(std::span(&segment, 1))};
  return static_cast<double>((checksum(pieces) >> 11) + 1) * 0x1p-53;
}

// Another one for each demand: what is thinned, merged and thinned again must not be chosen by the same numbers.
uint64_t seed_of(const Demand& demand) {
  std::vector<Bytes> pieces;
  for (const auto& [hash, segments] : demand) {
    pieces.push_back(std::as_bytes(std::span(hash)));
    pieces.push_back(bytes_of(segments));
  }
  return checksum(pieces);
}

const char* fault_of(const Demand& demand) {
  if (demand.empty()) return "it asks nothing of any object";
  if (demand.size() > kMostAskedObjects) return "more objects than a demand may have";
  if (segment_count(demand) > kMostAskedSegments) return "more segments than a demand may have: thin it";
  return nullptr;
}

}  // namespace

std::vector<AskedSegment> in_order(std::vector<AskedSegment> segments) {
  std::erase_if(segments, [](const AskedSegment& s) {
    return !usable_in_demand(s.segment) || !(s.weight > 0 && s.weight <= kMostWeight);
  });
  // By weight too, so that sums do not depend on the order before.
  std::ranges::sort(segments, [](const AskedSegment& a, const AskedSegment& b) {
    if (comes_before(a.segment, b.segment)) return true;
    return !comes_before(b.segment, a.segment) && a.weight < b.weight;
  });
  size_t count = 0;
  for (const AskedSegment& s : segments)
    if (count > 0 && !comes_before(segments[count - 1].segment, s.segment)) {
      double& weight = segments[count - 1].weight;
      weight = std::min(weight + s.weight, kMostWeight);
    } else {
      segments[count++] = s;
    }
  segments.resize(count);
  return segments;
}

Demand merge(std::span<const Demand> demands) {
  Demand all;
  for (const Demand& demand : demands)
    for (const auto& [hash, segments] : demand) {
      auto& of_object = all[hash];
      of_object.insert(of_object.end(), segments.begin(), segments.end());
    }
  for (auto& [hash, segments] : all) segments = in_order(std::move(segments));
  std::erase_if(all, [](const auto& object) { return object.second.empty(); });
  return all;
}

uint64_t segment_count(const Demand& demand) {
  uint64_t count = 0;
  for (const auto& [hash, segments] : demand) count += segments.size();
  return count;
}

Demand thin(Demand demand, uint64_t most) {
  const uint64_t count = segment_count(demand);
  if (count <= most) return demand;
  const uint64_t seed = seed_of(demand);
  using Priority = std::pair<double, uint64_t>;  // and which segment of all, so that no two are equal
  std::vector<Priority> priorities;
  priorities.reserve(count);
  for (const auto& [hash, segments] : demand)
    for (const AskedSegment& s : segments)
      priorities.push_back({s.weight / share_of(s.segment, seed), priorities.size()});
  std::vector<Priority> order = priorities;
  std::nth_element(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(most), order.end(), std::greater<>());
  const Priority first_out = order[most];
  size_t number = 0;
  for (auto& [hash, segments] : demand) {
    std::vector<AskedSegment> kept;
    for (const auto& [segment, weight] : segments)
      if (priorities[number++] > first_out)
        kept.push_back({segment, std::min(std::max(weight, first_out.first), kMostWeight)});
    segments = std::move(kept);
  }
  std::erase_if(demand, [](const auto& object) { return object.second.empty(); });
  return demand;
}

Result<uint64_t> write_demand(const std::filesystem::path& path, const Demand& demand) try {
  if (const char* fault = fault_of(demand)) return Error{ErrorCode::usage, path.string() + ": " + fault};
  std::vector<DemandObject> objects;
  for (const auto& [hash, segments] : demand) objects.push_back({hash, segments.size(), checksum(bytes_of(segments))});
  DemandHeader header{};
  header.magic = kDemandMagic;
  header.version_major = kDemandVersionMajor;
  header.version_minor = kDemandVersionMinor;
  header.object_count = static_cast<uint32_t>(objects.size());
  header.file_size = sizeof header + bytes_of(objects).size() + segment_count(demand) * sizeof(AskedSegment);
  header.objects_xxh3 = checksum(bytes_of(objects));
  const Bytes header_bytes = std::as_bytes(std::span(&header, 1));
  header.header_xxh3 = checksum(header_bytes.first(offsetof(DemandHeader, header_xxh3)));

  AtomicFile file(path, kDemandBegin);
  file.append(header_bytes);
  file.append(bytes_of(objects));
  for (const auto& [hash, segments] : demand) file.append(bytes_of(segments));
  return file.commit([](Bytes bytes) {
    const auto written = read_demand(bytes, "what was written");
    return written ? std::string() : written.error().message;
  });
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::runtime, path.string() + ": out of memory"};
}

}  // namespace vcd
