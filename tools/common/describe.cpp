#include "describe.h"

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <numeric>

#include "readable.h"

namespace vcd::tools {

std::string hex(const std::array<uint8_t, 16>& hash) {
  std::string out;
  char digits[3];
  for (uint8_t byte : hash) {
    std::snprintf(digits, sizeof digits, "%02x", byte);
    out += digits;
  }
  return out;
}

std::string hex(uint64_t value) {
  char digits[17];
  std::snprintf(digits, sizeof digits, "%016llx", static_cast<unsigned long long>(value));
  return digits;
}

std::string printable(std::string_view name) {
  if (name.empty()) return "(no name)";
  std::string out = "\"";
  for (char c : name) {
    if (static_cast<unsigned char>(c) < 32 || c == 127) {
      char escaped[8];
      std::snprintf(escaped, sizeof escaped, "\\x%02x", static_cast<unsigned char>(c));
      out += escaped;
    } else {
      out += c;
    }
  }
  return out + "\"";
}

namespace {

double share(const ObjectRecord& r, int which) {
  const uint64_t counts[] = {r.cells[0], r.cells[1], r.cells[2], r.statistical_cells};
  return static_cast<double>(counts[which]) / static_cast<double>(tree_shape(r.depth).cells());
}

double bytes_a_triangle(const HierarchyView& hierarchy) {
  return static_cast<double>(hierarchy.bytes().size()) / static_cast<double>(hierarchy.header().triangle_count);
}

}  // namespace

const char* method_name(Method method) {
  switch (method) {
    case Method::none: return "none";
    case Method::sampled: return "sampled";
    case Method::proven: return "proven";
    case Method::hybrid: return "hybrid";
  }
  return "unknown";
}

const char* guarantee(Method method) {
  switch (method) {
    case Method::none: return "cells would not pay, every segment is unclassified";
    case Method::sampled: return "clear and blocked are statistics";
    case Method::proven: return "clear and blocked are proofs";
    case Method::hybrid: return "clear and blocked are proofs, statistically blocked is kept apart";
  }
  return "unknown";
}

Json describe_object(const ObjectContents& object) {
  const ObjectRecord& r = *object.record;
  Json json;
  json["name"] = object.name;
  json["source_index"] = r.source_index;
  json["depth"] = r.depth;
  json["method"] = method_name(static_cast<Method>(r.method));
  json["guarantee"] = guarantee(static_cast<Method>(r.method));
  json["samples"] = r.method_parameters[0];
  json["seed"] = r.method_parameters[1] | uint64_t{r.method_parameters[2]} << 32;
  json["box_min"] = r.box_min;
  json["box_max"] = r.box_max;
  json["shift"] = r.shift;
  json["parts_left_out"] = (r.flags & kPartsLeftOut) != 0;
  json["look_up_first"] = {{"from_outside", (r.flags & kLookUpFromOutside) != 0},
                           {"from_inside", (r.flags & kLookUpFromInside) != 0},
                           {"together_from_outside", (r.flags & kLookUpTogetherFromOutside) != 0},
                           {"together_from_inside", (r.flags & kLookUpTogetherFromInside) != 0},
                           {"one_from_outside", (r.flags & kLookUpOneFromOutside) != 0},
                           {"one_from_inside", (r.flags & kLookUpOneFromInside) != 0}};
  json["geometry_hash"] = hex(r.geometry_hash);
  json["triangle_count"] = r.triangle_count;
  json["vertex_count"] = r.vertex_count;
  json["cells"] = {{"clear", r.cells[0]},
                   {"blocked", r.cells[1]},
                   {"unclassified", r.cells[2]},
                   {"statistically_blocked", r.statistical_cells}};
  json["shares"] = {{"clear", share(r, 0)},
                    {"blocked", share(r, 1)},
                    {"unclassified", share(r, 2)},
                    {"statistically_blocked", share(r, 3)}};
  json["guard_band"] = r.guard_band;
  json["audit"] = nullptr;
  if (r.audit_lines[0] > 0)
    json["audit"] = {{"lines", r.audit_lines[0]},
                     {"wrong", r.audit_wrong[0]},
                     {"aimed_lines", r.audit_lines[1]},
                     {"aimed_wrong", r.audit_wrong[1]},
                     {"wrong_rate_bound_95", r.audit_bound_95}};
  json["blocks"] = {{"levels", r.block_counts}, {"bricks", r.brick_count}};
  json["nodes"] = {{"unfolded", r.nodes_unfolded}, {"folded", r.nodes_folded}, {"shared", r.nodes_shared}};
  json["hierarchy"] = nullptr;
  if (object.hierarchy) {
    const HierarchyHeader& h = object.hierarchy.header();
    json["hierarchy"] = {{"bytes", object.hierarchy.bytes().size()},
                         {"bytes_a_triangle", bytes_a_triangle(object.hierarchy)},
                         {"nodes", h.node_count},
                         {"leaves", h.leaf_count},
                         {"levels", h.levels}};
  }
  json["horizons"] = nullptr;
  if (object.horizon) {
    const HorizonHeader& h = object.horizon.header();
    json["horizons"] = {
        {"bytes", object.horizon.size()}, {"triangles", h.entries}, {"uniform", h.uniform}, {"cosine", h.cosine}};
  }
  json["embedded_geometry_bytes"] = object.geometry.size();
  return json;
}

Json describe_section(const SectionEntry& s) {
  Json json;
  json["type"] = section_type_name(s.type);
  json["critical"] = (s.flags & kSectionCritical) != 0;
  json["object"] = s.object == kNone ? Json(nullptr) : Json(s.object);
  json["storage"] = s.storage == static_cast<uint32_t>(Storage::raw) ? "raw" : "zstd";
  json["offset"] = s.offset;
  json["stored_size"] = s.stored_size;
  json["logical_size"] = s.logical_size;
  json["stored_xxh3"] = hex(s.stored_xxh3);
  json["logical_xxh3"] = hex(s.logical_xxh3);
  return json;
}

Json describe_finding(const Finding& finding) {
  const FindingInfo& info = finding_info(finding.id);
  return {{"id", info.id},
          {"severity", info.severity == Severity::error ? "error" : "warning"},
          {"message", info.message},
          {"detail", finding.detail},
          {"byte_offset", finding.offset},
          {"spec_section", info.spec_section}};
}

std::string object_summary(const ObjectRecord& r) {
  char line[512];
  std::string out;
  std::snprintf(line, sizeof line, "  mesh      %llu triangles, %llu vertices, geometry hash %s\n",
                static_cast<unsigned long long>(r.triangle_count), static_cast<unsigned long long>(r.vertex_count),
                hex(r.geometry_hash).c_str());
  out += line;
  std::snprintf(line, sizeof line, "  box       (%.9g, %.9g, %.9g) to (%.9g, %.9g, %.9g)\n", r.box_min[0], r.box_min[1],
                r.box_min[2], r.box_max[0], r.box_max[1], r.box_max[2]);
  out += line;
  if (std::any_of(std::begin(r.shift), std::end(r.shift), [](double x) { return x != 0; })) {
    std::snprintf(line, sizeof line,
                  "  shift     (%.17g, %.17g, %.17g) was subtracted from the mesh file's coordinates\n", r.shift[0],
                  r.shift[1], r.shift[2]);
    out += line;
  }
  if (r.flags & kPartsLeftOut)
    out += "  left out  parts of the mesh are not in this object: clear means clear of what is in it\n";
  const auto method = static_cast<Method>(r.method);
  if (method == Method::none) return out + "  method    none: " + guarantee(method) + "\n";
  std::snprintf(line, sizeof line, "  method    %s, depth %u: %s\n", method_name(method), r.depth, guarantee(method));
  out += line;
  if (r.method_parameters[0] > 0) {
    std::snprintf(line, sizeof line, "  samples   %u rays a cell%s\n", r.method_parameters[0],
                  method == Method::hybrid ? " of the statistical tier" : "");
    out += line;
  }
  if (r.guard_band > 0) {
    std::snprintf(line, sizeof line, "  guard     proofs hold for lines within %.3g of the grid's 256 units\n",
                  static_cast<double>(r.guard_band));
    out += line;
  }
  std::snprintf(line, sizeof line, "  lines     %.1f %% clear, %.1f %% blocked, ", 100 * share(r, 0),
                100 * share(r, 1));
  out += line;
  if (method == Method::hybrid) {
    std::snprintf(line, sizeof line, "%.1f %% statistically blocked, ", 100 * share(r, 3));
    out += line;
  }
  std::snprintf(line, sizeof line, "%.1f %% unclassified\n", 100 * share(r, 2));
  out += line;
  if (r.audit_lines[0] > 0) {
    std::snprintf(line, sizeof line,
                  "  audit     %llu of %llu lines wrong (95 %% bound %.2g), %llu of %llu aimed at the mesh\n",
                  static_cast<unsigned long long>(r.audit_wrong[0]), static_cast<unsigned long long>(r.audit_lines[0]),
                  static_cast<double>(r.audit_bound_95), static_cast<unsigned long long>(r.audit_wrong[1]),
                  static_cast<unsigned long long>(r.audit_lines[1]));
    out += line;
  } else {
    out += "  audit     none\n";
  }
  std::snprintf(line, sizeof line,
                "  octree    %s unfolded, %s folded, %s shared (32-bit nodes, as the paper counts)\n",
                readable_bytes(4 * r.nodes_unfolded).c_str(), readable_bytes(4 * r.nodes_folded).c_str(),
                readable_bytes(4 * r.nodes_shared).c_str());
  out += line;
  const uint64_t bytes = tree_shape(r.depth).bytes(r.block_counts, r.brick_count);
  const uint64_t blocks = std::accumulate(r.block_counts.begin(), r.block_counts.end(), uint64_t{0});
  return out + "  tree      " + readable_bytes(bytes) + ": " +
         (blocks > 0 ? std::to_string(blocks) + " blocks and " : "") + std::to_string(r.brick_count) + " bricks\n";
}

std::string hierarchy_summary(const ObjectRecord& r, const HierarchyView& hierarchy) {
  if (!hierarchy) return "";
  const HierarchyHeader& h = hierarchy.header();
  char line[256];
  std::snprintf(line, sizeof line, "  hierarchy %s, %.1f bytes a triangle: %u nodes, %u leaves, %u levels\n",
                readable_bytes(hierarchy.bytes().size()).c_str(), bytes_a_triangle(hierarchy), h.node_count,
                h.leaf_count, h.levels);
  const auto first = [&](uint16_t from_outside, uint16_t from_inside) {
    const bool outside = (r.flags & from_outside) != 0, inside = (r.flags & from_inside) != 0;
    return outside && inside ? "from outside the box, and from inside"
           : outside         ? "from outside the box"
           : inside          ? "from inside the box"
                             : "nowhere";
  };
  return line + std::string("            look-ups before it save time for single segments ") +
         first(kLookUpOneFromOutside, kLookUpOneFromInside) + ", for arrays " +
         first(kLookUpFromOutside, kLookUpFromInside) + ", for bundles " +
         first(kLookUpTogetherFromOutside, kLookUpTogetherFromInside) + "\n";
}

std::string horizon_summary(const HorizonView& horizon) {
  if (!horizon) return "";
  const HorizonHeader& h = horizon.header();
  char line[256];
  std::snprintf(line, sizeof line,
                "  horizons  %s: answer %.0f %% of the directions above a triangle, %.0f %% by their cosine\n",
                readable_bytes(horizon.size()).c_str(), 100 * double{h.uniform}, 100 * double{h.cosine});
  return line;
}

std::string json_text(const Json& json, int indent) {
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

void print_json(const Json& json) { std::printf("%s\n", json_text(json, 2).c_str()); }

}  // namespace vcd::tools
