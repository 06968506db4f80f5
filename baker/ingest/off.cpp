#include "ingest/off.h"

#include <algorithm>
#include <string>

#include "ingest/check.h"
#include "ingest/soup.h"
#include "ingest/text.h"

namespace vcd::baker {
namespace {

class OffReader {
 public:
  explicit OffReader(std::string_view text) : lines_(text) {}

  // Empty on success, or the reason with its line.
  std::string read(PolygonSoup& soup, ErrorCode& code) {
    std::string reason = header(code);
    if (reason.empty()) reason = vertices(soup);
    if (reason.empty()) reason = faces(soup);
    if (!reason.empty()) return "line " + std::to_string(std::max<size_t>(lines_.number(), 1)) + ": " + reason;
    if (next_line()) {
      soup.notes.push_back("what follows the last face was passed over (from line " + std::to_string(lines_.number()) +
                           ")");
    }
    return "";
  }

 private:
  // The next line that holds more than a comment, without its comment.
  bool next_line() {
    while (lines_.next(line_)) {
      line_ = line_.substr(0, line_.find('#'));
      if (!Words(line_).next().empty()) return true;
    }
    return false;
  }

  std::string header(ErrorCode& code) {
    next_line();
    const size_t keyword = line_.find("OFF");
    const std::string_view prefix = Words(line_.substr(0, keyword)).next();
    if (keyword == std::string_view::npos || prefix.find_first_not_of("STCN4n") != std::string_view::npos) {
      return "the keyword OFF is missing";
    }
    line_.remove_prefix(keyword + 3);
    const std::string_view after = Words(line_).next();
    if (after == "BINARY" || prefix.find_first_of("4n") != std::string_view::npos) {
      code = ErrorCode::unsupported;
      return after == "BINARY" ? "binary OFF" : "OFF in other than three dimensions";
    }
    // The counts mostly stand on the next line, but some writers let them follow the keyword, even without a
    // space.
    if (after.empty() && !next_line()) return "the counts of vertices and faces are missing";
    return counts();
  }

  std::string counts() {
    Words words(line_);
    for (uint64_t* count : {&vertex_count_, &face_count_}) {
      const std::string_view word = words.next();
      const std::optional<int64_t> value = parse_integer(word);
      if (!value || *value < 0) return in_quotes(word) + " is not a count of vertices or faces";
      *count = static_cast<uint64_t>(*value);
    }
    // "0 0 0\n" is the shortest vertex and "0\n" the shortest face; the last line may lack its end.
    if (vertex_count_ > lines_.remaining() / 6 + 1 || face_count_ > lines_.remaining() / 2 + 1) {
      return counted(vertex_count_, "vertex", "vertices") + " and " + counted(face_count_, "face") +
             " are more than the rest of the file can hold";
    }
    return "";
  }

  // The next word of an element, which may go on over several lines. Should one take words of the next
  // element so, because its own are too few, then the file ends too early for the last one: no such mistake
  // goes unnoticed.
  std::string_view next_word() {
    std::string_view word = words_.next();
    while (word.empty() && next_line()) {
      words_ = Words(line_);
      word = words_.next();
    }
    return word;
  }

  std::string vertices(PolygonSoup& soup) {
    // Normal, colour, texture coordinates: more numbers than these on a line are several vertices.
    constexpr size_t kMostExtras = 3 + 4 + 2;
    soup.positions.reserve(vertex_count_);
    for (uint64_t i = 0; i < vertex_count_; ++i) {
      words_ = Words({});
      Coordinates position;
      std::string reason;
      for (int axis = 0; axis < 3 && reason.empty(); ++axis) {
        const std::string_view word = next_word();
        reason = word.empty() ? file_ends(vertex_count_) : parse_coordinate(word, position[axis]);
      }
      size_t extras = 0;
      while (!words_.next().empty()) ++extras;
      if (reason.empty() && extras > kMostExtras) reason = "too many numbers on its line";
      if (!reason.empty()) return "vertex " + std::to_string(i) + ": " + reason;
      soup.add_position(position);
    }
    return "";
  }

  std::string faces(PolygonSoup& soup) {
    soup.face_ends.reserve(face_count_);
    for (uint64_t i = 0; i < face_count_; ++i) {
      words_ = Words({});  // what the line before still held was colour
      const std::string reason = face(soup);
      if (!reason.empty()) return "face " + std::to_string(i) + ": " + reason;
    }
    return "";
  }

  std::string face(PolygonSoup& soup) {
    const std::string_view count_word = next_word();
    if (count_word.empty()) return file_ends(face_count_);
    const std::optional<int64_t> corner_count = parse_integer(count_word);
    if (!corner_count || *corner_count < 0) return in_quotes(count_word) + " is not a count of corners";
    for (int64_t i = 0; i < *corner_count; ++i) {
      const std::string_view word = next_word();
      if (word.empty()) return file_ends(face_count_);
      const std::optional<int64_t> index = parse_integer(word);
      if (!index) return in_quotes(word) + " is not an index";
      if (*index < 0 || static_cast<uint64_t>(*index) >= vertex_count_) {
        return "index " + std::to_string(*index) + " is out of range (" + counted(vertex_count_, "vertex", "vertices") +
               ")";
      }
      soup.corners.push_back(static_cast<uint32_t>(*index));
    }
    soup.end_face();
    return "";
  }

  static std::string file_ends(uint64_t announced) {
    return "the file ends within it (" + std::to_string(announced) + " are announced)";
  }

  LineReader lines_;
  std::string_view line_;
  Words words_{std::string_view()};
  uint64_t vertex_count_ = 0;
  uint64_t face_count_ = 0;
};

}  // namespace

Result<Ingested> ingest_off(const std::filesystem::path& path, std::string_view bytes, const IngestOptions& options) {
  if (is_wide_text(bytes)) return file_error(path, ErrorCode::unsupported, "UTF-16 text or no text at all");
  PolygonSoup soup;
  soup.shift = options.shift;
  ErrorCode code = ErrorCode::invalid_file;
  const std::string reason = OffReader(without_byte_order_mark(bytes)).read(soup, code);
  if (!reason.empty()) return file_error(path, code, reason);
  return mesh_from_soup(path, std::move(soup), options);
}

}  // namespace vcd::baker
