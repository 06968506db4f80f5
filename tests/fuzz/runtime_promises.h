// What the runtime promises of its answers, whatever the tree says: spec/conventions.md, spec/vcd-format.md "The
// answer".
#pragma once

#include <cmath>
#include <vector>

#include <vcd/format/contents.h>
#include <vcd/runtime/sidecar.h>

#include "format/reference_line_cell.h"
#include "fuzz/fuzz.h"
#include "support/segments.h"

namespace vcd::fuzz {

using Answer = Visibility;

// The answer by the spec's text, from the plain twin of the line → cell map.
inline Answer plain_answer(const ObjectContents& object, const Segment& s, bool proven_only) {
  const ObjectRecord& record = *object.record;
  const auto method = static_cast<Method>(record.method);
  if (method == Method::none || (proven_only && method == Method::sampled)) return Answer::unclassified;
  LineCell line = test::reference_locate(record.box_min, record.box_max, s);
  if (!line.valid) return Answer::unclassified;
  if (!line.hits || s.t_min >= line.t_exit || s.t_max <= line.t_entry) return Answer::clear;
  const auto cell = static_cast<uint32_t>(class_of(object.tree, line));
  if (cell == 0) return Answer::clear;
  if (cell != 1 && (cell != 3 || method != Method::hybrid || proven_only)) return Answer::unclassified;
  if (s.t_min <= line.t_entry && s.t_max >= line.t_exit) return Answer::blocked;
  if (!object.tree.clearances) return Answer::unclassified;
  line.swapped = locate(make_grid_frame(record.box_min, record.box_max), s).swapped;
  return within_clearances(object.tree.clearances, line, s.t_min, s.t_max) ? Answer::blocked : Answer::unclassified;
}

// counts_are_right: the record's counts have been checked. If not, "no clear cell" there may be a lie that leaves a
// segment unclassified.
inline void require_answer(const ObjectContents& object, const Segment& s, Answer answer, bool proven_only,
                           bool counts_are_right) {
  const Answer plain = plain_answer(object, s, proven_only);
  require(answer == plain || (!counts_are_right && answer == Answer::unclassified),
          "the answer is that of the spec's text");
  if (!test::is_finite(s))
    require(answer == Answer::unclassified, "12: a NaN or an infinity in origin or direction gives unclassified");
  if (s.direction[0] == 0 && s.direction[1] == 0 && s.direction[2] == 0)
    require(answer == Answer::unclassified, "13: a direction of zero length gives unclassified");
  if (!(s.t_min < s.t_max))
    require(answer != Answer::blocked, "4, 16: an empty interval, or a NaN in it, is never blocked");
}

// Proofs alone say nothing else than all answers do, and maybe less.
inline void require_no_more(Answer proven, Answer all) {
  require(proven == Answer::unclassified || proven == all, "what is proven is among all answers");
  require(all != Answer::clear || proven != Answer::blocked, "clear is not blocked");
}

struct Bits {
  std::vector<uint64_t> blocked, open;
  size_t count;

  explicit Bits(size_t size) : blocked((size + 63) / 64, ~uint64_t{0}), open(blocked), count(size) {}
  Answer operator[](size_t i) const {
    if (open[i / 64] >> (i % 64) & 1) return Answer::unclassified;
    return blocked[i / 64] >> (i % 64) & 1 ? Answer::blocked : Answer::clear;
  }
  bool operator==(const Bits&) const = default;

  void require_well_formed() const {
    for (size_t w = 0; w < blocked.size(); ++w) {
      require((blocked[w] & open[w]) == 0, "no sample is blocked and open");
      const size_t used = count - 64 * w;
      if (used < 64) require((blocked[w] | open[w]) >> used == 0, "bits past the last sample are 0");
    }
  }
};

}  // namespace vcd::fuzz
