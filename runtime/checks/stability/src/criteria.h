#pragma once
/// The numbers that several cases are judged by. Limits are in the unit that each names.

#include <cstddef>

#include "checks/stability/suite.h"

namespace atl::stability {

// Criteria of the last state.

Criterion penetration(double limit);           ///< m, the deepest overlap of a pair that may touch
Criterion relative_penetration(double limit);  ///< of the smaller shape's bounding radius
Criterion drift(double limit);                 ///< m across gravity, of dynamic bodies, from where they started
Criterion relative_drift(double limit);        ///< the same in all directions, over a body's size
Criterion sink(double limit);                  ///< m along gravity
Criterion tilt(double limit);                  ///< rad, from how they started
Criterion joint_gap(double limit);             ///< m, of locked offsets
Criterion end_speed(double limit);             ///< m/s, of centres of mass of dynamic bodies

// Over the run.

Criterion peak_joint_gap(double limit);
Criterion peak_speed(double limit);  ///< m/s, of centres of mass of dynamic bodies
/// m, of dynamic bodies: how far one is at the end from where its velocity, trapezoid by trapezoid, would have brought
/// it. Impacts within a step make some centimetres of that; a body that hangs in the air though it has a velocity more.
Criterion travel_error(double limit);
Criterion rise(double limit);  ///< m, of a dynamic body above where it started
/// The largest growth of kinetic and potential energy, over the size that their sum starts with; the origin's height is
/// that of no potential energy.
Criterion energy_gain(double limit);
Criterion energy_change(double limit);            ///< the same to either side
Criterion angular_momentum_change(double limit);  ///< about the origin, over its size at the start

/// A number of one body, by its place in the scene: the largest over the run.
using BodyMeasure = std::function<double(const BodyState&)>;
Criterion peak_of(std::string name, std::string unit, double limit, std::size_t body, BodyMeasure measure);

/// The criterion, which is exceeded for a reason as things stand.
Criterion known_to_fail(Criterion criterion, std::string reason);

/// Criteria of towers: less than 1 mm of overlap, 10 mm of drift.
std::vector<Criterion> stands();

/// The same of towers that are known to overlap by more.
std::vector<Criterion> stands_softly();
inline const std::string softness =
    "soft contacts give by half a millimetre for each body above; only where that is more than half a percent of the "
    "thickness are columns solved at once, and other islands not before 1.5%";

}  // namespace atl::stability
