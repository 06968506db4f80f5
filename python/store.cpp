// Folders of sidecars: <vcd/runtime/sidecar_store.h>.
#include <filesystem>
#include <memory>
#include <optional>
#include <vector>

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <vcd/runtime/sidecar_store.h>

#include "arrays.h"
#include "asking.h"
#include "module.h"

namespace vcd::python {
namespace {

using Store = std::shared_ptr<SidecarStore>;

Store open_store(const std::vector<std::filesystem::path>& folders, bool proven_only, bool copy,
                 const std::string& check, const std::string& look_up, const std::string& kernel) {
  const OpenOptions options = options_of(proven_only, copy, check, look_up, kernel);
  auto store = [&] {
    const py::gil_scoped_release unlocked;
    return SidecarStore::open(folders, options);
  }();
  return std::make_shared<SidecarStore>(value_or_raise(std::move(store)));
}

std::optional<OpenObject> find(const Store& self, const py::bytes& hash) {
  const GeometryHash geometry = hash_of(hash);
  auto found = [&] {
    const py::gil_scoped_release unlocked;
    return self->find(geometry);
  }();
  const auto object = value_or_raise(std::move(found));
  if (!object) return {};
  return OpenObject{self, *object};
}

std::vector<std::string> passed_over(const SidecarStore& self) {
  std::vector<std::string> messages;
  for (const Error& error : self.passed_over()) messages.push_back(error.message);
  return messages;
}

}  // namespace

void define_store(py::module_& module) {
  py::class_<SidecarStore, Store>(module, "SidecarStore",
                                  "Folders of sidecars, found by the geometry that they are of: each file is opened "
                                  "when it is first asked for, once. Any number of threads may share a store.")
      .def(py::init(&open_store), py::arg("folders"), py::kw_only(), py::arg("proven_only") = false,
           py::arg("copy") = false, py::arg("check") = "checksums", py::arg("look_up") = "as_baked",
           py::arg("kernel") = "",
           "Looks for *.vcd in the folders, a sequence of paths, and all below.\n\n"
           "A file whose table cannot be read is passed over. The other arguments are those of open(), for every file. "
           "Raises FileError where a folder cannot be read. Releases the GIL.")
      .def("find", &find, py::arg("geometry_hash"),
           "The object of that hash (16 bytes: geometry_hash()), or None. It keeps the store.\n\n"
           "Of two files with it, the one counts that comes first, by folders as they were given, then by path. Raises "
           "what open() raises; FileError too where the file was replaced since. Releases the GIL.")
      .def("__len__", &SidecarStore::size, "Different geometries.")
      .def_property_readonly("passed_over", &passed_over, "Why files were passed over, a text each.");
}

}  // namespace vcd::python
