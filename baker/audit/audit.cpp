#include <vcd/baker/audit.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include <tbb/parallel_for.h>

#include <vcd/baker/referee.h>

#include "audit/lines.h"

namespace vcd::baker {
namespace {

constexpr uint64_t kBatch = 4096;  // segments that share a generator

struct Batch {
  AuditCounts counts;
  std::vector<Contradiction> contradictions;
};

class Audit {
 public:
  Audit(const PreparedMesh& mesh, const Answers& answers, const Answers& proven)
      : mesh_(mesh), referee_(mesh), answers_(answers), proven_(proven) {}

  Batch run(AuditKind kind, uint64_t seed, uint64_t count) const {
    Batch batch;
    std::vector<Segment> segments(count);
    std::vector<Visibility> given(count);
    AuditLines lines(mesh_, kind, seed);
    for (Segment& segment : segments) segment = lines.next();
    answers_(segments, given);
    batch.counts.segments = count;
    for (uint64_t i = 0; i < count; ++i) {
      if (given[i] == Visibility::unclassified) continue;
      const bool blocked = given[i] == Visibility::blocked;
      ++batch.counts.answered[blocked];
      if (referee_.occluded(segments[i]) == blocked) continue;
      Visibility by_proof = Visibility::unclassified;
      proven_(std::span(&segments[i], 1), std::span(&by_proof, 1));
      ++batch.counts.wrong[blocked];
      batch.counts.wrong_proven += by_proof == given[i];
      batch.contradictions.push_back({kind, segments[i], given[i], by_proof == given[i]});
    }
    return batch;
  }

 private:
  const PreparedMesh& mesh_;
  Referee referee_;
  const Answers& answers_;
  const Answers& proven_;
};

uint64_t lines_of(AuditKind kind, uint64_t all) {
  switch (kind) {
    case AuditKind::uniform:
    case AuditKind::chords: return all / 3;
    case AuditKind::vertices: return all - 2 * (all / 3) - 2 * (all / 9);
    default: return all / 9;
  }
}

}  // namespace

const char* audit_kind_name(AuditKind kind) {
  constexpr const char* kNames[kAuditKinds] = {"uniform", "chords", "inside", "edges", "vertices"};
  return kNames[static_cast<size_t>(kind)];
}

AuditCounts& AuditCounts::operator+=(const AuditCounts& other) {
  segments += other.segments;
  for (int c = 0; c < 2; ++c) answered[c] += other.answered[c], wrong[c] += other.wrong[c];
  wrong_proven += other.wrong_proven;
  return *this;
}

AuditCounts AuditReport::sum(bool aimed) const {
  AuditCounts sum;
  for (size_t k = 0; k < kAuditKinds; ++k)
    if (is_aimed(static_cast<AuditKind>(k)) == aimed) sum += counts[k];
  return sum;
}

AuditReport audit(const PreparedMesh& mesh, const Answers& answers, const Answers& proven,
                  const AuditOptions& options) {
  const Audit audit(mesh, answers, proven);

  AuditReport report;
  for (size_t k = 0; k < kAuditKinds; ++k) {
    const auto kind = static_cast<AuditKind>(k);
    const uint64_t lines = lines_of(kind, options.lines);
    std::vector<Batch> batches((lines + kBatch - 1) / kBatch);
    tbb::parallel_for(size_t{0}, batches.size(), [&](size_t b) {
      if (options.stop && options.stop()) return;
      batches[b] = audit.run(kind, options.seed * 1000003 + b, std::min(kBatch, lines - b * kBatch));
    });
    for (const Batch& batch : batches) {
      report.counts[k] += batch.counts;
      for (const Contradiction& contradiction : batch.contradictions)
        if (report.contradictions.size() < options.keep) report.contradictions.push_back(contradiction);
    }
  }
  return report;
}

std::vector<Segment> audit_segments(const PreparedMesh& mesh, AuditKind kind, uint64_t seed, uint64_t count) {
  AuditLines lines(mesh, kind, seed);
  std::vector<Segment> segments(count);
  for (Segment& segment : segments) segment = lines.next();
  return segments;
}

namespace {

// The Poisson mean under which seeing `most` or fewer has this probability, by bisection.
double mean_of_at_most(uint64_t most, double probability) {
  const auto probability_of_so_few = [&](double mean) {
    double sum = 0;
    for (uint64_t k = 0; k <= most; ++k)
      sum += std::exp(static_cast<double>(k) * std::log(mean) - mean - std::lgamma(static_cast<double>(k) + 1));
    return sum;
  };
  const double around = static_cast<double>(most) + 1, reach = 10 + 5 * std::sqrt(around);
  double low = std::max(1e-9, around - reach), high = around + reach;
  for (int i = 0; i < 60; ++i) (probability_of_so_few((low + high) / 2) > probability ? low : high) = (low + high) / 2;
  return high;
}

}  // namespace

double upper_bound_95(uint64_t wrong, uint64_t all) {
  return all == 0 ? 1 : std::min(1.0, mean_of_at_most(wrong, 0.05) / static_cast<double>(all));
}

double lower_bound_95(uint64_t wrong, uint64_t all) {
  return wrong == 0 ? 0 : mean_of_at_most(wrong - 1, 0.95) / static_cast<double>(all);
}

}  // namespace vcd::baker
