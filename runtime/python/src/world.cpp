// The world: bodies, joints, steps, and arrays over its memory.

#include <atoll/atoll.h>
#include <nanobind/stl/string_view.h>

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "arrays.h"
#include "callbacks.h"
#include "fields.h"
#include "parts.h"
#include "shapes.h"
#include "signals.h"

namespace atl::python {
namespace {

using Class = nb::class_<World>;
using Ids = std::optional<std::vector<BodyId>>;

constexpr auto without_gil = nb::call_guard<nb::gil_scoped_release>();

// The named bodies; all bodies if none are named.
std::vector<BodyId> those(const World& world, const Ids& ids) { return ids ? *ids : world.bodies(); }

template <int columns>
View<columns> view_of(nb::handle self, const double* numbers, std::size_t rows) {
  // The world lives as long as its views, and keeps what they look at.
  return View<columns>(numbers, {rows, static_cast<std::size_t>(columns)}, self);
}

template <int columns, auto column>
void bind_view(Class& world, const char* name, const char* doc) {
  world.def_prop_ro(
      name,
      [](nb::handle self) {
        World& of = nb::cast<World&>(self);
        of.keep_views();
        const auto map = (of.*column)();
        return view_of<columns>(self, map.data(), static_cast<std::size_t>(map.cols()));
      },
      doc);
}

void bind_bodies(Class& world) {
  world.def("add_body", &World::add_body, nb::arg("definition"),
            "Raises Error naming the field and the value if the definition is unusable.");
  with_body_fields([&]<typename... M>(const Field<BodyDef, M>&... fields) {
    const BodyDef defaults;
    world.def(
        "add_body",
        [=](World& self, M... values) {
          BodyDef def;
          ((def.*(fields.member) = std::move(values)), ...);
          return self.add_body(def);
        },
        nb::kw_only(), (nb::arg(fields.name) = defaults.*(fields.member))...,
        "The same, of a BodyDef of these fields.");
  });
  world.def("remove_body", &World::remove_body, nb::arg("body"), "Wakes what touched it, and removes its joints.")
      .def("__contains__", nb::overload_cast<BodyId>(&World::contains, nb::const_), nb::arg("body"))
      .def("__contains__", nb::overload_cast<JointId>(&World::contains, nb::const_), nb::arg("joint"))
      .def_prop_ro("body_count", &World::body_count)
      .def_prop_ro("bodies", &World::bodies, "in order of their indices")
      .def("find_body", &World::find_body, nb::arg("name"), "The first that has the name, or None.")
      .def("pose", &World::pose, nb::arg("body"), "Of the body's frame, in which its shape was given.")
      .def("velocity", &World::velocity, nb::arg("body"), "m/s, shape (3,), of the centre of mass")
      .def("angular_velocity", &World::angular_velocity, nb::arg("body"), "rad/s, shape (3,)")
      .def("centre_of_mass", &World::centre_of_mass, nb::arg("body"), "m, shape (3,), world frame")
      .def("mass", &World::mass, nb::arg("body"), "kg; infinite of static and kinematic bodies")
      .def("type", &World::type, nb::arg("body"))
      .def("is_asleep", &World::is_asleep, nb::arg("body"))
      .def("definition", &World::definition, nb::arg("body"), "One that makes another body like it, as it is now.")
      .def("set_pose", &World::set_pose, nb::arg("body"), nb::arg("pose"))
      .def(
          "set_velocity",
          [](World& self, BodyId body, const Vector3& linear, const Vector3& angular) {
            self.set_velocity(body, linear, angular);
          },
          nb::arg("body"), nb::arg("linear"), nb::arg("angular"), "m/s and rad/s, shape (3,)")
      .def("move_to", &World::move_to, nb::arg("body"), nb::arg("pose"), nb::arg("dt"),
           "Gives a kinematic body the velocities that take it to a pose in a step of dt seconds.")
      .def("set_surface_velocity", &World::set_surface_velocity, nb::arg("body"), nb::arg("velocity"),
           nb::arg("angular") = Vector3(0, 0, 0), "m/s and rad/s, shape (3,), body frame")
      .def("apply_force", &World::apply_force, nb::arg("body"), nb::arg("force"), nb::arg("torque") = Vector3(0, 0, 0),
           "Adds a force (N) through the centre of mass and a torque (N m) to those of the next step.")
      .def("apply_impulse", &World::apply_impulse, nb::arg("body"), nb::arg("impulse"), nb::arg("point"),
           "Changes the velocities at once by an impulse (N s) at a point (m) of the world.")
      .def("wake", &World::wake, nb::arg("body"))
      .def("sleep", &World::sleep, nb::arg("body"), "At once, with all that touches it or is joined to it.")
      .def(
          "bounds",
          [](const World& self, BodyId body) {
            const BoundingBox bounds = self.bounds(body);
            return nb::make_tuple(bounds.lower, bounds.upper);
          },
          nb::arg("body"), "m, world frame: the lower and the upper corner of the smallest box around its shapes",
          nb::sig("def bounds(self, body: BodyId) -> tuple[numpy.typing.NDArray[numpy.float64], "
                  "numpy.typing.NDArray[numpy.float64]]"))
      .def("set_filter", &World::set_filter, nb::arg("body"), nb::arg("filter"))
      .def("material", &World::material, nb::arg("body"))
      .def("set_material", &World::set_material, nb::arg("body"), nb::arg("material"))
      .def("set_material_pair", &World::set_material_pair, nb::arg("pair"),
           "Friction and restitution between two materials, by Material.id. A pair that says neither takes it back.")
      .def_prop_ro("material_pairs",
                   [](const World& self) {
                     return std::vector<MaterialPair>(self.material_pairs().begin(), self.material_pairs().end());
                   })
      .def("set_mass", &World::set_mass, nb::arg("body"), nb::arg("mass"), "kg, > 0; the inertia changes likewise")
      .def("set_gravity_scale", &World::set_gravity_scale, nb::arg("body"), nb::arg("scale"))
      .def("set_damping", &World::set_damping, nb::arg("body"), nb::arg("linear"), nb::arg("angular"), "1/s, >= 0")
      .def("set_shape", &World::set_shape, nb::arg("body"), nb::arg("shape"), "Frame, mass and motion stay.")
      .def(
          "set_heights",
          [](World& self, BodyId body, std::uint32_t row, std::uint32_t column, const Heights& heights) {
            const std::size_t count = heights.shape(0) * heights.shape(1);
            self.set_heights(body, column, row, static_cast<std::uint32_t>(heights.shape(1)), {heights.data(), count});
          },
          nb::arg("body"), nb::arg("row"), nb::arg("column"), nb::arg("heights"),
          "Gives a body's HeightField other heights, m, shape (rows, columns), NaN for holes, from that sample on: "
          "heights[row:, column:]. Only what touches it near there wakes and is found anew.")
      .def("set_definition", &World::set_definition, nb::arg("body"), nb::arg("definition"),
           "Makes of a body, under its id, what a definition says: another type, mass, sensor or not, ... Begin with "
           "definition(body); what is as there stays.")
      .def("set_enabled", &World::set_enabled, nb::arg("body"), nb::arg("enabled"),
           "A disabled body keeps its id, pose and velocities, and neither moves nor touches anything.")
      .def("is_enabled", &World::is_enabled, nb::arg("body"))
      .def("user_data", nb::overload_cast<BodyId>(&World::user_data, nb::const_), nb::arg("body"))
      .def("set_user_data", nb::overload_cast<BodyId, std::uint64_t>(&World::set_user_data), nb::arg("body"),
           nb::arg("data"))
      .def("name", nb::overload_cast<BodyId>(&World::name, nb::const_), nb::arg("body"))
      .def("set_name", nb::overload_cast<BodyId, std::string_view>(&World::set_name), nb::arg("body"), nb::arg("name"))
      .def("set_collision_enabled", &World::set_collision_enabled, nb::arg("a"), nb::arg("b"), nb::arg("enabled"),
           "Whether two bodies may touch at all.")
      .def("refilter", &World::refilter, nb::arg("body"), "Has the contact filter asked again of all that is near it.");
}

void bind_arrays(Class& world) {
  bind_view<3, &World::positions>(world, "positions",
                                  "m, shape (n, 3): centres of mass, a row a body index. A view of the world's memory, "
                                  "which follows its steps; once bodies have been added, ask for it again.");
  bind_view<4, &World::orientations>(world, "orientations", "shape (n, 4): x, y, z, w; a view as positions is");
  bind_view<3, &World::velocities>(world, "velocities", "m/s, shape (n, 3); a view as positions is");
  bind_view<3, &World::angular_velocities>(world, "angular_velocities", "rad/s, shape (n, 3); a view as positions is");
  world.def_prop_ro(
      "origins",
      [](const World& self) {
        const Eigen::Matrix3Xd origins = self.origins();
        return nb::steal(array_of(origins.data(), {static_cast<std::size_t>(origins.cols()), 3}));
      },
      "m, shape (n, 3): origins of the bodies' frames; a copy",
      nb::sig("def origins(self) -> numpy.typing.NDArray[numpy.float64]"));
  const auto bind_copy = [&world](const char* name, const char* signature, const char* doc, const auto& column) {
    world.def_prop_ro(
        name,
        [column](const World& self) {
          const auto& numbers = column(self);
          return nb::steal(array_of(
              numbers.data(), {static_cast<std::size_t>(numbers.cols()), static_cast<std::size_t>(numbers.rows())}));
        },
        doc, nb::sig(signature));
  };
  bind_copy("accelerations", "def accelerations(self) -> numpy.typing.NDArray[numpy.float64]",
            "m/s^2, shape (n, 3), with Settings.accelerations: of centres of mass, the mean over the last step; a copy",
            [](const World& self) { return self.accelerations(); });
  bind_copy("angular_accelerations", "def angular_accelerations(self) -> numpy.typing.NDArray[numpy.float64]",
            "rad/s^2, shape (n, 3), likewise; a copy", [](const World& self) { return self.angular_accelerations(); });
  bind_copy("contact_wrenches", "def contact_wrenches(self) -> numpy.typing.NDArray[numpy.float64]",
            "shape (n, 6): force (N) and torque (N m, about the centre of mass) that contacts exert in the last "
            "substep; a copy",
            [](const World& self) { return self.contact_wrenches(); });
  world
      .def(
          "set_poses",
          [](World& self, const Rows<3>& positions, const Rows<4>& orientations, const Ids& ids) {
            self.set_poses(those(self, ids), columns_of<3>(positions), columns_of<4>(orientations));
          },
          nb::arg("positions"), nb::arg("orientations"), nb::arg("bodies") = nb::none(),
          "m, shape (n, 3), of the frames' origins, and x, y, z, w, shape (n, 4); a row a body, of all bodies in order "
          "if none are named. All of it, or Error and nothing.")
      .def(
          "set_velocities",
          [](World& self, const Rows<3>& linear, const Rows<3>& angular, const Ids& ids) {
            self.set_velocities(those(self, ids), columns_of<3>(linear), columns_of<3>(angular));
          },
          nb::arg("linear"), nb::arg("angular"), nb::arg("bodies") = nb::none(), "m/s and rad/s, shape (n, 3)")
      .def(
          "apply_forces",
          [](World& self, const Rows<3>& forces, const std::optional<Rows<3>>& torques, const Ids& ids) {
            const Eigen::Matrix3Xd none = Eigen::Matrix3Xd::Zero(3, torques ? 0 : columns_of<3>(forces).cols());
            if (torques) return self.apply_forces(those(self, ids), columns_of<3>(forces), columns_of<3>(*torques));
            self.apply_forces(those(self, ids), columns_of<3>(forces), none);
          },
          nb::arg("forces"), nb::arg("torques") = nb::none(), nb::arg("bodies") = nb::none(),
          "N and N m, shape (n, 3), of the next step");
}

void bind_joints_of(Class& world) {
  world.def("add_joint", &World::add_joint, nb::arg("definition"), "Joins two bodies, and wakes them.")
      .def("remove_joint", &World::remove_joint, nb::arg("joint"))
      .def_prop_ro("joint_count", &World::joint_count)
      .def_prop_ro("joints", &World::joints, "in order of their indices")
      .def("find_joint", &World::find_joint, nb::arg("name"), "The first that has the name, or None.")
      .def(
          "joint", [](const World& self, JointId joint) { return self.joint(joint); }, nb::arg("joint"),
          "A copy of its definition.")
      .def("joint_state", &World::joint_state, nb::arg("joint"))
      .def("user_data", nb::overload_cast<JointId>(&World::user_data, nb::const_), nb::arg("joint"))
      .def("set_user_data", nb::overload_cast<JointId, std::uint64_t>(&World::set_user_data), nb::arg("joint"),
           nb::arg("data"))
      .def("name", nb::overload_cast<JointId>(&World::name, nb::const_), nb::arg("joint"))
      .def("set_name", nb::overload_cast<JointId, std::string_view>(&World::set_name), nb::arg("joint"),
           nb::arg("name"))
      .def("set_joint", nb::overload_cast<JointId, const JointDef&>(&World::set_joint), nb::arg("joint"),
           nb::arg("definition"),
           "Changes all but kind and bodies: frames, what acts, collide, break limits, name, user_data.")
      .def("set_joint", nb::overload_cast<JointId, const JointKind&>(&World::set_joint), nb::arg("joint"),
           nb::arg("kind"), "Changes ranges, springs and motors.")
      .def(
          "joint_axis",
          [](const World& self, JointId joint, std::size_t coordinate) { return self.joint_axis(joint, coordinate); },
          nb::arg("joint"), nb::arg("coordinate") = 0, "A copy.")
      .def("set_joint_axis", &World::set_joint_axis, nb::arg("joint"), nb::arg("axis"), nb::arg("coordinate") = 0)
      .def("set_motor_speed", &World::set_motor_speed, nb::arg("joint"), nb::arg("speed"), nb::arg("coordinate") = 0,
           "m/s or rad/s")
      .def("set_servo_target", &World::set_servo_target, nb::arg("joint"), nb::arg("target"), nb::arg("coordinate") = 0,
           "m or rad")
      .def("set_joint_enabled", &World::set_joint_enabled, nb::arg("joint"), nb::arg("enabled"))
      .def("count_turns_from", &World::count_turns_from, nb::arg("joint"), nb::arg("angle"), nb::arg("coordinate") = 0,
           "Says which of its full turns an angle is in, after set_pose(): the one that brings it nearest to `angle`, "
           "rad.");
}

void bind_results(Class& world) {
  static const std::vector<Member> pairs = {
      {"a", "id", offsetof(PairForce, a)},
      {"b", "id", offsetof(PairForce, b)},
      {"force", "(3,)f8", offsetof(PairForce, force)},
      {"normal_force", "f8", offsetof(PairForce, normal_force)},
      {"separation", "f8", offsetof(PairForce, separation)},
  };
  static const std::vector<Member> contacts = {
      {"a", "id", offsetof(ContactEvent, a)},
      {"b", "id", offsetof(ContactEvent, b)},
      {"began", "?", offsetof(ContactEvent, began)},
      {"persists", "?", offsetof(ContactEvent, persists)},
      {"point", "(3,)f8", offsetof(ContactEvent, point)},
      {"normal", "(3,)f8", offsetof(ContactEvent, normal)},
      {"normal_force", "f8", offsetof(ContactEvent, normal_force)},
      {"impulse", "f8", offsetof(ContactEvent, impulse)},
      {"approach_speed", "f8", offsetof(ContactEvent, approach_speed)},
      {"child_a", "u4", offsetof(ContactEvent, child_a)},
      {"child_b", "u4", offsetof(ContactEvent, child_b)},
  };
  static const std::vector<Member> sensors = {
      {"sensor", "id", offsetof(SensorEvent, sensor)},
      {"body", "id", offsetof(SensorEvent, body)},
      {"entered", "?", offsetof(SensorEvent, entered)},
      {"child_sensor", "u4", offsetof(SensorEvent, child_sensor)},
      {"child_body", "u4", offsetof(SensorEvent, child_body)},
  };
  static const std::vector<Member> sleepers = {
      {"body", "id", offsetof(SleepEvent, body)},
      {"asleep", "?", offsetof(SleepEvent, asleep)},
  };
#define ATOLL_RECORDS(name) nb::sig("def " name "(self) -> numpy.typing.NDArray[numpy.void]")
  world
      .def(
          "contact_forces",
          [](const World& self) { return records_of(self.contact_forces(), contact_force_members()); },
          "A structured array: one record a manifold point that carries force, by body ids. a, b: index and "
          "generation; "
          "position (m), normal (from a to b), normal_force (N), friction (N, on b), separation (m), feature_id, "
          "child_a and child_b (in a compound, else 0).",
          ATOLL_RECORDS("contact_forces"))
      .def(
          "pair_forces", [](const World& self) { return records_of(self.pair_forces(), pairs); },
          "A structured array: one record for two bodies that press on each other: a, b, force (N, on b), normal_force "
          "(N), separation (m).",
          ATOLL_RECORDS("pair_forces"))
      .def(
          "contact_events", [](const World& self) { return records_of(self.contact_events(), contacts); },
          "With Settings.contact_events, a structured array of what began and ended in the last step, and of what goes "
          "on where that is asked for: a, b, began, persists, point (m), normal, normal_force (N), and of the whole "
          "step impulse (N s), approach_speed (m/s), child_a, child_b.",
          ATOLL_RECORDS("contact_events"))
      .def(
          "sensor_events", [](const World& self) { return records_of(self.sensor_events(), sensors); },
          "A structured array of what got into sensors and out of them: sensor, body, entered, child_sensor, "
          "child_body.",
          ATOLL_RECORDS("sensor_events"))
      .def(
          "sleep_events", [](const World& self) { return records_of(self.sleep_events(), sleepers); },
          "A structured array of bodies that fell asleep or woke: body, asleep.", ATOLL_RECORDS("sleep_events"));
#undef ATOLL_RECORDS
  nb::class_<Wrench> wrench(world, "Wrench", "A force and a torque about a body's centre of mass.");
  bind_result(wrench, Field{"force", &Wrench::force, "N, shape (3,)"},
              Field{"torque", &Wrench::torque, "N m, shape (3,)"});
  world
      .def("contact_wrench", &World::contact_wrench, nb::arg("body"),
           "What contacts exert on it in the last substep, with friction.")
      .def("proper_acceleration", &World::proper_acceleration, nb::arg("body"), nb::arg("point") = Vector3(0, 0, 0),
           "m/s^2, shape (3,), along the axes of the body's frame: what an accelerometer at a point (m) of it reads, "
           "with Settings.accelerations.");
  world.def("bodies_in", &World::bodies_in, nb::arg("sensor"), "At the end of the last step.")
      .def("joint_events",
           [](const World& self) {
             const auto events = self.joint_events();
             return std::vector<JointEvent>(events.begin(), events.end());
           })
      .def(
          "quarantined",
          [](const World& self) {
            const auto all = self.quarantined();
            return std::vector<Quarantined>(all.begin(), all.end());
          },
          "Bodies that are out of the world because their state was not finite, or absurd.")
      .def(
          "missed_targets",
          [](const World& self) {
            const auto all = self.missed_targets();
            return std::vector<MissedTarget>(all.begin(), all.end());
          },
          "With Settings.target, islands with an error beyond it after the last step, by their lowest bodies.")
      .def("is_quarantined", &World::is_quarantined, nb::arg("body"))
      .def("release", &World::release, nb::arg("body"), "Lets it take part again.")
      .def(
          "memory",
          [](const World& self) {
            nb::dict parts;
            for (const MemoryUse& use : self.memory()) parts[use.name] = use.bytes;
            return parts;
          },
          "bytes, by what they are for", nb::sig("def memory(self) -> dict[str, int]"));
}

// A copy with the same state, settings and threads, but without functions, and not recorded.
World copy_of(const World& world) {
  World copy({.threads = world.threads(), .settings = world.settings()});
  Snapshot now;
  world.save(now);
  copy.restore(now);
  return copy;
}

#define ATOLL_TAKES(call, question, answer) \
  nb::sig("def " call "(self, function: collections.abc.Callable[[" question "], " answer "] | None) -> None")

void bind_steps(Class& world) {
  world
      .def(
          "step", [](World& self, double dt) { return self.step(dt); }, nb::arg("dt") = 1.0 / 60, without_gil,
          "Advances by dt seconds, in [1e-12, 1], else Error. Other threads of Python run meanwhile.")
      .def(
          "step",
          [](World& self, double dt, nb::object law) {
            const ForceLaw function = function_of<void, Forces>(std::move(law));
            const nb::gil_scoped_release release;
            return self.step(dt, function);
          },
          nb::arg("dt"), nb::arg("law"),
          "The same under forces that depend on where bodies are: law(forces) is called as each substep begins, and as "
          "the last one ends. What it raises goes through.",
          nb::sig("def step(self, dt: float, law: collections.abc.Callable[[Forces], None]) -> StepReport"))
      .def(
          "steps",
          [](World& self, int count, double dt) {
            if (count < 0) throw Error("World.steps: found " + std::to_string(count) + " steps; expected 0 or more");
            SignalCheck check_signals;
            StepReport last;
            for (int i = 0; i < count; ++i) {
              last = self.step(dt);
              check_signals();
            }
            return last;
          },
          nb::arg("count"), nb::arg("dt") = 1.0 / 60, without_gil,
          "So many in a row; the report is of the last. Ctrl-C ends them between two. Raises Error if count < 0.")
      .def(
          "set_contact_filter",
          [](World& self, nb::object function) {
            self.set_contact_filter(function_of<bool, const ContactCandidate>(std::move(function), &self));
          },
          nb::arg("function").none(), "Says of a ContactCandidate whether two shapes may touch; None unsets it.",
          ATOLL_TAKES("set_contact_filter", "ContactCandidate", "bool"))
      .def(
          "set_contact_modifier",
          [](World& self, nb::object function) {
            self.set_contact_modifier(function_of<void, ModifiableContact>(std::move(function), &self));
          },
          nb::arg("function").none(), "May change a ModifiableContact in each step; None unsets it.",
          ATOLL_TAKES("set_contact_modifier", "ModifiableContact", "None"));
}

/// A recording under way, for `with`.
struct Recording {
  nb::object world;
};

void bind_recording(nb::module_& module) {
  nb::class_<Recording>(module, "Recording", "A recording under way: `with world.record(path):` ends it.")
      .def(
          "__enter__", [](nb::object self) { return self; }, nb::sig("def __enter__(self) -> Recording"))
      .def(
          "__exit__",
          [](const Recording& self, nb::args) {
            World& world = nb::cast<World&>(self.world);
            if (world.is_recording()) world.stop_recording();
          },
          nb::sig("def __exit__(self, *reason: object) -> None"));
}

void bind_state(Class& world) {
  world
      .def(
          "save",
          [](const World& self) {
            Snapshot snapshot;
            self.save(snapshot);
            return snapshot;
          },
          "The state of the world at this moment.")
      .def("save", &World::save, nb::arg("snapshot"), "Over what a snapshot holds, whose memory is used again.")
      .def("restore", &World::restore, nb::arg("snapshot"),
           "Goes back, or on, to a state: from there on every step has the same bits as in the world that was saved.")
      .def("__copy__", &copy_of)
      .def(
          "__deepcopy__", [](const World& self, const nb::dict&) { return copy_of(self); }, nb::arg("memo"),
          nb::sig("def __deepcopy__(self, memo: dict[int, object]) -> World"))
      .def("state_hash", &World::state_hash, "64 bits, of everything that the future of this world depends on.")
      .def("body_hashes", &World::body_hashes, "By body, to find where two worlds part.")
      .def_prop_rw(
          "settings", [](const World& self) { return self.settings(); }, &World::set_settings, "a copy")
      .def_prop_rw(
          "gravity", [](const World& self) { return self.gravity(); }, &World::set_gravity, "m/s^2, shape (3,)")
      .def_prop_ro("time", &World::time, "s, sum of all steps; snapshots hold it")
      .def_prop_rw("threads", &World::threads, &World::set_threads, "may change between steps; no result depends on it")
      .def_prop_ro("simd", &World::simd, "the instruction set in use")
      .def(
          "record",
          [](nb::object self, const std::string& path, int body_hash_interval, std::size_t few_bodies) {
            nb::cast<World&>(self).record(path, {.body_hash_interval = body_hash_interval, .few_bodies = few_bodies});
            return Recording{std::move(self)};
          },
          nb::arg("path"), nb::arg("body_hash_interval") = RecordingOptions{}.body_hash_interval,
          nb::arg("few_bodies") = RecordingOptions{}.few_bodies,
          "From here on notes down in a file every call that changes this world, and what every step comes to: until "
          "stop_recording(), or the end of a `with` block. Raises Error if the file can't be written.")
      .def_prop_ro("is_recording", &World::is_recording)
      .def("stop_recording", &World::stop_recording);
}

void bind_snapshot(nb::module_& module) {
  nb::class_<Snapshot>(module, "Snapshot", "The state of a world at one moment. Can be pickled: see write().")
      .def(nb::init<>(), "Empty.")
      .def_prop_ro("empty", &Snapshot::empty)
      .def_prop_ro("size", &Snapshot::size, "bytes")
      .def("write", &Snapshot::write, nb::arg("path"),
           "To a file. Hulls, meshes and height fields are written as fingerprints only.")
      .def_static("read", &Snapshot::read, nb::arg("path"))
      .def("__getstate__",
           [](const Snapshot& self) {
             const std::vector<std::byte> bytes = self.to_bytes();
             return nb::bytes(bytes.data(), bytes.size());
           })
      .def("__setstate__",
           [](Snapshot& self, const nb::bytes& state) {
             const auto* first = static_cast<const std::byte*>(state.data());
             new (&self) Snapshot(Snapshot::from_bytes({first, state.size()}));
           })
      .def("__repr__", [](const Snapshot& self) { return "<Snapshot of " + std::to_string(self.size()) + " bytes>"; });
}

}  // namespace

void bind_world(nb::module_& module) {
  nb::class_<Quarantined>(module, "Quarantined", "A body that is in quarantine.")
      .def_ro("id", &Quarantined::id)
      .def_ro("reason", &Quarantined::reason)
      .def_ro("why", &Quarantined::why, "the reason in words")
      .def_ro("step", &Quarantined::step, "the first is 1");
  nb::class_<BodyHash> hash(module, "BodyHash", "64-bit hashes of the state of one body, by part.");
  hash.def_ro("pose", &BodyHash::pose)
      .def_ro("velocity", &BodyHash::velocity)
      .def_ro("input", &BodyHash::input)
      .def_ro("rest", &BodyHash::rest)
      .def_ro("bounds", &BodyHash::bounds)
      .def_ro("contacts", &BodyHash::contacts)
      .def_ro("joints", &BodyHash::joints)
      .def("__eq__", [](const BodyHash& a, const nb::object& b) {
        return nb::isinstance<BodyHash>(b) && a == nb::cast<BodyHash>(b);
      });
  bind_snapshot(module);

  // Its functions may hold it in turn: Python's collector has to see such rings to end them.
  Class world(
      module, "World", nb::type_slots(world_slots),
      "A world of rigid bodies. Same calls, same bits: whatever the threads, vector width or machine. One world "
      "may be used from one thread at a time; a call while another thread steps it raises Error.");
  world.def(
      "__init__",
      [](World* self, const Vector3& gravity, int threads, bool dynamic_threads, const Settings& settings) {
        new (self)
            World({.gravity = gravity, .threads = threads, .dynamic_threads = dynamic_threads, .settings = settings});
      },
      nb::kw_only(), nb::arg("gravity") = WorldDef{}.gravity, nb::arg("threads") = 1, nb::arg("dynamic_threads") = true,
      nb::arg("settings") = Settings{},
      "gravity: m/s^2, shape (3,). threads: workers, in [1, 1024]. dynamic_threads: works on one while others take the "
      "cores. Raises Error on a setting out of range.");
  bind_recording(module);
  bind_bodies(world);
  bind_arrays(world);
  bind_joints_of(world);
  bind_results(world);
  bind_steps(world);
  bind_state(world);
  world.def("__repr__", [](const World& self) {
    return "<World of " + std::to_string(self.body_count()) + " bodies, " + std::to_string(self.joint_count()) +
           " joints>";
  });
}

}  // namespace atl::python
