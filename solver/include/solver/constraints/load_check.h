#pragma once

#include <collision/contacts/contact.h>
#include <jobs/scratch.h>

#include <cstdint>
#include <vector>

namespace atl::solver {

/// The structure of an island, so far as it decides how much load its contacts may carry.
enum class Build : std::uint8_t {
  Any,
  /// Small and of so few contacts that it is little but columns (or arches): to solve it at once costs not much more
  /// than to sweep it.
  Columns,
  Joined,  ///< there are joints in it
};

/// The lighter body of a contact that carries more than soft ones are made for.
struct OverloadedBody {
  std::uint32_t body;
  bool deep;
};

/// By worker, in any order.
using OverloadedBodies = jobs::Scratch<std::vector<OverloadedBody>>;

/// A contact and its bodies, with inverse masses in 1/kg: 0 of what doesn't respond.
struct LoadedContact {
  const collision::ContactManifold& manifold;
  std::uint32_t first, second;
  double inverse_first, inverse_second;
};

/// N s: all that its points push with, as of the last step.
double load_of(const collision::ContactManifold& manifold);

/// Adds what a contact is, if it is overloaded. `give` in m kg: how far contacts between dynamic bodies give under the
/// load that it carries, times the mass.
void check_load(const LoadedContact& contact, double penetration, Build build, std::vector<OverloadedBody>& overloaded);

}  // namespace atl::solver
