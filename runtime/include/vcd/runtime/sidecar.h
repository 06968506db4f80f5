// Opens .vcd sidecars and answers segments. This header and a few kilobytes of code are all that a renderer needs.
//
//   auto sidecar = vcd::Sidecar::open("tree.vcd");
//   if (!sidecar) return fail(sidecar.error().message);
//   vcd::Object tree = sidecar->object(0);
//   bool dark = tree.occluded(segment, [&] { return my_bvh_occluded(segment); });
//
// Threads: everything is immutable after open(); any number of threads may query at once without locks.
// Queries never allocate, throw or touch global state.
#pragma once

#include <array>
#include <cstddef>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <vcd/format/bytes.h>
#include <vcd/format/error.h>
#include <vcd/format/layout.h>
#include <vcd/format/segment.h>
#include <vcd/runtime/bundle.h>
#include <vcd/runtime/look_up_policy.h>
#include <vcd/runtime/segment_arrays.h>
#include <vcd/runtime/version.h>

namespace vcd {

struct ObjectData;       // private: what a query needs, in one place
struct SidecarContents;  // <vcd/format/contents.h>

// One object of an open sidecar: a pointer, to be passed by value. Valid as long as its Sidecar lives (moving the
// Sidecar is fine). All coordinates are in the object's own frame, before any instance transform.
class Object {
 public:
  // Is the segment blocked by this object? See spec/conventions.md for every corner case.
  // Any bit pattern is allowed in the segment; what is doubtful is unclassified.
  Visibility classify(const Segment& segment) const noexcept;

  // The same for an array. answers.size() must be at least segments.size() (asserted); answers[i] is segments[i]'s.
  void classify(std::span<const Segment> segments, std::span<Visibility> answers) const noexcept;
  void classify(const SegmentArrays& segments, std::span<Visibility> answers) const noexcept;

  // The same for segments from one point to samples of one light: see <vcd/runtime/bundle.h>. Bit i % 64 of word i / 64
  // of `blocked` says that sample i is blocked, of `unclassified` that it is that; neither: clear. Both need (size() +
  // 63) / 64 words; bits past the last sample become 0.
  void classify(const QuadBundle& bundle, std::span<uint64_t> blocked, std::span<uint64_t> unclassified) const noexcept;
  void classify(const SphereBundle& bundle, std::span<uint64_t> blocked,
                std::span<uint64_t> unclassified) const noexcept;

  // Whether the segment is blocked, with `fallback() -> bool` asked for unclassified segments only.
  template <class Fallback>
  bool occluded(const Segment& segment, Fallback&& fallback) const {
    const Visibility answer = classify(segment);
    return answer == Visibility::unclassified ? static_cast<bool>(std::forward<Fallback>(fallback)())
                                              : answer == Visibility::blocked;
  }

  // Whether the object blocks the segment, with no fallback: what no look-up decides, its hierarchy of triangles does,
  // and exactly (<vcd/format/meets.h>). So of a proven object every answer is that of real arithmetic on these floats,
  // whatever the kernel, and one by one or many together. Needs has_hierarchy(); without one it ends the program with a
  // message.
  //
  // from  where segments begin. It says whether to look up before the hierarchy is asked (OpenOptions::look_up), and
  //       changes no answer but those by statistics.
  bool occluded(const Segment& segment, From from = From::outside) const noexcept;
  // Bit i % 64 of word i / 64 of `blocked` says that segment i is blocked; it needs (size + 63) / 64 words.
  void occluded(std::span<const Segment> segments, std::span<uint64_t> blocked,
                From from = From::outside) const noexcept;
  void occluded(const QuadBundle& bundle, std::span<uint64_t> blocked, From from = From::outside) const noexcept;
  void occluded(const SphereBundle& bundle, std::span<uint64_t> blocked, From from = From::outside) const noexcept;
  void occluded(const PointBundle& bundle, std::span<uint64_t> blocked, From from = From::outside) const noexcept;
  // Whether the file holds the object's triangles in a hierarchy. The baker stores one unless it is told not to, the
  // file's budget has no room for it, or the coordinates are out of its range: ask before occluded() above.
  bool has_hierarchy() const noexcept;

  // Segments that begin on the object itself, on a triangle that the renderer can name: the file's horizons prove most
  // of those clear that leave a compact object (spec/conventions.md, 25 to 30). The answer is clear or unclassified.
  // Whatever is given, it is never wrong: what does not begin above the triangle is unclassified, and so is everything
  // where there are no horizons.
  //
  // primitive  the triangle's number in the source mesh, as ingest() gives it; for arrays as many as segments
  // (asserted)
  Visibility classify_self(const Segment& segment, uint32_t primitive) const noexcept;
  void classify_self(std::span<const Segment> segments, std::span<const uint32_t> primitives,
                     std::span<Visibility> answers) const noexcept;
  // Bit i % 64 of word i / 64 says that sample i is unclassified; the others are clear.
  void classify_self(const QuadBundle& bundle, uint32_t primitive, std::span<uint64_t> unclassified) const noexcept;
  void classify_self(const SphereBundle& bundle, uint32_t primitive, std::span<uint64_t> unclassified) const noexcept;
  void classify_self(const PointBundle& bundle, uint32_t primitive, std::span<uint64_t> unclassified) const noexcept;
  // The same, and what horizons leave unclassified the hierarchy decides. Needs has_hierarchy().
  bool occluded_self(const Segment& segment, uint32_t primitive) const noexcept;
  void occluded_self(std::span<const Segment> segments, std::span<const uint32_t> primitives,
                     std::span<uint64_t> blocked) const noexcept;
  void occluded_self(const QuadBundle& bundle, uint32_t primitive, std::span<uint64_t> blocked) const noexcept;
  void occluded_self(const SphereBundle& bundle, uint32_t primitive, std::span<uint64_t> blocked) const noexcept;
  void occluded_self(const PointBundle& bundle, uint32_t primitive, std::span<uint64_t> blocked) const noexcept;
  // Whether the file holds horizons: the baker stores them if it is told to and they answer enough. Without them there
  // is no need to ask.
  bool has_horizons() const noexcept;

  std::string_view name() const noexcept;  // UTF-8; empty where the source had none
  // False: every segment is unclassified (the baker found that look-ups would not pay, or OpenOptions refuse what it
  // has), so there is no need to ask.
  bool answers() const noexcept;
  const ObjectRecord& record() const noexcept;  // box, depth, method, hash, counts: <vcd/format/layout.h>

 private:
  friend class Scene;
  friend class Sidecar;
  explicit Object(const ObjectData* data) : data_(data) {}
  const ObjectData* data_;
};

// Whether Object::occluded() and Scene::occluded() look up before they ask a hierarchy.
enum class LookUpFirst : uint8_t {
  as_baked,  // where the baker found that it saves time: for segments from outside, from inside the box, or neither;
             // one by one, in arrays and in bundles
  always,    // except for segments that begin on the object itself: look-ups say next to nothing of them
  never,
};

enum class Load {
  map,   // memory-map: pages are read when first touched. For files that nobody truncates or rewrites in place
         // (a truncated map raises SIGBUS). vcd's own programs replace files by renaming, which is safe.
  copy,  // read into memory first: for storage that others may rewrite
};

struct OpenOptions {
  Load load = Load::map;
  // checksums reads the whole file once. bounds reads the tables and indices only: queries are memory-safe on any
  // bytes, but damage to the cells themselves is not noticed. See <vcd/format/bytes.h>.
  CheckLevel check = CheckLevel::checksums;
  // Trust proofs only: cells that are blocked by statistics alone are unclassified, and so is everything of objects
  // that were baked by sampling. Costs nothing in a query.
  bool proven_only = false;
  LookUpFirst look_up = LookUpFirst::as_baked;
  // What classifies arrays and bundles, and traces hierarchies: one of kernels(); empty: the fastest.
  std::string kernel = {};
};

// The kernels that this processor can run, fastest first: "AVX3" (AVX-512), "AVX2", "SSE4" or "NEON", and last
// "scalar". All give the same answers, but that "scalar" decides no bundle as a whole.
std::vector<std::string> kernels();

class Sidecar {
 public:
  // Opens a file. Errors: io (cannot be opened or read), invalid_file or unsupported (the first finding, see
  // <vcd/format/findings.h>), runtime (out of memory). The message names the file, the byte and the reason.
  static Result<Sidecar> open(const std::filesystem::path& path, const OpenOptions& options = {});

  // Opens a file that is already in memory, without a copy where bytes.data() is 64-byte aligned (else trees are
  // copied). The caller keeps the bytes alive and unchanged as long as the Sidecar lives; 8-byte alignment is needed.
  // options.load does not matter.
  static Result<Sidecar> open_buffer(Bytes bytes, const OpenOptions& options = {});

  Sidecar(Sidecar&&) noexcept;
  Sidecar& operator=(Sidecar&&) noexcept;
  ~Sidecar();

  size_t object_count() const noexcept;
  Object object(size_t index) const noexcept;  // index < object_count()

  // The first object of that name or geometry hash, in file order. Linear in the number of objects: look up once.
  std::optional<Object> find(std::string_view name) const noexcept;
  std::optional<Object> find(const std::array<uint8_t, 16>& geometry_hash) const noexcept;

  std::string_view kernel() const noexcept;          // the one in use
  const SidecarContents& contents() const noexcept;  // sections and provenance

 private:
  struct State;
  explicit Sidecar(std::unique_ptr<State> state);
  static Result<Sidecar> read(std::unique_ptr<State> state, Bytes bytes, const OpenOptions& options,
                              const std::string& name);
  std::unique_ptr<State> state_;
};

}  // namespace vcd
