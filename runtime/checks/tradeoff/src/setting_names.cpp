#include "checks/tradeoff/setting_names.h"

#include <array>
#include <stdexcept>
#include <utility>

namespace atl::tradeoff {
namespace {

template <class Enum>
using Named = std::pair<Enum, const char*>;

constexpr std::array frictions = {Named<FrictionModel>{FrictionModel::Cone, "cone"},
                                  Named<FrictionModel>{FrictionModel::Pyramid, "pyramid"}};
constexpr std::array stabilisations = {Named<Stabilisation>{Stabilisation::Soft, "soft"},
                                       Named<Stabilisation>{Stabilisation::Baumgarte, "baumgarte"},
                                       Named<Stabilisation>{Stabilisation::SplitImpulse, "split_impulse"}};
constexpr std::array contact_solvers = {Named<ContactSolver>{ContactSolver::Auto, "auto"},
                                        Named<ContactSolver>{ContactSolver::Iterative, "iterative"},
                                        Named<ContactSolver>{ContactSolver::Direct, "direct"}};
constexpr std::array joint_solvers = {Named<JointSolver>{JointSolver::Auto, "auto"},
                                      Named<JointSolver>{JointSolver::Iterative, "iterative"},
                                      Named<JointSolver>{JointSolver::Direct, "direct"}};

template <class Enum, std::size_t size>
const char* find_name(const std::array<Named<Enum>, size>& all, Enum value) {
  for (const auto& [each, name] : all) {
    if (each == value) return name;
  }
  return "unknown";
}

template <class Enum, std::size_t size>
bool is_name(const std::array<Named<Enum>, size>& all, std::string_view name) {
  for (const auto& [value, each] : all) {
    if (each == name) return true;
  }
  return false;
}

template <class Enum, std::size_t size>
Enum find_value(const std::array<Named<Enum>, size>& all, std::string_view name) {
  for (const auto& [value, each] : all) {
    if (each == name) return value;
  }
  throw std::logic_error("an option let an unknown name pass: " + std::string(name));
}

}  // namespace

const char* name_of(FrictionModel friction) { return find_name(frictions, friction); }
const char* name_of(Stabilisation stabilisation) { return find_name(stabilisations, stabilisation); }
const char* name_of(ContactSolver solver) { return find_name(contact_solvers, solver); }
const char* name_of(JointSolver solver) { return find_name(joint_solvers, solver); }
FrictionModel friction_named(std::string_view name) { return find_value(frictions, name); }
Stabilisation stabilisation_named(std::string_view name) { return find_value(stabilisations, name); }
ContactSolver contact_solver_named(std::string_view name) { return find_value(contact_solvers, name); }
bool is_contact_solver(const std::string& name) { return is_name(contact_solvers, name); }
bool is_joint_solver(const std::string& name) { return is_name(joint_solvers, name); }
JointSolver joint_solver_named(std::string_view name) { return find_value(joint_solvers, name); }
Simd simd_named(std::string_view name) { return find_value(simd_names, name); }

}  // namespace atl::tradeoff
