// The text header of a PLY file: which elements follow, how many of each, made of what.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace vcd::baker {

enum class PlyScalar { i8, u8, i16, u16, i32, u32, f32, f64 };

// In bytes, as binary files store it.
size_t size_of(PlyScalar type);
bool is_float(PlyScalar type);

struct PlyProperty {
  std::string name;
  PlyScalar type = PlyScalar::f32;  // of the value, or of each item of a list
  bool is_list = false;
  PlyScalar count_type = PlyScalar::u8;  // of a list's count; an integer
};

struct PlyElement {
  std::string name;
  uint64_t count = 0;
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  enum class Encoding { ascii, little_endian, big_endian };
  Encoding encoding = Encoding::ascii;
  std::vector<PlyElement> elements;
  size_t body_offset = 0;  // of the first byte after the header
  size_t line_count = 0;   // of the header
};

// Reads the header of a PLY file. Returns an empty string, or what is wrong and in which line. Counts are
// what the file claims: whoever allocates compares them with the bytes that remain.
std::string parse_ply_header(std::string_view bytes, PlyHeader& header);

}  // namespace vcd::baker
