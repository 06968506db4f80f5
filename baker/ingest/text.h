// Bytes, lines, words and numbers: what the readers of OBJ, PLY, STL and OFF share.
//
// The formats are read by code of this project. Of the packaged libraries that were tried (OpenMesh 9.0,
// tinyobjloader 2.0rc10, Assimp 5.2, CGAL 5.5), each makes a wrong mesh of some file of the format and
// reports no error, or refuses sound files; and none says where a file is broken. spec/results.md has the
// table.
#pragma once

#include <vcd/baker/mesh.h>
#include <vcd/format/error.h>

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace vcd::baker {

// The text without a UTF-8 byte order mark, if it has one.
std::string_view without_byte_order_mark(std::string_view text);

// True for UTF-16 and UTF-32, with or without byte order mark: a zero byte stands among the first four.
bool is_wide_text(std::string_view text);

// Walks over lines that end in LF, CR LF or CR; the last one may lack its end.
class LineReader {
 public:
  explicit LineReader(std::string_view text, size_t offset = 0, size_t line_number = 0)
      : text_(text), offset_(offset), number_(line_number) {}

  // False at the end of the text. The line comes without its end.
  bool next(std::string_view& line);

  size_t number() const { return number_; }                    // of the line last returned, counted from 1
  size_t remaining() const { return text_.size() - offset_; }  // bytes not yet returned

 private:
  std::string_view text_;
  size_t offset_;
  size_t number_;
};

// Walks over the words of a line: what stands between spaces, tabs and the rarer kinds of white space.
class Words {
 public:
  explicit Words(std::string_view line) : rest_(line) {}
  std::string_view next();  // empty at the end

 private:
  std::string_view rest_;
};

// The float nearest to a decimal number (correctly rounded; infinite where it is too large for a float),
// "inf" or "nan"; nothing if the word is anything else, even in its last character.
std::optional<float> parse_float(std::string_view word);

// A decimal integer with optional sign; nothing for anything else or beyond 64 bits.
std::optional<int64_t> parse_integer(std::string_view word);

// A coordinate as a file gives it, and the float nearest to that.
struct Coordinate {
  double value = 0;
  float nearest = 0;

  Coordinate() = default;
  Coordinate(double number) : value(number), nearest(static_cast<float>(number)) {}
};
using Coordinates = std::array<Coordinate, 3>;

// A decimal coordinate of a vertex: fills `value` and returns an empty string, or returns the reason why it cannot be.
std::string parse_coordinate(std::string_view word, Coordinate& value);

// The next three words as coordinates; returns an empty string or the reason.
std::string parse_position(Words& words, Coordinates& position);

// A word of the file for a message: in quotes, short, and harmless to a terminal.
std::string in_quotes(std::string_view word);

// "1 face", "2 faces".
std::string counted(uint64_t count, const std::string& noun, const std::string& plural = "");

}  // namespace vcd::baker
