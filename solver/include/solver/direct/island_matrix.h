#pragma once

#include <solver/direct/block_ldlt.h>
#include <solver/direct/island_problem.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>

namespace atl::solver {

/// The second derivative of an IslandProblem's function, M plus J^T K J with K the stiffness of what holds: positive
/// definite, with a block of 6 x 6 for each body and each pair, and its factor L D L^T.
class IslandMatrix {
 public:
  /// For as many bodies, of which these pairs touch or are joined. Returns false if the factor would be too large.
  bool analyse(std::size_t body_count, std::span<const std::pair<std::uint32_t, std::uint32_t>> pairs);

  /// Of the pieces of their laws that contacts and joints are on now, which are noted. Returns false if there is no
  /// factor.
  [[nodiscard]] bool factor(IslandProblem& problem);

  /// Replaces b by what the factor makes of it.
  void solve(std::span<double> b) const { system_.solve(b); }

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(system_); }

 private:
  void add_masses(std::span<const DirectBody> bodies);
  void add_stiffness(const DirectContact& contact, const std::array<Six, 6>& k);
  void add_stiffness(DirectJoint& joint);

  BlockLdlt system_;
};

/// Whether the factor is of the pieces that everything is on.
bool is_factored(const IslandProblem& problem);

/// Where bodies, axes or stiffnesses have changed: it is of none.
void forget_factor(IslandProblem& problem);

}  // namespace atl::solver
