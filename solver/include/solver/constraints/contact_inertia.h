#pragma once

#include <solver/integrate/body_table.h>

#include <cstdint>

namespace atl::solver {

/// As part of mass times inner radius squared: no moment of a solid of uniform density is less than three times this.
inline constexpr double least_moment_share = 0.1;

/// Whether contacts see a body with more inertia than it has, in islands without joints: one with moments that no solid
/// of its shape could have. A point of contact turns such a body thousands of times as easily as it moves it, and that
/// is what sweeps would do instead of lifting it, ever faster: a needle of 1 to 1e6 ended in infinities. The spin about
/// the light axis is then wrong in contact; it has next to no energy.
bool is_seen_heavier(const BodyTable& bodies, std::uint32_t body);

/// kg m^2, about the principal axes: what contacts see of such a body.
Vector3 moments_in_contact(const BodyTable& bodies, std::uint32_t body);

/// The same as a matrix, or its inverse; world frame.
Matrix3 inertia_in_contact(const BodyTable& bodies, std::uint32_t body);
Matrix3 inverse_inertia_in_contact(const BodyTable& bodies, std::uint32_t body);

}  // namespace atl::solver
