// What the steps of read_sidecar() share, and the steps. Each appends what it finds to `findings`; one that returns
// bool returns false where the steps after it would not be safe, or say nothing new.
#pragma once

#include <algorithm>
#include <iterator>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include <vcd/format/contents.h>

namespace vcd {

template <class Range>
bool all_zero(const Range& range) {
  return std::all_of(std::begin(range), std::end(range), [](auto b) { return b == decltype(b){}; });
}

struct Reading {
  Bytes file;
  CheckLevel level;
  std::vector<Finding>& findings;
  SidecarContents contents{};
  const SectionEntry* objects = nullptr;  // the entries of the sections that no object owns
  const SectionEntry* names = nullptr;
  const SectionEntry* provenance = nullptr;
  std::vector<uint32_t> hierarchies{};  // for each object its HIER section or kNone; empty if there is none at all
  std::vector<uint32_t> horizons{};     // likewise its HORZ section

  bool checksums() const { return level >= CheckLevel::checksums; }
  bool canonical() const { return level >= CheckLevel::canonical; }

  bool report(FindingId id, uint64_t offset, std::string detail = {}) {  // false, so that a check can return it
    findings.push_back({id, offset, std::move(detail)});
    return false;
  }
  // Reserved fields must be zero in a file of a version that this reader knows; a later minor version may use them.
  template <class T>
  bool check_reserved(const T& bytes, uint64_t offset, const char* what) {
    if (contents.header->version_minor > kVersionMinor) return true;
    return all_zero(bytes) || report(FindingId::reserved_not_zero, offset, what);
  }

  Bytes stored(const SectionEntry& e) const { return file.subspan(e.offset, e.stored_size); }
  uint64_t entry_offset(uint64_t index) const { return sizeof(FileHeader) + index * sizeof(SectionEntry); }
  uint64_t record_offset(uint64_t index) const { return objects->offset + index * sizeof(ObjectRecord); }
};

inline bool is_zstd(const SectionEntry& e) { return e.storage == static_cast<uint32_t>(Storage::zstd); }

// The logical bytes of a TREE, HIER or HORZ section, in place where that is possible, else in `inflated`. 64-byte
// aligned. Empty after a finding.
Bytes mapped_bytes(Reading& reading, const SectionEntry& e, const std::string& owner);

bool read_header(Reading& reading);         // magic, version, size
bool read_section_table(Reading& reading);  // every entry, where its bytes lie, and the checksums of stored bytes
bool read_objects(Reading& reading);        // OBJT and NAME, and what belongs to which object
bool read_trees(Reading& reading);
bool read_hierarchies(Reading& reading);
bool read_horizons(Reading& reading);           // behind the hierarchies
bool check_unknown_sections(Reading& reading);  // the logical checksums of compressed ones
void read_provenance(Reading& reading);

}  // namespace vcd
