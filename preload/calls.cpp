// Embree's functions that build scenes: each is passed on, and what it said is tracked.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>

#include "counts.h"
#include "known_meshes.h"
#include "next.h"
#include "settings.h"
#include "tracked.h"

using vcd::preload::Geometry;

namespace {

// Errors that the program has not asked for yet, but that this library had to take from Embree to see whether a call
// failed. The first one of a device counts, as with Embree. A fixed array: it needs no memory and no destructor, so
// that threads may still call while they end. The oldest error makes room.
struct PendingError {
  RTCDevice device;
  RTCError error;
};
constexpr size_t kMostPending = 16;
constinit thread_local PendingError pending[kMostPending] = {};
constinit thread_local size_t pending_count = 0;

PendingError* pending_of(RTCDevice device) {
  PendingError* const end = pending + pending_count;
  PendingError* const found = std::find_if(pending, end, [=](const PendingError& p) { return p.device == device; });
  return found == end ? nullptr : found;
}

void remove(PendingError* error) {
  std::copy(error + 1, pending + pending_count, error);
  --pending_count;
}

RTCError take_error(RTCDevice device) {
  const RTCError error = VCD_NEXT(rtcGetDeviceError)(device);
  if (error == RTC_ERROR_NONE || pending_of(device)) return error;
  if (pending_count == kMostPending) remove(pending);
  pending[pending_count++] = {device, error};
  return error;
}

void report() {
  using vcd::preload::Count;
  const auto count = [](Count which) { return static_cast<unsigned long long>(total(which)); };
  unsigned long long asked = 0;
  for (size_t i = 0; i < static_cast<size_t>(Count::kCount); ++i) asked += count(static_cast<Count>(i));
  const auto meshes = vcd::preload::mesh_counts();
  std::fprintf(stderr, "libvcd_embree3: %zu meshes: %zu with a sidecar, %zu exported\n", meshes.meshes,
               meshes.with_sidecar, meshes.exported);
  std::fprintf(
      stderr,
      "libvcd_embree3: %llu shadow rays: %llu clear, %llu blocked; clear of sidecars, the rest traced by "
      "Embree: %llu; traced by Embree: %llu unclassified, %llu blocked unless a filter or mask says no, %llu since "
      "look-ups cost more, %llu in scenes without sidecars or by rtcOccludedNp\n",
      asked, count(Count::clear), count(Count::blocked), count(Count::clear_but_rest), count(Count::unclassified),
      count(Count::held_back), count(Count::not_looked_up), count(Count::other_scenes));
}

template <class Commit>
void commit(RTCScene scene, Commit commit) {
  static const int registered = std::atexit(report);
  static_cast<void>(registered);
  const RTCDevice device = vcd::preload::device_of(scene);
  if (!device) return commit(scene);
  take_error(device);
  commit(scene);
  vcd::preload::committed(scene, take_error(device) != RTC_ERROR_NONE);
}

// set: sets the buffer and returns its first byte. Where Embree refuses, it keeps the old buffer or has none: which one
// is not known here, so that the geometry is left to Embree for good.
template <class Set>
void* set_buffer(RTCGeometry geometry, RTCBufferType type, unsigned slot, RTCFormat format, size_t stride, size_t count,
                 const Set& set) {
  const RTCDevice device = vcd::preload::device_of(geometry);
  if (!device) return set();
  take_error(device);
  void* const first = set();
  const bool refused = take_error(device) != RTC_ERROR_NONE;
  const auto change = [&](Geometry& told) {
    if (refused) told.odd = true;
    if (refused || (type != RTC_BUFFER_TYPE_VERTEX && type != RTC_BUFFER_TYPE_INDEX)) return;
    if (slot != 0) told.odd = true;  // of another time, or another topology
    else
      (type == RTC_BUFFER_TYPE_VERTEX ? told.mesh.positions : told.mesh.faces) = {static_cast<const std::byte*>(first),
                                                                                  format, stride, count};
  };
  vcd::preload::change(geometry, std::ref(change));  // by reference: that needs no memory
  return first;
}

}  // namespace

extern "C" {

RTCError rtcGetDeviceError(RTCDevice device) {
  const RTCError error = VCD_NEXT(rtcGetDeviceError)(device);
  PendingError* const earlier = pending_of(device);
  if (!earlier) return error;
  const RTCError first = earlier->error;
  remove(earlier);
  return first;
}

RTCDevice rtcNewDevice(const char* config) {
  const RTCDevice device = VCD_NEXT(rtcNewDevice)(config);
  if (PendingError* const of_a_dead_one = pending_of(device)) remove(of_a_dead_one);
  return device;
}
RTCScene rtcNewScene(RTCDevice device) {
  const RTCScene scene = VCD_NEXT(rtcNewScene)(device);
  if (scene) vcd::preload::add_scene(scene, device);
  return scene;
}
void rtcRetainScene(RTCScene scene) {
  VCD_NEXT(rtcRetainScene)(scene);
  vcd::preload::retain(scene);
}
void rtcReleaseScene(RTCScene scene) {
  vcd::preload::release(scene);
  VCD_NEXT(rtcReleaseScene)(scene);
}
void rtcCommitScene(RTCScene scene) { commit(scene, VCD_NEXT(rtcCommitScene)); }
void rtcJoinCommitScene(RTCScene scene) { commit(scene, VCD_NEXT(rtcJoinCommitScene)); }
unsigned rtcAttachGeometry(RTCScene scene, RTCGeometry geometry) {
  const unsigned id = VCD_NEXT(rtcAttachGeometry)(scene, geometry);
  vcd::preload::attach(scene, geometry, id);
  return id;
}
void rtcAttachGeometryByID(RTCScene scene, RTCGeometry geometry, unsigned id) {
  VCD_NEXT(rtcAttachGeometryByID)(scene, geometry, id);
  vcd::preload::attach(scene, geometry, id);
}
void rtcDetachGeometry(RTCScene scene, unsigned id) {
  vcd::preload::detach(scene, id);
  VCD_NEXT(rtcDetachGeometry)(scene, id);
}

RTCGeometry rtcNewGeometry(RTCDevice device, RTCGeometryType type) {
  const RTCGeometry geometry = VCD_NEXT(rtcNewGeometry)(device, type);
  if (geometry) vcd::preload::add_geometry(geometry, device, type);
  return geometry;
}
void rtcRetainGeometry(RTCGeometry geometry) {
  VCD_NEXT(rtcRetainGeometry)(geometry);
  vcd::preload::retain(geometry);
}
void rtcReleaseGeometry(RTCGeometry geometry) {
  vcd::preload::release(geometry);
  VCD_NEXT(rtcReleaseGeometry)(geometry);
}
void rtcCommitGeometry(RTCGeometry geometry) {
  VCD_NEXT(rtcCommitGeometry)(geometry);
  vcd::preload::change(geometry, [](Geometry&) {});
}
void rtcEnableGeometry(RTCGeometry geometry) {
  VCD_NEXT(rtcEnableGeometry)(geometry);
  vcd::preload::change(geometry, [](Geometry& told) { told.enabled = true; });
}
void rtcDisableGeometry(RTCGeometry geometry) {
  VCD_NEXT(rtcDisableGeometry)(geometry);
  vcd::preload::change(geometry, [](Geometry& told) { told.enabled = false; });
}
void rtcSetGeometryTimeStepCount(RTCGeometry geometry, unsigned count) {
  VCD_NEXT(rtcSetGeometryTimeStepCount)(geometry, count);
  vcd::preload::change(geometry, [=](Geometry& told) { told.time_steps = count; });
}
void rtcSetGeometryMask(RTCGeometry geometry, unsigned mask) {
  VCD_NEXT(rtcSetGeometryMask)(geometry, mask);
  vcd::preload::change(geometry, [=](Geometry& told) { told.mask = mask; });
}
void rtcSetGeometryOccludedFilterFunction(RTCGeometry geometry, RTCFilterFunctionN filter) {
  VCD_NEXT(rtcSetGeometryOccludedFilterFunction)(geometry, filter);
  vcd::preload::change(geometry, [=](Geometry& told) { told.filtered = filter != nullptr; });
}

void rtcSetGeometryBuffer(RTCGeometry geometry, RTCBufferType type, unsigned slot, RTCFormat format, RTCBuffer buffer,
                          size_t offset, size_t stride, size_t count) {
  set_buffer(geometry, type, slot, format, stride, count, [&]() -> void* {
    VCD_NEXT(rtcSetGeometryBuffer)(geometry, type, slot, format, buffer, offset, stride, count);
    auto* const first = buffer ? static_cast<std::byte*>(VCD_NEXT(rtcGetBufferData)(buffer)) : nullptr;
    return first ? first + offset : nullptr;
  });
}
void rtcSetSharedGeometryBuffer(RTCGeometry geometry, RTCBufferType type, unsigned slot, RTCFormat format,
                                const void* first, size_t offset, size_t stride, size_t count) {
  set_buffer(geometry, type, slot, format, stride, count, [&]() -> void* {
    VCD_NEXT(rtcSetSharedGeometryBuffer)(geometry, type, slot, format, first, offset, stride, count);
    return static_cast<std::byte*>(const_cast<void*>(first)) + offset;
  });
}
void* rtcSetNewGeometryBuffer(RTCGeometry geometry, RTCBufferType type, unsigned slot, RTCFormat format, size_t stride,
                              size_t count) {
  return set_buffer(geometry, type, slot, format, stride, count,
                    [&] { return VCD_NEXT(rtcSetNewGeometryBuffer)(geometry, type, slot, format, stride, count); });
}
void rtcUpdateGeometryBuffer(RTCGeometry geometry, RTCBufferType type, unsigned slot) {
  VCD_NEXT(rtcUpdateGeometryBuffer)(geometry, type, slot);
  vcd::preload::change(geometry, [](Geometry&) {});
}

void rtcSetGeometryInstancedScene(RTCGeometry geometry, RTCScene scene) {
  VCD_NEXT(rtcSetGeometryInstancedScene)(geometry, scene);
  vcd::preload::set_instanced(geometry, scene);
}
void rtcSetGeometryTransform(RTCGeometry geometry, unsigned step, RTCFormat format, const void* transform) {
  VCD_NEXT(rtcSetGeometryTransform)(geometry, step, format, transform);
  vcd::preload::change(geometry, [](Geometry&) {});
}
void rtcSetGeometryTransformQuaternion(RTCGeometry geometry, unsigned step, const RTCQuaternionDecomposition* to) {
  VCD_NEXT(rtcSetGeometryTransformQuaternion)(geometry, step, to);
  vcd::preload::change(geometry, [](Geometry& told) { told.odd = true; });
}

}  // extern "C"
