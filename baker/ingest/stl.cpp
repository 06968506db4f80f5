#include "ingest/stl.h"

#include <cmath>
#include <cstring>
#include <string>

#include "ingest/check.h"
#include "ingest/soup.h"
#include "ingest/text.h"

namespace vcd::baker {
namespace {

// Binary layout, little-endian: 80 bytes of header, the count of facets, then for each facet 12 floats
// (normal, three corners) and 2 bytes of attributes.
constexpr size_t kHeaderSize = 80;
constexpr size_t kFacetsBegin = 84;
constexpr size_t kFacetSize = 50;
constexpr size_t kNormalSize = 12;

uint32_t load_u32(const char* bytes) {
  uint32_t value = 0;
  for (int i = 3; i >= 0; --i) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

float load_f32(const char* bytes) {
  const uint32_t bits = load_u32(bytes);
  float value;
  std::memcpy(&value, &bits, sizeof(value));
  return value;
}

void append_corner(const Coordinates& position, PolygonSoup& soup) {
  soup.corners.push_back(static_cast<uint32_t>(soup.positions.size()));
  soup.add_position(position);
}

std::string read_binary(std::string_view bytes, PolygonSoup& soup) {
  if (bytes.size() < kFacetsBegin) return "too short for an STL file (" + counted(bytes.size(), "byte") + ")";
  const uint64_t count = load_u32(bytes.data() + kHeaderSize);
  const uint64_t room = bytes.size() - kFacetsBegin;
  // A few bytes of padding do no harm, but a whole facet that the count does not know of means that the count
  // lies.
  if (count * kFacetSize > room || count * kFacetSize + kFacetSize <= room) {
    return "byte 80 announces " + counted(count, "facet") + " (" + std::to_string(count * kFacetSize) +
           " bytes), but " + counted(room, "byte") + " follow";
  }
  soup.positions.reserve(count * 3);
  soup.corners.reserve(count * 3);
  soup.face_ends.reserve(count);
  for (uint64_t facet = 0; facet < count; ++facet) {
    const size_t offset = kFacetsBegin + facet * kFacetSize;
    for (size_t corner = 0; corner < 3; ++corner) {
      const char* from = bytes.data() + offset + kNormalSize + corner * 12;
      const Position p = {load_f32(from), load_f32(from + 4), load_f32(from + 8)};
      if (!std::isfinite(p[0]) || !std::isfinite(p[1]) || !std::isfinite(p[2])) {
        return "facet " + std::to_string(facet) + " (byte " + std::to_string(offset) + "): corner " +
               std::to_string(corner) + " is not finite";
      }
      append_corner({p[0], p[1], p[2]}, soup);
    }
    soup.end_face();
  }
  if (count * kFacetSize < room) {
    soup.notes.push_back(counted(room - count * kFacetSize, "byte") + " after the last facet passed over");
  }
  return "";
}

// Keywords come in lower and upper case.
bool equal_ignoring_case(std::string_view word, std::string_view keyword) {
  if (word.size() != keyword.size()) return false;
  for (size_t i = 0; i < word.size(); ++i) {
    if ((word[i] | 0x20) != keyword[i]) return false;
  }
  return true;
}

// Words across lines; a statement may stand on one line or on several.
class TextStl {
 public:
  explicit TextStl(std::string_view text) : lines_(text) {}

  std::string read(PolygonSoup& soup) {
    std::string reason = solids(soup);
    return reason.empty() ? reason : "line " + std::to_string(lines_.number()) + ": " + reason;
  }

 private:
  std::string solids(PolygonSoup& soup) {
    for (std::string_view word; !(word = next()).empty();) {
      if (!equal_ignoring_case(word, "solid")) return in_quotes(word) + " instead of \"solid\"";
      skip_line();  // the name
      for (;;) {
        word = next();
        if (equal_ignoring_case(word, "endsolid")) break;
        if (!equal_ignoring_case(word, "facet")) return instead_of("facet\" or \"endsolid", word);
        const std::string reason = facet(soup);
        if (!reason.empty()) return "facet " + std::to_string(soup.face_ends.size()) + ": " + reason;
      }
      skip_line();
    }
    return "";
  }

  // After the word "facet".
  std::string facet(PolygonSoup& soup) {
    std::string reason = expect({"normal"});
    // The normal is not looked at: "-nan(ind)" and the like are common in it and do no harm.
    for (int i = 0; i < 3; ++i) next();
    if (reason.empty()) reason = expect({"outer", "loop"});
    for (int corner = 0; corner < 3 && reason.empty(); ++corner) {
      reason = expect({"vertex"});
      Coordinates position;
      for (int axis = 0; axis < 3 && reason.empty(); ++axis) reason = parse_coordinate(next(), position[axis]);
      if (reason.empty()) append_corner(position, soup);
    }
    if (reason.empty()) reason = expect({"endloop", "endfacet"});
    if (reason.empty()) soup.end_face();
    return reason;
  }

  std::string expect(std::initializer_list<std::string_view> keywords) {
    for (const std::string_view keyword : keywords) {
      const std::string_view word = next();
      if (!equal_ignoring_case(word, keyword)) return instead_of(keyword, word);
    }
    return "";
  }

  static std::string instead_of(std::string_view keyword, std::string_view word) {
    if (word.empty()) return "the file ends where \"" + std::string(keyword) + "\" should stand";
    return in_quotes(word) + " instead of \"" + std::string(keyword) + "\"";
  }

  std::string_view next() {
    for (;;) {
      const std::string_view word = words_.next();
      std::string_view line;
      if (!word.empty() || !lines_.next(line)) return word;
      words_ = Words(line);
    }
  }
  void skip_line() { words_ = Words({}); }

  LineReader lines_;
  Words words_{std::string_view()};
};

bool looks_like_text(std::string_view bytes) {
  constexpr size_t kProbe = 1024;
  return equal_ignoring_case(Words(bytes.substr(0, kProbe)).next(), "solid") &&
         bytes.substr(0, kProbe).find('\0') == std::string_view::npos;
}

}  // namespace

bool size_fits_binary_stl(std::string_view bytes) {
  return bytes.size() >= kFacetsBegin &&
         kFacetsBegin + kFacetSize * uint64_t{load_u32(bytes.data() + kHeaderSize)} == bytes.size();
}

Result<Ingested> ingest_stl(const std::filesystem::path& path, std::string_view bytes, const IngestOptions& options) {
  const std::string_view text = without_byte_order_mark(bytes);
  PolygonSoup soup;
  soup.shift = options.shift;
  std::string reason;
  if (!size_fits_binary_stl(bytes) && looks_like_text(text)) {
    reason = TextStl(text).read(soup);
  } else if (!size_fits_binary_stl(bytes) && (bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF"))) {
    return file_error(path, ErrorCode::unsupported, "UTF-16 text");
  } else {
    reason = read_binary(bytes, soup);
  }
  if (!reason.empty()) return file_error(path, ErrorCode::invalid_file, reason);
  return mesh_from_soup(path, std::move(soup), options);
}

}  // namespace vcd::baker
