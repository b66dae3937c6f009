#pragma once

#include <solver/direct/block_ldlt.h>
#include <solver/direct/island_problem.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace atl::solver {

/// The inverse of M plus J^T K J where nothing touches the joints, by what these take of the bodies' answer:
/// M^-1 - M^-1 J^T (J M^-1 J^T + K^-1)^-1 J M^-1 (Woodbury's formula). Its system has a node a joint and a block where
/// two share a body, of as many rows as the joints have: for chains a quarter of what a node a body takes.
class JointResponse {
 public:
  /// Returns false where joints share bodies so that the system would have more than two blocks a joint, and where a
  /// tendon acts on more than two bodies.
  bool analyse(const IslandProblem& problem);
  bool empty() const { return nodes_.empty(); }
  void clear() { nodes_.clear(); }

  /// Factors the system on the pieces of their laws that joints are on now, which are noted. Returns false if it has no
  /// factor.
  [[nodiscard]] bool factor(IslandProblem& problem);
  /// Replaces momenta by velocities.
  void solve(const IslandProblem& problem, std::span<double> b) const;
  /// Replaces rates by the impulses that make them: of all rows, those of the first joint first.
  void impulses_of(std::vector<double>& rates) const { system_.solve(rates); }
  /// Adds what bodies make of such impulses to velocities.
  void add_answer(const IslandProblem& problem, const std::vector<double>& impulses,
                  std::vector<double>& velocities) const;
  std::size_t rows() const { return system_.rows(); }
  /// Inverts the factored system, for for_each_response().
  void invert() { system_.invert(inverse_); }
  /// Calls visit(joint, row, other joint, other row, response) with the rate along the one row that an impulse along
  /// the other makes, under all that rows hold. Visits the pairs of a joint's rows, each row with itself too, and those
  /// of joints that share a body, once each; only rows that have a slope.
  template <typename Visit>
  void for_each_response(const IslandProblem& problem, const Visit& visit) const;

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(system_, couplings_, nodes_, response_, inverse_, rates_, momenta_); }

 private:
  // Two joints at one body.
  struct Coupling {
    std::uint32_t row, column;  // nodes
    std::uint32_t body;
    bool row_second, column_second;  // the body is the second of the node
    bool transposed;                 // in the system
    bool again;                      // the two share a body before this one, too
    std::size_t block;
  };

  // A joint: its rows, and how its bodies answer to an impulse along each.
  struct Node {
    std::size_t block;                  // diagonal
    std::uint8_t idle;                  // by row, a bit where its law doesn't act
    Matrix3 point_first, point_second;  // arms' cross matrices times the inverse inertia
    double linear[BlockLdlt::max_size][3];
    double first[BlockLdlt::max_size][3], second[BlockLdlt::max_size][3];                // angular
    double answer_first[BlockLdlt::max_size][3], answer_second[BlockLdlt::max_size][3];  // 1/(kg m^2) times these
  };

  // Fills in all rows, whether they act or not, as laws come and go many times at one pose.
  void fill(IslandProblem& problem);
  void fill_points(const IslandProblem& problem);
  void take_laws(IslandProblem& problem);
  template <typename Visit>
  void for_each_value(const IslandProblem& problem, const Coupling& coupling, const Visit& visit);
  void leave_out_rows(std::size_t rows, const Node& node);
  void leave_out_coupling(const IslandProblem& problem, const Coupling& coupling);
  void fill_point(const IslandProblem& problem, const DirectJoint& joint, Node& node);
  void fill_point_coupling(const IslandProblem& problem, const Coupling& coupling);
  void fill_rows(const IslandProblem& problem, const DirectJoint& joint, Node& node);
  void fill_coupling(const IslandProblem& problem, const Coupling& coupling);

  BlockLdlt system_;
  std::vector<Coupling> couplings_;
  std::vector<Node> nodes_;                      // by joint
  std::vector<double> response_;                 // the system without laws
  std::vector<double> inverse_;                  // of the system
  bool plain_ = false;                           // all joints are points alone
  bool assigns_ = false;                         // every value of the system is written once
  mutable std::vector<double> rates_, momenta_;  // momenta are 0 between calls
};

// By Woodbury's formula the response is K^-1 - K^-1 (J M^-1 J^T + K^-1)^-1 K^-1.
template <typename Visit>
void JointResponse::for_each_response(const IslandProblem& problem, const Visit& visit) const {
  const auto compliance_of = [&](std::size_t joint, std::size_t row) {
    const DirectJoint& of = problem.joints[joint];
    const double slope = of.is_lock(row) || of.law[row].locked ? 0 : of.law[row].slope(of.rate[row]);
    return slope > 0 ? 1 / slope : 0;
  };
  const auto visit_block = [&](std::size_t row, std::size_t column, std::size_t block, bool transposed) {
    const std::size_t rows = problem.joints[row].rows, columns = problem.joints[column].rows;
    for (std::size_t c = 0; c < columns; ++c) {
      const double given = compliance_of(column, c);
      if (given == 0) continue;
      for (std::size_t r = row == column ? c : 0; r < rows; ++r) {
        const double gives = compliance_of(row, r);
        const double value = inverse_[block + (transposed ? columns * r + c : r + rows * c)];
        const double own = row == column && r == c ? gives : 0;
        if (gives > 0) visit(row, r, column, c, own - gives * value * given);
      }
    }
  };
  for (std::size_t i = 0; i < nodes_.size(); ++i) visit_block(i, i, nodes_[i].block, false);
  for (const Coupling& coupling : couplings_) {
    if (!coupling.again) visit_block(coupling.row, coupling.column, coupling.block, coupling.transposed);
  }
}

}  // namespace atl::solver
