// Does a tree keep its promises? Fresh lines, asked and traced.
#pragma once

#include <cstdint>
#include <vector>

#include <vcd/baker/prepare.h>
#include <vcd/format/error.h>
#include <vcd/format/layout.h>
#include <vcd/format/segment.h>
#include <vcd/format/tree.h>

namespace vcd {

// How the lines of an audit are chosen. All are segments in the object's frame, from origins up to a few boxes away.
enum class AuditKind : uint8_t {
  uniform,     // lines through two points that are uniform on two faces of the box: what the cells measure
  chords,      // isotropic lines: what light from all around sends through the box
  inside,      // from a point of the mesh outwards: an end inside the box
  edges,       // through a random point of a random edge
  vertices,    // through a random vertex
};
inline constexpr size_t kAuditKinds = 5;
const char* audit_kind_name(AuditKind kind);

struct AuditCounts {
  uint64_t segments = 0;
  uint64_t answered[2] = {};  // clear, blocked
  uint64_t wrong[2] = {};     // clear but traced blocked, blocked but traced clear
};

struct Contradiction {
  AuditKind kind;
  Segment segment;
  Visibility promised;  // clear or blocked; the trace says otherwise
};

struct AuditReport {
  AuditCounts counts[kAuditKinds];
  std::vector<Contradiction> contradictions;  // the first of them, at most AuditOptions::keep
};

struct AuditOptions {
  uint64_t lines = 1000000;  // of kinds uniform and chords, each; half as many of each other kind
  uint64_t seed = 1;         // independent of the bake's random numbers whatever its seed
  size_t keep = 10;
};

// The same mesh, record and options give the same report. mesh must be the one whose hash the record holds.
// Errors: runtime (Embree out of memory).
Result<AuditReport> audit(const PreparedMesh& mesh, const ObjectRecord& record, const TreeView& tree,
                          const AuditOptions& options);

// `count` segments of one kind, as an audit draws them.
std::vector<Segment> audit_segments(const PreparedMesh& mesh, AuditKind kind, uint64_t seed, uint64_t count);

// Whether one segment, in the object's frame, meets the mesh.
Result<bool> trace_segment(const PreparedMesh& mesh, const Segment& segment);

// Upper end of the one-sided 95 % confidence interval of a rate of which `wrong` of `all` were seen (Poisson, exact).
double upper_bound_95(uint64_t wrong, uint64_t all);

}  // namespace vcd
