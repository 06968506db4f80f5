#include <vcd/writer/writer.h>

#include <algorithm>
#include <cassert>
#include <cstring>
#include <exception>
#include <memory>

#include <zstd.h>

#include <vcd/format/checksum.h>
#include <vcd/format/utf8.h>
#include <vcd/writer/atomic_file.h>

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
  const auto put = [&](Bytes bytes) {
    out.resize(out.size() + bytes.size());
    std::ranges::copy(bytes, out.end() - static_cast<std::ptrdiff_t>(bytes.size()));
  };
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
  const bool in_units = e.type == kSectionHierarchy || e.type == kSectionHorizon;
  const bool compressible = e.type == kSectionTree || in_units || !is_known_section(e.type);
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
  e.alignment = e.type == kSectionTree ? kPageAlignment
                : in_units             ? kUnitAlignment
                                       : std::max(e.alignment, kSmallAlignment);
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

// What is wrong with the contents; null if nothing is that is looked at before they are written.
const char* fault_of(const SidecarToWrite& contents) {
  for (const auto& [key, value] : contents.provenance)
    if (!is_utf8(key)) return "a key of the provenance is not UTF-8";
  for (const ObjectToWrite& object : contents.objects)
    if (!object.clearance.empty() && object.clearance.size() != kClearanceBytes)
      return "the clearance of an object is not of kClearanceBytes bytes";
  return nullptr;
}

// All bytes of a file, in place or ready to be made.
class Layout {
 public:
  // False if contents.stop stopped it.
  bool make(const SidecarToWrite& contents);
  uint64_t size() const { return header_.file_size; }

  // put(Bytes) for one piece after the other. False if stop stopped it.
  template <class Put>
  bool emit(const std::function<bool()>& stop, const Put& put) const {
    static constexpr std::byte kZeros[kPageAlignment] = {};
    put(bytes_of(header_));
    put(std::as_bytes(std::span(table_)));
    uint64_t end = sizeof header_ + table_.size() * sizeof(SectionEntry);
    for (const Section& section : sections_) {
      if (stop && stop()) return false;
      put(Bytes(kZeros, section.entry.offset - end));
      if (!section.compressed.empty()) put(Bytes(section.compressed));
      else
        for (Bytes piece : section.pieces) put(piece);
      end = section.entry.offset + section.entry.stored_size;
    }
    return true;
  }

 private:
  FileHeader header_{};
  std::vector<SectionEntry> table_;
  std::vector<Section> sections_;
  std::vector<ObjectRecord> records_;
  std::string names_;
  std::vector<std::byte> provenance_;
};

bool Layout::make(const SidecarToWrite& contents) {
  for (const ObjectToWrite& object : contents.objects) {
    ObjectRecord record = object.record;
    const std::string name = make_utf8(object.name);
    record.name_offset = static_cast<uint32_t>(names_.size());
    record.name_length = static_cast<uint32_t>(name.size());
    names_ += name;
    records_.push_back(record);
  }
  provenance_ = encode_provenance(contents.provenance);

  sections_.push_back(make_section(kSectionObjects, kSectionCritical, kNone, {std::as_bytes(std::span(records_))}));
  sections_.push_back(make_section(kSectionNames, kSectionCritical, kNone, {std::as_bytes(std::span(names_))}));
  sections_.push_back(make_section(kSectionProvenance, 0, kNone, {provenance_}));
  for (uint32_t i = 0; i < contents.objects.size(); ++i) {
    const ObjectToWrite& object = contents.objects[i];
    const auto add = [&](uint32_t type, uint32_t flags, std::vector<Bytes> pieces) {
      sections_.push_back(make_section(type, flags, i, std::move(pieces)));
      return static_cast<uint32_t>(sections_.size() - 1);
    };
    const bool has_tree = object.record.method != static_cast<uint8_t>(Method::none);
    records_[i].tree_section = has_tree ? add(kSectionTree, kSectionCritical, object.tree) : kNone;
    if (!object.hierarchy.empty()) add(kSectionHierarchy, 0, {object.hierarchy});
    if (!object.horizon.empty()) add(kSectionHorizon, 0, {object.horizon});
    if (!object.clearance.empty()) add(kSectionClearance, 0, {object.clearance});
    records_[i].geometry_section = object.geometry.empty() ? kNone : add(kSectionGeometry, 0, {object.geometry});
  }
  for (const OptionalSection& other : contents.others) {
    sections_.push_back(make_section(other.entry.type, other.entry.flags, other.entry.object, {other.logical}));
    sections_.back().entry.alignment = other.entry.alignment;
  }

  uint64_t budget = largest_logical_total(0);
  uint64_t end = sizeof(FileHeader) + sections_.size() * sizeof(SectionEntry);
  for (Section& section : sections_) {
    if (contents.stop && contents.stop()) return false;
    store(section, contents, budget);
    SectionEntry& e = section.entry;
    e.offset = (end + e.alignment - 1) / e.alignment * e.alignment;
    end = e.offset + e.stored_size;
    table_.push_back(e);
  }
  header_.magic = kMagic;
  header_.version_major = kVersionMajor;
  header_.version_minor = kVersionMinor;
  header_.section_count = static_cast<uint32_t>(table_.size());
  header_.file_size = end;
  header_.section_table_xxh3 = checksum(std::as_bytes(std::span(table_)));
  header_.header_xxh3 = checksum(bytes_of(header_).first(offsetof(FileHeader, header_xxh3)));
  return true;
}

}  // namespace

std::vector<Bytes> tree_pieces(const TreeView& tree) {
  assert(tree.top[tree.shape.top_words()] == 0);
  const auto piece = [](const void* data, uint64_t size) { return Bytes(static_cast<const std::byte*>(data), size); };
  std::vector<Bytes> pieces = {piece(tree.top, tree.shape.top_bytes())};
  for (uint32_t k = 0; k < tree.shape.block_levels; ++k)
    pieces.push_back(piece(tree.blocks[k], tree.block_counts[k] * kBlockBytes));
  pieces.push_back(piece(tree.bricks, tree.brick_count * kBrickBytes));
  return pieces;
}

Result<uint64_t> write_sidecar(const std::filesystem::path& path, const SidecarToWrite& contents) try {
  if (const char* fault = fault_of(contents)) return Error{ErrorCode::usage, path.string() + ": " + fault};
  const Error stopped{ErrorCode::runtime, path.string() + ": stopped"};
  Layout layout;
  if (!layout.make(contents)) return stopped;
  AtomicFile file(path, kSidecarBegin);
  if (!layout.emit(contents.stop, [&](Bytes bytes) { file.append(bytes); })) return stopped;
  if (contents.stop && contents.stop()) return stopped;
  return file.commit([](Bytes bytes) -> std::string {
    std::vector<Finding> findings;
    read_sidecar(bytes, CheckLevel::canonical, findings);
    for (const Finding& finding : findings)
      if (finding_info(finding.id).severity == Severity::error) return describe(finding);
    return {};
  });
} catch (const std::exception& e) {  // out of memory, no random numbers for a temporary name
  return Error{ErrorCode::runtime, path.string() + ": cannot write: " + e.what()};
}

Result<AlignedBytes> sidecar_bytes(const SidecarToWrite& contents) try {
  if (const char* fault = fault_of(contents)) return Error{ErrorCode::usage, fault};
  Layout layout;
  if (!layout.make(contents)) return Error{ErrorCode::runtime, "stopped"};
  AlignedBytes file = allocate_aligned(layout.size());
  if (!file.data) return Error{ErrorCode::runtime, "out of memory"};
  size_t at = 0;
  layout.emit({}, [&](Bytes bytes) {
    if (!bytes.empty()) std::memcpy(file.data.get() + at, bytes.data(), bytes.size());
    at += bytes.size();
  });
  return file;
} catch (const std::bad_alloc&) {
  return Error{ErrorCode::runtime, "out of memory"};
}

}  // namespace vcd
