// The bytes of a .vcd file, shared by reader, writer and validator. Normative text: spec/vcd-format.md.
// All numbers are little-endian; all structs below are exactly the bytes on disk.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace vcd {

static_assert(std::endian::native == std::endian::little,
              "vcd reads and writes its files in place: little-endian only");

// Like PNG's: the high bit catches 7-bit transfers, CR LF and LF catch line-ending translation, 0x1A stops `type`.
inline constexpr std::array<uint8_t, 8> kMagic = {0x89, 'V', 'C', 'D', '\r', '\n', 0x1A, '\n'};
inline constexpr std::string_view kSidecarBegin = "\x89VCD\r\n\x1A\n";  // the same bytes as a text
inline constexpr uint16_t kVersionMajor = 1;                            // the only one that is read
inline constexpr uint16_t kVersionMinor = 2;

struct FileHeader {
  std::array<uint8_t, 8> magic;
  uint16_t version_major;
  uint16_t version_minor;
  uint32_t section_count;
  uint64_t file_size;           // of the whole file, bytes
  uint64_t section_table_xxh3;  // XXH3-64 of the section table that follows this header
  uint8_t reserved[24];         // zero
  uint64_t header_xxh3;         // XXH3-64 of the 56 bytes above
};
static_assert(sizeof(FileHeader) == 64 && offsetof(FileHeader, version_major) == 8 &&
              offsetof(FileHeader, section_count) == 12 && offsetof(FileHeader, file_size) == 16 &&
              offsetof(FileHeader, section_table_xxh3) == 24 && offsetof(FileHeader, reserved) == 32 &&
              offsetof(FileHeader, header_xxh3) == 56);

constexpr uint32_t section_type(const char (&name)[5]) {
  return static_cast<uint32_t>(static_cast<uint8_t>(name[0])) |
         static_cast<uint32_t>(static_cast<uint8_t>(name[1])) << 8 |
         static_cast<uint32_t>(static_cast<uint8_t>(name[2])) << 16 |
         static_cast<uint32_t>(static_cast<uint8_t>(name[3])) << 24;
}
inline constexpr uint32_t kSectionObjects = section_type("OBJT");     // critical, one: ObjectRecord[]
inline constexpr uint32_t kSectionNames = section_type("NAME");       // critical, one: UTF-8 bytes of the object names
inline constexpr uint32_t kSectionProvenance = section_type("PROV");  // optional, at most one: sorted key/value pairs
inline constexpr uint32_t kSectionTree = section_type("TREE");  // critical, one an object, but none for Method::none
inline constexpr uint32_t kSectionGeometry = section_type("GEOM");   // optional, at most one an object: Draco bytes
inline constexpr uint32_t kSectionClearance = section_type("CLEA");  // optional, at most one an object: bytes

inline constexpr uint32_t kSectionHierarchy = section_type("HIER");  // optional, at most one an object: hierarchy.h
inline constexpr uint32_t kSectionHorizon = section_type("HORZ");    // optional, at most one an object: horizon.h

constexpr bool is_known_section(uint32_t type) {
  return type == kSectionObjects || type == kSectionNames || type == kSectionProvenance || type == kSectionTree ||
         type == kSectionGeometry || type == kSectionClearance || type == kSectionHierarchy || type == kSectionHorizon;
}

// A CLEA section divides each face of the box into 16 × 16 squares and gives each square a byte, its clearance: nothing
// of the mesh is within so many grid units, in all three coordinates, of any point of the square. Face by face;
// row-major, the face's first axis first.
inline constexpr uint32_t kClearanceSquares = 16;
inline constexpr size_t kClearanceBytes = 6 * kClearanceSquares * kClearanceSquares;

inline constexpr uint32_t kSectionCritical = 1;  // SectionEntry::flags: a reader that does not know the type must stop
inline constexpr uint32_t kNone = 0xFFFFFFFF;    // SectionEntry::object, ObjectRecord::{tree,geometry}_section

enum class Storage : uint32_t { raw = 0, zstd = 1 };

struct SectionEntry {
  uint32_t type;
  uint32_t flags;
  uint32_t object;        // index of the object that the section belongs to, or kNone
  uint32_t storage;       // Storage
  uint64_t offset;        // from the start of the file; a multiple of alignment
  uint64_t stored_size;   // bytes in the file
  uint64_t logical_size;  // bytes after decompression
  uint64_t stored_xxh3;   // XXH3-64 of the stored bytes
  uint64_t logical_xxh3;  // XXH3-64 of the logical bytes
  uint32_t alignment;     // 8, 64 or 4096
  uint32_t reserved;      // zero
};
static_assert(sizeof(SectionEntry) == 64 && offsetof(SectionEntry, object) == 8 &&
              offsetof(SectionEntry, storage) == 12 && offsetof(SectionEntry, offset) == 16 &&
              offsetof(SectionEntry, stored_size) == 24 && offsetof(SectionEntry, logical_size) == 32 &&
              offsetof(SectionEntry, stored_xxh3) == 40 && offsetof(SectionEntry, logical_xxh3) == 48 &&
              offsetof(SectionEntry, alignment) == 56 && offsetof(SectionEntry, reserved) == 60);

inline constexpr uint32_t kSmallAlignment = 8;
inline constexpr uint32_t kUnitAlignment = 64;    // of raw HIER and HORZ sections, which are mapped and used in place
inline constexpr uint32_t kPageAlignment = 4096;  // of raw TREE sections, which are mapped and used in place

// What zstd sections may claim, so that a small file cannot ask for a large allocation: each by itself, and all of a
// file together.
constexpr uint64_t largest_logical_size(uint64_t stored_size) { return (uint64_t{1} << 20) + 256 * stored_size; }
constexpr uint64_t largest_logical_total(uint64_t file_size) { return (uint64_t{64} << 20) + 256 * file_size; }

enum class Method : uint8_t {
  none = 0,     // a sidecar would not pay: every segment is unclassified, and no tree is stored
  sampled = 1,  // clear and blocked where all sample lines were; both may be wrong
  proven = 2,   // clear and blocked are proofs
  hybrid = 3,   // as proven, and a class of its own for cells whose sample lines were all blocked
};

// ObjectRecord::flags. The other bits are zero.
inline constexpr uint16_t kPartsLeftOut = 1;  // parts of the source mesh are not in the object: see the provenance
// Where a HIER section holds the object's triangles: look-ups before it save time for segments from outside the box, or
// from inside: as arrays; together, as bundles (since format 1.1: before, the first two say it); and one by one, which
// arrays are too where the object is an instance of a scene (since format 1.2: before, the first two say it of segments
// in the object's own frame, and in scenes those of bundles from outside).
inline constexpr uint16_t kLookUpFromOutside = 2, kLookUpFromInside = 4;
inline constexpr uint16_t kLookUpTogetherFromOutside = 8, kLookUpTogetherFromInside = 16;
inline constexpr uint16_t kLookUpOneFromOutside = 32, kLookUpOneFromInside = 64;
constexpr uint16_t known_object_flags(uint16_t version_minor) {
  return kPartsLeftOut | kLookUpFromOutside | kLookUpFromInside |
         (version_minor > 0 ? kLookUpTogetherFromOutside | kLookUpTogetherFromInside : 0) |
         (version_minor > 1 ? kLookUpOneFromOutside | kLookUpOneFromInside : 0);
}

inline constexpr uint32_t kMostBlockLevels = 3;

struct ObjectRecord {
  uint32_t name_offset;   // into the NAME section
  uint32_t name_length;   // bytes; 0 for an object without a name
  uint32_t source_index;  // of the mesh in its source file
  uint8_t depth;          // 1 … 8
  uint8_t method;         // Method
  uint16_t flags;         // known_object_flags()
  float box_min[3];       // the padded box, object frame
  float box_max[3];
  std::array<uint8_t, 16> geometry_hash;  // canonical XXH3-128 of the welded mesh, most significant byte first
  uint64_t triangle_count;                // of the welded mesh
  uint64_t vertex_count;
  uint64_t cells[3];          // clear, blocked, unclassified cells of the deepest stored level
  uint32_t tree_section;      // index into the section table; kNone for Method::none
  uint32_t geometry_section;  // likewise; kNone where no geometry is embedded
  std::array<uint32_t, kMostBlockLevels> block_counts;  // of each level's pool in the TREE section; 0: it has none
  uint32_t brick_count;
  uint32_t reserved[2];     // zero
  uint64_t nodes_unfolded;  // of the octree as the paper counts: every node a 32-bit word
  uint64_t nodes_folded;    // with sixteen leaf children folded into their parent's word
  uint64_t nodes_shared;    // and identical groups of sixteen children stored once
  // Samples a cell (hybrid: of the statistical tier; proven: 0), seed (low word, high word).
  uint32_t method_parameters[8];
  uint64_t statistical_cells;  // of class 3; with cells[], 15 * 16^levels
  uint64_t audit_lines[2];     // asked after the bake: undirected, and aimed at the mesh; 0: not audited
  uint64_t audit_wrong[2];     // of them answered wrongly; proven: none
  float audit_bound_95;        // one-sided 95 % bound of the rate of wrong undirected lines; 0: not audited
  float guard_band;            // of the proofs, grid units; else 0
  double shift[3];  // subtracted from the source's coordinates: x of the object + shift[0] is x of the source
};
static_assert(sizeof(ObjectRecord) == 256 && offsetof(ObjectRecord, source_index) == 8 &&
              offsetof(ObjectRecord, depth) == 12 && offsetof(ObjectRecord, flags) == 14 &&
              offsetof(ObjectRecord, box_min) == 16 && offsetof(ObjectRecord, geometry_hash) == 40 &&
              offsetof(ObjectRecord, triangle_count) == 56 && offsetof(ObjectRecord, cells) == 72 &&
              offsetof(ObjectRecord, tree_section) == 96 && offsetof(ObjectRecord, block_counts) == 104 &&
              offsetof(ObjectRecord, nodes_unfolded) == 128 && offsetof(ObjectRecord, method_parameters) == 152 &&
              offsetof(ObjectRecord, statistical_cells) == 184 && offsetof(ObjectRecord, audit_lines) == 192 &&
              offsetof(ObjectRecord, audit_bound_95) == 224 && offsetof(ObjectRecord, guard_band) == 228 &&
              offsetof(ObjectRecord, shift) == 232);

}  // namespace vcd
