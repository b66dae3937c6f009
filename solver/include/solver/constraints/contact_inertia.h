#pragma once

#include <solver/integrate/body_table.h>

#include <cstdint>

namespace atl::solver {

/// The least moment of inertia that contacts assume, as part of mass times inner radius squared. Every moment of a
/// solid of uniform density is at least three times this.
inline constexpr double min_moment_share = 0.1;

/// Ratio of the largest to the least moment above which a body is slender: a rod from 1:15 on. Bodies below it gain no
/// energy in impacts: 100 capsules of 1:6 that hit a wall at 1000 m/s don't, 100 of 1:50 do.
inline constexpr double slender_ratio = 100;

/// Part of the largest moment that a body's least one counts as at least, wherever it is. The inverse of less is so
/// large that its rounding to single precision is more than all of the inverse of the largest. Then sweeps see a matrix
/// that isn't positive: needles of 1:10^4 that lay still took off at 1e7 m/s. Those of 1:1000 are above it.
inline constexpr double resolved_share = 1e-6;

/// True if contacts may have to assume more inertia than a body has, in islands without joints. There are two causes.
///
/// The first is a body with moments that no solid of its shape could have. An impulse at a contact point turns it
/// thousands of times as easily as it moves it. Sweeps would spin it ever faster instead of lifting it: a needle of 1
/// to 1e6 ended in infinities. With the added inertia the spin about the light axis is wrong in contact, but it has
/// next to no energy.
///
/// The second is a slender body that swings. Contacts keep the inertia of one orientation for the whole step. They make
/// spin about the light axis as it was; once the axis has swung by an angle, that angle's share of the spin is about
/// the heavy axes. Its energy grows by the ratio of the largest to the least moment times the angle's square. So the
/// least moment counts as no less than the largest times that square.
bool is_seen_heavier(const BodyTable& bodies, std::uint32_t body);

/// kg m^2, about the principal axes: what such a body has at least, however it moves.
Vector3 moments_in_contact(const BodyTable& bodies, std::uint32_t body);

/// rad, by which the light axis of such a body may swing in `dt` seconds, with what it touches closing at up to
/// `approach` m/s. 0 where it isn't slender.
double swing_in_contact(const BodyTable& bodies, std::uint32_t body, double approach, double dt);

/// The inertia that contacts assume (kg m^2), or its inverse; world frame.
Matrix3 inertia_in_contact(const BodyTable& bodies, std::uint32_t body, double swing);
Matrix3 inverse_inertia_in_contact(const BodyTable& bodies, std::uint32_t body, double swing);

}  // namespace atl::solver
