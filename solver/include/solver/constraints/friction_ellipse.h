#pragma once

#include <array>

namespace atl::solver {

/// Friction that depends on its direction: impulses lie within an ellipse. What slips takes the impulse of those that
/// takes the most energy from it, which need not be straight against the slip (Michalowski and Mroz, "Associated and
/// non-associated sliding rules in contact friction problems", Archives of Mechanics 30, 1978).
struct FrictionEllipse {
  double cosine = 1, sine = 0;  ///< of the direction of most friction, in the contact's tangents
  double ratio = 1;             ///< of the friction across that direction, to that along it; above 0

  bool is_disc() const { return ratio == 1; }

  /// Shortens impulses p that would stop all slip to the ellipse whose longer half axis is `bound`. With the effective
  /// mass m (11, 12, 22) the result f leaves a slip that it is the right answer to: p = f + s m n, n the ellipse's
  /// normal at f. Returns true if it did.
  bool hold(const std::array<double, 3>& mass, double bound, std::array<double, 2>& impulse) const;
  /// The same of the rectangle about the ellipse, of which a bit of the result is set for each side that binds.
  int hold_in_rectangle(double bound, std::array<double, 2>& impulse) const;
};

}  // namespace atl::solver
