// What Embree, sidecars or hierarchies say of every shadow ray of a picture, held against what is true: a pass that is
// not timed.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "judge.h"
#include "shadows.h"
#include "test_counter.h"

namespace vcd::render {

// How a segment lies to the object's box. One object: the first four; many instances: the other two.
enum class SegmentKind : uint8_t {
  missing,           // passes the box by
  piercing,          // both ends outside, the box between them
  own,               // starts on the object
  inside,            // starts elsewhere inside the box, on the ground; or ends there
  instanced_ground,  // in a scene of instances, from the ground …
  instanced_own,     // … and from an object
};
inline constexpr size_t kSegmentKinds = 6;
const char* segment_kind_name(SegmentKind kind);
SegmentKind segment_kind(const World& world, uint32_t surface, const Segment& segment);  // that it begins on

struct KindCounts {
  uint64_t segments = 0;
  uint64_t answered[2] = {};    // clear, blocked: no hierarchy was asked
  uint64_t wrong = 0;           // the final answer is not the true one
  uint64_t wrong_answered = 0;  // of these, answered without the hierarchy

  uint64_t resolved() const { return answered[0] + answered[1]; }
  void add(const KindCounts& other);
};

struct CensusPass {
  std::array<KindCounts, kSegmentKinds> kinds;
  uint64_t tests = 0;               // ray–triangle tests of what the sidecars left open
  std::vector<double> pixel_tests;  // the same by pixel
  std::vector<double> pixel_open;   // segments that were left open, by pixel

  KindCounts total() const;
};

// The counts of one variant, gathered by one caster a thread. The picture that such a pass renders is that of the
// variant.
class Census {
 public:
  // objects: one a world object, or none: then all is traced, and counted. truth: how to trace what is true. judge:
  // corrects that; it learns from what is traced where there are no objects, and the passes after that are of the same
  // segments. None: nothing that is traced is wrong.
  Census(const World& world, std::vector<Object> objects, const TestCounter& counter, EmbreeQuery truth, size_t pixels,
         Judge* judge = nullptr);
  // What casters that need no BVH say: all segments count as answered.
  Census(const World& world, MakeCaster whole, EmbreeQuery truth, size_t pixels, const Judge* judge = nullptr);
  std::unique_ptr<ShadowCaster> caster();  // one a thread, before the threads start
  CensusPass take();                       // after they ended

 private:
  class Caster;
  const World& world_;
  std::vector<Object> objects_;
  MakeCaster whole_;
  const TestCounter* counter_ = nullptr;  // none: nothing is traced
  EmbreeQuery truth_;
  Judge* learning_ = nullptr;
  const Judge* judge_ = nullptr;
  CensusPass pass_;
  std::vector<std::unique_ptr<CensusPass>> passes_;  // one a thread; their pixel counts are shared, in pass_
};

}  // namespace vcd::render
