#include <vcd/format/contents.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>
#include <new>
#include <string>

#include <zstd.h>

#include <vcd/format/tree_statistics.h>

#include <vcd/format/checksum.h>
#include <vcd/format/utf8.h>

namespace vcd {

void AlignedBytes::Free::operator()(std::byte* p) const { ::operator delete[](p, std::align_val_t{64}); }

AlignedBytes allocate_aligned(uint64_t size) {
  AlignedBytes bytes;
  bytes.data.reset(new (std::align_val_t{64}, std::nothrow) std::byte[std::max<uint64_t>(size, 1)]);
  bytes.size = bytes.data ? size : 0;
  return bytes;
}

namespace {

constexpr size_t kFirstVersionBytes = offsetof(ObjectRecord, statistical_cells);  // of a record of version 1

template <class T>
bool all_zero(const T& bytes) {
  return std::all_of(std::begin(bytes), std::end(bytes), [](auto b) { return b == decltype(b){}; });
}

class Reader {
 public:
  Reader(Bytes file, CheckLevel level, std::vector<Finding>& findings)
      : file_(file), level_(level), findings_(findings) {}

  std::optional<SidecarContents> read() {
    const size_t first = findings_.size();
    const bool complete = read_header() && read_section_table() && read_objects() && read_trees();
    if (complete) read_provenance();
    if (!complete || has_error(std::span(findings_).subspan(first))) return std::nullopt;
    return std::move(contents_);
  }

 private:
  bool checksums() const { return level_ >= CheckLevel::checksums; }
  bool canonical() const { return level_ >= CheckLevel::canonical; }
  bool report(FindingId id, uint64_t offset, std::string detail = {}) {  // false, so that a check can return it
    findings_.push_back({id, offset, std::move(detail)});
    return false;
  }
  uint64_t entry_offset(uint64_t index) const { return sizeof(FileHeader) + index * sizeof(SectionEntry); }
  Bytes stored(const SectionEntry& e) const { return file_.subspan(e.offset, e.stored_size); }

  bool read_header();
  bool check_reserved(const void* bytes, size_t size, uint64_t offset, const char* what);
  bool read_section_table();
  bool check_section(uint32_t index, uint64_t& end);
  bool check_kind(const SectionEntry& e, uint64_t at);
  bool check_sizes(const SectionEntry& e, uint64_t at, const std::string& name);
  bool read_objects();
  bool set_margins(const SectionEntry& s, uint32_t index);
  bool check_object(uint32_t index, uint64_t at, uint64_t& names_end);
  bool method_is_known(const ObjectRecord& r) const;
  bool check_owned_sections(uint32_t index, const ObjectRecord& r, uint64_t at);
  bool read_trees();
  bool check_unknown_sections();
  bool read_tree(uint32_t index);
  bool check_pool(const uint32_t* words, uint64_t words_a_block, uint64_t count, uint64_t below, uint64_t at);
  void read_provenance();

  Bytes file_;
  CheckLevel level_;
  std::vector<Finding>& findings_;
  SidecarContents contents_;
  uint64_t inflated_total_ = 0;
  const SectionEntry* objects_entry_ = nullptr;
  const SectionEntry* names_entry_ = nullptr;
  const SectionEntry* provenance_entry_ = nullptr;
};

bool Reader::read_header() {
  if (file_.size() < sizeof(FileHeader))
    return report(FindingId::file_too_short, file_.size(), std::to_string(file_.size()) + " bytes, the header has 64");
  contents_.header = reinterpret_cast<const FileHeader*>(file_.data());
  const FileHeader& h = *contents_.header;
  if (h.magic != kMagic) {
    const auto* m = h.magic.data();
    const bool named = m[1] == 'V' && m[2] == 'C' && m[3] == 'D';
    return report(named ? FindingId::transfer_damage : FindingId::bad_magic, 0);
  }
  if (h.version_major != 1 && h.version_major != kVersionMajor)
    return report(FindingId::unsupported_version, 8,
                  "version " + std::to_string(h.version_major) + "." + std::to_string(h.version_minor) +
                      ", this reader knows 1 and 2");
  if (checksum(file_.first(offsetof(FileHeader, header_xxh3))) != h.header_xxh3)
    return report(FindingId::header_checksum, offsetof(FileHeader, header_xxh3));
  check_reserved(h.reserved, sizeof h.reserved, offsetof(FileHeader, reserved), "header");
  if (h.file_size != file_.size())
    return report(
        FindingId::file_size, offsetof(FileHeader, file_size),
        "the header says " + std::to_string(h.file_size) + " bytes, the file has " + std::to_string(file_.size()));
  return true;
}

// Reserved fields must be zero in a file of a version that this reader knows; a later minor version may use them.
bool Reader::check_reserved(const void* bytes, size_t size, uint64_t offset, const char* what) {
  const uint16_t last_known = contents_.header->version_major == kVersionMajor ? kVersionMinor : 0;
  if (contents_.header->version_minor > last_known) return true;
  return all_zero(std::span(static_cast<const uint8_t*>(bytes), size)) ||
         report(FindingId::reserved_not_zero, offset, what);
}

bool Reader::read_section_table() {
  const uint64_t count = contents_.header->section_count;
  if (count > (file_.size() - sizeof(FileHeader)) / sizeof(SectionEntry))
    return report(FindingId::section_table_range, 12, std::to_string(count) + " sections");
  const Bytes table = file_.subspan(sizeof(FileHeader), count * sizeof(SectionEntry));
  if (checksum(table) != contents_.header->section_table_xxh3)
    return report(FindingId::section_table_checksum, sizeof(FileHeader));
  contents_.sections = std::span(reinterpret_cast<const SectionEntry*>(table.data()), count);
  uint64_t end = sizeof(FileHeader) + table.size();
  bool good = true;
  for (uint32_t i = 0; i < count; ++i) {
    if (!check_section(i, end)) good = false;
  }
  if (good && end != file_.size()) good = report(FindingId::trailing_bytes, end);
  if (!objects_entry_) good = report(FindingId::section_count, sizeof(FileHeader), "there is no OBJT section");
  if (!names_entry_) good = report(FindingId::section_count, sizeof(FileHeader), "there is no NAME section");
  return good;
}

bool Reader::check_section(uint32_t index, uint64_t& end) {
  const SectionEntry& e = contents_.sections[index];
  const uint64_t at = entry_offset(index);
  const std::string name = "section " + std::to_string(index) + ", " + section_type_name(e.type);
  bool good = check_reserved(&e.reserved, sizeof e.reserved, at + offsetof(SectionEntry, reserved), "section entry");
  if (e.alignment != kSmallAlignment && e.alignment != kPageAlignment)
    return report(FindingId::section_alignment, at, name);
  const uint64_t expected = (end + e.alignment - 1) / e.alignment * e.alignment;
  if (e.offset != expected || e.offset > file_.size() || e.stored_size > file_.size() - e.offset)
    return report(FindingId::section_range, at,
                  name + ": offset " + std::to_string(e.offset) + ", size " + std::to_string(e.stored_size) +
                      ", expected offset " + std::to_string(expected));
  if (canonical() && !all_zero(file_.subspan(end, e.offset - end)))
    good = report(FindingId::padding_not_zero, end, name);
  end = e.offset + e.stored_size;
  good &= check_kind(e, at) && check_sizes(e, at, name);
  const bool small = e.type == kSectionObjects || e.type == kSectionNames;
  if ((checksums() || small) && checksum(stored(e)) != e.stored_xxh3)
    good = report(FindingId::stored_checksum, e.offset, name);
  return good;
}

// Type, flags, owner, storage and alignment.
bool Reader::check_kind(const SectionEntry& e, uint64_t at) {
  const std::string name = section_type_name(e.type);
  const bool known_storage = e.storage <= static_cast<uint32_t>(Storage::zstd);
  const bool is_raw = e.storage == static_cast<uint32_t>(Storage::raw);
  if (!known_storage) return report(FindingId::section_storage, at, name + ": storage " + std::to_string(e.storage));
  const auto only_one = [&](const SectionEntry*& slot) {
    if (slot) return report(FindingId::section_count, at, "a second " + name);
    slot = &e;
    return true;
  };
  uint32_t flags = kSectionCritical, alignment = kSmallAlignment;
  bool owned = false, raw_only = true;
  switch (e.type) {
    case kSectionObjects:
      if (!only_one(objects_entry_)) return false;
      break;
    case kSectionNames:
      if (!only_one(names_entry_)) return false;
      break;
    case kSectionProvenance:
      if (!only_one(provenance_entry_)) return false;
      flags = 0;
      break;
    case kSectionTree:
      owned = true;
      raw_only = false;
      alignment = is_raw ? kPageAlignment : kSmallAlignment;
      break;
    case kSectionGeometry:
    case kSectionMargins:
      flags = 0;
      owned = true;
      break;
    default:
      if (e.flags & kSectionCritical) return report(FindingId::unknown_critical, at, name);
      return e.flags == 0 || report(FindingId::section_flags, at, name);
  }
  if (e.flags != flags) return report(FindingId::section_flags, at, name);
  if (raw_only && !is_raw) return report(FindingId::section_storage, at, name + " must be raw");
  if (e.alignment != alignment) return report(FindingId::section_alignment, at, name);
  if ((e.object != kNone) != owned) return report(FindingId::section_object, at, name);
  return true;
}

bool Reader::check_sizes(const SectionEntry& e, uint64_t at, const std::string& name) {
  const std::string sizes =
      name + ": stored " + std::to_string(e.stored_size) + ", logical " + std::to_string(e.logical_size) + " bytes";
  if (e.storage == static_cast<uint32_t>(Storage::raw))
    return (e.logical_size == e.stored_size && e.logical_xxh3 == e.stored_xxh3) ||
           report(FindingId::section_size, at, sizes);
  if (e.logical_size > largest_logical_size(e.stored_size))
    return report(FindingId::section_size, at, sizes + ", more than a frame of that size may claim");
  inflated_total_ += e.logical_size;
  if (inflated_total_ > largest_logical_total(file_.size()))
    return report(FindingId::section_size, at, sizes + ", with those before more than a file of this size may claim");
  const std::byte* frame = file_.data() + e.offset;
  if (ZSTD_getFrameContentSize(frame, e.stored_size) != e.logical_size ||
      ZSTD_findFrameCompressedSize(frame, e.stored_size) != e.stored_size)
    return report(FindingId::section_size, at, sizes + ", which the zstd frame contradicts");
  return true;
}

bool Reader::read_objects() {
  const SectionEntry& e = *objects_entry_;
  if (e.stored_size % sizeof(ObjectRecord) != 0)
    return report(FindingId::section_size, e.offset, "OBJT is not a whole number of 256-byte records");
  const auto* records = reinterpret_cast<const ObjectRecord*>(file_.data() + e.offset);
  contents_.objects.resize(e.stored_size / sizeof(ObjectRecord));
  if (contents_.header->version_major == 1) {  // what it does not have is 0, whatever later minor versions put there
    contents_.upgraded.assign(records, records + contents_.objects.size());
    for (uint32_t i = 0; i < contents_.upgraded.size(); ++i) {
      auto* rest = reinterpret_cast<std::byte*>(&contents_.upgraded[i]) + kFirstVersionBytes;
      check_reserved(rest, sizeof(ObjectRecord) - kFirstVersionBytes,
                     e.offset + i * sizeof(ObjectRecord) + kFirstVersionBytes, "object record");
      std::memset(rest, 0, sizeof(ObjectRecord) - kFirstVersionBytes);
    }
    records = contents_.upgraded.data();
  }
  bool good = true;
  uint64_t names_end = 0;
  for (uint32_t i = 0; i < contents_.objects.size(); ++i) {
    contents_.objects[i].record = &records[i];
    if (!check_object(i, e.offset + i * sizeof(ObjectRecord), names_end)) good = false;
  }
  if (good && names_end != names_entry_->stored_size) good = report(FindingId::names_slack, names_entry_->offset);
  // Every TREE and GEOM section belongs to an object that names it.
  for (uint32_t i = 0; good && i < contents_.sections.size(); ++i) {
    const SectionEntry& s = contents_.sections[i];
    if (s.type != kSectionTree && s.type != kSectionGeometry && s.type != kSectionMargins) continue;
    if (s.object >= contents_.objects.size()) return report(FindingId::section_object, entry_offset(i));
    if (s.type == kSectionMargins) {
      if (!set_margins(s, i)) return false;
      continue;
    }
    const ObjectRecord& r = records[s.object];
    if ((s.type == kSectionTree ? r.tree_section : r.geometry_section) != i)
      good = report(FindingId::section_object, entry_offset(i), "its object names another section");
  }
  return good;
}

bool Reader::set_margins(const SectionEntry& s, uint32_t index) {
  const std::string name = section_type_name(s.type);
  if (s.logical_size != kClearanceBytes)
    return report(FindingId::section_size, entry_offset(index),
                  name + ": " + std::to_string(s.logical_size) + " bytes, not " + std::to_string(kClearanceBytes));
  const uint8_t*& margins = contents_.objects[s.object].tree.clearances;
  if (margins)
    return report(FindingId::section_count, entry_offset(index),
                  "a second " + name + " of object " + std::to_string(s.object));
  margins = reinterpret_cast<const uint8_t*>(stored(s).data());
  return true;
}

bool box_is_usable(const ObjectRecord& r) {
  for (int a = 0; a < 3; ++a) {
    const float extent = r.box_max[a] - r.box_min[a];
    if (!std::isfinite(r.box_min[a]) || !std::isfinite(r.box_max[a]) || !usable_extent(extent)) return false;
  }
  return true;
}

bool Reader::method_is_known(const ObjectRecord& r) const {
  const uint32_t samples = r.method_parameters[0];
  if (!all_zero(std::span(r.method_parameters).subspan(3))) return false;
  const bool first_version = contents_.header->version_major == 1;
  const bool guarded = std::isfinite(r.guard_band) && r.guard_band > 0;
  switch (static_cast<Method>(r.method)) {
    case Method::sampled: return (samples == 16 || samples == 81 || samples == 256) && r.guard_band == 0;
    case Method::none: return !first_version && r.depth == 1 && all_zero(r.method_parameters) && r.guard_band == 0;
    case Method::proven: return !first_version && samples == 0 && guarded;
    case Method::hybrid: return !first_version && (samples == 81 || samples == 256) && guarded;
  }
  return false;
}

bool audit_is_sound(const ObjectRecord& r) {
  for (int i = 0; i < 2; ++i)
    if (r.audit_wrong[i] > r.audit_lines[i] ||
        (r.method == static_cast<uint8_t>(Method::proven) && r.audit_wrong[i] > 0))
      return false;
  if (r.audit_lines[0] == 0) return r.audit_bound_95 == 0;
  const double rate = static_cast<double>(r.audit_wrong[0]) / static_cast<double>(r.audit_lines[0]);
  return static_cast<double>(r.audit_bound_95) >= rate && r.audit_bound_95 <= 1;  // NaN: false
}

// All cells are of one of the classes that the method has.
bool counts_add_up(const ObjectRecord& r, uint64_t cells) {
  if (r.statistical_cells != 0 && r.method != static_cast<uint8_t>(Method::hybrid)) return false;
  if (r.method == static_cast<uint8_t>(Method::none) && r.cells[2] != cells) return false;
  for (uint64_t count : {r.cells[0], r.cells[1], r.cells[2], r.statistical_cells}) {
    if (count > cells) return false;
    cells -= count;
  }
  return cells == 0;
}

bool Reader::check_object(uint32_t index, uint64_t at, uint64_t& names_end) {
  const ObjectRecord& r = *contents_.objects[index].record;
  const std::string name = "object " + std::to_string(index);
  const Bytes names = stored(*names_entry_);
  if (r.name_offset != names_end) return report(FindingId::names_slack, at, name);
  if (r.name_length > names.size() - names_end) return report(FindingId::object_name, at, name);
  names_end += r.name_length;
  contents_.objects[index].name = {reinterpret_cast<const char*>(names.data()) + r.name_offset, r.name_length};
  if (!is_utf8(contents_.objects[index].name)) return report(FindingId::object_name, at, name);
  if (r.depth < kMinDepth || r.depth > kMaxDepth) return report(FindingId::object_depth, at + 12, name);
  if (!method_is_known(r)) return report(FindingId::object_method, at + 13, name);
  bool good = check_reserved(r.reserved0, sizeof r.reserved0, at + offsetof(ObjectRecord, reserved0), "object record");
  good &= check_reserved(r.reserved1, sizeof r.reserved1, at + offsetof(ObjectRecord, reserved1), "object record");
  if (!audit_is_sound(r)) good = report(FindingId::object_audit, at + offsetof(ObjectRecord, audit_lines), name);
  if (!box_is_usable(r)) return report(FindingId::object_box, at + offsetof(ObjectRecord, box_min), name);

  const TreeShape shape = tree_shape(r.depth);
  const auto pool_fits = [](bool present, uint64_t count) {
    return present ? count >= kUniformBlocks && count <= kNone : count == 0;
  };
  const uint64_t cells = shape.cells();
  if (!pool_fits(shape.has_blocks256, r.block256_count) || !pool_fits(shape.has_blocks16, r.block16_count) ||
      !pool_fits(true, r.brick_count) || !counts_add_up(r, cells))
    return report(FindingId::object_counts, at + offsetof(ObjectRecord, cells), name);
  return check_owned_sections(index, r, at) && good;
}

bool Reader::check_owned_sections(uint32_t index, const ObjectRecord& r, uint64_t at) {
  const std::string name = "object " + std::to_string(index);
  const auto owned = [&](uint32_t section, uint32_t type) {
    return section < contents_.sections.size() && contents_.sections[section].type == type &&
           contents_.sections[section].object == index;
  };
  if (!owned(r.tree_section, kSectionTree))
    return report(FindingId::object_section, at + offsetof(ObjectRecord, tree_section), name);
  if (r.geometry_section != kNone && !owned(r.geometry_section, kSectionGeometry))
    return report(FindingId::object_section, at + offsetof(ObjectRecord, geometry_section), name);
  const uint64_t size = tree_shape(r.depth).bytes(r.block256_count, r.block16_count, r.brick_count);
  if (contents_.sections[r.tree_section].logical_size != size)
    return report(FindingId::object_counts, at + offsetof(ObjectRecord, block256_count),
                  name + ": its pools need " + std::to_string(size) + " bytes");
  if (r.geometry_section != kNone) contents_.objects[index].geometry = stored(contents_.sections[r.geometry_section]);
  return true;
}

bool Reader::read_trees() {
  bool good = true;
  for (uint32_t i = 0; good && i < contents_.objects.size(); ++i) good = read_tree(i);
  return good && (!checksums() || check_unknown_sections());
}

// Compressed sections that nobody here reads still have to hold what their entry says.
bool Reader::check_unknown_sections() {
  for (const SectionEntry& e : contents_.sections) {
    if (e.type == kSectionTree || e.storage == static_cast<uint32_t>(Storage::raw)) continue;
    const AlignedBytes bytes = section_bytes(file_, e);
    if (bytes.size != e.logical_size) return report(FindingId::decompression, e.offset, section_type_name(e.type));
    if (checksum({bytes.data.get(), bytes.size}) != e.logical_xxh3)
      return report(FindingId::logical_checksum, e.offset, section_type_name(e.type));
  }
  return true;
}

// Every word of every block is below `below`; blocks 0, 1, 2 are uniform.
bool Reader::check_pool(const uint32_t* words, uint64_t words_a_block, uint64_t count, uint64_t below, uint64_t at) {
  uint32_t largest = 0;
  for (uint64_t i = 0; i < count * words_a_block; ++i) largest = std::max(largest, words[i]);
  if (count > 0 && largest >= below)
    return report(FindingId::tree_index, at, "index " + std::to_string(largest) + " of " + std::to_string(below));
  for (uint64_t i = 0; i < std::min<uint64_t>(count, kUniformBlocks) * words_a_block; ++i)
    if (words[i] != i / words_a_block) return report(FindingId::tree_uniform, at);
  return true;
}

bool Reader::read_tree(uint32_t index) {
  ObjectContents& object = contents_.objects[index];
  const ObjectRecord& r = *object.record;
  const SectionEntry& e = contents_.sections[r.tree_section];
  Bytes bytes = stored(e);
  if (e.storage == static_cast<uint32_t>(Storage::zstd) || reinterpret_cast<uintptr_t>(bytes.data()) % 64 != 0) {
    AlignedBytes copy = section_bytes(file_, e);
    if (copy.size != e.logical_size)
      return report(FindingId::decompression, e.offset, "object " + std::to_string(index));
    bytes = {copy.data.get(), copy.size};
    contents_.inflated.push_back(std::move(copy));
  }
  if (checksums() && e.storage == static_cast<uint32_t>(Storage::zstd) && checksum(bytes) != e.logical_xxh3)
    return report(FindingId::logical_checksum, e.offset, "object " + std::to_string(index));

  TreeView& tree = object.tree;
  tree.shape = tree_shape(r.depth);
  tree.block256_count = r.block256_count;
  tree.block16_count = r.block16_count;
  tree.brick_count = r.brick_count;
  tree.answers = answer_table(r.method == static_cast<uint8_t>(Method::hybrid) ? Trust::statistics : Trust::proofs,
                              classes_in(r));
  tree.top = reinterpret_cast<const uint32_t*>(bytes.data());
  tree.blocks256 = tree.top + tree.shape.top_bytes() / 4;
  tree.blocks16 = tree.blocks256 + tree.block256_count * kBlock256Words;
  tree.bricks = reinterpret_cast<const uint8_t*>(tree.blocks16 + tree.block16_count * kBlock16Words);

  const uint64_t below16 = tree.brick_count;
  const uint64_t below256 = tree.shape.has_blocks16 ? tree.block16_count : below16;
  const uint64_t below_top = tree.shape.has_blocks256 ? tree.block256_count : below256;
  bool good = check_pool(tree.blocks16, kBlock16Words, tree.block16_count, below16, e.offset) &&
              check_pool(tree.blocks256, kBlock256Words, tree.block256_count, below256, e.offset);
  const uint64_t used = tree.shape.top_words();
  if (const uint32_t largest = *std::max_element(tree.top, tree.top + used); largest >= below_top)
    good = report(FindingId::tree_index, e.offset,
                  "index " + std::to_string(largest) + " of " + std::to_string(below_top) + " in the top table");
  if (!all_zero(std::span(tree.top + used, tree.shape.top_bytes() / 4 - used)))
    good = report(FindingId::tree_spare, e.offset, "after word " + std::to_string(used) + " of the top table");
  for (uint64_t i = 0; i < kUniformBlocks * kBrickBytes; ++i)
    if (tree.bricks[i] != i / kBrickBytes * 0x55) {
      good = report(FindingId::tree_uniform, e.offset, "bricks");
      break;
    }
  if (!canonical() || !good) return good;

  const TreeStatistics s = measure_tree(tree);
  if (r.depth == 1 && s.mixed_groups > 0)
    return report(FindingId::tree_depth, e.offset, std::to_string(s.mixed_groups) + " groups of sixteen cells differ");
  if (s.cells[3] > 0 && r.method != static_cast<uint8_t>(Method::hybrid))
    return report(FindingId::tree_class, e.offset, std::to_string(s.cells[3]) + " cells of class 3");
  if (s.unreferenced_blocks > 0)
    return report(FindingId::tree_unreferenced, e.offset, std::to_string(s.unreferenced_blocks) + " blocks");
  if (s.duplicate_blocks > 0)
    return report(FindingId::tree_duplicate, e.offset, std::to_string(s.duplicate_blocks) + " blocks");
  if (s.cells != std::array<uint64_t, 4>{r.cells[0], r.cells[1], r.cells[2], r.statistical_cells} ||
      s.nodes_unfolded != r.nodes_unfolded || s.nodes_folded != r.nodes_folded || s.nodes_shared != r.nodes_shared)
    return report(FindingId::object_statistics, objects_entry_->offset + index * sizeof(ObjectRecord));
  return true;
}

void Reader::read_provenance() {
  if (!provenance_entry_) return;
  const uint64_t at = provenance_entry_->offset;
  Bytes rest = stored(*provenance_entry_);
  const auto number = [&](uint32_t& value) {
    if (rest.size() < 4) return false;
    std::memcpy(&value, rest.data(), 4);
    rest = rest.subspan(4);
    return true;
  };
  const auto text = [&](uint32_t size, std::string_view& value) {
    if (rest.size() < size) return false;
    value = {reinterpret_cast<const char*>(rest.data()), size};
    rest = rest.subspan(size);
    return is_utf8(value);
  };
  uint32_t count = 0;
  bool good = number(count);
  for (uint32_t i = 0; good && i < count; ++i) {
    uint32_t key_size = 0, value_size = 0;
    std::string_view key, value;
    good = number(key_size) && number(value_size) && text(key_size, key) && text(value_size, value) &&
           (contents_.provenance.empty() || contents_.provenance.back().first < key);
    if (good) contents_.provenance.emplace_back(key, value);
  }
  if (!good || !rest.empty()) report(FindingId::provenance, at);
}

}  // namespace

std::string section_type_name(uint32_t type) {
  std::string name;
  for (int i = 0; i < 4; ++i) {
    const char c = static_cast<char>(type >> (8 * i));
    if (c > 32 && c < 127) {
      name += c;
    } else {
      char hex[8];
      std::snprintf(hex, sizeof hex, "\\x%02X", static_cast<unsigned>(type >> (8 * i) & 255));
      name += hex;
    }
  }
  return name;
}

std::optional<SidecarContents> read_sidecar(Bytes file, CheckLevel level, std::vector<Finding>& findings) {
  return Reader(file, level, findings).read();
}

AlignedBytes section_bytes(Bytes file, const SectionEntry& section) {
  AlignedBytes out = allocate_aligned(section.logical_size);
  if (!out.data) return {};
  const std::byte* stored = file.data() + section.offset;
  if (section.storage == static_cast<uint32_t>(Storage::raw)) {
    std::memcpy(out.data.get(), stored, section.logical_size);
    return out;
  }
  const size_t size = ZSTD_decompress(out.data.get(), out.size, stored, section.stored_size);
  return ZSTD_isError(size) || size != section.logical_size ? AlignedBytes{} : std::move(out);
}

}  // namespace vcd
