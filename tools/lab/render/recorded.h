// A renderer's shadow rays, recorded as a demand while they are answered.
#pragma once

#include <memory>
#include <utility>

#include <vcd/recorder/recorder.h>

#include "path_casters.h"
#include "renderer.h"

namespace vcd::render {

// Of the world's instances. Errors: runtime (out of memory).
Result<Recorder> recorder_of(const World& world, size_t most);

// The shadow rays of a picture, at most so many of them, as a demand. Nothing is traced for them. One thread: the same
// world and settings give the same demand. Errors: runtime (out of memory, or stopped).
Result<Demand> demand_of_picture(const World& world, RenderSettings settings, size_t most,
                                 const RenderHooks& hooks = {});

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

class RecordedPaths : public PathCaster {
 public:
  // The recorder's buffer outlives this.
  RecordedPaths(std::unique_ptr<PathCaster> caster, Recorder::Thread& thread)
      : caster_(std::move(caster)), thread_(thread) {}
  void cast(const AskedRays& rays, std::span<uint8_t> blocked) override {
    for (size_t i = 0; i < rays.segments.size(); ++i) thread_.asked(rays.segments[i], rays.origins[i]);
    caster_->cast(rays, blocked);
  }

 private:
  std::unique_ptr<PathCaster> caster_;
  Recorder::Thread& thread_;
};

}  // namespace vcd::render
