#pragma once

#include <collision/contacts/contact.h>
#include <solver/constraints/load_check.h>
#include <solver/direct/joint_systems.h>
#include <solver/integrate/body_table.h>
#include <solver/islands/islands.h>
#include <solver/solver_settings.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace atl::solver {

/// What loads on contacts are estimated from.
struct LoadInput {
  const Islands& islands;
  const BodyTable& bodies;
  const collision::ContactManifold* manifolds;  ///< by slot
  Vector3 gravity;                              ///< m/s^2
  double dt;                                    ///< s
  const SolverSettings& settings;
  const JointGraph* joint_graph = nullptr;      ///< null where there are no joints
  const JointSystems* joint_systems = nullptr;  ///< likewise
  bool refines = true;                          ///< what sags; else targets say how many substeps it gets
};

/// What the contacts of an island carry if all stands: from the top down, each body hands its weight and what it
/// carries on to what is below it, in equal parts.
class LoadEstimate {
 public:
  void add_overloaded(const LoadInput& input, std::size_t island, std::vector<OverloadedBody>& overloaded);

 private:
  struct Support {
    std::uint32_t above, below;  // places in the island; below may be none
    double along;                // cosine of the normal against up
    std::uint32_t slot, first, second;
  };
  std::vector<double> height_, load_;
  std::vector<std::uint32_t> order_, start_;
  std::vector<Support> supports_;
};

}  // namespace atl::solver
