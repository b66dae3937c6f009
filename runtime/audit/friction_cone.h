#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

namespace atl::audit {

/// Impulses or velocities at the rows of a patch of contact: along the normal at each point, along the two tangents at
/// the centre, and about the normal. Torsion is taken per arm (an angular impulse over L, a spin times L), so that
/// all rows have the same unit.
struct PatchVector {
  std::array<double, 4> normal = {};
  std::size_t points = 0;  ///< in [1, 4]; how many of `normal` count
  Eigen::Vector2d tangential = Eigen::Vector2d::Zero();
  double torsional = 0;
  Eigen::Vector2d rolling = Eigen::Vector2d::Zero();  ///< about the tangents, per arm likewise

  double squared_norm() const;
};

PatchVector operator-(const PatchVector& a, const PatchVector& b);

/// How much of the normal impulse the others may be; all >= 0.
struct FrictionBounds {
  double tangential = 0;
  double torsional = 0;
  double rolling = 0;
};

/// The nearest member, in the Euclidean norm, of the convex cone
///   K = {r_i >= 0,  |r_T| <= mu_T R,  |r_w| <= mu_w R,  |r_r| <= mu_r R},   R the sum of the r_i.
///
/// With R given, the frictional parts r_k are clamped, which costs (|z_k| - mu_k R)^+; the r_i then minimise half the
/// sum of squares, so r_i = max(0, z_i + l) with l = sum over k of mu_k (|z_k| - mu_k R)^+. The l that the first needs
/// for a sum of R rises with R, the second falls: R is the zero of an increasing piecewise linear function, found
/// exactly between two of its at most seven breakpoints.
PatchVector project_on_cone(const PatchVector& z, const FrictionBounds& friction);

}  // namespace atl::audit
