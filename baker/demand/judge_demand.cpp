#include <vcd/baker/demand.h>

#include <algorithm>

#include <vcd/baker/referee.h>
#include <vcd/format/checksum.h>

#include "audit/audit_object.h"
#include "demand/kept_out.h"
#include "prepare/place.h"

namespace vcd::baker {
namespace {

GridFrame frame_of(const PreparedMesh& mesh) { return make_grid_frame(mesh.box_min.data(), mesh.box_max.data()); }

}  // namespace

bool is_kept_out(const Segment& segment) { return checksum(std::as_bytes(std::span(&segment, 1))) % 8 == 0; }

bool enters_box(const GridFrame& frame, const Segment& segment) {
  const Place place = place_of(locate(frame, segment), segment.t_min, segment.t_max);
  return place == Place::pierces || place == Place::ends_inside;
}

std::vector<AskedSegment> kept_out_segments(const PreparedMesh& mesh, std::span<const AskedSegment> asked) {
  const GridFrame frame = frame_of(mesh);
  std::vector<AskedSegment> kept;
  std::ranges::copy_if(asked, std::back_inserter(kept),
                       [&](const AskedSegment& s) { return is_kept_out(s.segment) && enters_box(frame, s.segment); });
  return kept;
}

Result<DemandReport> judge_demand(const PreparedMesh& mesh, const ObjectRecord& record, const TreeView& tree,
                                  std::span<const AskedSegment> asked, const std::function<bool()>& stop) {
  const GridFrame frame = frame_of(mesh);
  TreeView trusted = tree, proven = tree;
  trusted.answers = answer_table(Trust::statistics), proven.answers = answer_table(Trust::proofs);
  DemandReport report;
  std::vector<Segment> answered;
  std::vector<uint8_t> said;  // 1: blocked
  for (const auto& [segment, weight] : kept_out_segments(mesh, asked)) {
    ++report.segments;
    report.weight += weight;
    const Visibility answer = classify(frame, trusted, trusted.shape, segment);
    if (answer == Visibility::unclassified) continue;
    report.answered_weight += weight;
    answered.push_back(segment);
    said.push_back(answer == Visibility::blocked);
  }
  report.answered = answered.size();
  std::vector<uint8_t> truth(answered.size());
  Referee(mesh).occluded(answered, truth);
  if (stop && stop()) return Error{ErrorCode::runtime, place_of(mesh) + ": stopped"};
  std::vector<Segment> wrongly_proven;
  for (size_t i = 0; i < answered.size(); ++i) {
    if (truth[i] == said[i]) continue;
    ++report.wrong;
    if (record.method != static_cast<uint8_t>(Method::sampled) &&
        classify(frame, proven, proven.shape, answered[i]) != Visibility::unclassified)
      wrongly_proven.push_back(answered[i]);
  }
  if (!wrongly_proven.empty())
    return wrong_proofs(mesh, wrongly_proven.size(),
                        std::span(wrongly_proven).first(std::min(wrongly_proven.size(), AuditOptions{}.keep)));
  return report;
}

}  // namespace vcd::baker
