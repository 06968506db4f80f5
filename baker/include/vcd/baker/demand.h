// What a bake for a demand has come to.
#pragma once

#include <cstdint>
#include <functional>
#include <span>

#include <vcd/baker/prepare.h>
#include <vcd/format/demand.h>
#include <vcd/format/layout.h>
#include <vcd/format/tree.h>

namespace vcd::baker {

// Whether a segment of a demand is kept out of bakes, to tell afterwards how much of what was not looked at is
// answered: one in eight, by a hash of the segment.
bool is_kept_out(const Segment& segment);

// Of the segments of a demand that were kept out and that enter the object's box.
struct DemandReport {
  uint64_t segments = 0;
  double weight = 0;
  double answered_weight = 0;  // of those that a look-up answers, statistics trusted
  uint64_t answered = 0;
  uint64_t wrong = 0;  // of the answered, by exact arithmetic; proofs were none

  double share() const { return weight > 0 ? answered_weight / weight : 0; }
};

// Asks a tree, of this record, for what was kept out of its bake. bake() has done so. Errors: difference (a proven
// answer is wrong), runtime (stopped).
// asked  the demand's segments of this mesh
// stop   may be empty
Result<DemandReport> judge_demand(const PreparedMesh& mesh, const ObjectRecord& record, const TreeView& tree,
                                  std::span<const AskedSegment> asked, const std::function<bool()>& stop = {});

}  // namespace vcd::baker
