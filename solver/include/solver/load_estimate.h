#pragma once

#include <collision/contact.h>
#include <solver/body_table.h>
#include <solver/islands.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace atl::solver {

/// The lighter body of a contact that carries more than soft ones are made for (overload_give in solver_settings.h).
struct Overload {
  std::uint32_t body;
  bool crushed;  ///< many times as much
};

/// Adds what a contact is, if it is overloaded; the kernels do the same of their lanes. `give` in m kg: how far
/// contacts between dynamic bodies give under the load that it carries, times the mass; inverse masses in 1/kg, `reach`
/// in m, the lesser of the two bodies.
void note_overload(double give, double inverse_mass_first, double inverse_mass_second, double reach,
                   std::uint32_t lighter, std::vector<Overload>& overloads);

/// What loads on contacts are estimated from.
struct LoadInput {
  const Islands& islands;
  const BodyTable& bodies;
  const collision::ContactManifold* manifolds;  ///< by slot
  Vector3 gravity;                              ///< m/s^2
  double give;                                  ///< m by N and 1/kg: of soft contacts between dynamic bodies
};

/// What the contacts of an island carry if all stands: from the top down, each body hands its weight and what it
/// carries on to what is below it, in equal parts.
class LoadEstimate {
 public:
  void add_overloads(const LoadInput& input, std::size_t island, std::vector<Overload>& overloads);

 private:
  struct Support {
    std::uint32_t above, below;  // places in the island; below may be none
    std::uint32_t lower_body, upper_body;
    double along;  // cosine of the normal against up
    double reach;  // m
  };
  std::vector<double> height_, load_;
  std::vector<std::uint32_t> order_, start_;
  std::vector<Support> supports_;
};

}  // namespace atl::solver
