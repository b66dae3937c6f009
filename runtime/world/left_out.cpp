#include "world/left_out.h"

#include <atoll/error.h>
#include <features/with_continuous.h>
#include <features/with_hulls.h>
#include <features/with_meshes.h>
#include <features/with_restitution.h>
#include <features/with_surfaces.h>

#include <string>

#include "world/body_definition.h"

namespace atl {

void throw_left_out(const char* asked, const char* what, const char* option) {
  throw Error(std::string(asked) + ", but Atoll was built without " + what + ": configure with -DATOLL_WITH_" + option +
              "=ON");
}

void check_built_for(const BodyConstants& body) {
  for_each_material(body, [](const Material& material) {
    if (!with_restitution && material.restitution > 0) {
      throw_left_out("BodyDef.material.restitution is above 0", "bounces", "RESTITUTION");
    }
    if (!with_surfaces && (material.rolling_friction > 0 || material.torsional_friction > 0)) {
      throw_left_out("BodyDef.material.rolling_friction or torsional_friction is above 0", "these", "SURFACES");
    }
    if (!with_surfaces && material.is_directed()) {
      throw_left_out("BodyDef.material.friction_direction is not zero", "friction by direction", "SURFACES");
    }
  });
  if (!with_continuous && body.continuous) {
    throw_left_out("BodyDef.continuous is true", "sweeps of fast bodies", "CONTINUOUS");
  }
  for (const CheckedCollider& collider : body.colliders) {
    if (!with_meshes && collision::is_surface(collider.shape.kind)) {
      throw_left_out("BodyDef.shape is a TriangleMesh or HeightField", "these", "MESHES");
    }
    if (!with_hulls && collider.shape.kind == collision::ShapeKind::Hull) {
      throw_left_out("BodyDef.shape is a ConvexHull", "these", "HULLS");
    }
  }
}

void check_built_for_surface(const char* what, const Vector3& velocity) {
  if (with_surfaces || velocity.isZero(0)) return;
  throw_left_out((std::string(what) + " is not zero").c_str(), "surfaces that run", "SURFACES");
}

}  // namespace atl
