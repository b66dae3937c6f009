// Scenes, built in and from files, and the errors of a run of one.

#include <atoll/error_meter.h>
#include <atoll/scene.h>
#include <atoll/world.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "fields.h"
#include "parts.h"

namespace atl::python {
namespace {

void bind_data(nb::module_& module) {
  nb::class_<SceneParameter>(module, "SceneParameter", "A parameter of a built-in scene.")
      .def_ro("name", &SceneParameter::name)
      .def_ro("value", &SceneParameter::value, "by default")
      .def_ro("min", &SceneParameter::min)
      .def_ro("max", &SceneParameter::max)
      .def_ro("integer", &SceneParameter::integer)
      .def_ro("help", &SceneParameter::help);
  nb::class_<BuiltinScene>(module, "BuiltinScene")
      .def_ro("name", &BuiltinScene::name)
      .def_ro("help", &BuiltinScene::help)
      .def_ro("parameters", &BuiltinScene::parameters)
      .def("__repr__", [](const BuiltinScene& self) { return "<BuiltinScene " + self.name + ": " + self.help + ">"; });
  module.def("builtin_scenes", &builtin_scenes, "All of them, in the order to show them.");

  nb::class_<SceneBody> body(module, "SceneBody", "A body of a scene.");
  bind_definition(body, Field{"name", &SceneBody::name, "unique in the scene, or empty"},
                  Field{"definition", &SceneBody::def, ""},
                  Field{"force", &SceneBody::force, "N, shape (3,), in every step"});
  nb::class_<SceneJoint> joint(module, "SceneJoint", "A joint of a scene.");
  bind_definition(joint, Field{"name", &SceneJoint::name, "unique among the joints, or empty"},
                  Field{"definition", &SceneJoint::def, "whose ids of bodies stand open"},
                  Field{"first", &SceneJoint::first, "the body's place in the scene"},
                  Field{"second", &SceneJoint::second, "the other's"},
                  Field{"terms", &SceneJoint::terms, "of a tendon: places of the joints of its terms"});
}

template <typename Part>
void bind_list(nb::class_<Scene>& scene, const char* name, std::vector<Part> Scene::*member) {
  scene.def_prop_rw(
      name,
      [=](nb::handle_t<Scene> self) -> nb::typed<nb::list, Part> {
        const nb::object lists = scene_lists().attr("setdefault")(self, nb::dict());
        if (lists.attr("get")(name).is_none()) lists[name] = nb::cast(nb::cast<const Scene&>(self).*member);
        return nb::borrow<nb::list>(nb::object(lists[name]));
      },
      [=](nb::handle_t<Scene> self, const nb::typed<nb::sequence, Part>& parts) {
        refuse_if_lost(self, "Scene." + std::string(name));
        const nb::object list = nb::isinstance<nb::list>(parts) ? nb::object(parts) : nb::object(nb::list(parts));
        std::vector<Part> read;
        if (!read_parts(list, name, read)) throw nb::type_error(refusal().c_str());
        const nb::object lists = scene_lists().attr("setdefault")(self, nb::dict());
        lists[name] = list;
      },
      "The scene's own list: its elements may be changed, and others put in.");
}

void bind_scene(nb::module_& module) {
  module.attr("_scene_lists") = nb::module_::import_("weakref").attr("WeakKeyDictionary")();
  nb::class_<Scene> scene(module, "Scene", nb::is_weak_referenceable(),
                          "A world to simulate, as data. Can be pickled, but for the closed form of a built-in scene "
                          "whose motion is known: an ErrorMeter of what was pickled has no analytic_error.");
  const auto bind = [&](const auto&... fields) {
    bind_constructor(scene, std::tuple(nb::kw_only()), fields...);
    bind_values(scene, fields...);
  };
  bind(Field{"name", &Scene::name, ""}, Field{"gravity", &Scene::gravity, "m/s^2, shape (3,)"},
       Field{"dt", &Scene::dt, "s"}, Field{"steps", &Scene::steps, "how many it is meant for"},
       Field{"settings", &Scene::settings, ""}, Field{"starts_at_rest", &Scene::starts_at_rest, ""},
       Field{"material_pairs", &Scene::material_pairs, ""}, Field{"bodies", &Scene::bodies, ""},
       Field{"joints", &Scene::joints, ""});
  bind_list(scene, "bodies", &Scene::bodies);
  bind_list(scene, "joints", &Scene::joints);
  bind_list(scene, "material_pairs", &Scene::material_pairs);
  scene.def("__copy__", [](const Scene& self) { return self; })
      .def(
          "__deepcopy__", [](const Scene& self, const nb::dict&) { return self; }, nb::arg("memo"),
          nb::sig("def __deepcopy__(self, memo: dict[int, object]) -> Scene"))
      .def(
          "build",
          [](const Scene& self, int threads, Simd simd) {
            Settings settings = self.settings;
            settings.simd = simd;
            World world({.gravity = self.gravity, .threads = threads, .settings = settings});
            build_scene(self, world);
            return world;
          },
          nb::arg("threads") = 1, nb::arg("simd") = Simd::Auto,
          "A world of the scene's gravity, settings, bodies and joints, whose ids are in the scene's order.")
      .def(
          "add_to", [](const Scene& self, World& world) { return build_scene(self, world); }, nb::arg("world"),
          "Adds all bodies and joints to a world that there is; the ids of the bodies.")
      .def(
          "apply_forces", [](const Scene& self, World& world) { apply_forces(self, world, world.bodies()); },
          nb::arg("world"), "Gives the scene's constant forces to the next step of a world that build() made.")
      .def(
          "write", [](const Scene& self, const std::string& path) { write_scene(self, path); }, nb::arg("path"))
      .def(
          "text", [](const Scene& self) { return scene_text(self); }, "As a scene file.")
      .def("__repr__", [](const Scene& self) {
        return "<Scene " + self.name + " of " + std::to_string(self.bodies.size()) + " bodies, " +
               std::to_string(self.joints.size()) + " joints>";
      });
  module.def(
      "load_scene", [](const std::string& text, std::uint64_t seed) { return load_scene(text, seed); }, nb::arg("text"),
      nb::arg("seed") = 1, "A built-in scene, as \"pile\" or \"pile:bodies=100\", or a scene file. Raises SceneError.");
  module.def(
      "parse_scene", [](const std::string& text, const std::string& origin) { return parse_scene(text, origin); },
      nb::arg("text"), nb::arg("origin") = "text", "A scene file's text.");
  module.def("scene_of", &scene_of, nb::arg("world"), "A world's bodies and joints as they are now.");
}

/// An ErrorMeter of a scene that it keeps.
struct Meter {
  std::unique_ptr<Scene> scene;
  ErrorMeter meter;

  Meter(Scene of, bool every_step)
      : scene(std::make_unique<Scene>(std::move(of))),
        meter(*scene, every_step ? ErrorMeter::Follow::Run : ErrorMeter::Follow::End) {}
};

void bind_meter(nb::module_& module) {
  nb::class_<Meter>(module, "ErrorMeter", "Measures a run of a scene, by code that shares nothing with the simulation.")
      .def(
          nb::init<Scene, bool>(), nb::arg("scene"), nb::arg("every_step") = true,
          "every_step: observe() is called after every step; else after the last one only, without means over the run.")
      .def(
          "observe",
          [](Meter& self, double time, const World& world) {
            const std::vector<BodyId> ids = world.bodies();
            const std::vector<BodyState> states = body_states(world, ids);
            if (!self.meter.needs_loads()) return self.meter.observe(time, states);
            self.meter.observe(time, states, contact_loads(world, ids));
          },
          nb::arg("time"), nb::arg("world"), "A world that Scene.build() made, at a time (s), in order.")
      .def(
          "errors",
          [](const Meter& self) {
            nb::dict errors;
            for (const ErrorMeasure& error : self.meter.errors()) errors[error.name.c_str()] = error.value;
            return errors;
          },
          "By name: penetration_max, joint_drift_max, ..., in SI units.",
          nb::sig("def errors(self) -> dict[str, float]"))
      .def(
          "fell", [](const Meter& self) { return self.meter.fell(); }, "Of a scene that starts at rest.");
}

}  // namespace

void bind_scenes(nb::module_& module) {
  bind_data(module);
  bind_scene(module);
  bind_meter(module);
}

}  // namespace atl::python
