// What a renderer asks → a demand, to bake sidecars for (spec/demand.md).
//
//   auto recorder = vcd::Recorder::build(instances);
//   vcd::Recorder::Thread& mine = recorder->thread();  // once a thread
//   mine.asked(segments, self);                        // beside each query
//   vcd::write_demand("scene.demand", recorder->demand());
//
// It needs no sidecar: only boxes, hashes and transforms. Who does not record calls nothing and pays nothing.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include <vcd/format/demand.h>
#include <vcd/format/error.h>
#include <vcd/format/segment.h>
#include <vcd/runtime/bundle.h>
#include <vcd/runtime/scene.h>
#include <vcd/runtime/segment_arrays.h>
#include <vcd/runtime/sidecar.h>

namespace vcd {

struct RecordedInstance {
  GeometryHash geometry_hash;
  SceneInstance place;  // its object is not looked at, its mask neither

  static RecordedInstance of(const Object& object, const Transform& to_world);
};

// A bounded, even sample of the segments that are asked of a scene, or of one object: then one instance, with the
// identity. Each thread has a buffer of its own. Only thread() locks.
class Recorder {
 public:
  // A thread's buffer: one of each so many consecutive segments, at a random place among them. So it is known
  // beforehand how many to pass over, and most calls cost a comparison and a subtraction. When the buffer is full, one
  // of each two stays. One thread at a time. Lives as long as the recorder.
  class Thread {
   public:
    // Segments in the world's frame, as they were asked. self: the instance that they begin on: of it they are not
    // recorded, because no look-up answers them.
    void asked(const Segment& segment, uint32_t self = kNoInstance) {
      if (!passes_over(1)) keep(segment, self);
    }
    void asked(std::span<const Segment> segments, uint32_t self = kNoInstance) {
      keep_some(segments.size(), self, [&](size_t i) { return segments[i]; });
    }
    void asked(const SegmentArrays& segments, uint32_t self = kNoInstance) {
      keep_some(segments.count, self, [&](size_t i) { return segment_at(segments, i); });
    }
    void asked(const QuadBundle& bundle, uint32_t self = kNoInstance) { keep_bundle(bundle, self); }
    void asked(const SphereBundle& bundle, uint32_t self = kNoInstance) { keep_bundle(bundle, self); }
    void asked(const PointBundle& bundle, uint32_t self = kNoInstance) { keep_bundle(bundle, self); }

    uint64_t seen() const { return seen_; }  // all that were asked

   private:
    friend class Recorder;
    struct Kept {
      Segment segment;
      uint32_t self;
    };
    Thread(uint64_t seed, size_t most);

    // True if none of the next `count` segments is kept; they are counted.
    bool passes_over(size_t count) {
      seen_ += count;
      if (skip_ < count) return false;
      skip_ -= count;
      return true;
    }
    template <class SegmentAt>
    void keep_some(size_t count, uint32_t self, const SegmentAt& segment_at) {
      if (passes_over(count)) return;
      for (size_t i = 0; i < count;) {
        if (skip_ >= count - i) return void(skip_ -= count - i);
        i += skip_;
        keep(segment_at(i++), self);
      }
    }
    template <class Bundle>
    void keep_bundle(const Bundle& bundle, uint32_t self) {
      keep_some(bundle.size(), self, [&](size_t i) { return segment_of(bundle, i); });
    }
    void keep(const Segment& segment, uint32_t self);  // and draws the next skip_
    void halve();
    uint64_t random();

    std::vector<Kept> kept_;
    size_t most_;         // even
    uint64_t skip_ = 0;   // so many are passed over before the next is kept
    uint64_t gap_ = 1;    // one of so many is kept; a power of two
    uint64_t place_ = 0;  // of the next one among these
    uint64_t seen_ = 0;
    uint64_t random_;
  };

  // Instances keep their indices. Errors: runtime (out of memory).
  // most  segments that each thread keeps, 36 bytes each; at least half of it once so many were asked
  static Result<Recorder> build(std::span<const RecordedInstance> instances, size_t most = kDefaultMost);
  static constexpr size_t kDefaultMost = size_t{1} << 18;

  Recorder(Recorder&&) noexcept;
  Recorder& operator=(Recorder&&) noexcept;
  ~Recorder();

  // A new buffer, for one thread. Safe from any thread.
  Thread& thread();

  // What was asked of each object, by all instances of it whose box a segment could meet, in the object's frame. Each
  // segment weighs as many as it stands for. At most kMostAskedSegments; more are thinned. No thread records meanwhile.
  Demand demand() const;

 private:
  struct State;
  explicit Recorder(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

}  // namespace vcd
