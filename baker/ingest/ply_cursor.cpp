#include "ingest/ply_cursor.h"

#include <cmath>
#include <cstring>

namespace vcd::baker {
namespace {

constexpr const char* kFileEnds = "the file ends within it";

template <class To, class From>
To bit_copy(From from) {
  static_assert(sizeof(To) == sizeof(From));
  To to;
  std::memcpy(&to, &from, sizeof(to));
  return to;
}

int64_t sign_extended(PlyScalar type, uint64_t bits) {
  switch (type) {
    case PlyScalar::i8: return static_cast<int8_t>(bits);
    case PlyScalar::i16: return static_cast<int16_t>(bits);
    case PlyScalar::i32: return static_cast<int32_t>(bits);
    default: return static_cast<int64_t>(bits);
  }
}

}  // namespace

bool PlyTextCursor::can_hold(const PlyElement& element) const {
  // A value takes two bytes at least, itself and what separates it from the next; the last one may lack the
  // latter.
  const uint64_t least = 2 * element.properties.size();
  return least == 0 || element.count <= (lines_.remaining() + 1) / least;
}

std::string PlyTextCursor::begin_element() {
  for (std::string_view line; lines_.next(line);) {
    words_ = Words(line);
    if (!Words(line).next().empty()) return "";
  }
  return "the file ends before it";
}

void PlyTextCursor::end_element() {
  // Some writers put values at the end of a line that their header does not speak of.
  if (words_.next().empty()) return;
  if (long_lines_++ == 0) first_long_line_ = lines_.number();
}

std::string PlyTextCursor::coordinate(PlyScalar, Coordinate& value) { return parse_coordinate(words_.next(), value); }

std::string PlyTextCursor::integer(PlyScalar, int64_t& value) {
  const std::string_view word = words_.next();
  if (word.empty()) return "its line ends too early";
  const std::optional<int64_t> parsed = parse_integer(word);
  if (!parsed) return in_quotes(word) + " is not an integer";
  value = *parsed;
  return "";
}

std::string PlyTextCursor::skip(PlyScalar, uint64_t count) {
  for (uint64_t i = 0; i < count; ++i) {
    if (words_.next().empty()) return "its line ends too early";
  }
  return "";
}

std::string PlyTextCursor::place(const std::string& element) const {
  return "line " + std::to_string(lines_.number()) + ": " + element;
}

void PlyTextCursor::add_notes(std::vector<std::string>& notes) {
  if (long_lines_ > 0) {
    notes.push_back(counted(long_lines_, "line") + " with more values than the header announces (the first is line " +
                    std::to_string(first_long_line_) + "); the surplus passed over");
  }
  if (begin_element().empty()) {
    notes.push_back("what follows the last element passed over (from line " + std::to_string(lines_.number()) + ")");
  }
}

bool PlyBinaryCursor::can_hold(const PlyElement& element) const {
  uint64_t least = 0;
  for (const PlyProperty& property : element.properties) {
    least += size_of(property.is_list ? property.count_type : property.type);
  }
  return least == 0 || element.count <= (bytes_.size() - offset_) / least;
}

std::string PlyBinaryCursor::begin_element() {
  element_offset_ = offset_;
  return "";
}

bool PlyBinaryCursor::load(PlyScalar type, uint64_t& bits) {
  const size_t size = size_of(type);
  if (bytes_.size() - offset_ < size) return false;
  bits = 0;
  for (size_t i = 0; i < size; ++i) {
    const size_t from = offset_ + (big_endian_ ? i : size - 1 - i);
    bits = bits << 8 | static_cast<unsigned char>(bytes_[from]);
  }
  offset_ += size;
  return true;
}

std::string PlyBinaryCursor::coordinate(PlyScalar type, Coordinate& value) {
  uint64_t bits;
  if (!load(type, bits)) return kFileEnds;
  if (type == PlyScalar::f32) {
    value = bit_copy<float>(static_cast<uint32_t>(bits));
  } else if (type == PlyScalar::f64) {
    value = bit_copy<double>(bits);
  } else {
    value = static_cast<double>(sign_extended(type, bits));
  }
  return std::isfinite(value.nearest) ? "" : "a coordinate is not finite as a 32-bit float";
}

std::string PlyBinaryCursor::integer(PlyScalar type, int64_t& value) {
  uint64_t bits;
  if (!load(type, bits)) return kFileEnds;
  value = sign_extended(type, bits);
  return "";
}

std::string PlyBinaryCursor::skip(PlyScalar type, uint64_t count) {
  if (count > (bytes_.size() - offset_) / size_of(type)) return kFileEnds;
  offset_ += count * size_of(type);
  return "";
}

std::string PlyBinaryCursor::place(const std::string& element) const {
  return element + " (byte " + std::to_string(element_offset_) + ")";
}

void PlyBinaryCursor::add_notes(std::vector<std::string>& notes) {
  if (offset_ == bytes_.size()) return;
  notes.push_back(counted(bytes_.size() - offset_, "byte") + " after the last element passed over");
}

}  // namespace vcd::baker
