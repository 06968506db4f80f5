#include "records.h"

#include <algorithm>
#include <cstring>

#include <pybind11/stl.h>

#include "arrays.h"

namespace vcd::python {
namespace {

template <class T>
py::tuple tuple_of(const T& values) {
  py::tuple tuple(std::size(values));
  for (size_t i = 0; i < std::size(values); ++i) tuple[i] = values[i];
  return tuple;
}

}  // namespace

void raise(const Error& error) {
  const char* type = "Error";
  switch (error.code) {
    case ErrorCode::usage: type = "UsageError"; break;
    case ErrorCode::io: type = "FileError"; break;
    case ErrorCode::invalid_file: type = "InvalidFile"; break;
    case ErrorCode::unsupported: type = "Unsupported"; break;
    case ErrorCode::difference: type = "Difference"; break;
    case ErrorCode::runtime:
    case ErrorCode::stale: break;
  }
  PyErr_SetString(py::module_::import("vcd.records").attr(type).ptr(), error.message.c_str());
  throw py::error_already_set();
}

std::string shape_text(const py::array& array) {
  return py::str(array.dtype()).cast<std::string>() + " array of shape " +
         py::str(py::object(array.attr("shape"))).cast<std::string>();
}

std::span<const Segment> segments_of(const py::array& array) {
  const auto floats = values_of<float>(array, {-1, 8}, "segments",
                                       "needs a float32 array of shape (n, 8), each row origin x, y, z, t_min, "
                                       "direction x, y, z, t_max (vcd.segments makes one)");
  return {reinterpret_cast<const Segment*>(floats.data()), floats.size() / 8};
}

std::array<float, 3> vector_of(const Numbers& array, const char* name) {
  if (array.ndim() != 1 || array.size() != 3)
    throw py::value_error(std::string(name) + ": needs three numbers; got " + shape_text(array));
  return {array.at(0), array.at(1), array.at(2)};
}

py::array_t<bool> bools_of(std::span<const uint64_t> bits, size_t count) {
  py::array_t<bool> bools(static_cast<py::ssize_t>(count));
  auto* out = reinterpret_cast<uint8_t*>(bools.mutable_data());
  const py::gil_scoped_release unlocked;
  size_t i = 0;
  for (; i + 8 <= count; i += 8) {  // eight bits to eight bytes: each byte of the product's mask is 0 or 1
    const uint64_t byte = bits[i / 64] >> (i % 64) & 0xFF;
    const uint64_t apart = (byte * 0x8040201008040201 & 0x8080808080808080) >> 7;
    const uint64_t ordered = __builtin_bswap64(apart);
    std::memcpy(out + i, &ordered, 8);
  }
  for (; i < count; ++i) out[i] = bits[i / 64] >> (i % 64) & 1;
  return bools;
}

py::bytes bytes_of_hash(const std::array<uint8_t, 16>& hash) {
  return {reinterpret_cast<const char*>(hash.data()), hash.size()};
}

std::array<uint8_t, 16> hash_of(const py::bytes& bytes) {
  const std::string_view view = bytes;
  std::array<uint8_t, 16> hash;
  if (view.size() != hash.size()) throw py::value_error("a geometry hash has 16 bytes");
  std::copy(view.begin(), view.end(), hash.begin());
  return hash;
}

const char* name_of(Method method) {
  constexpr const char* kNames[] = {"none", "sampled", "proven", "hybrid"};
  return kNames[static_cast<size_t>(method)];
}

py::object record_of(const ObjectRecord& r, std::string_view name) {
  return make_record("Record", name, r.source_index, name_of(static_cast<Method>(r.method)), r.depth,
                     r.method_parameters[0], r.method_parameters[1] | uint64_t{r.method_parameters[2]} << 32,
                     tuple_of(r.box_min), tuple_of(r.box_max), bytes_of_hash(r.geometry_hash), r.triangle_count,
                     r.vertex_count, r.cells[0], r.cells[1], r.cells[2], r.statistical_cells, tuple_of(r.audit_lines),
                     tuple_of(r.audit_wrong), r.audit_bound_95, r.guard_band, tuple_of(r.shift),
                     (r.flags & kPartsLeftOut) != 0, (r.flags & kLookUpFromOutside) != 0,
                     (r.flags & kLookUpFromInside) != 0);
}

py::object plan_of(const baker::Plan& plan) {
  py::list forecasts;
  for (const baker::DepthForecast& f : plan.forecasts)
    forecasts.append(make_record("DepthForecast", f.depth, f.bytes, f.seconds, f.resolved, f.resolved_shadow, f.gain));
  return make_record("Plan", plan.depth, plan.reason, forecasts, plan.seconds);
}

py::object audit_of(const baker::AuditReport& report) {
  py::list counts, contradictions;
  for (size_t kind = 0; kind < baker::kAuditKinds; ++kind) {
    const baker::AuditCounts& c = report.counts[kind];
    counts.append(make_record("AuditCounts", baker::audit_kind_name(static_cast<baker::AuditKind>(kind)), c.segments,
                              c.answered[0], c.answered[1], c.wrong[0], c.wrong[1], c.wrong_proven));
  }
  for (const baker::Contradiction& c : report.contradictions) {
    const Segment& s = c.segment;
    contradictions.append(make_record("Contradiction", baker::audit_kind_name(c.kind),
                                      py::make_tuple(s.origin[0], s.origin[1], s.origin[2], s.t_min, s.direction[0],
                                                     s.direction[1], s.direction[2], s.t_max),
                                      make_record("Visibility", static_cast<int>(c.promised)), c.proven));
  }
  return make_record("Audit", counts, contradictions);
}

}  // namespace vcd::python
