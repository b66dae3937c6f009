#pragma once

#include <solver/integrate/body_table.h>

#include <cstdint>

namespace atl::solver {

/// As part of mass times inner radius squared: no moment of a solid of uniform density is less than three times this.
inline constexpr double least_moment_share = 0.1;

/// A body whose largest moment is more than so many times the least is slender: a rod from 1:15 on. What is less
/// slender gains no energy in impacts as it is: 100 capsules of 1:6 that hit a wall at 1000 m/s don't, such of 1:50 do.
inline constexpr double slender_ratio = 100;

/// Whether contacts may see a body with more inertia than it has, in islands without joints.
///
/// Either one with moments that no solid of its shape could have. A point of contact turns such a body thousands of
/// times as easily as it moves it, and that is what sweeps would do instead of lifting it, ever faster: a needle of 1
/// to 1e6 ended in infinities. The spin about the light axis is then wrong in contact; it has next to no energy.
///
/// Or a slender one that swings. Contacts keep the inertia of one place in the step. The spin about the light axis that
/// they make along where that axis was is, once it has swung by an angle, one about the heavy axes by so much, and its
/// energy grows by their moment over the least times the square of the angle. So the least moment counts as no less
/// than the largest times that square.
bool is_seen_heavier(const BodyTable& bodies, std::uint32_t body);

/// kg m^2, about the principal axes: what such a body has at least, however it moves.
Vector3 moments_in_contact(const BodyTable& bodies, std::uint32_t body);

/// rad, by which the light axis of such a body may swing in `dt` seconds, with what it touches closing at up to
/// `approach` m/s. 0 where it isn't slender.
double swing_in_contact(const BodyTable& bodies, std::uint32_t body, double approach, double dt);

/// What contacts see of it, or the inverse; world frame.
Matrix3 inertia_in_contact(const BodyTable& bodies, std::uint32_t body, double swing);
Matrix3 inverse_inertia_in_contact(const BodyTable& bodies, std::uint32_t body, double swing);

}  // namespace atl::solver
