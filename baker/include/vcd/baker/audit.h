// Does a sidecar keep its promises? Fresh lines, asked, and judged exactly.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include <vcd/baker/prepare.h>
#include <vcd/format/error.h>
#include <vcd/format/segment.h>

namespace vcd::baker {

// How the lines of an audit are chosen. All are segments in the object's frame. Of every kind but inside, a tenth come
// from far away (1 to 500 boxes, log-uniformly; the others from a few boxes at most), and a twentieth run along an
// axis.
enum class AuditKind : uint8_t {
  uniform,   // lines through two points that are uniform on two faces of the box: what the cells measure
  chords,    // isotropic lines: what light from all around sends through the box
  inside,    // from a point of the mesh outwards: an end inside the box
  edges,     // through a random point of a random edge, as nearly as floats allow
  vertices,  // through a random vertex, likewise
};
inline constexpr size_t kAuditKinds = 5;
const char* audit_kind_name(AuditKind kind);
inline bool is_aimed(AuditKind kind) { return kind >= AuditKind::inside; }  // the others do not look at the mesh

struct AuditCounts {
  uint64_t segments = 0;
  uint64_t answered[2] = {};  // clear, blocked
  uint64_t wrong[2] = {};     // clear but the segment meets the mesh; blocked but it does not
  uint64_t wrong_proven = 0;  // of the wrong ones, those that were given as proven

  AuditCounts& operator+=(const AuditCounts& other);
  uint64_t all_wrong() const { return wrong[0] + wrong[1]; }
};

struct Contradiction {
  AuditKind kind;
  Segment segment;
  Visibility promised;  // clear or blocked; the mesh says otherwise
  bool proven;
};

struct AuditReport {
  AuditCounts counts[kAuditKinds];
  std::vector<Contradiction> contradictions;  // the first wrong answers, at most AuditOptions::keep

  AuditCounts sum(bool aimed) const;  // of the kinds that are aimed, or of those that are not
};

struct AuditOptions {
  uint64_t lines = 1000000;         // in all: a third uniform, a third chords, the rest aimed, in equal parts
  uint64_t seed = 1;                // independent of the bake's random numbers whatever its seed
  size_t keep = 10;                 // wrong answers to report, at most
  std::function<bool()> stop = {};  // asked now and then, from many threads; true: the rest is not asked
};

// What is under audit answers segments[i] by answers[i]; asked from many threads at once.
using Answers = std::function<void(std::span<const Segment>, std::span<Visibility>)>;

// Asks `answers` and holds each clear or blocked answer against the referee: against exact arithmetic in the object's
// own frame, so that nothing that a bake rests on (Embree, the mapping to the grid, rounding) can hide a fault. proven:
// what is answered where proofs alone are trusted, asked for wrong answers only. The same mesh, answers and options
// give the same report.
AuditReport audit(const PreparedMesh& mesh, const Answers& answers, const Answers& proven, const AuditOptions& options);

// A segment as text, "ox,oy,oz,t_min,dx,dy,dz,t_max", with digits enough to be read back exactly: what the programs'
// --segment takes.
std::string replayable(const Segment& segment);
// False if the text is not eight numbers.
bool parse_segment(const std::string& text, Segment& segment);

// `count` segments of one kind, as an audit draws them.
std::vector<Segment> audit_segments(const PreparedMesh& mesh, AuditKind kind, uint64_t seed, uint64_t count);

// Ends of the one-sided 95 % confidence intervals of a rate of which `wrong` of `all` were seen (Poisson, exact).
double upper_bound_95(uint64_t wrong, uint64_t all);
double lower_bound_95(uint64_t wrong, uint64_t all);

}  // namespace vcd::baker
