#include <vcd/format/contents.h>

#include <cassert>
#include <cstdio>
#include <cstring>

#include <zstd.h>

#include <vcd/format/checksum.h>

#include "reading.h"

namespace vcd {

std::optional<SidecarContents> read_sidecar(Bytes file, CheckLevel level, std::vector<Finding>& findings) {
  assert(reinterpret_cast<uintptr_t>(file.data()) % 8 == 0);
  const size_t first = findings.size();
  Reading reading{file, level, findings};
  const bool complete = read_header(reading) && read_section_table(reading) && read_objects(reading) &&
                        read_trees(reading) && read_hierarchies(reading) && read_horizons(reading);
  if (complete && reading.checksums()) check_unknown_sections(reading);
  if (complete) read_provenance(reading);
  if (!complete || has_error(std::span(findings).subspan(first))) return std::nullopt;
  return std::move(reading.contents);
}

Result<std::vector<GeometryHash>> read_geometry_hashes(Bytes file, const std::string& name) {
  assert(reinterpret_cast<uintptr_t>(file.data()) % 8 == 0);
  std::vector<Finding> findings;
  Reading reading{file, CheckLevel::bounds, findings};
  if (!read_header(reading) || !read_section_table(reading) || !read_objects(reading) || has_error(findings))
    return first_error(name, findings);
  std::vector<GeometryHash> hashes;
  for (const ObjectContents& object : reading.contents.objects) hashes.push_back(object.record->geometry_hash);
  return hashes;
}

Error first_error(const std::string& name, std::span<const Finding> findings) {
  for (const Finding& finding : findings) {
    if (finding_info(finding.id).severity != Severity::error) continue;
    return {error_code(finding.id), name + ": " + describe(finding)};
  }
  return {ErrorCode::invalid_file, name + ": not a valid sidecar"};
}

Bytes mapped_bytes(Reading& reading, const SectionEntry& e, const std::string& owner) {
  const Bytes stored = reading.stored(e);
  if (!is_zstd(e) && reinterpret_cast<uintptr_t>(stored.data()) % kUnitAlignment == 0) return stored;
  AlignedBytes copy = section_bytes(reading.file, e);
  const Bytes bytes{copy.data.get(), copy.size};
  if (copy.size != e.logical_size) return reading.report(FindingId::decompression, e.offset, owner), Bytes{};
  if (reading.checksums() && is_zstd(e) && checksum(bytes) != e.logical_xxh3)
    return reading.report(FindingId::logical_checksum, e.offset, owner), Bytes{};
  reading.contents.inflated.push_back(std::move(copy));
  return bytes;
}

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

AlignedBytes section_bytes(Bytes file, const SectionEntry& section) {
  assert(section.offset <= file.size() && section.stored_size <= file.size() - section.offset);
  AlignedBytes out = allocate_aligned(section.logical_size);
  if (!out.data) return {};
  const std::byte* stored = file.data() + section.offset;
  if (!is_zstd(section)) {
    assert(section.stored_size == section.logical_size);
    std::memcpy(out.data.get(), stored, section.logical_size);
    return out;
  }
  const size_t size = ZSTD_decompress(out.data.get(), out.size, stored, section.stored_size);
  return ZSTD_isError(size) || size != section.logical_size ? AlignedBytes{} : std::move(out);
}

}  // namespace vcd
