#include "ingest/obj.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <string>

#include "ingest/check.h"
#include "ingest/soup.h"
#include "ingest/text.h"

namespace vcd::baker {
namespace {

// Statements without a shape of their own; no reason to speak of them.
constexpr std::string_view kSilent[] = {"vt",     "vn",  "g",      "o",      "s",     "mg",       "usemtl",
                                        "mtllib", "lod", "maplib", "usemap", "bevel", "c_interp", "d_interp"};

// Statements of numbers, which a '\' at the end of a line continues on the next. Elsewhere it belongs to a name
// ("mtllib C:\models\") or to a remark, and joining the next line would swallow a vertex or a face.
constexpr std::string_view kContinued[] = {"v",     "vt",   "vn",   "vp",   "p",    "l",    "f",  "fo",  "curv",
                                           "curv2", "surf", "parm", "trim", "hole", "scrv", "sp", "bmat"};

bool goes_on(std::string_view line) { return line.ends_with('\\') && line.find('#') == std::string_view::npos; }

bool may_go_on(std::string_view line) {
  return std::find(std::begin(kContinued), std::end(kContinued), Words(line).next()) != std::end(kContinued);
}

// Counts statements that are passed over, for one note each kind.
struct Skipped {
  size_t count = 0;
  size_t first_line = 0;
  std::string first_keyword;

  void add(std::string_view keyword, size_t line) {
    if (count++ > 0) return;
    first_line = line;
    first_keyword = in_quotes(keyword);
  }
  void note(const std::string& what, const std::string& plural, std::vector<std::string>& notes) const {
    if (count == 0) return;
    notes.push_back(counted(count, what, plural) + " passed over (the first is " + first_keyword + " in line " +
                    std::to_string(first_line) + ")");
  }
};

class ObjReader {
 public:
  explicit ObjReader(std::string_view text) : lines_(text) {}

  // Empty on success, or the reason with its line.
  std::string read(PolygonSoup& soup) {
    std::string joined;
    for (std::string_view line; next_statement(line, joined);) {
      const std::string reason = statement(line, soup);
      if (!reason.empty()) return in_line(first_line_, reason);
    }
    for (const Forward& forward : forward_) {
      const uint32_t index = soup.corners[forward.corner];
      if (index >= soup.positions.size()) {
        return in_line(forward.line, out_of_range(int64_t{index} + 1, soup.positions.size()));
      }
    }
    points_.note("point statement", "", soup.notes);
    lines_of_mesh_.note("line statement", "", soup.notes);
    unknown_.note("statement that is neither vertex nor face", "statements that are neither vertex nor face",
                  soup.notes);
    return "";
  }

 private:
  // A face may name a vertex that comes after it. Such corners are looked at again at the end.
  struct Forward {
    size_t corner;
    size_t line;
  };

  static std::string in_line(size_t line, const std::string& reason) {
    return "line " + std::to_string(line) + ": " + reason;
  }
  static std::string out_of_range(int64_t index, size_t vertex_count) {
    return "vertex index " + std::to_string(index) + " is out of range (" +
           counted(vertex_count, "vertex", "vertices") + ")";
  }

  // One line, or several that are joined by '\'; `joined` holds the text of the latter.
  bool next_statement(std::string_view& line, std::string& joined) {
    if (!lines_.next(line)) return false;
    first_line_ = lines_.number();
    if (!goes_on(line) || !may_go_on(line)) return true;
    joined.clear();
    while (goes_on(line)) {
      joined.append(line.substr(0, line.size() - 1)).append(" ");
      if (!lines_.next(line)) line = {};
    }
    joined.append(line);
    line = joined;
    return true;
  }

  std::string statement(std::string_view line, PolygonSoup& soup) {
    Words words(line.substr(0, line.find('#')));
    const std::string_view keyword = words.next();
    if (keyword.empty()) return "";
    if (keyword == "v") return vertex(words, soup);
    if (keyword == "f" || keyword == "fo") return face(words, soup);
    if (keyword == "p") {
      points_.add(keyword, first_line_);
    } else if (keyword == "l") {
      lines_of_mesh_.add(keyword, first_line_);
    } else if (std::find(std::begin(kSilent), std::end(kSilent), keyword) == std::end(kSilent)) {
      unknown_.add(keyword, first_line_);
    }
    return "";
  }

  std::string vertex(Words& words, PolygonSoup& soup) {
    Coordinates position;
    std::string reason = parse_position(words, position);
    // Weight and colour are of no use here, but what is not even a number betrays a line that lost its end.
    for (std::string_view word; reason.empty() && !(word = words.next()).empty();) {
      if (!parse_float(word)) reason = in_quotes(word) + " is not a number";
    }
    if (!reason.empty()) return "vertex " + std::to_string(soup.positions.size() + 1) + ": " + reason;
    soup.add_position(position);
    return "";
  }

  std::string face(Words& words, PolygonSoup& soup) {
    for (std::string_view word; !(word = words.next()).empty();) {
      const std::string reason = corner(word, soup);
      if (!reason.empty()) return "face " + std::to_string(soup.face_ends.size() + 1) + ": " + reason;
    }
    soup.end_face();
    return "";
  }

  std::string corner(std::string_view word, PolygonSoup& soup) {
    const size_t slash = word.find('/');
    const std::optional<int64_t> index = parse_integer(word.substr(0, slash));
    const bool clean_rest =
        word.substr(std::min(slash, word.size())).find_first_not_of("/-+0123456789") == std::string_view::npos;
    if (!index || !clean_rest) return in_quotes(word) + " is not a corner of a face";
    const int64_t vertex_count = static_cast<int64_t>(soup.positions.size());
    const int64_t from_zero = *index > 0 ? *index - 1 : *index + vertex_count;
    if (*index == 0) return "vertex index 0 (indices begin with 1)";
    if (from_zero < 0 || from_zero >= std::numeric_limits<uint32_t>::max()) {
      return out_of_range(*index, soup.positions.size());
    }
    if (from_zero >= vertex_count) forward_.push_back({soup.corners.size(), first_line_});
    soup.corners.push_back(static_cast<uint32_t>(from_zero));
    return "";
  }

  LineReader lines_;
  size_t first_line_ = 0;  // of the statement at hand
  std::vector<Forward> forward_;
  Skipped points_, lines_of_mesh_, unknown_;
};

}  // namespace

Result<Ingested> ingest_obj(const std::filesystem::path& path, std::string_view bytes, const IngestOptions& options) {
  if (is_wide_text(bytes)) return file_error(path, ErrorCode::unsupported, "UTF-16 text or no text at all");
  PolygonSoup soup;
  soup.shift = options.shift;
  const std::string reason = ObjReader(without_byte_order_mark(bytes)).read(soup);
  if (!reason.empty()) return file_error(path, ErrorCode::invalid_file, reason);
  return mesh_from_soup(path, std::move(soup), options);
}

}  // namespace vcd::baker
