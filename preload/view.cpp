#include "view.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>
#include <cstdio>
#include <cstring>

#include "next.h"
#include "settings.h"

namespace vcd::preload {
namespace {

bool is_finite(const Segment& s) {
  float sum = 0;  // of zeros, or not a number
  for (int a = 0; a < 3; ++a) sum += s.origin[a] * 0 + s.direction[a] * 0;
  return sum == 0 && s.t_min <= s.t_max;
}

// Open addressing. A scene keeps its slot for good; addresses of dead scenes come back.
struct Slot {
  std::atomic<RTCScene> scene;
  std::atomic<const View*> view;
};
constexpr size_t kSlots = size_t{1} << 16;  // a power of two
constinit Slot slots[kSlots] = {};
constinit size_t slots_used = 0;

size_t first_slot(RTCScene scene) { return (reinterpret_cast<uintptr_t>(scene) * 0x9E3779B97F4A7C15u) >> 48; }
static_assert(kSlots == size_t{1} << (64 - 48));

// Null: it has none. A slot that is empty when it is looked at may be another scene's at once.
Slot* slot_of(RTCScene scene) {
  for (size_t i = first_slot(scene);; i = (i + 1) % kSlots) {  // ends: half of the slots stay empty
    const RTCScene there = slots[i].scene.load(std::memory_order_relaxed);
    if (!there) return nullptr;
    if (there == scene) return &slots[i];
  }
}

// For a scene that has none; null: there is no room. One thread at a time.
Slot* claim_slot(RTCScene scene) {
  if (slots_used == kSlots / 2) return nullptr;
  ++slots_used;
  size_t i = first_slot(scene);
  while (slots[i].scene.load(std::memory_order_relaxed)) i = (i + 1) % kSlots;
  slots[i].scene.store(scene, std::memory_order_relaxed);
  return &slots[i];
}

}  // namespace

Visibility View::classify(const Segment& segment) const {
  if (!exact_) return single_ ? single_->classify(segment) : scene_->classify(segment);
  if (!is_finite(segment)) return Visibility::unclassified;
  return (single_ ? single_->occluded(segment) : scene_->occluded(segment)) ? Visibility::blocked : Visibility::clear;
}

void View::classify(std::span<const Segment> segments, std::span<Visibility> answers) const {
  assert(segments.size() <= kMost && answers.size() == segments.size());
  if (!exact_) return single_ ? single_->classify(segments, answers) : scene_->classify(segments, answers);
  uint64_t blocked = 0;
  if (single_) single_->occluded(segments, std::span(&blocked, 1));
  else scene_->occluded(segments, std::span(&blocked, 1));
  for (size_t i = 0; i < segments.size(); ++i)
    answers[i] = !is_finite(segments[i])   ? Visibility::unclassified
                 : (blocked >> i & 1) != 0 ? Visibility::blocked
                                           : Visibility::clear;
}

View::~View() {
  if (rest_) VCD_NEXT(rtcReleaseScene)(rest_);
}

ViewMaker::~ViewMaker() {
  for (const auto& [geometry, id] : rest_) VCD_NEXT(rtcReleaseGeometry)(geometry);
}

void ViewMaker::add_rest(RTCGeometry geometry, unsigned id) {
  rest_.emplace_back(geometry, id);
  VCD_NEXT(rtcRetainGeometry)(geometry);
}

void ViewMaker::add_mask(uint32_t mask) {
  if (masks_matter_ && std::find(masks_.begin(), masks_.end(), mask) == masks_.end()) masks_.push_back(mask);
}

bool ViewMaker::add_objects(View& view) const {
  const bool exact = settings().answers == Answers::exact;
  const Transform& to_world = instances_[0].to_world;
  if (instances_.size() == 1 && std::memcmp(&to_world, &kIdentity, sizeof to_world) == 0) {
    view.single_ = instances_[0].object;
    view.exact_ = exact && view.single_->has_hierarchy();
    return true;
  }
  auto scene = Scene::build(instances_);
  if (!scene) return std::fprintf(stderr, "libvcd_embree3: %s\n", scene.error().message.c_str()), false;
  view.exact_ = exact && scene->has_hierarchies();
  view.scene_ = std::move(*scene);
  return true;
}

bool ViewMaker::add_rest_scene(View& view, RTCDevice device, RTCScene scene) const {
  if (rest_.empty()) return true;
  view.rest_ = VCD_NEXT(rtcNewScene)(device);
  if (!view.rest_) return false;
  VCD_NEXT(rtcSetSceneFlags)(view.rest_, VCD_NEXT(rtcGetSceneFlags)(scene));
  for (const auto& [geometry, id] : rest_) VCD_NEXT(rtcAttachGeometryByID)(view.rest_, geometry, id);
  VCD_NEXT(rtcCommitScene)(view.rest_);
  return VCD_NEXT(rtcGetDeviceError)(device) == RTC_ERROR_NONE;
}

std::unique_ptr<const View> ViewMaker::make(RTCDevice device, RTCScene scene) const {
  if (instances_.empty()) return nullptr;
  std::unique_ptr<View> view(new View);
  static std::atomic<uint64_t> views = 0;
  view->id_ = ++views;
  view->filtered_ = filtered_;
  view->masks_ = masks_;
  if (!add_objects(*view) || !add_rest_scene(*view, device, scene)) return nullptr;
  return view;
}

const View* view_of(RTCScene scene) {
  const Slot* slot = slot_of(scene);
  return slot ? slot->view.load(std::memory_order_acquire) : nullptr;
}

bool publish(RTCScene scene, const View* view) {
  Slot* slot = slot_of(scene);
  if (!slot && !view) return true;
  if (!slot) slot = claim_slot(scene);
  if (!slot) return false;
  slot->view.store(view, std::memory_order_release);
  return true;
}

}  // namespace vcd::preload
