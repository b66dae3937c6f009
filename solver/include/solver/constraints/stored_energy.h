#pragma once

#include <solver/constraints/joint.h>

namespace atl::solver {

/// J: what one of all joints can give back, with its bodies as they are now.
struct StoredEnergy {
  double potential =
      0;              ///< of springs and servos; a servo's limit bounds its force, so it grows linearly from there on
  double rotors = 0;  ///< of armatures, by the rates of their coordinates

  static StoredEnergy of(std::uint32_t joint, const Joint* joints, const BodyTable& bodies);
  void add(const Law& law, double value, double rate);
};

/// Tells a joint that gives no energy but what it has stored. A motor with a speed does, and so does a spring of a
/// frequency, whose stiffness goes with the masses along it.
bool only_stores(const Joint& joint);

}  // namespace atl::solver
