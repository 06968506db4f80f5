// Objects, bundles and scenes: <vcd/runtime/sidecar.h> and <vcd/runtime/scene.h> for arrays.
#include <optional>
#include <vector>

#include <pybind11/stl.h>

#include <vcd/runtime/scene.h>
#include <vcd/runtime/sidecar.h>

#include "arrays.h"
#include "asking.h"
#include "module.h"
#include "records.h"

namespace vcd::python {

namespace {

struct OpenScene {
  Scene scene;
  std::vector<OpenObject> objects;
};

From from_named(const std::string& name) {
  constexpr Named<From> kAll[] = {{"outside", From::outside}, {"inside", From::inside}, {"self", From::self}};
  return value_named(kAll, name, "start");
}

size_t words(size_t count) { return (count + 63) / 64; }

// ask(answers) fills count answers, without the GIL.
template <class Ask>
py::array_t<uint8_t> answers_of(size_t count, Ask&& ask) {
  py::array_t<uint8_t> answers(static_cast<py::ssize_t>(count));
  const std::span out(reinterpret_cast<Visibility*>(answers.mutable_data()), count);
  const py::gil_scoped_release unlocked;
  ask(out);
  return answers;
}

// ask(blocked) fills the bits, without the GIL.
template <class Ask>
py::array_t<bool> blocked_of(size_t count, Ask&& ask) {
  std::vector<uint64_t> blocked(words(count));
  {
    const py::gil_scoped_release unlocked;
    ask(std::span(blocked));
  }
  return bools_of(blocked, count);
}

// ask(blocked, unclassified) fills the bits of a bundle.
template <class Ask>
py::array_t<uint8_t> bundle_answers(size_t count, Ask&& ask) {
  return answers_of(count, [&](std::span<Visibility> answers) {
    std::vector<uint64_t> blocked(words(count)), unclassified(words(count));
    ask(std::span(blocked), std::span(unclassified));
    for (size_t i = 0; i < count; ++i)
      answers[i] =
          static_cast<Visibility>((blocked[i / 64] >> (i % 64) & 1) | (unclassified[i / 64] >> (i % 64) & 1) << 1);
  });
}

void require_hierarchy(bool has) {
  if (!has)
    throw py::value_error("occluded() needs the hierarchy of each object, and one was baked without: see classify()");
}

py::array_t<uint8_t> classify(const OpenObject& self, const py::array& segments) {
  const auto asked = segments_of(segments);
  return answers_of(asked.size(), [&](std::span<Visibility> answers) { self.object.classify(asked, answers); });
}

py::array_t<bool> occluded(const OpenObject& self, const py::array& segments, const std::string& start) {
  require_hierarchy(self.object.has_hierarchy());
  const auto asked = segments_of(segments);
  const From from = from_named(start);
  return blocked_of(asked.size(), [&](std::span<uint64_t> bits) { self.object.occluded(asked, bits, from); });
}

constexpr const char* kPrimitives =
    "needs a uint32 array of shape (n,), the triangle that each segment begins on or 0xFFFFFFFF";

py::array_t<uint8_t> classify_self(const OpenObject& self, const py::array& segments, const py::array& primitives) {
  const auto asked = segments_of(segments);
  const auto begin = values_of<uint32_t>(primitives, {segments.shape(0)}, "primitives", kPrimitives);
  return answers_of(asked.size(),
                    [&](std::span<Visibility> answers) { self.object.classify_self(asked, begin, answers); });
}

py::array_t<bool> occluded_self(const OpenObject& self, const py::array& segments, const py::array& primitives) {
  require_hierarchy(self.object.has_hierarchy());
  const auto asked = segments_of(segments);
  const auto begin = values_of<uint32_t>(primitives, {segments.shape(0)}, "primitives", kPrimitives);
  return blocked_of(asked.size(), [&](std::span<uint64_t> bits) { self.object.occluded_self(asked, begin, bits); });
}

// A bundle and the arrays that it points into.
template <class Bundle>
struct ArrayBundle {
  Bundle bundle;
  std::vector<py::array> arrays;
};

template <class Bundle>
py::array_t<uint8_t> classify_bundle(const OpenObject& self, const ArrayBundle<Bundle>& asked) {
  return bundle_answers(asked.bundle.size(),
                        [&](auto blocked, auto left) { self.object.classify(asked.bundle, blocked, left); });
}

template <class Bundle>
py::array_t<bool> bundle_occluded(const OpenObject& self, const ArrayBundle<Bundle>& asked, const std::string& start) {
  require_hierarchy(self.object.has_hierarchy());
  const From from = from_named(start);
  return blocked_of(asked.bundle.size(),
                    [&](std::span<uint64_t> bits) { self.object.occluded(asked.bundle, bits, from); });
}

template <class Bundle>
py::array_t<uint8_t> bundle_classify_self(const OpenObject& self, const ArrayBundle<Bundle>& asked,
                                          uint32_t primitive) {
  return bundle_answers(asked.bundle.size(),
                        [&](auto, auto left) { self.object.classify_self(asked.bundle, primitive, left); });
}

template <class Bundle>
py::array_t<bool> bundle_occluded_self(const OpenObject& self, const ArrayBundle<Bundle>& asked, uint32_t primitive) {
  require_hierarchy(self.object.has_hierarchy());
  return blocked_of(asked.bundle.size(),
                    [&](std::span<uint64_t> bits) { self.object.occluded_self(asked.bundle, primitive, bits); });
}

void copy_vector(const Numbers& array, const char* name, float (&out)[3]) {
  const auto values = vector_of(array, name);
  std::copy(values.begin(), values.end(), out);
}

std::span<const float> column(const py::array& array, const char* name, py::ssize_t size) {
  return values_of<float>(array, {size}, name, "needs a float32 array of shape (n,), as long as the others");
}

ArrayBundle<QuadBundle> quad_bundle(const Numbers& origin, const Numbers& corner, const Numbers& edge_u,
                                    const Numbers& edge_v, const py::array& u, const py::array& v) {
  ArrayBundle<QuadBundle> made{{}, {u, v}};
  copy_vector(origin, "origin", made.bundle.origin);
  copy_vector(corner, "corner", made.bundle.corner);
  copy_vector(edge_u, "edge_u", made.bundle.edge_u);
  copy_vector(edge_v, "edge_v", made.bundle.edge_v);
  made.bundle.u = column(u, "u", -1);
  made.bundle.v = column(v, "v", u.size());
  return made;
}

template <class Bundle>
void take_samples(ArrayBundle<Bundle>& made, const py::array& x, const py::array& y, const py::array& z) {
  made.arrays = {x, y, z};
  made.bundle.x = column(x, "x", -1);
  made.bundle.y = column(y, "y", x.size());
  made.bundle.z = column(z, "z", x.size());
}

ArrayBundle<SphereBundle> sphere_bundle(const Numbers& origin, const Numbers& centre, float radius, const py::array& x,
                                        const py::array& y, const py::array& z) {
  ArrayBundle<SphereBundle> made;
  copy_vector(origin, "origin", made.bundle.origin);
  copy_vector(centre, "centre", made.bundle.centre);
  made.bundle.radius = radius;
  take_samples(made, x, y, z);
  return made;
}

ArrayBundle<PointBundle> point_bundle(const Numbers& origin, const py::array& x, const py::array& y,
                                      const py::array& z) {
  ArrayBundle<PointBundle> made;
  copy_vector(origin, "origin", made.bundle.origin);
  take_samples(made, x, y, z);
  return made;
}

std::span<const Transform> transforms_of(const py::array& to_world, size_t count) {
  const auto floats =
      values_of<float>(to_world, {static_cast<py::ssize_t>(count), 3, 4}, "to_world",
                       "needs a float32 array of shape (instances, 3, 4), rows of world = rows * (object, 1)");
  return {reinterpret_cast<const Transform*>(floats.data()), count};
}

OpenScene build_scene(const std::vector<OpenObject>& objects, const py::array& to_world,
                      const std::optional<py::array>& masks, const std::string& kernel) {
  const auto transforms = transforms_of(to_world, objects.size());
  std::span<const uint32_t> bits;
  if (masks)
    bits = values_of<uint32_t>(*masks, {static_cast<py::ssize_t>(objects.size())}, "masks",
                               "needs a uint32 array of shape (instances,)");
  std::vector<SceneInstance> instances;
  instances.reserve(objects.size());
  for (size_t i = 0; i < objects.size(); ++i) {
    instances.push_back(SceneInstance::of(objects[i].object, transforms[i]));
    if (masks) instances.back().mask = bits[i];
  }
  auto scene = [&] {
    const py::gil_scoped_release unlocked;
    return Scene::build(instances, kernel);
  }();
  return {value_or_raise(std::move(scene)), objects};
}

void set_transforms(OpenScene& self, const py::array& to_world) {
  if (const auto error = self.scene.set_transforms(transforms_of(to_world, self.scene.size()))) raise(*error);
}

const char* use_of(const OpenScene& self, uint32_t instance) {
  if (instance >= self.scene.size()) throw py::index_error("no such instance");
  constexpr const char* kNames[] = {"asked", "left", "absent"};
  return kNames[static_cast<size_t>(self.scene.use(instance))];
}

// origins, primitives: of `count` segments, or none.
SceneQuery query_of(const OpenScene& self, uint32_t mask, const std::optional<py::array>& origins,
                    const std::optional<py::array>& primitives, size_t count) {
  SceneQuery query{mask, {}, {}};
  if (primitives) {
    if (!origins) throw py::value_error("primitives: without origins nothing says whose triangles they are");
    query.primitives = values_of<uint32_t>(*primitives, {static_cast<py::ssize_t>(count)}, "primitives", kPrimitives);
  }
  if (origins)
    query.origins = values_of<uint32_t>(*origins, {static_cast<py::ssize_t>(count)}, "origins",
                                        "needs a uint32 array of shape (n,), the instance that each segment begins on "
                                        "or 0xFFFFFFFF");
  for (const uint32_t origin : query.origins)
    if (origin >= self.scene.size() && origin != kNoInstance) throw py::index_error("origins: no such instance");
  return query;
}

py::array_t<uint8_t> classify_scene(const OpenScene& self, const py::array& segments, uint32_t mask,
                                    const std::optional<py::array>& origins) {
  const auto asked = segments_of(segments);
  const SceneQuery query = query_of(self, mask, origins, {}, asked.size());
  return answers_of(asked.size(), [&](std::span<Visibility> answers) { self.scene.classify(asked, answers, query); });
}

py::array_t<bool> scene_occluded(const OpenScene& self, const py::array& segments, uint32_t mask,
                                 const std::optional<py::array>& origins, const std::optional<py::array>& primitives) {
  require_hierarchy(self.scene.has_hierarchies());
  const auto asked = segments_of(segments);
  const SceneQuery query = query_of(self, mask, origins, primitives, asked.size());
  return blocked_of(asked.size(), [&](std::span<uint64_t> bits) { self.scene.occluded(asked, bits, query); });
}

// origin: the instance that the bundle begins on, or none; primitive: likewise, of that instance.
template <class Bundle>
py::array_t<bool> scene_bundle_occluded(const OpenScene& self, const ArrayBundle<Bundle>& asked, uint32_t mask,
                                        std::optional<uint32_t> origin, std::optional<uint32_t> primitive) {
  require_hierarchy(self.scene.has_hierarchies());
  if (origin && *origin >= self.scene.size()) throw py::index_error("origin: no such instance");
  if (primitive && !origin) throw py::value_error("primitive: without origin nothing says whose triangle it is");
  SceneQuery query{mask, {}, {}};
  if (origin) query.origins = {&*origin, 1};
  if (primitive) query.primitives = {&*primitive, 1};
  return blocked_of(asked.bundle.size(),
                    [&](std::span<uint64_t> bits) { self.scene.occluded(asked.bundle, bits, query); });
}

template <class Bundle, class Make, class... Arguments>
void define_bundle(py::module_& module, py::class_<OpenObject>& object, py::class_<OpenScene>& scene, const char* name,
                   const char* doc, Make&& make, Arguments&&... arguments) {
  py::class_<ArrayBundle<Bundle>>(module, name, doc)
      .def(py::init(make), arguments...)
      .def("__len__", [](const ArrayBundle<Bundle>& self) { return self.bundle.size(); });
  if constexpr (!std::is_same_v<Bundle, PointBundle>)  // which is for occluded() alone
    object.def("classify", &classify_bundle<Bundle>, py::arg("bundle"));
  object.def("occluded", &bundle_occluded<Bundle>, py::arg("bundle"), py::arg("start") = "outside");
  object.def("classify_self", &bundle_classify_self<Bundle>, py::arg("bundle"), py::arg("primitive"));
  object.def("occluded_self", &bundle_occluded_self<Bundle>, py::arg("bundle"), py::arg("primitive"));
  scene.def("occluded", &scene_bundle_occluded<Bundle>, py::arg("bundle"), py::kw_only(), py::arg("mask") = 0xFFFFFFFFu,
            py::arg("origin") = py::none(), py::arg("primitive") = py::none());
}

py::class_<OpenObject> define_object(py::module_& module) {
  py::class_<OpenObject> object(module, "Object", "One object of an open sidecar. Keeps the sidecar open.");
  object
      .def_property_readonly(
          "name", [](const OpenObject& self) { return self.object.name(); }, "As in the file; may be empty.")
      .def_property_readonly(
          "record", [](const OpenObject& self) { return record_of(self.object.record(), self.object.name()); },
          "A Record: box, depth, method, hash, counts.")
      .def_property_readonly(
          "answers", [](const OpenObject& self) { return self.object.answers(); },
          "False: every segment is unclassified, so that there is no need to ask.")
      .def_property_readonly(
          "has_hierarchy", [](const OpenObject& self) { return self.object.has_hierarchy(); },
          "Whether the file holds the triangles, which occluded() needs.")
      .def("classify", &classify, py::arg("segments"),
           "What look-ups say of each segment: (n, 8) float32 in, (n,) uint8 of Visibility out.\n\n"
           "A QuadBundle or SphereBundle of n segments may be given too. Any bits are allowed in a segment; what is "
           "doubtful is "
           "unclassified. Releases the GIL.")
      .def("occluded", &occluded, py::arg("segments"), py::arg("start") = "outside",
           "Whether the object blocks each segment: (n, 8) float32, or a bundle, in, (n,) bool out.\n\n"
           "What no look-up decides, the hierarchy of triangles does, exactly. start: where segments begin, "
           "\"outside\" the box, \"inside\" it, or on the object it\"self\"; it says whether to look up first. "
           "ValueError without has_hierarchy. Releases the GIL.")
      .def_property_readonly(
          "has_horizons", [](const OpenObject& self) { return self.object.has_horizons(); },
          "Whether classify_self() proves anything: the bake was asked for horizons, and they answer enough.")
      .def("classify_self", &classify_self, py::arg("segments"), py::arg("primitives"),
           "What horizons prove of segments that begin on the object: (n,) uint8, clear or unclassified.\n\n"
           "primitives: (n,) uint32, the triangle that each begins on, as prepare() was given them, or 0xFFFFFFFF. Of "
           "a bundle one. Never wrong, whatever is given. Releases the GIL.")
      .def("occluded_self", &occluded_self, py::arg("segments"), py::arg("primitives"),
           "The same, and what horizons leave unclassified the hierarchy decides: (n,) bool, exact.\n\n"
           "ValueError without has_hierarchy. Releases the GIL.");
  return object;
}

py::class_<OpenScene> define_scene(py::module_& module) {
  py::class_<OpenScene> scene(module, "Scene", "Instances of objects, asked together.");
  scene
      .def(py::init(&build_scene), py::arg("objects"), py::arg("to_world"), py::arg("masks") = py::none(),
           py::arg("kernel") = "",
           "objects: one for each instance. to_world: (instances, 3, 4) float32, rows of world = rows * (object, 1). "
           "masks: (instances,) uint32; an instance is asked where its mask shares a bit with the query's.")
      .def("__len__", [](const OpenScene& self) { return self.scene.size(); })
      .def("set_transforms", &set_transforms, py::arg("to_world"),
           "New transforms for all instances, (instances, 3, 4) float32. Not beside a query of another thread.")
      .def("use", &use_of, py::arg("instance"),
           "\"asked\"; \"left\" (unclassified wherever a segment could meet it); \"absent\" (scale 0).")
      .def("classify", &classify_scene, py::arg("segments"), py::kw_only(), py::arg("mask") = 0xFFFFFFFFu,
           py::arg("origins") = py::none(),
           "What look-ups say of each segment, in the world's frame: (n, 8) float32 in, (n,) uint8 of Visibility "
           "out.\n\norigins: (n,) uint32, the instance that each segment begins on or 0xFFFFFFFF. Releases the GIL.")
      .def("occluded", &scene_occluded, py::arg("segments"), py::kw_only(), py::arg("mask") = 0xFFFFFFFFu,
           py::arg("origins") = py::none(), py::arg("primitives") = py::none(),
           "Whether an instance blocks each segment: (n, 8) float32, or a bundle, in, (n,) bool out, exact.\n\n"
           "origins: as for classify(). primitives: (n,) uint32, the triangle of that instance's object that each "
           "segment begins on or 0xFFFFFFFF, for its horizons. A bundle has one origin and one primitive, or None. "
           "ValueError where an object has no hierarchy. Releases the GIL.");
  return scene;
}

}  // namespace

void define_asking(py::module_& module) {
  auto object = define_object(module);
  auto scene = define_scene(module);
  define_bundle<QuadBundle>(module, object, scene, "QuadBundle",
                            "Segments from origin to corner + u[i] * edge_u + v[i] * edge_v; u and v: (n,) float32.",
                            &quad_bundle, py::arg("origin"), py::arg("corner"), py::arg("edge_u"), py::arg("edge_v"),
                            py::arg("u"), py::arg("v"));
  define_bundle<SphereBundle>(module, object, scene, "SphereBundle",
                              "Segments from origin to samples (x[i], y[i], z[i]) in or on a sphere; (n,) float32.",
                              &sphere_bundle, py::arg("origin"), py::arg("centre"), py::arg("radius"), py::arg("x"),
                              py::arg("y"), py::arg("z"));
  define_bundle<PointBundle>(module, object, scene, "PointBundle",
                             "Segments from origin to origin + (x[i], y[i], z[i]); (n,) float32.", &point_bundle,
                             py::arg("origin"), py::arg("x"), py::arg("y"), py::arg("z"));
  module.def("kernels", &kernels, "What this processor can run, fastest first; all give the same answers.");
  module.def("version", &runtime_version_string, "The library's version, \"1.2.3\".");
}

}  // namespace vcd::python
