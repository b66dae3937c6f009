#pragma once
/// Functions of yours that have a say in which bodies touch and how: see World::set_contact_filter() and
/// set_contact_modifier().

#include <atoll/types.h>

#include <cstdint>
#include <span>

namespace atl {

class World;

/// Two shapes whose bounds have come to overlap, for a ContactFilter to say whether they may touch.
struct ContactCandidate {
  const World& world;
  BodyId a;  ///< of the two bodies the one with the lower index
  BodyId b;
  std::uint32_t child_a = 0;  ///< in a compound, else 0
  std::uint32_t child_b = 0;
};

/// A manifold point of a ModifiableContact.
struct ModifiablePoint {
  Vector3 position;   ///< m, world frame, half way between the surfaces
  double separation;  ///< m, as the step begins; negative where the shapes overlap
  std::uint64_t feature_id;
  bool enabled = true;  ///< to be changed: a point that is not holds nothing up in this step
};

/// Two shapes that touch, or may come to within the step, with up to four points in one tangent plane. What is to be
/// changed holds for this step alone: the next one asks again, from what materials say.
struct ModifiableContact {
  const World& world;  ///< bodies are where they were as the step, or the substep of a force law, began
  BodyId a;            ///< of the two bodies the one with the lower index
  BodyId b;
  std::uint32_t child_a = 0;  ///< in a compound, else 0
  std::uint32_t child_b = 0;
  std::uint32_t part = 0;  ///< of a solid and a mesh or height field: they may touch in several manifolds
  Vector3 normal;          ///< unit, world frame, from a to b

  // To be changed.
  std::span<ModifiablePoint> points;
  double friction = 0;                         ///< Coulomb coefficient of the two, >= 0
  double restitution = 0;                      ///< of the two, in [0, 1]
  Vector3 surface_velocity = Vector3::Zero();  ///< m/s, world frame: what b's surface runs at along its body, less a's,
                                               ///< beside BodyDef::surface_velocity; what is along the normal is void.
                                               ///< At most 1e6 along each axis
  bool enabled = true;                         ///< false: they pass through each other in this step

  /// Lets the surface of one of the two run along its body at a velocity (m/s, world frame): what lies on it is taken
  /// along, as by BodyDef::surface_velocity. A body that is neither of the two is left alone.
  void run_surface(BodyId of, const Vector3& velocity) {
    if (of == b) surface_velocity += velocity;
    if (of == a) surface_velocity -= velocity;
  }
};

}  // namespace atl
