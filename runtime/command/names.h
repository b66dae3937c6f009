#pragma once

#include <string>

#include "checks/tradeoff/number_text.h"
#include "checks/tradeoff/setting_names.h"

namespace atl::command {

using tradeoff::contact_solver_named;
using tradeoff::fixed;
using tradeoff::friction_named;
using tradeoff::is_contact_solver;
using tradeoff::is_joint_solver;
using tradeoff::joint_solver_named;
using tradeoff::name_of;
using tradeoff::plural;
using tradeoff::simd_named;
using tradeoff::stabilisation_named;

/// The parts of a world's state that belong to no body, for messages about a difference outside the bodies.
inline constexpr const char* beside_bodies = "settings, gravity, quarantine, or which ids come next";

/// At most so many significant digits, as "3.14" or "1e-09".
std::string significant(double value, int digits);
/// The same without an exponent, for rates: 80,000 is "80000".
std::string plain(double value, int digits);

}  // namespace atl::command
