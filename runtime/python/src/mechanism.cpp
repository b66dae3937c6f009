// Trees of joints as coordinates.

#include <atoll/mechanism.h>
#include <atoll/world.h>

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "arrays.h"
#include "fields.h"
#include "parts.h"

namespace atl::python {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

#define ATOLL_FLOATS "numpy.typing.NDArray[numpy.float64]"
#define ATOLL_NUMBERS "numpy.typing.ArrayLike"

Eigen::Map<const VectorXd> vector_of(const Numbers& numbers) {
  return {numbers.data(), static_cast<Eigen::Index>(numbers.shape(0))};
}

// An array that its caller may write to.
nb::object array_with(const double* numbers, const std::vector<std::size_t>& shape) {
  std::size_t count = 1;
  for (const std::size_t length : shape) count *= length;
  auto* copy = new double[count];
  std::copy_n(numbers, count, copy);
  const nb::capsule owner(copy, [](void* memory) noexcept { delete[] static_cast<double*>(memory); });
  return nb::ndarray<nb::numpy, double>(copy, shape.size(), shape.data(), owner).cast();
}

nb::object array_from(const VectorXd& vector) {
  return array_with(vector.data(), {static_cast<std::size_t>(vector.size())});
}

nb::object array_from(const MatrixXd& matrix) {
  const MatrixXd by_row = matrix.transpose();
  return array_with(by_row.data(), {static_cast<std::size_t>(matrix.rows()), static_cast<std::size_t>(matrix.cols())});
}

void bind_structure(nb::class_<Mechanism>& mechanism) {
  mechanism.def_prop_ro("nq", &Mechanism::nq, "How many numbers q has.")
      .def_prop_ro("nv", &Mechanism::nv, "How many numbers v and tau have.")
      .def_prop_ro("is_floating", &Mechanism::is_floating, "True if the base is free.")
      .def_prop_ro("base", &Mechanism::base)
      .def_prop_ro("bodies", &Mechanism::bodies, "Dynamic ones, each after the one that carries it.")
      .def_prop_ro("joints", &Mechanism::joints, "In order of their coordinates; a free base is the first.")
      .def_prop_ro("loops", &Mechanism::loops,
                   "Joints on bodies of the tree that are not in it: those that close a loop, gears, and distance "
                   "joints.")
      .def_prop_ro(
          "names",
          [](const Mechanism& self) {
            std::vector<std::string> names;
            for (const MechanismJoint& joint : self.joints()) names.push_back(joint.name);
            return names;
          },
          "Names of the joints, in their order.");
}

void bind_state(nb::class_<Mechanism>& mechanism) {
  mechanism
      .def(
          "q", [](const Mechanism& self) { return array_from(self.q()); }, nb::sig("def q(self) -> " ATOLL_FLOATS),
          "shape (nq,): coordinates, as the world measures them now; quaternions x, y, z, w")
      .def(
          "v", [](const Mechanism& self) { return array_from(self.v()); }, nb::sig("def v(self) -> " ATOLL_FLOATS),
          "shape (nv,): their rates")
      .def(
          "set", [](Mechanism& self, const Numbers& q, const Numbers& v) { self.set(vector_of(q), vector_of(v)); },
          nb::arg("q"), nb::arg("v"),
          "Puts all bodies where q has them, shape (nq,), with the velocities that follow from v, shape (nv,).")
      .def(
          "integrate",
          [](const Mechanism& self, const Numbers& q, const Numbers& v) {
            return array_from(self.integrate(vector_of(q), vector_of(v)));
          },
          nb::arg("q"), nb::arg("v"),
          nb::sig("def integrate(self, q: " ATOLL_NUMBERS ", v: " ATOLL_NUMBERS ") -> " ATOLL_FLOATS),
          "shape (nq,): the configuration after a step v from q, which turns quaternions.")
      .def(
          "apply", [](Mechanism& self, const Numbers& tau) { self.apply(vector_of(tau)); }, nb::arg("tau"),
          "Adds generalised forces (N or N m), shape (nv,), to what acts in the next step.");
}

void bind_dynamics(nb::class_<Mechanism>& mechanism) {
  mechanism
      .def(
          "mass_matrix", [](const Mechanism& self) { return array_from(self.mass_matrix()); },
          nb::sig("def mass_matrix(self) -> " ATOLL_FLOATS),
          "shape (nv, nv), symmetric, with armatures. Featherstone, Rigid Body Dynamics Algorithms, 2008, section 6.2.")
      .def(
          "bias", [](const Mechanism& self) { return array_from(self.bias()); },
          nb::sig("def bias(self) -> " ATOLL_FLOATS),
          "shape (nv,): Coriolis and centrifugal forces, less those of gravity. Featherstone, section 5.3.")
      .def(
          "gravity", [](const Mechanism& self) { return array_from(self.gravity()); },
          nb::sig("def gravity(self) -> " ATOLL_FLOATS), "shape (nv,): the tau that holds the tree still.")
      .def(
          "inverse_dynamics",
          [](const Mechanism& self, const Numbers& acceleration) {
            return array_from(self.inverse_dynamics(vector_of(acceleration)));
          },
          nb::arg("acceleration"),
          nb::sig("def inverse_dynamics(self, acceleration: " ATOLL_NUMBERS ") -> " ATOLL_FLOATS),
          "shape (nv,): the tau for these accelerations v', shape (nv,).")
      .def(
          "forward_dynamics",
          [](const Mechanism& self, const Numbers& tau) { return array_from(self.forward_dynamics(vector_of(tau))); },
          nb::arg("tau"), nb::sig("def forward_dynamics(self, tau: " ATOLL_NUMBERS ") -> " ATOLL_FLOATS),
          "shape (nv,): the accelerations v' that follow from tau, shape (nv,).")
      .def("centre_of_mass", &Mechanism::centre_of_mass, "m, shape (3,), world frame")
      .def(
          "centre_of_mass_jacobian", [](const Mechanism& self) { return array_from(self.centre_of_mass_jacobian()); },
          nb::sig("def centre_of_mass_jacobian(self) -> " ATOLL_FLOATS), "shape (3, nv)")
      .def("momentum", &Mechanism::momentum)
      .def("kinetic_energy", &Mechanism::kinetic_energy, "J, with that of armatures")
      .def("potential_energy", &Mechanism::potential_energy, "J, of gravity, against the world's origin");
}

void bind_reach(nb::class_<Mechanism>& mechanism) {
  mechanism
      .def(
          "jacobian",
          [](const Mechanism& self, BodyId body, const Vector3& point) {
            return array_from(self.jacobian(body, point));
          },
          nb::arg("body"), nb::arg("point") = Vector3(0, 0, 0),
          nb::sig("def jacobian(self, body: BodyId, point: " ATOLL_NUMBERS " = (0, 0, 0)) -> " ATOLL_FLOATS),
          "shape (6, nv): J v is the velocity (m/s) of a point (m, body frame) and the body's angular velocity "
          "(rad/s), "
          "in the world's axes.")
      .def("inverse_kinematics", &Mechanism::inverse_kinematics, nb::arg("body"), nb::arg("point"), nb::arg("target"),
           nb::arg("orientation") = nb::none(),
           "Looks for a q, from where the world is, that takes a point (m, body frame) to a target (m, world frame), "
           "and "
           "the body to an orientation. It moves nothing, and keeps to ranges. The errors tell whether it got there. "
           "Damped least squares: Buss, 2004, section 6.");
}

}  // namespace

void bind_mechanisms(nb::module_& module) {
  nb::class_<MechanismJoint> joint(module, "MechanismJoint",
                                   "The places of a joint's coordinates in the arrays of a Mechanism.");
  bind_result(joint, Field{"joint", &MechanismJoint::joint, "no joint's id, for a free base"},
              Field{"name", &MechanismJoint::name, "the joint's, or the body's for a free base"},
              Field{"body", &MechanismJoint::body, "the one that it carries"},
              Field{"q", &MechanismJoint::q, "the first place in q"},
              Field{"q_count", &MechanismJoint::q_count, "how many numbers of q"},
              Field{"v", &MechanismJoint::v, "the first place in v and tau"},
              Field{"v_count", &MechanismJoint::v_count, "how many numbers of v and tau"});
  nb::class_<MechanismMomentum> momentum(module, "MechanismMomentum");
  bind_result(momentum, Field{"linear", &MechanismMomentum::linear, "kg m/s, shape (3,)"},
              Field{"angular", &MechanismMomentum::angular, "kg m^2/s, shape (3,), about the centre of mass"});
  nb::class_<InverseKinematics>(module, "InverseKinematics", "Result of Mechanism.inverse_kinematics().")
      .def_prop_ro(
          "q", [](const InverseKinematics& self) { return array_from(self.q); },
          nb::sig("def q(self) -> " ATOLL_FLOATS), "shape (nq,), for Mechanism.set()")
      .def_ro("position_error", &InverseKinematics::position_error, "m, from the point to its target")
      .def_ro("angle_error", &InverseKinematics::angle_error, "rad; 0 without an orientation to reach")
      .def_ro("iterations", &InverseKinematics::iterations);
  nb::class_<Mechanism> mechanism(
      module, "Mechanism",
      "A tree of joints and bodies in generalised coordinates, for control and planning: its kinematics and dynamics "
      "at "
      "the state in which the world is when asked.\n\n"
      "q, shape (nq,), and v, shape (nv,), have the coordinates of a free base first: the origin of its frame (m) and "
      "its "
      "orientation (x, y, z, w); velocity of that origin (m/s) and angular velocity (rad/s), in the world's axes. Then "
      "those of the joints, in order of their indices: hinges in rad, sliders in m, balls as a quaternion in q and an "
      "angular velocity in the axes of the first frame in v. What is locked by its range is no coordinate.\n\n"
      "Only bodies, armatures and gravity count. Forces of springs, motors, friction, contacts and loops are part of "
      "tau. "
      "Raises Error where joints or bodies of the tree have come or gone since: make another then.");
  mechanism.def(
      nb::init<World&, BodyId>(), nb::arg("world"), nb::arg("base"), nb::keep_alive<1, 2>(),
      "Takes what hangs together with `base` by enabled joints, up to bodies that are not dynamic: on a fixed base "
      "if there is one, else on `base` itself, which is free. Raises Error on kinds of joints that have other "
      "coordinates, which it names.");
  bind_structure(mechanism);
  bind_state(mechanism);
  bind_dynamics(mechanism);
  bind_reach(mechanism);
}

}  // namespace atl::python
