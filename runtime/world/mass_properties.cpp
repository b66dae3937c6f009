#include <atoll/error.h>
#include <atoll/shapes.h>

#include <string>
#include <vector>

#include "world/body_definition.h"

namespace atl {
namespace {

double density_factor(const Shape& shape, std::size_t part) {
  const auto* compound = std::get_if<Compound>(&shape);
  return compound == nullptr ? 1 : compound->children[part].density_factor;
}

Vector3 centre_of(const CheckedCollider& part) {
  return part.local.position + part.local.orientation * collision::mass_properties(part.shape).centre;
}

// Second moments of a unit mass at `arm` from the axes' origin.
Matrix3 point_inertia(const Vector3& arm) { return arm.squaredNorm() * Matrix3::Identity() - arm * arm.transpose(); }

}  // namespace

// Parts are summed up about the common centre (parallel axes), which needs a first pass to find it.
MassProperties mass_properties(const Shape& shape) {
  const std::vector<CheckedCollider> parts = checked_colliders("mass_properties: shape", shape);
  MassProperties total;
  Vector3 moment = Vector3::Zero();
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (const char* name = massless_name(parts[i].shape.kind)) {
      throw Error(std::string("mass_properties: shape is a ") + name + "; expected a solid, which has a volume");
    }
    const collision::MassProperties part = collision::mass_properties(parts[i].shape);
    const double mass = density_factor(shape, i) * part.volume;
    total.volume += part.volume;
    total.mass += mass;
    moment += mass * centre_of(parts[i]);
  }
  // The centre of a single part is its own, to the bit: the part then has no offset from the body's centre.
  total.centre = parts.size() == 1 ? centre_of(parts[0]) : Vector3(moment / total.mass);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const collision::MassProperties part = collision::mass_properties(parts[i].shape);
    const Matrix3 turn = parts[i].local.orientation.toRotationMatrix();
    const Vector3 arm = parts[i].local.position + turn * part.centre - total.centre;
    total.inertia +=
        density_factor(shape, i) * part.volume * (turn * part.unit_inertia * turn.transpose() + point_inertia(arm));
  }
  return total;
}

}  // namespace atl
