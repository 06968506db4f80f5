#include <vcd/format/demand.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <new>
#include <optional>
#include <string>

#include <vcd/format/checksum.h>
#include <vcd/format/file_bytes.h>

#include "reading.h"

namespace vcd {
namespace {

template <class T>
T value_at(Bytes bytes, uint64_t offset) {
  T value;
  std::memcpy(&value, bytes.data() + offset, sizeof value);
  return value;
}

constexpr uint64_t kMostDemandBytes =
    sizeof(DemandHeader) + kMostAskedObjects * sizeof(DemandObject) + kMostAskedSegments * sizeof(AskedSegment);

class DemandReader {
 public:
  DemandReader(Bytes file, std::string_view name) : file_(file), name_(name) {}

  Result<Demand> read() {
    if (auto fault = read_header()) return *std::move(fault);
    if (auto fault = read_objects()) return *std::move(fault);
    uint64_t at = end_of_objects();
    for (const DemandObject& object : objects_) {
      if (auto fault = read_segments(object, at)) return *std::move(fault);
      at += object.segment_count * sizeof(AskedSegment);
    }
    return std::move(demand_);
  }

 private:
  Error fault(uint64_t offset, const std::string& reason, ErrorCode code = ErrorCode::invalid_file) const {
    return {code, std::string(name_) + ": at byte " + std::to_string(offset) + ": " + reason};
  }
  uint64_t end_of_objects() const { return sizeof(DemandHeader) + header_.object_count * sizeof(DemandObject); }

  std::optional<Error> read_header() {
    if (!begins_like_demand(file_)) return fault(0, "this is not a demand");
    if (file_.size() < sizeof header_) return fault(file_.size(), "the file is shorter than its header");
    header_ = value_at<DemandHeader>(file_, 0);
    if (header_.version_major != kDemandVersionMajor)
      return fault(8, "only demands of version 1 are known, this is of " + std::to_string(header_.version_major),
                   ErrorCode::unsupported);
    if (header_.header_xxh3 != checksum(file_.first(offsetof(DemandHeader, header_xxh3))))
      return fault(56, "the header's checksum does not match");
    if (header_.file_size != file_.size())
      return fault(16, "the file has " + std::to_string(file_.size()) + " bytes, and " +
                           std::to_string(header_.file_size) + " by its header");
    if (header_.version_minor <= kDemandVersionMinor && !all_zero(header_.reserved))
      return fault(32, "a reserved field is not zero");
    if (header_.object_count == 0) return fault(12, "it asks nothing of any object");
    if (header_.object_count > kMostAskedObjects) return fault(12, "more than 65,536 objects", ErrorCode::unsupported);
    if (header_.object_count > (file_.size() - sizeof header_) / sizeof(DemandObject))
      return fault(12, "its objects do not fit in the file");
    return std::nullopt;
  }

  std::optional<Error> read_objects() {
    const Bytes table = file_.subspan(sizeof header_, header_.object_count * sizeof(DemandObject));
    if (header_.objects_xxh3 != checksum(table)) return fault(24, "the checksum of its objects does not match");
    uint64_t segments_left = (file_.size() - end_of_objects()) / sizeof(AskedSegment);
    if (segments_left > kMostAskedSegments)
      return fault(16, "more than 16,777,216 segments; thin what it was merged from", ErrorCode::unsupported);
    for (uint32_t i = 0; i < header_.object_count; ++i) {
      const uint64_t offset = sizeof header_ + i * sizeof(DemandObject);
      objects_.push_back(value_at<DemandObject>(file_, offset));
      const DemandObject& object = objects_.back();
      if (i > 0 && !(objects_[i - 1].geometry_hash < object.geometry_hash))
        return fault(offset, "objects are not in the order of their hashes, or one stands twice");
      if (object.segment_count == 0) return fault(offset, "an object of which nothing is asked");
      if (object.segment_count > segments_left) return fault(offset, "an object's segments do not fit in the file");
      segments_left -= object.segment_count;
    }
    if (segments_left > 0 || (file_.size() - end_of_objects()) % sizeof(AskedSegment) != 0)
      return fault(16, "bytes follow the last segment");
    return std::nullopt;
  }

  std::optional<Error> read_segments(const DemandObject& object, uint64_t offset) {
    const Bytes bytes = file_.subspan(offset, object.segment_count * sizeof(AskedSegment));
    if (object.segments_xxh3 != checksum(bytes))
      return fault(offset, "the checksum of an object's segments does not match");
    std::vector<AskedSegment> segments(object.segment_count);
    std::memcpy(segments.data(), bytes.data(), bytes.size());
    for (size_t i = 0; i < segments.size(); ++i) {
      const auto& [segment, weight] = segments[i];
      const uint64_t at = offset + i * sizeof(AskedSegment);
      if (!usable_in_demand(segment))
        return fault(at, "a segment has a number that is not finite, no direction, or no point");
      if (!(weight > 0 && weight <= kMostWeight)) return fault(at + 32, "a weight is not in (0, 2^60]");
      if (i > 0 && !comes_before(segments[i - 1].segment, segment))
        return fault(at, "segments are not in their order, or one stands twice");
    }
    demand_.emplace_hint(demand_.end(), object.geometry_hash, std::move(segments));
    return std::nullopt;
  }

  Bytes file_;
  std::string_view name_;
  DemandHeader header_{};
  std::vector<DemandObject> objects_;
  Demand demand_;
};

}  // namespace

bool usable_in_demand(const Segment& s) {
  const auto finite = [](float x) { return std::isfinite(x); };
  return std::ranges::all_of(s.origin, finite) && std::ranges::all_of(s.direction, finite) &&
         std::ranges::any_of(s.direction, [](float x) { return x != 0; }) && finite(s.t_min) && s.t_min < s.t_max;
}

bool comes_before(const Segment& a, const Segment& b) {
  std::array<uint32_t, 8> x, y;
  std::memcpy(x.data(), &a, sizeof x), std::memcpy(y.data(), &b, sizeof y);
  return x < y;
}

bool begins_like_demand(Bytes file) {
  return file.size() >= kDemandMagic.size() && std::memcmp(file.data(), kDemandMagic.data(), kDemandMagic.size()) == 0;
}

Result<Demand> read_demand(Bytes file, std::string_view name) try {
  return DemandReader(file, name).read();
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::runtime, std::string(name) + ": out of memory"};
}

Result<Demand> read_demand(const std::filesystem::path& path) {
  std::error_code ignored;  // what cannot be read has an error below
  if (const auto size = std::filesystem::file_size(path, ignored); !ignored && size > kMostDemandBytes)
    return Error{ErrorCode::unsupported,
                 path.string() + ": its " + std::to_string(size) + " bytes are more than a demand may have"};
  const auto file = FileBytes::copy(path);
  if (!file) return file.error();
  return read_demand(file->bytes(), path.string());
}

}  // namespace vcd
