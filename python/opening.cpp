// Sidecars: files and buffers are opened, and objects taken from them.
#include <memory>
#include <optional>

#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <vcd/format/contents.h>
#include <vcd/runtime/sidecar.h>

#include "arrays.h"
#include "asking.h"
#include "module.h"

namespace vcd::python {

OpenOptions options_of(bool proven_only, bool copy, const std::string& check, const std::string& look_up,
                       const std::string& kernel) {
  constexpr Named<CheckLevel> kChecks[] = {
      {"checksums", CheckLevel::checksums}, {"bounds", CheckLevel::bounds}, {"canonical", CheckLevel::canonical}};
  constexpr Named<LookUpFirst> kLookUps[] = {
      {"as_baked", LookUpFirst::as_baked}, {"always", LookUpFirst::always}, {"never", LookUpFirst::never}};
  OpenOptions options;
  options.load = copy ? Load::copy : Load::map;
  options.check = value_named(kChecks, check, "check");
  options.proven_only = proven_only;
  options.look_up = value_named(kLookUps, look_up, "look_up");
  options.kernel = kernel;
  return options;
}

namespace {

struct OpenFile {
  Sidecar sidecar;
  py::object buffer;  // that it was opened from, if it was
};
using File = std::shared_ptr<OpenFile>;

File open_file(const py::object& source, bool proven_only, bool copy, const std::string& check,
               const std::string& look_up, const std::string& kernel) {
  const OpenOptions options = options_of(proven_only, copy, check, look_up, kernel);
  if (!PyObject_CheckBuffer(source.ptr())) {
    const auto path = source.cast<std::filesystem::path>();
    auto sidecar = [&] {
      const py::gil_scoped_release unlocked;
      return Sidecar::open(path, options);
    }();
    return std::make_shared<OpenFile>(OpenFile{value_or_raise(std::move(sidecar)), {}});
  }
  // The view keeps the memory, and keeps a bytearray from being resized.
  const py::object view = py::module_::import("numpy").attr("frombuffer")(source, "uint8");
  const py::array bytes = view.cast<py::array>();
  if (reinterpret_cast<uintptr_t>(bytes.data()) % 8 != 0)
    throw py::value_error("the buffer needs to be aligned to 8 bytes (to 64 bytes it is used without a copy)");
  const Bytes in_place{static_cast<const std::byte*>(bytes.data()), static_cast<size_t>(bytes.size())};
  auto sidecar = [&] {
    const py::gil_scoped_release unlocked;
    return Sidecar::open_buffer(in_place, options);
  }();
  return std::make_shared<OpenFile>(OpenFile{value_or_raise(std::move(sidecar)), view});
}

OpenObject object_at(const File& file, py::ssize_t index) {
  const auto count = static_cast<py::ssize_t>(file->sidecar.object_count());
  if (index < 0) index += count;
  if (index < 0 || index >= count) throw py::index_error("no such object");
  return {file, file->sidecar.object(static_cast<size_t>(index))};
}

OpenObject object_named(const File& file, const std::string& name) {
  const auto object = file->sidecar.find(name);
  if (!object) throw py::key_error(name);
  return {file, *object};
}

std::optional<OpenObject> object_of_hash(const File& file, const py::bytes& hash) {
  const auto object = file->sidecar.find(hash_of(hash));
  if (!object) return {};
  return OpenObject{file, *object};
}

}  // namespace

void define_opening(py::module_& module) {
  py::class_<OpenFile, File>(module, "Sidecar", "An open sidecar: a sequence of its objects.")
      .def("__len__", [](const OpenFile& self) { return self.sidecar.object_count(); })
      .def("__getitem__", &object_at, py::arg("index"))
      .def("__getitem__", &object_named, py::arg("name"))
      .def("find", &object_of_hash, py::arg("geometry_hash"), "The first object of that hash (16 bytes), or None.")
      .def_property_readonly(
          "kernel", [](const OpenFile& self) { return self.sidecar.kernel(); }, "What answers arrays: see kernels().")
      .def_property_readonly(
          "provenance",
          [](const OpenFile& self) {
            py::dict provenance;
            for (const auto& [key, value] : self.sidecar.contents().provenance)
              provenance[py::str(key.data(), key.size())] = py::str(value.data(), value.size());
            return provenance;
          },
          "What the file says of its making, a dict of texts.");
  module.def("open", &open_file, py::arg("source"), py::kw_only(), py::arg("proven_only") = false,
             py::arg("copy") = false, py::arg("check") = "checksums", py::arg("look_up") = "as_baked",
             py::arg("kernel") = "",
             "Opens a sidecar: a path, or a buffer that holds a whole file and stays unchanged.\n\n"
             "proven_only: trust proofs alone. copy: read a file into memory rather than map it. check: \"checksums\", "
             "\"bounds\" (faster) or \"canonical\" (slow). look_up: before the hierarchy, \"as_baked\", \"always\" or "
             "\"never\". kernel: one of kernels(). A buffer has to be aligned to 8 bytes, and is used without a copy "
             "where it is aligned to 64. Raises FileError, InvalidFile or Unsupported. Releases the GIL.");
}

}  // namespace vcd::python
