// The dataclasses of vcd/records.py, filled from the libraries' structs.
#pragma once

#include <string_view>

#include <pybind11/pybind11.h>

#include <vcd/baker/audit.h>
#include <vcd/baker/plan.h>
#include <vcd/format/layout.h>

namespace vcd::python {

pybind11::object record_of(const ObjectRecord& record, std::string_view name);
pybind11::object plan_of(const baker::Plan& plan);
pybind11::object audit_of(const baker::AuditReport& report);

const char* name_of(Method method);

// An instance of a class of vcd/records.py.
template <class... Members>
pybind11::object make_record(const char* type, Members&&... members) {
  return pybind11::module_::import("vcd.records").attr(type)(std::forward<Members>(members)...);
}

}  // namespace vcd::python
