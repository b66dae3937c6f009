#pragma once
/// Bodies, hinges and rods that the cases of joints share.

#include "cases.h"

namespace atl::physics {

inline constexpr CollisionFilter no_contact = {.mask = 0};

/// The least turn from one direction to another. Eigen's FromTwoVectors() decomposes a matrix where they are opposites,
/// which takes the compiler 7 s in each file.
inline Quaternion turn_between(const Vector3& from, const Vector3& to) {
  const Vector3 a = from.normalized(), b = to.normalized();
  Quaternion turn;
  turn.w() = 1 + a.dot(b);
  turn.vec() = turn.w() > 1e-12 ? a.cross(b) : a.unitOrthogonal();
  return turn.normalized();
}

/// A world whose joints are solved at once.
World mechanism_world(const Resolution& at, double gravity);

/// A fixed body that nothing touches.
BodyId add_floor(World& world);

/// Turns about an axis of the world, at a place of it (m), as both bodies are now.
JointId add_hinge(World& world, BodyId first, BodyId second, const Vector3& place, const Vector3& axis,
                  const JointAxis& angle = {});

/// A body that nothing touches and whose inertia is given, kg m^2, in its own frame.
struct Part {
  BodyId body;
  Matrix3 inertia;
};
Part add_part(World& world, double mass, const Vector3& moments, const Pose& pose, const Vector3& velocity = {0, 0, 0},
              const Vector3& spin = {0, 0, 0});

/// kg m^2/s, about the common centre of mass.
Vector3 angular_momentum(const World& world, const std::vector<Part>& parts);

/// Rods of 1 kg as thin as they may be, and what they weigh together.
class Rods {
 public:
  explicit Rods(World& world) : world_(world) {}

  BodyId add(const Vector3& tail, const Vector3& head, const Vector3& velocity = Vector3::Zero());
  double energy() const;

 private:
  World& world_;
  std::vector<Part> rods_;
};

}  // namespace atl::physics
