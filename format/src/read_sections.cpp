// The header and the section table.
#include <cstring>

#include <zstd.h>

#include <vcd/format/checksum.h>

#include "reading.h"

namespace vcd {
namespace {

bool check_zstd(Reading& reading, const SectionEntry& e, uint64_t at, const std::string& sizes) {
  if (e.logical_size > largest_logical_size(e.stored_size))
    return reading.report(FindingId::section_size, at, sizes + ", more than a frame of that size may claim");
  const Bytes stored = reading.stored(e);
  // A skippable frame is none: no checksum of logical bytes covers what it holds.
  uint32_t magic = 0;
  if (stored.size() >= sizeof magic) std::memcpy(&magic, stored.data(), sizeof magic);
  if (magic != ZSTD_MAGICNUMBER || ZSTD_findFrameCompressedSize(stored.data(), stored.size()) != stored.size())
    return reading.report(FindingId::zstd_frame, e.offset, sizes);
  return ZSTD_getFrameContentSize(stored.data(), stored.size()) == e.logical_size ||
         reading.report(FindingId::section_size, at, sizes + ", which the zstd frame contradicts");
}

bool check_sizes(Reading& reading, const SectionEntry& e, uint64_t at, const std::string& name, uint64_t& inflated) {
  const std::string sizes =
      name + ": stored " + std::to_string(e.stored_size) + ", logical " + std::to_string(e.logical_size) + " bytes";
  if (!is_zstd(e))
    return (e.logical_size == e.stored_size && e.logical_xxh3 == e.stored_xxh3) ||
           reading.report(FindingId::section_size, at, sizes);
  if (!check_zstd(reading, e, at, sizes)) return false;
  inflated += e.logical_size;
  return inflated <= largest_logical_total(reading.file.size()) ||
         reading.report(FindingId::section_size, at,
                        sizes + ", with those before more than a file of this size may claim");
}

// Type, flags, owner, storage and alignment.
bool check_kind(Reading& reading, const SectionEntry& e, uint64_t at) {
  const std::string name = section_type_name(e.type);
  if (e.storage > static_cast<uint32_t>(Storage::zstd))
    return reading.report(FindingId::section_storage, at, name + ": storage " + std::to_string(e.storage));
  uint32_t flags = kSectionCritical, alignment = kSmallAlignment;
  bool owned = false, raw_only = true;
  const SectionEntry** only_one = nullptr;
  switch (e.type) {
    case kSectionObjects: only_one = &reading.objects; break;
    case kSectionNames: only_one = &reading.names; break;
    case kSectionProvenance: only_one = &reading.provenance, flags = 0; break;
    case kSectionTree:
      owned = true, raw_only = false;
      alignment = is_zstd(e) ? kSmallAlignment : kPageAlignment;
      break;
    case kSectionHierarchy:
    case kSectionHorizon:
      owned = true, raw_only = false, flags = 0;
      alignment = is_zstd(e) ? kSmallAlignment : kUnitAlignment;
      break;
    case kSectionGeometry:
    case kSectionClearance: owned = true, flags = 0; break;
    default:
      if (e.flags & kSectionCritical) return reading.report(FindingId::unknown_critical, at, name);
      return e.flags == 0 || reading.report(FindingId::section_flags, at, name);
  }
  if (only_one && *only_one) return reading.report(FindingId::section_count, at, "a second " + name);
  if (only_one) *only_one = &e;
  if (e.flags != flags) return reading.report(FindingId::section_flags, at, name);
  if (raw_only && is_zstd(e)) return reading.report(FindingId::section_storage, at, name + " must be raw");
  if (e.alignment != alignment) return reading.report(FindingId::section_alignment, at, name);
  return (e.object != kNone) == owned || reading.report(FindingId::section_object, at, name);
}

// `end` is where the section before it ended, and then where this one ends; `inflated` likewise of what is compressed.
bool check_section(Reading& reading, uint32_t index, uint64_t& end, uint64_t& inflated) {
  const SectionEntry& e = reading.contents.sections[index];
  const uint64_t at = reading.entry_offset(index), size = reading.file.size();
  const std::string name = "section " + std::to_string(index) + ", " + section_type_name(e.type);
  bool good = reading.check_reserved(std::span(&e.reserved, 1), at + offsetof(SectionEntry, reserved), "section entry");
  if (e.alignment != kSmallAlignment && e.alignment != kUnitAlignment && e.alignment != kPageAlignment)
    return reading.report(FindingId::section_alignment, at, name);
  const uint64_t expected = (end + e.alignment - 1) / e.alignment * e.alignment;
  if (e.offset != expected || e.offset > size || e.stored_size > size - e.offset)
    return reading.report(FindingId::section_range, at,
                          name + ": offset " + std::to_string(e.offset) + ", size " + std::to_string(e.stored_size) +
                              ", expected offset " + std::to_string(expected));
  if (reading.canonical() && !all_zero(reading.file.subspan(end, e.offset - end)))
    good = reading.report(FindingId::padding_not_zero, end, name);
  end = e.offset + e.stored_size;
  good &= check_kind(reading, e, at) && check_sizes(reading, e, at, name, inflated);
  const bool small = e.type == kSectionObjects || e.type == kSectionNames;
  if ((reading.checksums() || small) && checksum(reading.stored(e)) != e.stored_xxh3)
    good = reading.report(FindingId::stored_checksum, e.offset, name);
  return good;
}

}  // namespace

bool read_header(Reading& reading) {
  const Bytes file = reading.file;
  if (file.size() < sizeof(FileHeader))
    return reading.report(FindingId::file_too_short, file.size(),
                          std::to_string(file.size()) + " bytes, the header has 64");
  reading.contents.header = reinterpret_cast<const FileHeader*>(file.data());
  const FileHeader& h = *reading.contents.header;
  if (h.magic != kMagic) {
    const bool named = h.magic[1] == 'V' && h.magic[2] == 'C' && h.magic[3] == 'D';
    return reading.report(named ? FindingId::transfer_damage : FindingId::bad_magic, 0);
  }
  if (h.version_major != kVersionMajor)
    return reading.report(FindingId::unsupported_version, offsetof(FileHeader, version_major),
                          "version " + std::to_string(h.version_major) + "." + std::to_string(h.version_minor) +
                              ", this reader knows " + std::to_string(kVersionMajor));
  if (checksum(file.first(offsetof(FileHeader, header_xxh3))) != h.header_xxh3)
    return reading.report(FindingId::header_checksum, offsetof(FileHeader, header_xxh3));
  reading.check_reserved(h.reserved, offsetof(FileHeader, reserved), "header");
  return h.file_size == file.size() || reading.report(FindingId::file_size, offsetof(FileHeader, file_size),
                                                      "the header says " + std::to_string(h.file_size) +
                                                          " bytes, the file has " + std::to_string(file.size()));
}

bool read_section_table(Reading& reading) {
  const uint64_t count = reading.contents.header->section_count;
  if (count > (reading.file.size() - sizeof(FileHeader)) / sizeof(SectionEntry))
    return reading.report(FindingId::section_table_range, offsetof(FileHeader, section_count),
                          std::to_string(count) + " sections");
  const Bytes table = reading.file.subspan(sizeof(FileHeader), count * sizeof(SectionEntry));
  if (checksum(table) != reading.contents.header->section_table_xxh3)
    return reading.report(FindingId::section_table_checksum, sizeof(FileHeader));
  reading.contents.sections = std::span(reinterpret_cast<const SectionEntry*>(table.data()), count);
  uint64_t end = sizeof(FileHeader) + table.size(), inflated = 0;
  bool good = true;
  for (uint32_t i = 0; i < count; ++i) good &= check_section(reading, i, end, inflated);
  if (good && end != reading.file.size()) good = reading.report(FindingId::trailing_bytes, end);
  if (!reading.objects) good = reading.report(FindingId::section_count, sizeof(FileHeader), "there is no OBJT section");
  if (!reading.names) good = reading.report(FindingId::section_count, sizeof(FileHeader), "there is no NAME section");
  return good;
}

bool check_unknown_sections(Reading& reading) {
  for (const SectionEntry& e : reading.contents.sections) {
    if (is_known_section(e.type) || !is_zstd(e)) continue;
    const AlignedBytes bytes = section_bytes(reading.file, e);
    const std::string name = section_type_name(e.type);
    if (bytes.size != e.logical_size) return reading.report(FindingId::decompression, e.offset, name);
    if (checksum({bytes.data.get(), bytes.size}) != e.logical_xxh3)
      return reading.report(FindingId::logical_checksum, e.offset, name);
  }
  return true;
}

}  // namespace vcd
