#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>

namespace atl::audit {

/// Impulses or velocities at the rows of a patch of contact: along the normal at each point, along the two tangents at
/// the centre, and about the normal. Twist is taken per lever arm (an angular impulse over L, a spin times L), so that
/// all rows have the same unit.
struct PatchVector {
  std::array<double, 4> normal = {};
  std::size_t points = 0;  ///< in [1, 4]; how many of `normal` count
  Eigen::Vector2d tangential = Eigen::Vector2d::Zero();
  double twist = 0;

  double squared_norm() const;
};

PatchVector operator-(const PatchVector& a, const PatchVector& b);

/// The nearest member, in the Euclidean norm, of the convex cone
///   K = {r_i >= 0,  |r_T| <= mu R,  |r_w| <= mu R},   R the sum of the r_i,
/// for friction mu >= 0.
///
/// With R given, r_T and r_w are clamped, which costs (|z_T| - mu R)^+ and (|z_w| - mu R)^+; the r_i then minimise half
/// the sum of squares, so r_i = max(0, z_i + l) with l = mu ((|z_T| - mu R)^+ + (|z_w| - mu R)^+). The l that the first
/// needs for a sum of R rises with R, the second falls: R is the zero of an increasing piecewise linear function, found
/// exactly between two of its at most six breakpoints.
PatchVector project_on_cone(const PatchVector& z, double friction);

}  // namespace atl::audit
