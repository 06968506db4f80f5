#include <vcd/format/writer.h>

#include <algorithm>
#include <exception>
#include <memory>

#include <zstd.h>

#include <vcd/format/atomic_file.h>
#include "checksum.h"
#include "utf8.h"

namespace vcd {
namespace {

template <class T>
Bytes bytes_of(const T& value) {
  return std::as_bytes(std::span(&value, 1));
}

struct Section {
  SectionEntry entry{};
  std::vector<Bytes> pieces;          // logical bytes
  std::vector<std::byte> compressed;  // in use when entry.storage is zstd
};

std::vector<std::byte> encode_provenance(const std::map<std::string, std::string>& pairs) {
  std::vector<std::byte> out;
  const auto put = [&](Bytes bytes) { out.insert(out.end(), bytes.begin(), bytes.end()); };
  const auto put_number = [&](size_t n) { put(bytes_of(static_cast<uint32_t>(n))); };
  put_number(pairs.size());
  for (const auto& [key, raw_value] : pairs) {
    const std::string value = make_utf8(raw_value);
    put_number(key.size());
    put_number(value.size());
    put(std::as_bytes(std::span(key)));
    put(std::as_bytes(std::span(value)));
  }
  return out;
}

// One zstd frame with its content size. Empty on failure, or when stopped.
std::vector<std::byte> compress(std::span<const Bytes> pieces, uint64_t logical_size, int level,
                                const std::function<bool()>& stop) {
  const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(), ZSTD_freeCCtx);
  ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, level);
  ZSTD_CCtx_setPledgedSrcSize(context.get(), logical_size);
  std::vector<std::byte> out(ZSTD_compressBound(logical_size));
  ZSTD_outBuffer output{out.data(), out.size(), 0};
  size_t left = 0;
  for (Bytes piece : pieces) {
    while (!piece.empty()) {
      if (stop && stop()) return {};
      ZSTD_inBuffer input{piece.data(), std::min(piece.size(), size_t{1} << 20), 0};
      if (ZSTD_isError(ZSTD_compressStream2(context.get(), &output, &input, ZSTD_e_continue))) return {};
      piece = piece.subspan(input.pos);
    }
  }
  ZSTD_inBuffer nothing{nullptr, 0, 0};
  do {
    left = ZSTD_compressStream2(context.get(), &output, &nothing, ZSTD_e_end);
    if (ZSTD_isError(left)) return {};
  } while (left != 0);
  out.resize(output.pos);
  out.shrink_to_fit();
  return out;
}

// Decides raw or zstd for one section and fills in its sizes and checksums. `budget` is what zstd sections may still
// claim (spec: Section table).
void store(Section& section, const SidecarToWrite& contents, uint64_t& budget) {
  SectionEntry& e = section.entry;
  e.logical_size = 0;
  for (Bytes piece : section.pieces) e.logical_size += piece.size();
  e.logical_xxh3 = checksum(section.pieces);
  const bool compressible = e.type == kSectionTree || !is_known_section(e.type);
  if (contents.storage == Storage::zstd && compressible && e.logical_size > 0) {
    section.compressed = compress(section.pieces, e.logical_size, contents.zstd_level, contents.stop);
    const uint64_t size = section.compressed.size();
    budget += largest_logical_total(size) - largest_logical_total(0);
    if (size > 0 && size < e.logical_size && e.logical_size <= largest_logical_size(size) && e.logical_size <= budget) {
      budget -= e.logical_size;
      e.storage = static_cast<uint32_t>(Storage::zstd);
      e.alignment = kSmallAlignment;
      e.stored_size = size;
      e.stored_xxh3 = checksum(section.compressed);
      return;
    }
    section.compressed.clear();
  }
  e.storage = static_cast<uint32_t>(Storage::raw);
  e.alignment = e.type == kSectionTree ? kPageAlignment : std::max(e.alignment, kSmallAlignment);
  e.stored_size = e.logical_size;
  e.stored_xxh3 = e.logical_xxh3;
}

Section make_section(uint32_t type, uint32_t flags, uint32_t object, std::vector<Bytes> pieces) {
  Section section;
  section.entry.type = type;
  section.entry.flags = flags;
  section.entry.object = object;
  section.pieces = std::move(pieces);
  return section;
}

}  // namespace

std::vector<Bytes> tree_pieces(const TreeView& tree) {
  const auto piece = [](const void* data, uint64_t size) { return Bytes(static_cast<const std::byte*>(data), size); };
  return {piece(tree.top, tree.shape.top_bytes()), piece(tree.blocks256, tree.block256_count * kBlock256Words * 4),
          piece(tree.blocks16, tree.block16_count * kBlock16Words * 4),
          piece(tree.bricks, tree.brick_count * kBrickBytes)};
}

Result<uint64_t> write_sidecar(const std::filesystem::path& path, const SidecarToWrite& contents) try {
  std::string names;
  std::vector<ObjectRecord> records;
  for (const ObjectToWrite& object : contents.objects) {
    ObjectRecord record = object.record;
    const std::string name = make_utf8(object.name);
    record.name_offset = static_cast<uint32_t>(names.size());
    record.name_length = static_cast<uint32_t>(name.size());
    names += name;
    records.push_back(record);
  }
  const std::vector<std::byte> provenance = encode_provenance(contents.provenance);

  std::vector<Section> sections;
  sections.push_back(make_section(kSectionObjects, kSectionCritical, kNone, {std::as_bytes(std::span(records))}));
  sections.push_back(make_section(kSectionNames, kSectionCritical, kNone, {std::as_bytes(std::span(names))}));
  sections.push_back(make_section(kSectionProvenance, 0, kNone, {provenance}));
  for (uint32_t i = 0; i < contents.objects.size(); ++i) {
    const ObjectToWrite& object = contents.objects[i];
    records[i].tree_section = static_cast<uint32_t>(sections.size());
    sections.push_back(make_section(kSectionTree, kSectionCritical, i, object.tree));
    records[i].geometry_section = object.geometry.empty() ? kNone : static_cast<uint32_t>(sections.size());
    if (!object.geometry.empty()) sections.push_back(make_section(kSectionGeometry, 0, i, {object.geometry}));
  }
  for (const OptionalSection& other : contents.others) {
    sections.push_back(make_section(other.entry.type, other.entry.flags, other.entry.object, {other.logical}));
    sections.back().entry.alignment = other.entry.alignment;
  }

  uint64_t budget = largest_logical_total(0);
  AtomicFile file(path);
  uint64_t end = sizeof(FileHeader) + sections.size() * sizeof(SectionEntry);
  file.append_zeros(end);
  std::vector<SectionEntry> table;
  for (Section& section : sections) {
    if (contents.stop && contents.stop()) return Error{ErrorCode::runtime, path.string() + ": stopped"};
    store(section, contents, budget);
    SectionEntry& e = section.entry;
    e.offset = (end + e.alignment - 1) / e.alignment * e.alignment;
    file.append_zeros(e.offset - end);
    if (!section.compressed.empty()) {
      file.append(section.compressed);
      section.compressed = {};
    } else {
      for (Bytes piece : section.pieces) file.append(piece);
    }
    end = e.offset + e.stored_size;
    table.push_back(e);
  }

  FileHeader header{};
  header.magic = kMagic;
  header.version_major = kVersionMajor;
  header.version_minor = kVersionMinor;
  header.section_count = static_cast<uint32_t>(table.size());
  header.file_size = end;
  header.section_table_xxh3 = checksum(std::as_bytes(std::span(table)));
  header.header_xxh3 = checksum(bytes_of(header).first(offsetof(FileHeader, header_xxh3)));
  file.overwrite(0, bytes_of(header));
  file.overwrite(sizeof header, std::as_bytes(std::span(table)));
  if (contents.stop && contents.stop()) return Error{ErrorCode::runtime, path.string() + ": stopped"};
  return file.commit();
} catch (const std::exception& e) {  // out of memory, no random numbers for a temporary name
  return Error{ErrorCode::runtime, path.string() + ": cannot write: " + e.what()};
}

}  // namespace vcd
