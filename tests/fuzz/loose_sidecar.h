// A .vcd file as its parts, to be bent and put together again so that offsets, sizes and checksums fit.
#pragma once

#include <algorithm>
#include <cstring>
#include <optional>
#include <span>
#include <vector>

#include <xxhash.h>
#include <zstd.h>

#include <vcd/format/layout.h>

namespace vcd::fuzz {

using Buffer = std::vector<uint8_t>;

struct LooseSection {
  SectionEntry entry;
  Buffer logical;
};

struct LooseSidecar {
  FileHeader header;
  std::vector<LooseSection> sections;
  Buffer tail;  // what follows the file's own size

  // Nothing if the sections cannot be told apart; checksums, order and content do not matter.
  static std::optional<LooseSidecar> parse(std::span<const uint8_t> bytes);
  Buffer join() const;

  LooseSection* first_of(uint32_t type) {
    const auto found = std::ranges::find(sections, type, [](const LooseSection& s) { return s.entry.type; });
    return found == sections.end() ? nullptr : &*found;
  }
};

// Makes the checksums of header, table and sections fit the bytes in place, as far as sections lie in the file.
inline void seal(std::span<uint8_t> file) {
  if (file.size() < sizeof(FileHeader)) return;
  FileHeader header;
  std::memcpy(&header, file.data(), sizeof header);
  const uint64_t count = std::min<uint64_t>(header.section_count, (file.size() - sizeof header) / sizeof(SectionEntry));
  for (uint64_t i = 0; i < count; ++i) {
    uint8_t* at = file.data() + sizeof header + i * sizeof(SectionEntry);
    SectionEntry entry;
    std::memcpy(&entry, at, sizeof entry);
    if (entry.offset > file.size() || entry.stored_size > file.size() - entry.offset) continue;
    entry.stored_xxh3 = XXH3_64bits(file.data() + entry.offset, entry.stored_size);
    if (entry.storage == static_cast<uint32_t>(Storage::raw)) entry.logical_xxh3 = entry.stored_xxh3;
    std::memcpy(at, &entry, sizeof entry);
  }
  header.section_table_xxh3 = XXH3_64bits(file.data() + sizeof header, count * sizeof(SectionEntry));
  header.header_xxh3 = XXH3_64bits(&header, offsetof(FileHeader, header_xxh3));
  std::memcpy(file.data(), &header, sizeof header);
}

inline std::optional<LooseSidecar> LooseSidecar::parse(std::span<const uint8_t> bytes) {
  constexpr uint64_t kLargestSection = 1 << 20;
  LooseSidecar loose;
  if (bytes.size() < sizeof(FileHeader)) return std::nullopt;
  std::memcpy(&loose.header, bytes.data(), sizeof(FileHeader));
  const uint64_t size = std::min<uint64_t>(loose.header.file_size, bytes.size());
  if (size < sizeof(FileHeader) || loose.header.section_count > (size - sizeof(FileHeader)) / sizeof(SectionEntry))
    return std::nullopt;
  loose.sections.resize(loose.header.section_count);
  for (size_t i = 0; i < loose.sections.size(); ++i) {
    auto& [entry, logical] = loose.sections[i];
    std::memcpy(&entry, bytes.data() + sizeof(FileHeader) + i * sizeof entry, sizeof entry);
    if (entry.offset > size || entry.stored_size > size - entry.offset || entry.logical_size > kLargestSection)
      return std::nullopt;
    const uint8_t* stored = bytes.data() + entry.offset;
    logical.assign(stored, stored + entry.stored_size);
    if (entry.storage != static_cast<uint32_t>(Storage::zstd)) continue;
    logical.resize(entry.logical_size);
    if (ZSTD_decompress(logical.data(), logical.size(), stored, entry.stored_size) != logical.size())
      return std::nullopt;
  }
  loose.tail.assign(bytes.begin() + static_cast<std::ptrdiff_t>(size), bytes.end());
  return loose;
}

inline Buffer LooseSidecar::join() const {
  Buffer file(sizeof(FileHeader) + sections.size() * sizeof(SectionEntry));
  for (size_t i = 0; i < sections.size(); ++i) {
    SectionEntry entry = sections[i].entry;
    Buffer stored = sections[i].logical;
    entry.logical_size = stored.size();
    entry.logical_xxh3 = XXH3_64bits(stored.data(), stored.size());
    if (entry.storage == static_cast<uint32_t>(Storage::zstd)) {
      Buffer packed(ZSTD_compressBound(stored.size()));
      packed.resize(ZSTD_compress(packed.data(), packed.size(), stored.data(), stored.size(), 1));
      stored = std::move(packed);
    }
    const uint64_t alignment = entry.alignment == 8 || entry.alignment == 4096 ? entry.alignment : 8;
    entry.offset = (file.size() + alignment - 1) / alignment * alignment;
    entry.stored_size = stored.size();
    file.resize(entry.offset);
    file.insert(file.end(), stored.begin(), stored.end());
    std::memcpy(file.data() + sizeof(FileHeader) + i * sizeof entry, &entry, sizeof entry);
  }
  FileHeader fitting = header;
  fitting.section_count = static_cast<uint32_t>(sections.size());
  fitting.file_size = file.size();
  std::memcpy(file.data(), &fitting, sizeof fitting);
  seal(file);
  file.insert(file.end(), tail.begin(), tail.end());
  return file;
}

}  // namespace vcd::fuzz
