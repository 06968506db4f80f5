// What the program told Embree of its scenes and geometries. All functions may be called from any thread.
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

void add_scene(RTCScene scene, RTCDevice device);
void add_geometry(RTCGeometry geometry, RTCDevice device, RTCGeometryType type);
void retain(RTCScene scene);
void retain(RTCGeometry geometry);
// Before Embree is told, since another thread may get the address of what ends.
void release(RTCScene scene);
void release(RTCGeometry geometry);
void attach(RTCScene scene, RTCGeometry geometry, unsigned id);
void detach(RTCScene scene, unsigned id);
void set_instanced(RTCGeometry geometry, RTCScene scene);

// change: to be done to it; the scenes that it is in have no view from now on.
void change(RTCGeometry geometry, const std::function<void(Geometry&)>& change);

// Null: it is not known.
RTCDevice device_of(RTCScene scene);
RTCDevice device_of(RTCGeometry geometry);
// After Embree has committed the scene. failed: it could not, so that Embree's answers are not of the scene.
void committed(RTCScene scene, bool failed);

}  // namespace vcd::preload
