// What the program told Embree of its scenes and geometries. All functions may be called from any thread. None
// throws: where memory is short, Embree answers.
//
// A scene has a view (view.h) from the end of its commit until anything in it changes, itself or an instanced scene.
// A view that is withdrawn is kept until the scene's next commit or its end: threads may be in the middle of it, as
// they may be in the middle of Embree's own.
#pragma once

#include <functional>

#include <embree3/rtcore.h>

#include "mesh.h"

namespace vcd::preload {

struct Geometry {
  RTCGeometryType type;
  Mesh mesh = {};
  RTCScene instanced = nullptr;
  unsigned time_steps = 1;
  uint32_t mask = 0xFFFFFFFF;
  bool enabled = true;
  bool filtered = false;
  bool odd = false;  // it has something that is not looked into
};

void add_scene(RTCScene scene, RTCDevice device) noexcept;
void add_geometry(RTCGeometry geometry, RTCDevice device, RTCGeometryType type) noexcept;
void retain(RTCScene scene) noexcept;
void retain(RTCGeometry geometry) noexcept;
// Before Embree is told, since another thread may get the address of what ends.
void release(RTCScene scene) noexcept;
void release(RTCGeometry geometry) noexcept;
void attach(RTCScene scene, RTCGeometry geometry, unsigned id) noexcept;
void detach(RTCScene scene, unsigned id) noexcept;
void set_instanced(RTCGeometry geometry, RTCScene scene) noexcept;

// change: to be done to it, and must not throw; the scenes that it is in have no view from now on.
void change(RTCGeometry geometry, const std::function<void(Geometry&)>& change) noexcept;

// Null: it is not known.
RTCDevice device_of(RTCScene scene) noexcept;
RTCDevice device_of(RTCGeometry geometry) noexcept;
// After Embree has committed the scene. failed: it could not, so that Embree's answers are not of the scene.
void committed(RTCScene scene, bool failed) noexcept;

}  // namespace vcd::preload
