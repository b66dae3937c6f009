// Errors, ids, poses: what everything else is told in.

#include <atoll/atoll.h>

#include <compare>
#include <functional>

#include "fields.h"
#include "parts.h"

namespace atl::python {
namespace {

// It stands for its index where an index is asked for, so that views are read by it: world.positions[body].
template <typename Id>
void bind_id(nb::module_& module, const char* name, const char* doc) {
  nb::class_<Id>(module, name, doc)
      .def(
          "__init__",
          [](Id* self, std::uint32_t index, std::uint32_t generation) {
            new (self) Id{index, generation};
          },
          nb::arg("index"), nb::arg("generation") = 0)
      .def_ro("index", &Id::index, "The row of the body in the views of a world.")
      .def_ro("generation", &Id::generation, "Which of those that had the index.")
      .def("__index__", [](const Id& self) { return self.index; })
      .def("__eq__", [](const Id& a, const nb::object& b) { return nb::isinstance<Id>(b) && a == nb::cast<Id>(b); })
      .def("__lt__", [](const Id& a, const Id& b) { return a < b; })
      .def("__hash__", [](const Id& self) { return std::hash<Id>()(self); })
      .def("__getstate__", [](const Id& self) { return std::tuple(self.index, self.generation); })
      .def("__setstate__",
           [](Id& self, const std::tuple<std::uint32_t, std::uint32_t>& state) {
             new (&self) Id{std::get<0>(state), std::get<1>(state)};
           })
      .def("__repr__", [name = std::string(name)](const Id& self) {
        return name + "(" + std::to_string(self.index) + ", " + std::to_string(self.generation) + ")";
      });
}

}  // namespace

void bind_types(nb::module_& module) {
  // An exception of C++ is that of the class that was made last of those that fit.
  const nb::exception<Error> error(module, "Error", PyExc_ValueError);
  error.doc() =
      "Raised by every call that is handed something unusable. The message names the field, the value that was found "
      "and what was expected. A call that raises has changed nothing.";
  const nb::exception<SceneError> scene_error(module, "SceneError", error);
  scene_error.doc() = "Raised for a scene that can't be read: which file, where in it, what was found and expected.";

  bind_id<BodyId>(module, "BodyId",
                  "Names a body for its lifetime. Stands for its index: world.positions[body] is the body's row.");
  bind_id<JointId>(module, "JointId", "Names a joint for its lifetime.");

  nb::class_<Pose> pose(module, "Pose", "Where the frame of a body lies in the world.");
  bind_struct(pose, Field{"position", &Pose::position, "m, shape (3,): of the frame's origin"},
              Field{"orientation", &Pose::orientation, "shape (4,): x, y, z, w"});

  nb::enum_<BodyType>(module, "BodyType", "How a body moves.")
      .value("STATIC", BodyType::Static, "Never; infinite mass.")
      .value("KINEMATIC", BodyType::Kinematic, "At the velocity that it is given; infinite mass.")
      .value("DYNAMIC", BodyType::Dynamic, "Under forces and contacts.");
  nb::enum_<Axis>(module, "Axis", "An axis of the world.").value("X", Axis::X).value("Y", Axis::Y).value("Z", Axis::Z);
  nb::enum_<Quarantine>(module, "Quarantine", "Why a body was taken out of the world.")
      .value("NOT_FINITE", Quarantine::NotFinite)
      .value("TOO_FAR", Quarantine::TooFar, "Its centre of mass is farther than 1e12 m from the origin.")
      .value("TOO_FAST", Quarantine::TooFast, "Above 1e6 m/s.")
      .value("TOO_FAST_SPIN", Quarantine::TooFastSpin, "Above 1e6 rad/s.")
      .value("TOO_FAST_SURFACE", Quarantine::TooFastSurface, "Its surface runs at more than 1e6 m/s.")
      .value("TOO_MUCH_FORCE", Quarantine::TooMuchForce)
      .value("TOO_MUCH_TORQUE", Quarantine::TooMuchTorque);

  nb::enum_<CombineRule>(
      module, "CombineRule",
      "How a coefficient of two that touch follows from that of each. Of two rules the later counts.")
      .value("DEFAULT", CombineRule::Default, "GEOMETRIC_MEAN of friction, MAX of restitution.")
      .value("AVERAGE", CombineRule::Average)
      .value("GEOMETRIC_MEAN", CombineRule::GeometricMean)
      .value("MIN", CombineRule::Min)
      .value("MULTIPLY", CombineRule::Multiply)
      .value("MAX", CombineRule::Max);
  nb::class_<Material> material(module, "Material",
                                "What a surface is like. Of two that touch friction and restitution follow by their "
                                "rules, all else is the larger "
                                "of the two.");
  bind_definition(
      material, Field{"friction", &Material::friction, "Coulomb's coefficient, >= 0"},
      Field{"friction_across", &Material::friction_across, "the same across friction_direction, where there is one"},
      Field{"friction_direction", &Material::friction_direction,
            "shape (3,), body frame: friction acts along it; alike in all directions if zero"},
      Field{"restitution", &Material::restitution, "Newton's coefficient, in [0, 1]"},
      Field{"rolling_friction", &Material::rolling_friction,
            "m, >= 0: the torque that holds back rolling, over the normal force"},
      Field{"torsional_friction", &Material::torsional_friction,
            "m, >= 0: the torque that holds back spinning about the normal, over the normal force"},
      Field{"friction_rule", &Material::friction_rule, "how friction follows from that of both"},
      Field{"restitution_rule", &Material::restitution_rule, "how restitution does"},
      Field{"id", &Material::id, "a number of yours for set_material_pair(), or 0"});
  nb::class_<MaterialPair> pair(module, "MaterialPair",
                                "What holds between two materials, whatever would follow from each.");
  bind_definition(
      pair, Field{"first", &MaterialPair::first, "the id of a material, not 0"},
      Field{"second", &MaterialPair::second, "that of the other, or the same"},
      Field{"friction", &MaterialPair::friction, "Coulomb's coefficient, >= 0; as without the pair if None"},
      Field{"friction_across", &MaterialPair::friction_across, "across a friction_direction; friction if None"},
      Field{"restitution", &MaterialPair::restitution, "in [0, 1], likewise"});

  nb::class_<CollisionFilter> filter(
      module, "CollisionFilter",
      "Which bodies may touch: the mask of each must have a bit of the other's category, unless both are of one group "
      "other than 0, which decides by its sign.");
  bind_definition(filter, Field{"category", &CollisionFilter::category, "32 bits"},
                  Field{"mask", &CollisionFilter::mask, "32 bits"},
                  Field{"group", &CollisionFilter::group, "0 for none"});
}

}  // namespace atl::python
