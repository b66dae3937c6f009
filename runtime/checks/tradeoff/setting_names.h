#pragma once

#include <atoll/settings.h>

#include <string>
#include <string_view>

#include "world/simd_names.h"

namespace atl::tradeoff {

/// The words that options, reports and tables have for the library's enumerations.
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

}  // namespace atl::tradeoff
