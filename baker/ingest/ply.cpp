#include "ingest/ply.h"

#include <limits>
#include <string>
#include <vector>

#include "ingest/check.h"
#include "ingest/ply_cursor.h"
#include "ingest/ply_header.h"
#include "ingest/soup.h"
#include "ingest/text.h"

namespace vcd::baker {
namespace {

// What a property is good for.
enum class Role { x, y, z, indices, none };

Role role_of(const PlyElement& element, const PlyProperty& property) {
  if (element.name == "vertex") {
    if (property.name == "x") return Role::x;
    if (property.name == "y") return Role::y;
    if (property.name == "z") return Role::z;
  }
  if (element.name == "face" || element.name == "tristrips") {
    if (property.name == "vertex_indices" || property.name == "vertex_index") return Role::indices;
  }
  return Role::none;
}

// The properties' roles in the element's order; or a reason why it cannot be read.
std::string assign_roles(const PlyElement& element, std::vector<Role>& roles) {
  size_t found[4] = {0, 0, 0, 0};
  for (const PlyProperty& property : element.properties) {
    const Role role = role_of(element, property);
    roles.push_back(role);
    if (role == Role::none) continue;
    if (property.is_list != (role == Role::indices))
      return "property " + in_quotes(property.name) + " is of the wrong kind";
    if (role == Role::indices && is_float(property.type)) return "its indices are not integers";
    if (++found[static_cast<size_t>(role)] > 1) return "property " + in_quotes(property.name) + " is there twice";
  }
  if (element.count == 0) return "";
  if (element.name == "vertex" && (found[0] == 0 || found[1] == 0 || found[2] == 0)) return "x, y or z is missing";
  if ((element.name == "face" || element.name == "tristrips") && found[3] == 0) return "has no list vertex_indices";
  return "";
}

template <class Cursor>
class PlyBody {
 public:
  PlyBody(std::string_view bytes, const PlyHeader& header, PolygonSoup& soup)
      : header_(header), cursor_(bytes, header), soup_(soup) {}

  // Empty on success, or the reason with its place.
  std::string read() {
    bool has_vertices = false;
    for (const PlyElement& element : header_.elements) {
      if (element.name != "vertex") continue;
      has_vertices = true;
      vertex_count_ = element.count;
    }
    if (!has_vertices) return "has no element \"vertex\"";
    for (const PlyElement& element : header_.elements) {
      std::string reason = elements(element);
      if (!reason.empty()) return reason;
    }
    cursor_.add_notes(soup_.notes);
    return "";
  }

 private:
  // All elements of one kind.
  std::string elements(const PlyElement& element) {
    std::vector<Role> roles;
    const std::string fault = assign_roles(element, roles);
    if (!fault.empty()) return "element " + in_quotes(element.name) + ": " + fault;
    if (!cursor_.can_hold(element)) {
      return "element " + in_quotes(element.name) + ": " + std::to_string(element.count) +
             " of them are more than the rest of the file can hold";
    }
    if (element.properties.empty()) return "";  // nothing stands in the file for them, however many they are
    if (element.name == "vertex") soup_.positions.reserve(element.count);
    for (uint64_t i = 0; i < element.count; ++i) {
      std::string reason = cursor_.begin_element();
      if (reason.empty()) reason = one(element, roles);
      if (!reason.empty()) return cursor_.place(element.name + " " + std::to_string(i)) + ": " + reason;
      cursor_.end_element();
    }
    return "";
  }

  std::string one(const PlyElement& element, const std::vector<Role>& roles) {
    Coordinates position;
    for (size_t i = 0; i < roles.size(); ++i) {
      const PlyProperty& property = element.properties[i];
      std::string reason;
      if (roles[i] == Role::indices) {
        reason = element.name == "face" ? face(property) : strips(property);
      } else if (roles[i] != Role::none) {
        reason = cursor_.coordinate(property.type, position[static_cast<size_t>(roles[i])]);
      } else {
        reason = skip(property);
      }
      if (!reason.empty()) return reason;
    }
    if (element.name == "vertex") soup_.add_position(position);
    return "";
  }

  std::string skip(const PlyProperty& property) {
    int64_t count = 1;
    const std::string reason = property.is_list ? list_count(property, count) : "";
    return reason.empty() ? cursor_.skip(property.type, static_cast<uint64_t>(count)) : reason;
  }

  std::string list_count(const PlyProperty& property, int64_t& count) {
    const std::string reason = cursor_.integer(property.count_type, count);
    return reason.empty() && count < 0 ? "a list of " + std::to_string(count) + " items" : reason;
  }

  std::string out_of_range(int64_t index) const {
    return "index " + std::to_string(index) + " is out of range (" + counted(vertex_count_, "vertex", "vertices") + ")";
  }
  bool in_range(int64_t index) const { return index >= 0 && static_cast<uint64_t>(index) < vertex_count_; }

  std::string face(const PlyProperty& property) {
    int64_t count = 0;
    std::string reason = list_count(property, count);
    for (int64_t i = 0; i < count && reason.empty(); ++i) {
      int64_t index = 0;
      reason = cursor_.integer(property.type, index);
      if (reason.empty() && !in_range(index)) reason = out_of_range(index);
      if (reason.empty()) soup_.corners.push_back(static_cast<uint32_t>(index));
    }
    if (reason.empty()) soup_.end_face();
    return reason;
  }

  std::string strips(const PlyProperty& property) {
    int64_t count = 0;
    std::string reason = list_count(property, count);
    uint32_t before_last = 0;
    uint32_t last = 0;
    uint64_t length = 0;  // of the strip so far
    for (int64_t i = 0; i < count && reason.empty(); ++i) {
      int64_t index = 0;
      reason = cursor_.integer(property.type, index);
      if (!reason.empty()) break;
      const bool restart =
          index == -1 || (property.type == PlyScalar::u32 && index == std::numeric_limits<uint32_t>::max());
      if (restart) {
        length = 0;
        continue;
      }
      if (!in_range(index)) return out_of_range(index);
      const uint32_t corner = static_cast<uint32_t>(index);
      if (length >= 2) strip_triangle(before_last, last, corner, length % 2 == 1);
      before_last = last;
      last = corner;
      ++length;
    }
    return reason;
  }

  void strip_triangle(uint32_t a, uint32_t b, uint32_t c, bool turned) {
    soup_.corners.insert(soup_.corners.end(), {turned ? b : a, turned ? a : b, c});
    soup_.end_face();
  }

  const PlyHeader& header_;
  Cursor cursor_;
  PolygonSoup& soup_;
  uint64_t vertex_count_ = 0;
};

}  // namespace

Result<Ingested> ingest_ply(const std::filesystem::path& path, std::string_view file, const IngestOptions& options) {
  const std::string_view bytes = without_byte_order_mark(file);
  PlyHeader header;
  PolygonSoup soup;
  soup.shift = options.shift;
  std::string reason = parse_ply_header(bytes, header);
  if (reason.empty()) {
    reason = header.encoding == PlyHeader::Encoding::ascii ? PlyBody<PlyTextCursor>(bytes, header, soup).read()
                                                           : PlyBody<PlyBinaryCursor>(bytes, header, soup).read();
  }
  if (!reason.empty()) return file_error(path, ErrorCode::invalid_file, reason);
  return mesh_from_soup(path, std::move(soup), options);
}

}  // namespace vcd::baker
