// A renderer's shadow rays, recorded as a demand while they are answered.
#pragma once

#include <memory>
#include <utility>

#include <vcd/recorder/recorder.h>

#include "shadows.h"

namespace vcd::render {

// Of the world's instances. Errors: runtime (out of memory).
Result<Recorder> recorder_of(const World& world, size_t most);

class RecordedShadows : public ShadowCaster {
 public:
  // The recorder's buffer outlives this.
  RecordedShadows(std::unique_ptr<ShadowCaster> caster, Recorder::Thread& thread)
      : caster_(std::move(caster)), thread_(thread) {}
  void cast(const Bundle& bundle, std::span<uint8_t> blocked) override {
    thread_.asked(bundle.segments, bundle.surface);
    caster_->cast(bundle, blocked);
  }

 private:
  std::unique_ptr<ShadowCaster> caster_;
  Recorder::Thread& thread_;
};
static_assert(kGroundSurface == kNoInstance);

}  // namespace vcd::render
