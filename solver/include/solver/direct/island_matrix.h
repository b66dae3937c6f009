#pragma once

#include <solver/direct/block_ldlt.h>
#include <solver/direct/island_problem.h>
#include <solver/direct/joint_response.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace atl::solver {

/// Blocks under the diagonal that the factor of so many bodies may have.
std::size_t max_factor_blocks(std::size_t body_count, bool touch);

/// The second derivative of an IslandProblem's function, M plus J^T K J with K the stiffness of what holds: positive
/// definite, with a block of 6 x 6 for each body and each pair, and its factor L D L^T.
class IslandMatrix {
 public:
  /// Analyses a matrix for `body_count` bodies of which these pairs are coupled. Returns false if the factor would have
  /// more than `max_blocks` blocks.
  bool analyse(std::size_t body_count, std::span<const std::pair<std::uint32_t, std::uint32_t>> pairs,
               std::size_t max_blocks);

  /// Does the same for a problem of joints alone, which its bodies and joints describe.
  bool analyse_joints(const IslandProblem& problem, std::size_t max_blocks);

  /// Factors the matrix for the pieces of their laws that contacts and joints are on now, and records these pieces.
  /// Returns false if there is no factor.
  [[nodiscard]] bool factor(IslandProblem& problem);

  /// Replaces b by what the factor makes of it.
  void solve(const IslandProblem& problem, std::span<double> b) const {
    joints_.empty() ? solve_by_bodies(problem, b) : joints_.solve(problem, b);
  }

  /// The response of joints, if the problem is of these alone and solved by it; else null.
  const JointResponse* joints() const { return joints_.empty() ? nullptr : &joints_; }
  JointResponse* joints() { return joints_.empty() ? nullptr : &joints_; }

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(system_, placed_, joints_); }

 private:
  enum class Rows { Locks, Others };

  // Fills in the parts that don't depend on pieces of laws: the masses of bodies and the locks of joints.
  void fill(IslandProblem& problem);
  void add_masses(std::span<const DirectBody> bodies);
  void add_stiffness(const DirectContact& contact, const std::array<Six, 6>& k);
  void add_stiffness(DirectJoint& joint, Rows rows);
  void add_tendon(DirectJoint& tendon);
  void solve_by_bodies(const IslandProblem& problem, std::span<double> b) const;

  BlockLdlt system_;
  std::vector<double> placed_;  // its values as they are filled
  JointResponse joints_;        // or empty: takes the place of the system
};

/// True if the factor belongs to the pieces of their laws that all rows are on now.
bool is_factored(const IslandProblem& problem);

/// Has the matrix factored anew, after stiffnesses have changed.
void forget_factor(IslandProblem& problem);

/// Has it filled anew as well, after bodies or axes have.
void forget_rows(IslandProblem& problem);

}  // namespace atl::solver
