#pragma once

#include <atoll/settings.h>

#include <cstdint>
#include <string>
#include <string_view>

#include "world/simd_names.h"

namespace atl::command {

/// The words that options and reports have for the library's enumerations.
const char* name_of(FrictionModel friction);
const char* name_of(Stabilisation stabilisation);
const char* name_of(ContactSolver solver);
const char* name_of(JointSolver solver);
using atl::name_of;  // Simd's
FrictionModel friction_named(std::string_view name);
Stabilisation stabilisation_named(std::string_view name);
ContactSolver contact_solver_named(std::string_view name);
JointSolver joint_solver_named(std::string_view name);
bool is_contact_solver(const std::string& name);
bool is_joint_solver(const std::string& name);
Simd simd_named(std::string_view name);

/// What of a world's state is no body's, where two of them differ.
inline constexpr const char* beside_bodies = "settings, gravity, quarantine, or which ids come next";

/// "1 step", "2 steps".
std::string plural(std::int64_t count, const std::string& one, const std::string& more);
std::string plural(std::int64_t count, const std::string& noun);

/// A fixed number of decimals, as "3.140".
std::string fixed(double value, int decimals);
/// At most so many significant digits, as "3.14" or "1e-09".
std::string significant(double value, int digits);
/// The same without an exponent, for rates: 80,000 is "80000".
std::string plain(double value, int digits);

}  // namespace atl::command
