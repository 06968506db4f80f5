// What all that asks has in common: how files are opened, and objects that keep what they came from.
#pragma once

#include <memory>
#include <string>

#include <pybind11/pybind11.h>

#include <vcd/runtime/sidecar.h>

namespace vcd::python {

// What is asked needs its file alive: every object keeps it, or the store that opened it.
struct OpenObject {
  std::shared_ptr<const void> keeps;
  Object object;
};

template <class Enum>
struct Named {
  const char* name;
  Enum value;
};

template <class Enum, size_t kCount>
Enum value_named(const Named<Enum> (&all)[kCount], const std::string& name, const char* what) {
  std::string known;
  for (const Named<Enum>& one : all) {
    if (name == one.name) return one.value;
    known += (known.empty() ? "\"" : ", \"") + std::string(one.name) + "\"";
  }
  throw py::value_error(std::string(what) + ": one of " + known + "; got \"" + name + "\"");
}

// From the arguments of vcd.open(). Throws ValueError where a name is none.
OpenOptions options_of(bool proven_only, bool copy, const std::string& check, const std::string& look_up,
                       const std::string& kernel);

}  // namespace vcd::python
