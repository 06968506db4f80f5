// Whether a thread looks up at all: single rays of a path tracer often cost Embree less than a look-up does.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include <vcd/runtime/look_up_policy.h>

namespace vcd::preload {

// Of one thread and one view.
class Choice {
 public:
  Choice() = default;
  Choice(uint64_t view_id, bool always) : view_id_(view_id) {
    if (always) policy_ = LookUpPolicy(LookUpPolicy::Use::always, LookUpPolicy::Use::always);
  }

  uint64_t view_id() const { return view_id_; }
  bool look_up(From from) const { return policy_.look_up(from); }
  bool undecided(From from) const { return policy_.undecided(from); }
  // What rays cost, tracing included. Rays are told of in batches, so that a few do not decide.
  void took(From from, bool looked_up, double nanoseconds, size_t rays) {
    constexpr size_t kBatch = 256;
    Batch& batch = batches_[static_cast<size_t>(from)];
    batch.nanoseconds += nanoseconds, batch.rays += rays;
    if (batch.rays < kBatch) return;
    policy_.took(from, looked_up, batch.nanoseconds, batch.rays);
    batch = {};
  }

 private:
  struct Batch {
    double nanoseconds = 0;
    size_t rays = 0;
  };
  uint64_t view_id_ = 0;  // of none
  LookUpPolicy policy_;
  std::array<Batch, 3> batches_ = {};
};

}  // namespace vcd::preload
