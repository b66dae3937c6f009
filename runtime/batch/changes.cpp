// Changes that differ from world to world of a batch, given as arrays.

#include <atoll/batch.h>
#include <atoll/error.h>

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "columns.h"

namespace atl {
namespace {

void check_count(const char* call, const char* what, std::size_t found, std::size_t expected) {
  if (found == expected) return;
  throw Error(std::string(call) + ": found " + std::to_string(found) + " numbers of " + what + "; expected " +
              std::to_string(expected) + " of them");
}

// Calls change(world, its number among `places`) for each.
template <typename Change>
void for_each(Batch& batch, std::span<const std::size_t> places, const Change& change) {
  const std::vector<std::size_t> numbers = numbers_of(batch, places);
  batch.for_each([&](World& world, std::size_t place) { change(world, numbers[place]); }, places);
}

// Gives each world its numbers of these bodies or joints, by set(world, id, number).
template <typename Id, typename Set>
void set_each(const char* what, Batch& batch, const std::vector<Id>& ids, std::span<const std::size_t> some,
              std::span<const double> numbers, std::span<const std::size_t> places, const Set& set) {
  for (const std::size_t place : some) {
    if (place < ids.size()) continue;
    throw Error(std::string("set_numbers: found ") + what + " " + std::to_string(place) + "; expected one below " +
                std::to_string(ids.size()));
  }
  check_count("set_numbers", what, numbers.size(), some.size() * (places.empty() ? batch.size() : places.size()));
  for_each(batch, places, [&](World& world, std::size_t i) {
    for (std::size_t k = 0; k < some.size(); ++k) set(world, ids[some[k]], numbers[i * some.size() + k]);
  });
}

// The size of a solid that a number stands for; null if it has none such.
struct SizeOf {
  BodyNumber what;

  double* operator()(auto& solid) const {
    if constexpr (requires { solid.radius; }) {
      if (what == BodyNumber::Radius) return &solid.radius;
    }
    if constexpr (requires { solid.half_height; }) {
      if (what == BodyNumber::HalfHeight) return &solid.half_height;
    }
    if constexpr (requires { solid.half_extents; }) return axis_of(solid.half_extents);
    if constexpr (requires { solid.half_axes; }) return axis_of(solid.half_axes);
    return nullptr;
  }
  double* axis_of(Vector3& along) const {
    return what < BodyNumber::HalfExtentX
               ? nullptr
               : &along[static_cast<Eigen::Index>(what) - static_cast<Eigen::Index>(BodyNumber::HalfExtentX)];
  }
};

void set_size(World& world, BodyId id, BodyNumber what, double number) {
  Shape shape = world.definition(id).shape;
  double* const size = std::visit(SizeOf{what}, shape);
  if (size == nullptr) throw Error("set_numbers: found a shape without such a size; expected one that has it");
  *size = number;
  world.set_shape(id, shape);
}

void set_number(World& world, BodyId id, BodyNumber what, double number) {
  if (what >= BodyNumber::Radius) return set_size(world, id, what, number);
  Material material = world.material(id);
  switch (what) {
    case BodyNumber::Mass:
      return world.set_mass(id, number);
    case BodyNumber::GravityScale:
      return world.set_gravity_scale(id, number);
    case BodyNumber::LinearDamping:
      return world.set_damping(id, number, world.definition(id).angular_damping);
    case BodyNumber::AngularDamping:
      return world.set_damping(id, world.definition(id).linear_damping, number);
    case BodyNumber::Friction:
      material.friction = number;
      break;
    case BodyNumber::Restitution:
      material.restitution = number;
      break;
    case BodyNumber::RollingFriction:
      material.rolling_friction = number;
      break;
    case BodyNumber::TorsionalFriction:
      material.torsional_friction = number;
      break;
    default:
      break;
  }
  world.set_material(id, material);
}

template <typename Part>
Part& part_of(std::optional<Part>& part, const char* what) {
  if (!part) throw Error(std::string("set_numbers: found no ") + what + " along the coordinate; expected one");
  return *part;
}

void set_number(World& world, JointId id, JointNumber what, std::size_t coordinate, double number) {
  JointAxis axis = world.joint_axis(id, coordinate);
  switch (what) {
    case JointNumber::ServoStiffness:
      part_of(part_of(axis.motor, "motor").servo, "servo").stiffness = number;
      break;
    case JointNumber::ServoDamping:
      part_of(part_of(axis.motor, "motor").servo, "servo").damping = number;
      break;
    case JointNumber::MaxForce:
      part_of(axis.motor, "motor").max_force = number;
      break;
    case JointNumber::SpringStiffness:
      part_of(axis.spring, "spring").stiffness = number;
      break;
    case JointNumber::SpringDamping:
      part_of(axis.spring, "spring").damping = number;
      break;
    case JointNumber::Friction:
      axis.friction = number;
      break;
    case JointNumber::Armature:
      axis.armature = number;
      break;
  }
  world.set_joint_axis(id, axis, coordinate);
}

}  // namespace

void set_gravities(Batch& batch, std::span<const double> gravities, std::span<const std::size_t> places) {
  check_count("set_gravities", "gravities", gravities.size(), 3 * (places.empty() ? batch.size() : places.size()));
  for_each(batch, places, [&](World& world, std::size_t i) { world.set_gravity(Vector3(gravities.data() + 3 * i)); });
}

void set_numbers(Batch& batch, BodyNumber what, std::span<const std::size_t> bodies, std::span<const double> numbers,
                 std::span<const std::size_t> places) {
  set_each("body", batch, batch.bodies(), bodies, numbers, places,
           [&](World& world, BodyId id, double number) { set_number(world, id, what, number); });
}

void set_numbers(Batch& batch, JointNumber what, std::span<const std::size_t> joints, std::span<const double> numbers,
                 std::size_t coordinate, std::span<const std::size_t> places) {
  set_each("joint", batch, batch.joints(), joints, numbers, places,
           [&](World& world, JointId id, double number) { set_number(world, id, what, coordinate, number); });
}

}  // namespace atl
