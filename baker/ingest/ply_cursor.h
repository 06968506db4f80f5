// The body of a PLY file, value by value, with the same face for text and binary. Every function that can
// fail returns an empty string or the reason.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "ingest/ply_header.h"
#include "ingest/text.h"

namespace vcd::baker {

class PlyTextCursor {
 public:
  PlyTextCursor(std::string_view bytes, const PlyHeader& header)
      : lines_(bytes, header.body_offset, header.line_count) {}

  // Can as many elements as the header claims still come? Ask before allocating for them.
  bool can_hold(const PlyElement& element) const;

  // Around each element of the file.
  std::string begin_element();
  void end_element();

  std::string coordinate(PlyScalar type, Coordinate& value);
  std::string integer(PlyScalar type, int64_t& value);
  std::string skip(PlyScalar type, uint64_t count);

  // Where the element at hand stands: "line 12: face 3".
  std::string place(const std::string& element) const;
  // After the last element: one sentence for each kind of surplus that was passed over.
  void add_notes(std::vector<std::string>& notes);

 private:
  LineReader lines_;
  Words words_{std::string_view()};
  size_t long_lines_ = 0;  // that hold more values than the header announces
  size_t first_long_line_ = 0;
};

class PlyBinaryCursor {
 public:
  PlyBinaryCursor(std::string_view bytes, const PlyHeader& header)
      : bytes_(bytes), offset_(header.body_offset), big_endian_(header.encoding == PlyHeader::Encoding::big_endian) {}

  bool can_hold(const PlyElement& element) const;
  std::string begin_element();
  void end_element() {}
  std::string coordinate(PlyScalar type, Coordinate& value);
  std::string integer(PlyScalar type, int64_t& value);
  std::string skip(PlyScalar type, uint64_t count);
  std::string place(const std::string& element) const;  // "face 3 (byte 1234)"
  void add_notes(std::vector<std::string>& notes);

 private:
  bool load(PlyScalar type, uint64_t& bits);  // false at the end of the file

  std::string_view bytes_;
  size_t offset_;
  size_t element_offset_ = 0;
  bool big_endian_;
};

}  // namespace vcd::baker
