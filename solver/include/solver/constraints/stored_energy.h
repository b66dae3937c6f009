#pragma once

#include <solver/constraints/joint.h>

namespace atl::solver {

/// J: what one of all joints can give back, with its bodies as they are now.
struct StoredEnergy {
  /// The energy of springs and servos; a servo's limit bounds its force, so it grows linearly from there on.
  double potential = 0;
  double rotors = 0;     ///< of armatures, by the rates of their coordinates
  bool springs = false;  ///< some spring or servo is there

  /// The potential is that which substeps of `lag` seconds of semi-implicit Euler keep together with the kinetic
  /// energy, as velocities are half a substep behind positions: k/2 times the offset now and the one a substep ago.
  static StoredEnergy of(std::uint32_t joint, const Joint* joints, const BodyTable& bodies, double lag);
  void add(const Law& law, double value, double rate, double lag);
};

/// Tells a joint that may have energy of its own: in springs, servos or rotors.
bool stores_energy(const Joint& joint);

/// J: the most that a joint gives in `dt` (s) beyond what it has stored. A motor with a speed works on its coordinate
/// up to that speed, and beyond it brakes. Infinite with a spring of a frequency, whose stiffness goes with the masses
/// along it.
double max_energy_given(const Joint& joint, double dt);

/// Tells a joint with a spring, a servo or ends that bounce, which gives motion back.
bool gives_back(const Joint& joint);

}  // namespace atl::solver
