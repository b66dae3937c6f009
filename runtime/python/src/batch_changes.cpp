// Changes of all worlds of a batch by arrays.

#include <cstddef>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "batches.h"
#include "fields.h"

namespace atl::python {
namespace {

void bind_motion(nb::class_<Batch>& batch) {
  batch
      .def(
          "set_poses",
          [](Batch& self, const Cube<3>& origins, const Cube<4>& orientations, const nb::object& worlds) {
            call(self, worlds, [&](auto places) { self.set_poses(span_of(origins), span_of(orientations), places); });
          },
          nb::arg("origins"), nb::arg("orientations"), nb::arg("worlds") = nb::none(),
          "m, shape (worlds, bodies, 3), and x, y, z, w, shape (worlds, bodies, 4); a row a world that is meant.")
      .def(
          "set_velocities",
          [](Batch& self, const Cube<3>& linear, const Cube<3>& angular, const nb::object& worlds) {
            call(self, worlds, [&](auto places) { self.set_velocities(span_of(linear), span_of(angular), places); });
          },
          nb::arg("linear"), nb::arg("angular"), nb::arg("worlds") = nb::none(),
          "m/s and rad/s, shape (worlds, bodies, 3)")
      .def(
          "apply_forces",
          [](Batch& self, const Cube<3>& forces, const std::optional<Cube<3>>& torques, const nb::object& worlds) {
            const std::vector<double> none(torques ? 0 : forces.size(), 0.0);
            const std::span<const double> turning = torques ? span_of(*torques) : std::span<const double>(none);
            call(self, worlds, [&](auto places) { self.apply_forces(span_of(forces), turning, places); });
          },
          nb::arg("forces"), nb::arg("torques") = nb::none(), nb::arg("worlds") = nb::none(),
          "N and N m, shape (worlds, bodies, 3), of the next step");
}

void bind_numbers(nb::module_& module, nb::class_<Batch>& batch) {
  nb::enum_<BodyNumber>(module, "BodyNumber",
                        "What Batch.set_body_numbers() sets, as BodyDef, Material and the shape have it.")
      .value("MASS", BodyNumber::Mass, "kg, > 0, of dynamic bodies.")
      .value("FRICTION", BodyNumber::Friction)
      .value("RESTITUTION", BodyNumber::Restitution)
      .value("ROLLING_FRICTION", BodyNumber::RollingFriction)
      .value("TORSIONAL_FRICTION", BodyNumber::TorsionalFriction)
      .value("GRAVITY_SCALE", BodyNumber::GravityScale)
      .value("LINEAR_DAMPING", BodyNumber::LinearDamping)
      .value("ANGULAR_DAMPING", BodyNumber::AngularDamping)
      .value("RADIUS", BodyNumber::Radius, "m, > 0; this and the next change the shape, the mass stays.")
      .value("HALF_HEIGHT", BodyNumber::HalfHeight, "m, > 0")
      .value("HALF_EXTENT_X", BodyNumber::HalfExtentX, "m, > 0, of a Box, or half axis of an Ellipsoid")
      .value("HALF_EXTENT_Y", BodyNumber::HalfExtentY, "m, > 0")
      .value("HALF_EXTENT_Z", BodyNumber::HalfExtentZ, "m, > 0");
  nb::enum_<JointNumber>(
      module, "JointNumber",
      "What Batch.set_joint_numbers() sets, as JointAxis has it; servo, motor or spring must be there.")
      .value("SERVO_STIFFNESS", JointNumber::ServoStiffness)
      .value("SERVO_DAMPING", JointNumber::ServoDamping)
      .value("MAX_FORCE", JointNumber::MaxForce)
      .value("SPRING_STIFFNESS", JointNumber::SpringStiffness)
      .value("SPRING_DAMPING", JointNumber::SpringDamping)
      .value("FRICTION", JointNumber::Friction)
      .value("ARMATURE", JointNumber::Armature);
  batch
      .def(
          "set_body_numbers",
          [](Batch& self, BodyNumber what, const std::vector<std::size_t>& bodies, const Values& numbers,
             const nb::object& worlds) {
            call(self, worlds, [&](auto places) { set_numbers(self, what, bodies, span_of(numbers), places); });
          },
          nb::arg("what"), nb::arg("bodies"), nb::arg("numbers"), nb::arg("worlds") = nb::none(),
          "A number of bodies, by their places in `bodies`: shape (worlds, bodies). Surfaces are those of the bodies' "
          "own "
          "materials: shapes that have a material of their own keep it.")
      .def(
          "set_joint_numbers",
          [](Batch& self, JointNumber what, const std::vector<std::size_t>& joints, const Values& numbers,
             std::size_t coordinate, const nb::object& worlds) {
            call(self, worlds,
                 [&](auto places) { set_numbers(self, what, joints, span_of(numbers), coordinate, places); });
          },
          nb::arg("what"), nb::arg("joints"), nb::arg("numbers"), nb::arg("coordinate") = 0,
          nb::arg("worlds") = nb::none(),
          "A number along a coordinate of joints, by their places in `joints`: shape (worlds, joints).");
}

void bind_joints_of(nb::class_<Batch>& batch) {
  batch
      .def(
          "set_motor_speeds",
          [](Batch& self, std::size_t joint, const Numbers& speeds, std::size_t coordinate, const nb::object& worlds) {
            call(self, worlds, [&](auto places) { self.set_motor_speeds(joint, span_of(speeds), coordinate, places); });
          },
          nb::arg("joint"), nb::arg("speeds"), nb::arg("coordinate") = 0, nb::arg("worlds") = nb::none(),
          "Of a joint by its place in `joints`: m/s or rad/s, shape (worlds,).")
      .def(
          "set_servo_targets",
          [](Batch& self, std::size_t joint, const Numbers& targets, std::size_t coordinate, const nb::object& worlds) {
            call(self, worlds,
                 [&](auto places) { self.set_servo_targets(joint, span_of(targets), coordinate, places); });
          },
          nb::arg("joint"), nb::arg("targets"), nb::arg("coordinate") = 0, nb::arg("worlds") = nb::none(),
          "m or rad, shape (worlds,)")
      .def(
          "set_gravities",
          [](Batch& self, const Rows<3>& gravities, const nb::object& worlds) {
            call(self, worlds, [&](auto places) { atl::set_gravities(self, span_of(gravities), places); });
          },
          nb::arg("gravities"), nb::arg("worlds") = nb::none(), "m/s^2, shape (worlds, 3)")
      .def(
          "set_masses",
          [](Batch& self, std::size_t body, const Numbers& masses, const nb::object& worlds) {
            call(self, worlds, [&](auto places) { atl::set_masses(self, body, span_of(masses), places); });
          },
          nb::arg("body"), nb::arg("masses"), nb::arg("worlds") = nb::none(),
          "Of a dynamic body by its place in `bodies`: kg, shape (worlds,).")
      .def(
          "set_frictions",
          [](Batch& self, std::size_t body, const Numbers& frictions, const nb::object& worlds) {
            call(self, worlds, [&](auto places) { atl::set_frictions(self, body, span_of(frictions), places); });
          },
          nb::arg("body"), nb::arg("frictions"), nb::arg("worlds") = nb::none(),
          "Of a body's own material, shape (worlds,); shapes that have a material of their own keep it.")
      .def(
          "read_joint",
          [](const Batch& self, std::size_t joint, std::size_t coordinate) {
            std::vector<double> positions(self.size()), speeds(self.size());
            self.read_joint(joint, positions, speeds, coordinate);
            return nb::make_tuple(array_owning(std::move(positions), {self.size()}),
                                  array_owning(std::move(speeds), {self.size()}));
          },
          nb::arg("joint"), nb::arg("coordinate") = 0, "Positions and speeds of a coordinate, shape (worlds,) each.",
          nb::sig("def read_joint(self, joint: int, coordinate: int = 0) -> tuple[numpy.typing.NDArray[numpy.float64], "
                  "numpy.typing.NDArray[numpy.float64]]"));
}

}  // namespace

void bind_batch_changes(nb::module_& module, nb::class_<Batch>& batch) {
  bind_motion(batch);
  bind_numbers(module, batch);
  bind_joints_of(batch);
}

}  // namespace atl::python
