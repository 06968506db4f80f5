// The object records, their names, and which sections belong to which object.
#include <cmath>

#include <vcd/format/utf8.h>

#include "reading.h"

namespace vcd {
namespace {

Method method_of(const ObjectRecord& r) { return static_cast<Method>(r.method); }

bool box_is_usable(const ObjectRecord& r) {
  for (int a = 0; a < 3; ++a) {
    const float extent = r.box_max[a] - r.box_min[a];
    if (!std::isfinite(r.box_min[a]) || !std::isfinite(r.box_max[a]) || !usable_extent(extent)) return false;
  }
  return true;
}

bool method_is_known(const ObjectRecord& r) {
  const uint32_t samples = r.method_parameters[0];
  if (!all_zero(std::span(r.method_parameters).subspan(3))) return false;
  const bool guarded = std::isfinite(r.guard_band) && r.guard_band > 0;
  switch (method_of(r)) {
    case Method::none: return r.depth == 1 && all_zero(r.method_parameters) && r.guard_band == 0;
    case Method::sampled: return (samples == 16 || samples == 81 || samples == 256) && r.guard_band == 0;
    case Method::proven: return samples == 0 && guarded;
    case Method::hybrid: return (samples == 81 || samples == 256) && guarded;
  }
  return false;
}

bool audit_is_sound(const ObjectRecord& r) {
  for (int i = 0; i < 2; ++i)
    if (r.audit_wrong[i] > r.audit_lines[i] || (method_of(r) == Method::proven && r.audit_wrong[i] > 0)) return false;
  if (r.audit_lines[0] == 0) return r.audit_bound_95 == 0;
  const double rate = static_cast<double>(r.audit_wrong[0]) / static_cast<double>(r.audit_lines[0]);
  return static_cast<double>(r.audit_bound_95) >= rate && r.audit_bound_95 <= 1;  // NaN: false
}

// All cells are of one of the classes that the method has.
bool cells_add_up(const ObjectRecord& r) {
  uint64_t left = tree_shape(r.depth).cells();
  if (r.statistical_cells != 0 && method_of(r) != Method::hybrid) return false;
  if (method_of(r) == Method::none && r.cells[2] != left) return false;
  for (uint64_t count : {r.cells[0], r.cells[1], r.cells[2], r.statistical_cells}) {
    if (count > left) return false;
    left -= count;
  }
  return left == 0;
}

// Counts of arrays that the shape has; of method none, those of the tree that stands for it.
bool pools_fit(const ObjectRecord& r) {
  for (uint32_t k = 0; k < kMostBlockLevels; ++k)
    if (k < tree_shape(r.depth).block_levels ? r.block_counts[k] < kUniformBlocks : r.block_counts[k] != 0)
      return false;
  return r.brick_count >= kUniformBlocks && (method_of(r) != Method::none || r.brick_count == kUniformBlocks);
}

bool owns(const Reading& reading, uint32_t object, uint32_t section, uint32_t type) {
  const auto sections = reading.contents.sections;
  return section < sections.size() && sections[section].type == type && sections[section].object == object;
}

bool check_owned_sections(Reading& reading, uint32_t index, const ObjectRecord& r, uint64_t at) {
  const std::string name = "object " + std::to_string(index);
  const bool has_tree = method_of(r) != Method::none;
  if (has_tree ? !owns(reading, index, r.tree_section, kSectionTree) : r.tree_section != kNone)
    return reading.report(FindingId::object_section, at + offsetof(ObjectRecord, tree_section), name);
  if (r.geometry_section != kNone && !owns(reading, index, r.geometry_section, kSectionGeometry))
    return reading.report(FindingId::object_section, at + offsetof(ObjectRecord, geometry_section), name);
  if (r.geometry_section != kNone)
    reading.contents.objects[index].geometry = reading.stored(reading.contents.sections[r.geometry_section]);
  if (!has_tree) return true;
  const uint64_t size = tree_shape(r.depth).bytes(r.block_counts, r.brick_count);
  return reading.contents.sections[r.tree_section].logical_size == size ||
         reading.report(FindingId::object_counts, at + offsetof(ObjectRecord, block_counts),
                        name + ": its pools need " + std::to_string(size) + " bytes");
}

// `names_end` is where the name before it ended, and then where its own ends.
bool check_name(Reading& reading, uint32_t index, uint64_t at, uint64_t& names_end) {
  ObjectContents& object = reading.contents.objects[index];
  const ObjectRecord& r = *object.record;
  const std::string name = "object " + std::to_string(index);
  const Bytes names = reading.stored(*reading.names);
  if (r.name_offset != names_end) return reading.report(FindingId::names_slack, at, name);
  if (r.name_length > names.size() - names_end) return reading.report(FindingId::object_name, at, name);
  names_end += r.name_length;
  object.name = {reinterpret_cast<const char*>(names.data()) + r.name_offset, r.name_length};
  return is_utf8(object.name) || reading.report(FindingId::object_name, at, name);
}

bool check_object(Reading& reading, uint32_t index, uint64_t& names_end) {
  const ObjectRecord& r = *reading.contents.objects[index].record;
  const uint64_t at = reading.record_offset(index);
  const std::string name = "object " + std::to_string(index);
  const auto report = [&](FindingId id, size_t member) { return reading.report(id, at + member, name); };
  if (!check_name(reading, index, at, names_end)) return false;
  if (r.depth < kMinDepth || r.depth > kMaxDepth) return report(FindingId::object_depth, offsetof(ObjectRecord, depth));
  if (!method_is_known(r)) return report(FindingId::object_method, offsetof(ObjectRecord, method));
  const uint16_t known = known_object_flags(reading.contents.header->version_minor);
  const uint16_t unknown_flags[] = {static_cast<uint16_t>(r.flags & ~known)};
  bool good = reading.check_reserved(unknown_flags, at + offsetof(ObjectRecord, flags), "flags of an object");
  good &= reading.check_reserved(r.reserved, at + offsetof(ObjectRecord, reserved), "object");
  if (!audit_is_sound(r)) good = report(FindingId::object_audit, offsetof(ObjectRecord, audit_lines));
  if (!std::all_of(std::begin(r.shift), std::end(r.shift), [](double x) { return std::isfinite(x); }))
    good = report(FindingId::object_shift, offsetof(ObjectRecord, shift));
  if (!box_is_usable(r)) return report(FindingId::object_box, offsetof(ObjectRecord, box_min));
  if (!pools_fit(r) || !cells_add_up(r)) return report(FindingId::object_counts, offsetof(ObjectRecord, cells));
  return check_owned_sections(reading, index, r, at) && good;
}

bool set_clearance(Reading& reading, const SectionEntry& s, uint64_t at) {
  const std::string name = section_type_name(s.type);
  if (s.logical_size != kClearanceBytes)
    return reading.report(
        FindingId::section_size, at,
        name + ": " + std::to_string(s.logical_size) + " bytes, not " + std::to_string(kClearanceBytes));
  ObjectContents& object = reading.contents.objects[s.object];
  if (!object.clearance.empty())
    return reading.report(FindingId::section_count, at, "a second " + name + " of object " + std::to_string(s.object));
  object.clearance = reading.stored(s);
  object.tree.clearances = reinterpret_cast<const uint8_t*>(object.clearance.data());
  return true;
}

// A HIER or HORZ section, whose content is looked at later. `of_objects` has the ones of its type.
bool set_section(Reading& reading, std::vector<uint32_t>& of_objects, uint32_t section, uint64_t at) {
  const SectionEntry& s = reading.contents.sections[section];
  of_objects.resize(reading.contents.objects.size(), kNone);
  if (of_objects[s.object] != kNone)
    return reading.report(FindingId::section_count, at,
                          "a second " + section_type_name(s.type) + " of object " + std::to_string(s.object));
  of_objects[s.object] = section;
  return true;
}

// Every section that objects own belongs to one that is there, and, where records name theirs, to the one that names
// it.
bool check_owner(Reading& reading, uint32_t section) {
  const SectionEntry& s = reading.contents.sections[section];
  const uint64_t at = reading.entry_offset(section);
  if (s.type != kSectionTree && s.type != kSectionGeometry && s.type != kSectionClearance &&
      s.type != kSectionHierarchy && s.type != kSectionHorizon)
    return true;
  if (s.object >= reading.contents.objects.size()) return reading.report(FindingId::section_object, at);
  if (s.type == kSectionClearance) return set_clearance(reading, s, at);
  if (s.type == kSectionHierarchy) return set_section(reading, reading.hierarchies, section, at);
  if (s.type == kSectionHorizon) return set_section(reading, reading.horizons, section, at);
  const ObjectRecord& r = *reading.contents.objects[s.object].record;
  return (s.type == kSectionTree ? r.tree_section : r.geometry_section) == section ||
         reading.report(FindingId::section_object, at, "its object does not name it");
}

}  // namespace

bool read_objects(Reading& reading) {
  const SectionEntry& e = *reading.objects;
  if (e.stored_size % sizeof(ObjectRecord) != 0)
    return reading.report(FindingId::section_size, e.offset, "OBJT is not a whole number of 256-byte records");
  const auto* records = reinterpret_cast<const ObjectRecord*>(reading.file.data() + e.offset);
  reading.contents.objects.resize(e.stored_size / sizeof(ObjectRecord));
  bool good = true;
  uint64_t names_end = 0;
  for (uint32_t i = 0; i < reading.contents.objects.size(); ++i) {
    reading.contents.objects[i].record = &records[i];
    good &= check_object(reading, i, names_end);
  }
  if (good && names_end != reading.names->stored_size)
    good = reading.report(FindingId::names_slack, reading.names->offset);
  for (uint32_t i = 0; good && i < reading.contents.sections.size(); ++i) good = check_owner(reading, i);
  return good;
}

}  // namespace vcd
