// The parts of the module.
#pragma once

#include <pybind11/pybind11.h>

namespace vcd::python {

void define_asking(pybind11::module_& module);   // objects, bundles, scenes
void define_opening(pybind11::module_& module);  // sidecars
void define_store(pybind11::module_& module);    // folders of sidecars
void define_baking(pybind11::module_& module);   // meshes, bakes, files, verification

}  // namespace vcd::python
