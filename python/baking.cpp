// Meshes from arrays, bakes, files and their verification: <vcd/baker/bake.h>, <vcd/writer/writer.h>,
// <vcd/verify/check.h>.
#include <atomic>
#include <cstring>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <vector>

#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <vcd/baker/bake.h>
#include <vcd/format/file_bytes.h>
#include <vcd/format/geometry_hash.h>
#include <vcd/verify/check.h>

#include "arrays.h"
#include "module.h"
#include "records.h"

namespace vcd::python {
namespace {

using Mesh = std::shared_ptr<baker::PreparedMesh>;

template <class Index>
bool take_triangles(const py::array& array, size_t vertices, std::vector<baker::TriangleIndices>& triangles) {
  if (!py::isinstance<py::array_t<Index>>(array)) return false;
  const auto corners = array.cast<py::array_t<Index>>().template unchecked<2>();
  triangles.resize(static_cast<size_t>(corners.shape(0)));
  for (py::ssize_t i = 0; i < corners.shape(0); ++i)
    for (py::ssize_t corner = 0; corner < 3; ++corner) {
      const Index index = corners(i, corner);
      if (index < 0 || static_cast<uint64_t>(index) >= vertices)
        throw py::value_error("triangles: row " + std::to_string(i) + " has the index " + std::to_string(index) +
                              ", and there are " + std::to_string(vertices) + " positions");
      triangles[static_cast<size_t>(i)][static_cast<size_t>(corner)] = static_cast<uint32_t>(index);
    }
  return true;
}

baker::SourceMesh source_mesh(const py::array& positions, const py::array& triangles, const std::string& name) {
  baker::SourceMesh source;
  source.name = name;
  if (!py::isinstance<py::array_t<float>>(positions))
    throw py::type_error("positions: needs a float32 array of shape (n, 3); got " + shape_text(positions));
  if (positions.ndim() != 2 || positions.shape(1) != 3)
    throw py::value_error("positions: needs a float32 array of shape (n, 3); got " + shape_text(positions));
  const auto at = positions.cast<py::array_t<float>>().unchecked<2>();
  source.positions.resize(static_cast<size_t>(at.shape(0)));
  for (py::ssize_t i = 0; i < at.shape(0); ++i)
    source.positions[static_cast<size_t>(i)] = {at(i, 0), at(i, 1), at(i, 2)};

  if (triangles.ndim() != 2 || triangles.shape(1) != 3)
    throw py::value_error("triangles: needs an array of shape (m, 3); got " + shape_text(triangles));
  const size_t vertices = source.positions.size();
  if (!take_triangles<int32_t>(triangles, vertices, source.triangles) &&
      !take_triangles<uint32_t>(triangles, vertices, source.triangles) &&
      !take_triangles<int64_t>(triangles, vertices, source.triangles) &&
      !take_triangles<uint16_t>(triangles, vertices, source.triangles))
    throw py::type_error("triangles: needs int32, uint32, int64 or uint16; got " + shape_text(triangles));
  return source;
}

Mesh prepare(const py::array& positions, const py::array& triangles, const std::string& name,
             const std::array<double, 3>& shift) {
  baker::SourceMesh source = source_mesh(positions, triangles, name);
  source.shift = shift;
  auto mesh = [&] {
    const py::gil_scoped_release unlocked;
    return baker::prepare(std::move(source));
  }();
  return std::make_shared<baker::PreparedMesh>(value_or_raise(std::move(mesh)));
}

py::bytes hash_of_mesh(const py::array& positions, const py::array& triangles) {
  const baker::SourceMesh mesh = source_mesh(positions, triangles, {});
  auto hash = [&] {
    const py::gil_scoped_release unlocked;
    return geometry_hash(mesh.positions, mesh.triangles);
  }();
  return bytes_of_hash(value_or_raise(std::move(hash)));
}

// A view of the mesh's own memory, which it keeps alive. Not writeable.
template <class T, size_t kColumns>
py::array_t<T> rows_of(const py::object& mesh, const std::vector<std::array<T, kColumns>>& rows) {
  py::array_t<T> view({rows.size(), kColumns}, rows.front().data(), mesh);
  view.attr("flags").attr("writeable") = false;
  return view;
}

Method method_named(const std::string& name) {
  for (const Method method : {Method::none, Method::sampled, Method::proven, Method::hybrid})
    if (name == name_of(method)) return method;
  throw py::value_error("method: one of \"hybrid\", \"proven\", \"sampled\", \"none\"; got \"" + name + "\"");
}

// A bake in a thread of its own. The caller's thread waits for it without the GIL, and calls Python now and then: so
// Ctrl-C and what `progress` raises end the bake.
class RunningBake {
 public:
  RunningBake(Mesh mesh, baker::BakeOptions options) : mesh_(std::move(mesh)), options_(std::move(options)) {
    options_.stop = [this] { return stopped_.load(std::memory_order_relaxed); };
    options_.on_pass = [this](baker::BakePass pass) { set(pass, 0); };
    options_.progress = [this](const baker::BakeProgress& p) { set({}, p.fraction); };
    result_ = std::async(std::launch::async, [this] { return baker::bake(*mesh_, options_); });
  }
  ~RunningBake() {
    stopped_ = true;
    const py::gil_scoped_release unlocked;
    if (result_.valid()) result_.wait();
  }

  Result<baker::BakedObject> wait(const py::object& progress) {
    for (bool done = false; !done;) {
      if (PyErr_CheckSignals() != 0) throw py::error_already_set();
      if (!progress.is_none()) tell(progress);
      const py::gil_scoped_release unlocked;
      done = result_.wait_for(std::chrono::milliseconds(50)) == std::future_status::ready;
    }
    return result_.get();
  }

 private:
  void set(std::optional<baker::BakePass> pass, double fraction) {
    const std::lock_guard lock(mutex_);
    pass_ = pass.value_or(pass_);
    fraction_ = fraction;
  }
  void tell(const py::object& progress) {
    std::unique_lock lock(mutex_);
    const auto [pass, fraction] = std::pair(pass_, fraction_);
    lock.unlock();
    progress(name_of(pass), fraction);
  }

  Mesh mesh_;
  baker::BakeOptions options_;
  std::atomic<bool> stopped_ = false;
  std::mutex mutex_;  // of the two below
  baker::BakePass pass_ = baker::BakePass::hierarchy;
  double fraction_ = 0;
  std::future<Result<baker::BakedObject>> result_;
};

using Baked = std::shared_ptr<baker::BakedObject>;

Baked bake(const Mesh& mesh, const std::string& method, uint32_t depth, uint32_t samples, uint64_t seed,
           unsigned threads, uint64_t budget_bytes, double budget_seconds, bool hierarchy, bool horizons,
           bool embed_geometry, uint64_t audit_lines, const py::object& progress) {
  baker::BakeOptions options;
  options.method = method_named(method);
  options.depth = depth;
  options.samples = samples;
  options.seed = seed;
  options.threads = threads;
  options.budget_bytes = budget_bytes;
  options.budget_seconds = budget_seconds;
  options.hierarchy = hierarchy;
  options.horizons = horizons;
  options.embed_geometry = embed_geometry;
  options.audit_lines = audit_lines;
  return std::make_shared<baker::BakedObject>(value_or_raise(RunningBake(mesh, std::move(options)).wait(progress)));
}

SidecarToWrite contents_of(const std::vector<Baked>& objects, const std::map<std::string, std::string>& provenance,
                           bool compress) {
  SidecarToWrite contents;
  for (const Baked& object : objects) contents.objects.push_back(object->to_write());
  contents.provenance = provenance;
  contents.storage = compress ? Storage::zstd : Storage::raw;
  return contents;
}

uint64_t write(const std::filesystem::path& path, const std::vector<Baked>& objects,
               const std::map<std::string, std::string>& provenance, bool compress) {
  const SidecarToWrite contents = contents_of(objects, provenance, compress);
  auto size = [&] {
    const py::gil_scoped_release unlocked;
    return write_sidecar(path, contents);
  }();
  return value_or_raise(std::move(size));
}

py::array_t<uint8_t> sidecar_in_memory(const std::vector<Baked>& objects,
                                       const std::map<std::string, std::string>& provenance, bool compress) {
  const SidecarToWrite contents = contents_of(objects, provenance, compress);
  auto result = [&] {
    const py::gil_scoped_release unlocked;
    return sidecar_bytes(contents);
  }();
  auto* bytes = new AlignedBytes(value_or_raise(std::move(result)));
  const py::capsule owner(bytes, [](void* p) { delete static_cast<AlignedBytes*>(p); });
  return py::array_t<uint8_t>(static_cast<py::ssize_t>(bytes->size),
                              reinterpret_cast<const uint8_t*>(bytes->data.get()), owner);
}

// The bytes of a file or a buffer, aligned to 64.
AlignedBytes aligned_copy(const py::object& source) {
  std::optional<FileBytes> file;
  py::array view;
  Bytes bytes;
  if (PyObject_CheckBuffer(source.ptr())) {
    view = py::module_::import("numpy").attr("frombuffer")(source, "uint8");
    bytes = {static_cast<const std::byte*>(view.data()), static_cast<size_t>(view.size())};
  } else {
    file = value_or_raise(FileBytes::map(source.cast<std::filesystem::path>()));
    bytes = file->bytes();
  }
  AlignedBytes copy = allocate_aligned(bytes.size());
  if (!copy.data) raise({ErrorCode::runtime, "out of memory"});
  if (!bytes.empty()) std::memcpy(copy.data.get(), bytes.data(), bytes.size());
  return copy;
}

py::object verification_of(const verify::Outcome& outcome) {
  py::list issues, audits;
  for (const verify::Issue& issue : outcome.issues)
    issues.append(
        make_record("Issue", issue.info->id, issue.severity == Severity::error ? "error" : "warning", issue.text()));
  for (const verify::ObjectCheck& object : outcome.objects)
    audits.append(object.audit ? audit_of(*object.audit) : py::none());
  return make_record("Verification", !outcome.failed(), issues, audits);
}

py::object verify_sidecar(const py::object& source, const std::vector<Mesh>& meshes, uint64_t lines, uint64_t seed) {
  const AlignedBytes bytes = aligned_copy(source);
  const verify::Outcome outcome = [&] {
    const py::gil_scoped_release unlocked;
    std::vector<baker::PreparedMesh> prepared;
    for (const Mesh& mesh : meshes) prepared.push_back(*mesh);
    verify::CheckOptions options;
    options.audit.lines = lines;
    options.audit.seed = seed;
    return verify::check_bytes({bytes.data.get(), bytes.size}, prepared, options);
  }();
  return verification_of(outcome);
}

void define_mesh(py::module_& module) {
  module.def("geometry_hash", &hash_of_mesh, py::arg("positions"), py::arg("triangles"),
             "The hash (16 bytes) that prepare() would give, and that Sidecar.find() takes: the same for equal "
             "geometry, whatever its order or winding. Arrays as for prepare().");
  py::class_<baker::PreparedMesh, Mesh>(module, "Mesh", "One mesh, welded and sorted: what is baked. Read-only.")
      .def_property_readonly(
          "name", [](const baker::PreparedMesh& self) { return self.name; }, "As it was given.")
      .def_property_readonly(
          "positions",
          [](const py::object& self) { return rows_of(self, self.cast<const baker::PreparedMesh&>().positions); },
          "(vertices, 3) float32, sorted, each once; a view.")
      .def_property_readonly(
          "triangles",
          [](const py::object& self) { return rows_of(self, self.cast<const baker::PreparedMesh&>().triangles); },
          "(triangles, 3) uint32, sorted, each once; a view.")
      .def_property_readonly(
          "geometry_hash", [](const baker::PreparedMesh& self) { return bytes_of_hash(self.geometry_hash); },
          "16 bytes: equal for equal geometry, whatever its order or winding.")
      .def_property_readonly(
          "box_min", [](const baker::PreparedMesh& self) { return py::tuple(py::cast(self.box_min)); },
          "The least corner of the padded box.")
      .def_property_readonly(
          "box_max", [](const baker::PreparedMesh& self) { return py::tuple(py::cast(self.box_max)); },
          "The greatest corner of the padded box.");
  module.def("prepare", &prepare, py::arg("positions"), py::arg("triangles"), py::kw_only(), py::arg("name") = "",
             py::arg("shift") = std::array<double, 3>{},
             "The mesh to bake.\n\n"
             "positions: (n, 3) float32, finite, in the object's own frame and unit. triangles: (m, 3) int32, uint32, "
             "int64 or uint16, rows of positions; any winding. shift: what was subtracted from the source's "
             "coordinates. Copies. Raises InvalidFile where no triangle has an area. Releases the GIL.");
}

void define_baked(py::module_& module) {
  py::class_<baker::BakedObject, Baked>(module, "Baked", "One baked object: to be written, with what the bake found.")
      .def_property_readonly(
          "name", [](const baker::BakedObject& self) { return self.name; }, "Of the mesh.")
      .def_property_readonly(
          "record", [](const baker::BakedObject& self) { return record_of(self.record, self.name); }, "A Record.")
      .def_property_readonly(
          "plan",
          [](const baker::BakedObject& self) -> py::object { return self.plan ? plan_of(*self.plan) : py::none(); },
          "A Plan if depth was 0, else None.")
      .def_property_readonly(
          "audit",
          [](const baker::BakedObject& self) -> py::object { return self.audit ? audit_of(*self.audit) : py::none(); },
          "An Audit if audit_lines was not 0 and the object answers anything, else None.")
      .def_property_readonly(
          "rays", [](const baker::BakedObject& self) { return self.rays; }, "Traced to classify.")
      .def_property_readonly(
          "seconds", [](const baker::BakedObject& self) { return self.seconds; }, "Of that.")
      .def_property_readonly(
          "out_of_time", [](const baker::BakedObject& self) { return self.out_of_time; },
          "Whether budget_seconds left cells unclassified.")
      .def_property_readonly(
          "without_horizons", [](const baker::BakedObject& self) { return self.without_horizons; },
          "Why there are none though they were asked for, a clause; else empty.");
  module.def("bake", &bake, py::arg("mesh"), py::kw_only(), py::arg("method") = "hybrid", py::arg("depth") = 0,
             py::arg("samples") = 0, py::arg("seed") = 0, py::arg("threads") = 0, py::arg("budget_bytes") = 0,
             py::arg("budget_seconds") = 0.0, py::arg("hierarchy") = true, py::arg("horizons") = false,
             py::arg("embed_geometry") = false, py::arg("audit_lines") = 0, py::arg("progress") = py::none(),
             "Bakes one mesh.\n\n"
             "method: \"hybrid\", \"proven\", \"sampled\" or \"none\". depth: 1 to 8; 0: as deep as pays. samples: "
             "rays a cell; 0: by method. threads: 0: all. budget_bytes, budget_seconds: 0: none. hierarchy: keep the "
             "triangles, which occluded() needs. horizons: for segments that begin on the object, see "
             "Object.occluded_self(). audit_lines: fresh lines, judged in exact arithmetic.\n\n"
             "progress(name of the pass, fraction of it): called some twenty times a second from the caller's thread. "
             "What it raises ends the bake and passes through; so does Ctrl-C. Equal meshes and options give equal "
             "bytes. Raises UsageError, Difference (a wrong proof) or Error. Releases the GIL.");
}

void define_files(py::module_& module) {
  module.def("write", &write, py::arg("path"), py::arg("objects"), py::kw_only(),
             py::arg("provenance") = std::map<std::string, std::string>{}, py::arg("compress") = false,
             "Writes a sidecar of baked objects and returns its size in bytes.\n\n"
             "The path belongs to the old file or to the whole new one at any time. provenance: texts on its making. "
             "compress: to ship, not to render. Raises FileError or UsageError. Releases the GIL.");
  module.def("sidecar_bytes", &sidecar_in_memory, py::arg("objects"), py::kw_only(),
             py::arg("provenance") = std::map<std::string, std::string>{}, py::arg("compress") = false,
             "The same bytes as an array of uint8, which open() uses without a copy.");
  module.def("verify", &verify_sidecar, py::arg("source"), py::arg("meshes"), py::kw_only(),
             py::arg("lines") = 1'000'000, py::arg("seed") = 1,
             "Holds a sidecar, a path or a buffer, against its meshes, as vc-verify does: every byte, the mesh's "
             "facts, and fresh lines judged in exact arithmetic.\n\n"
             "meshes: prepare() makes them; each object needs the one with its geometry hash. Returns a Verification. "
             "Releases the GIL.");
}

}  // namespace

void define_baking(py::module_& module) {
  define_mesh(module);
  define_baked(module);
  define_files(module);
}

}  // namespace vcd::python

PYBIND11_MODULE(_native, module) {
  module.doc() = "The compiled part of vcd.";
  vcd::python::define_asking(module);
  vcd::python::define_opening(module);
  vcd::python::define_store(module);
  vcd::python::define_baking(module);
}
