#include "ingest/ply_header.h"

#include <algorithm>
#include <optional>

#include "ingest/text.h"

namespace vcd::baker {
namespace {

struct TypeName {
  std::string_view name;
  PlyScalar type;
};

constexpr TypeName kTypeNames[] = {
    {"char", PlyScalar::i8},   {"int8", PlyScalar::i8},     {"uchar", PlyScalar::u8},   {"uint8", PlyScalar::u8},
    {"short", PlyScalar::i16}, {"int16", PlyScalar::i16},   {"ushort", PlyScalar::u16}, {"uint16", PlyScalar::u16},
    {"int", PlyScalar::i32},   {"int32", PlyScalar::i32},   {"uint", PlyScalar::u32},   {"uint32", PlyScalar::u32},
    {"float", PlyScalar::f32}, {"float32", PlyScalar::f32}, {"double", PlyScalar::f64}, {"float64", PlyScalar::f64},
};

std::string parse_type(std::string_view word, PlyScalar& type) {
  for (const TypeName& known : kTypeNames) {
    if (known.name == word) {
      type = known.type;
      return "";
    }
  }
  return in_quotes(word) + " is not a type";
}

// Lines end in LF, CR LF or CR, in any mixture. One case is ambiguous: binary data that follow "end_header\r" may
// themselves begin with '\n'. There the line before tells: if a bare CR ended it, so does one end this line.
class HeaderLines {
 public:
  explicit HeaderLines(std::string_view bytes) : bytes_(bytes) {}

  bool next(std::string_view& line) {
    const size_t end = bytes_.find_first_of("\r\n", offset_);
    if (end == std::string_view::npos) return false;
    line = bytes_.substr(offset_, end - offset_);
    const bool pair = bytes_.substr(end, 2) == "\r\n" && !bare_;
    bare_ = bytes_[end] == '\r' && !pair;
    offset_ = end + (pair ? 2 : 1);
    ++number_;
    return true;
  }

  size_t offset() const { return offset_; }
  size_t number() const { return number_; }

 private:
  std::string_view bytes_;
  bool bare_ = false;  // the last line ended in CR alone
  size_t offset_ = 0;
  size_t number_ = 0;
};

std::string parse_format(Words& words, PlyHeader& header) {
  const std::string_view name = words.next();
  if (name == "ascii") {
    header.encoding = PlyHeader::Encoding::ascii;
  } else if (name == "binary_little_endian") {
    header.encoding = PlyHeader::Encoding::little_endian;
  } else if (name == "binary_big_endian") {
    header.encoding = PlyHeader::Encoding::big_endian;
  } else {
    return in_quotes(name) + " is not a PLY format";
  }
  const std::string_view version = words.next();
  return version == "1.0" ? "" : "version " + in_quotes(version) + " of PLY is not known";
}

std::string parse_element(Words& words, PlyHeader& header) {
  PlyElement element;
  element.name = words.next();
  const std::string_view word = words.next();
  const std::optional<int64_t> count = parse_integer(word);
  if (!count || *count < 0) return in_quotes(word) + " is not a count of elements";
  element.count = static_cast<uint64_t>(*count);
  if (std::any_of(header.elements.begin(), header.elements.end(),
                  [&](const PlyElement& other) { return other.name == element.name; })) {
    return "element " + in_quotes(element.name) + " is there already";
  }
  header.elements.push_back(std::move(element));
  return "";
}

std::string parse_property(Words& words, PlyHeader& header) {
  if (header.elements.empty()) return "a property before any element";
  PlyProperty property;
  std::string_view word = words.next();
  property.is_list = word == "list";
  if (property.is_list) {
    word = words.next();
    std::string reason = parse_type(word, property.count_type);
    if (reason.empty() && is_float(property.count_type)) reason = "a list cannot be counted in " + in_quotes(word);
    if (!reason.empty()) return reason;
    word = words.next();
  }
  std::string reason = parse_type(word, property.type);
  if (!reason.empty()) return reason;
  property.name = words.next();
  if (property.name.empty()) return "a property without a name";
  header.elements.back().properties.push_back(std::move(property));
  return "";
}

std::string parse_line(std::string_view line, PlyHeader& header, bool& has_format, bool& at_end) {
  Words words(line);
  const std::string_view keyword = words.next();
  std::string reason;
  if (keyword.empty() || keyword == "comment" || keyword == "obj_info") return "";
  if (keyword == "format") {
    if (has_format) return "a second format";
    has_format = true;
    reason = parse_format(words, header);
  } else if (keyword == "element") {
    reason = parse_element(words, header);
  } else if (keyword == "property") {
    reason = parse_property(words, header);
  } else if (keyword == "end_header") {
    at_end = true;
  } else {
    return in_quotes(keyword) + " is no statement of a PLY header";
  }
  const std::string_view surplus = words.next();
  return reason.empty() && !surplus.empty() ? in_quotes(surplus) + " is too much" : reason;
}

}  // namespace

size_t size_of(PlyScalar type) {
  switch (type) {
    case PlyScalar::i8:
    case PlyScalar::u8: return 1;
    case PlyScalar::i16:
    case PlyScalar::u16: return 2;
    case PlyScalar::i32:
    case PlyScalar::u32:
    case PlyScalar::f32: return 4;
    case PlyScalar::f64: break;
  }
  return 8;
}

bool is_float(PlyScalar type) { return type == PlyScalar::f32 || type == PlyScalar::f64; }

std::string parse_ply_header(std::string_view bytes, PlyHeader& header) {
  HeaderLines lines(bytes);
  std::string_view line;
  if (!lines.next(line) || Words(line).next() != "ply") return "does not begin with \"ply\"";
  bool has_format = false;
  bool at_end = false;
  while (!at_end) {
    if (!lines.next(line)) return "the header has no \"end_header\"";
    const std::string reason = parse_line(line, header, has_format, at_end);
    if (!reason.empty()) return "line " + std::to_string(lines.number()) + ": " + reason;
  }
  if (!has_format) return "the header names no format";
  header.body_offset = lines.offset();
  header.line_count = lines.number();
  return "";
}

}  // namespace vcd::baker
