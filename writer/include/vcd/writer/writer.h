// What is to be stored → a .vcd file. Renderers do not need this library: <vcd/format/contents.h> reads.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <vcd/format/contents.h>
#include <vcd/format/error.h>

namespace vcd {

struct ObjectToWrite {
  std::string_view name;
  ObjectRecord record{};    // the writer fills in the name's place and the section indices; the rest is the caller's
  std::vector<Bytes> tree;  // the TREE section's logical bytes, in pieces; not looked at for Method::none
  Bytes geometry;           // Draco bytes or empty
  Bytes hierarchy = {};     // the HIER section, or empty: its triangles are those of the record
  Bytes clearance = {};     // must be kClearanceBytes bytes or empty
  Bytes horizon = {};       // the HORZ section of the object with that hierarchy, or empty
};
struct OptionalSection {  // one of a type this version does not know, carried along
  SectionEntry entry{};   // type, flags, object and alignment are kept
  Bytes logical;
};

struct SidecarToWrite {
  std::vector<ObjectToWrite> objects;
  std::map<std::string, std::string> provenance;
  std::vector<OptionalSection> others;
  Storage storage = Storage::raw;  // zstd: compress what gains by it, align sections to 8 bytes; to ship, not to render
  int zstd_level = 19;
  std::function<bool()> stop;  // asked now and then; true ends the writing with an error and no file
};

// The TREE section's logical bytes of a tree in memory, in pieces that point into it. tree.top must have
// shape.top_bytes() bytes: the words, then the spare slot and padding, which must be zero.
std::vector<Bytes> tree_pieces(const TreeView& tree);

// Writes the file beside `path` (AtomicFile), flushes it to disk, reads it back and checks it (CheckLevel::canonical),
// and puts it in the place of `path`, so that a reader sees the old file or the new one, and an error leaves nothing
// behind. Returns the file's size. Errors: io, naming the file and the system's reason, or what the check found; usage
// (a key that is not UTF-8, or a clearance of another size); runtime (out of memory, or stopped). The same contents
// always give the same bytes. Bytes of names and provenance values that are not UTF-8 are replaced by U+FFFD; keys must
// be UTF-8.
Result<uint64_t> write_sidecar(const std::filesystem::path& path, const SidecarToWrite& contents);

// The same bytes in memory, ready for Sidecar::open_buffer; they are not checked. Errors: usage and runtime, as above.
Result<AlignedBytes> sidecar_bytes(const SidecarToWrite& contents);

}  // namespace vcd
