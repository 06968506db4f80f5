// What is asked in a scene's stead.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include <embree3/rtcore.h>
#include <vcd/runtime/scene.h>

#include "known_meshes.h"

namespace vcd::preload {

constexpr Transform kIdentity = {{{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}}};

// A scene's content as it was committed. Never changes, so that any number of threads may ask at once.
//
// Its meshes with sidecars are asked first. What meets none of them, Embree traces through the rest: a scene of its own
// that holds everything else. What they leave unclassified, Embree traces through the program's whole scene.
class View {
 public:
  ~View();
  View(const View&) = delete;
  View& operator=(const View&) = delete;

  Visibility classify(const Segment& segment) const;
  // At most kMost segments; answers.size() must be segments.size().
  static constexpr size_t kMost = 64;
  void classify(std::span<const Segment> segments, std::span<Visibility> answers) const;

  // Whether a `blocked` answer is Embree's too, for a ray of this mask. It is not where a filter or a mask may let the
  // ray pass; `clear` answers stand all the same, since no triangle is met.
  bool may_block(uint32_t ray_mask) const {
    bool seen = !filtered_;
    for (const uint32_t mask : masks_) seen &= (mask & ray_mask) != 0;
    return seen;
  }

  // Where a ray begins, as far as that is known at once.
  From from(const float origin[3]) const {
    if (!single_) return From::outside;
    const ObjectRecord& record = single_->record();
    for (int a = 0; a < 3; ++a)
      if (!(origin[a] > record.box_min[a] && origin[a] < record.box_max[a])) return From::outside;
    return From::inside;
  }

  uint64_t id() const { return id_; }      // no other view has or had it; never 0
  RTCScene rest() const { return rest_; }  // null: nothing else is in the scene

 private:
  friend class ViewMaker;
  View() = default;
  std::optional<Object> single_;  // of a scene that is one mesh
  std::optional<Scene> scene_;    // of all others
  bool exact_ = false;            // hierarchies decide what look-ups leave
  bool filtered_ = false;
  std::vector<uint32_t> masks_;  // all different ones of what may block
  RTCScene rest_ = nullptr;
  uint64_t id_ = 0;
};

// Puts a View together, part by part.
class ViewMaker {
 public:
  explicit ViewMaker(bool masks_matter) : masks_matter_(masks_matter) {}
  ViewMaker(ViewMaker&&) = default;
  ~ViewMaker();

  void add(Object object, const Transform& to_world) { instances_.push_back(SceneInstance::of(object, to_world)); }
  void add_rest(RTCGeometry geometry, unsigned id);
  void add_filter() { filtered_ = true; }  // on something that was added
  void add_mask(uint32_t mask);

  // None where it would answer nothing. scene: the program's, which is committed.
  std::unique_ptr<const View> make(RTCDevice device, RTCScene scene) const;

 private:
  bool add_objects(View& view) const;
  bool add_rest_scene(View& view, RTCDevice device, RTCScene scene) const;
  std::vector<SceneInstance> instances_;
  std::vector<std::pair<RTCGeometry, unsigned>> rest_;  // with their ids; each is held
  std::vector<uint32_t> masks_;
  bool masks_matter_;  // Embree heeds them
  bool filtered_ = false;
};

// The view of a scene that is committed and unchanged since; null: ask Embree. Never locks.
const View* view_of(RTCScene scene);
// One thread at a time. False: there is no room for that many scenes.
bool publish(RTCScene scene, const View* view);

}  // namespace vcd::preload
