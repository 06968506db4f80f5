// Structs of the C interfaces as those of C++: for libraries that have both.
#pragma once

#include <cassert>
#include <cstddef>
#include <cstring>
#include <string>

#include <vcd/format/error.h>
#include <vcd/runtime/bundle.h>
#include <vcd/runtime/segment_arrays.h>
#include <vcd/runtime/vcd.h>

namespace vcd::in_c {

static_assert(sizeof(vcd_segment) == sizeof(Segment) && offsetof(vcd_segment, t_max) == offsetof(Segment, t_max));

// All structs have their first version. One that grows needs a copy here that is zero beyond the caller's size.
template <class Struct>
size_t size_of(const Struct& s) {
  return s.size == 0 ? sizeof(Struct) : s.size;
}
template <class Struct>
bool is_whole(const Struct& s) {
  return size_of(s) >= sizeof(Struct);
}

inline vcd_result fail(vcd_error* error, vcd_result result, const std::string& message) {
  if (error && size_of(*error) > offsetof(vcd_error, message)) {
    const size_t room = size_of(*error) - offsetof(vcd_error, message) - 1;
    const size_t length = message.copy(error->message, room);
    error->message[length] = '\0';
  }
  return result;
}

inline vcd_result fail(vcd_error* error, const Error& from) {
  return fail(error, static_cast<vcd_result>(from.code), from.message);
}

inline QuadBundle translate(const vcd_quad_bundle& b) {
  assert(is_whole(b));
  QuadBundle bundle{};
  std::memcpy(bundle.origin, b.origin, sizeof bundle.origin);
  std::memcpy(bundle.corner, b.corner, sizeof bundle.corner);
  std::memcpy(bundle.edge_u, b.edge_u, sizeof bundle.edge_u);
  std::memcpy(bundle.edge_v, b.edge_v, sizeof bundle.edge_v);
  bundle.u = {b.u, b.count}, bundle.v = {b.v, b.count};
  return bundle;
}

inline SphereBundle translate(const vcd_sphere_bundle& b) {
  assert(is_whole(b));
  SphereBundle bundle{};
  std::memcpy(bundle.origin, b.origin, sizeof bundle.origin);
  std::memcpy(bundle.centre, b.centre, sizeof bundle.centre);
  bundle.radius = b.radius;
  bundle.x = {b.x, b.count}, bundle.y = {b.y, b.count}, bundle.z = {b.z, b.count};
  return bundle;
}

inline PointBundle translate(const vcd_point_bundle& b) {
  assert(is_whole(b));
  PointBundle bundle{};
  std::memcpy(bundle.origin, b.origin, sizeof bundle.origin);
  bundle.x = {b.x, b.count}, bundle.y = {b.y, b.count}, bundle.z = {b.z, b.count};
  return bundle;
}

inline Segment translate(const vcd_segment& from) {
  Segment segment;
  std::memcpy(&segment, &from, sizeof segment);
  return segment;
}

inline SegmentArrays translate(const vcd_segment_arrays& from) {
  return {{from.origin[0], from.origin[1], from.origin[2]},
          from.t_min,
          {from.direction[0], from.direction[1], from.direction[2]},
          from.t_max,
          from.count};
}

}  // namespace vcd::in_c
