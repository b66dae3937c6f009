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

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(system_, couplings_, nodes_, response_, rates_, momenta_); }

 private:
  // Two joints at one body.
  struct Coupling {
    std::uint32_t row, column;  // nodes
    std::uint32_t body;
    bool row_second, column_second;  // the body is the second of the node
    bool transposed;                 // in the system
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
  bool plain_ = false;                           // all joints are points alone
  bool assigns_ = false;                         // every value of the system is written once
  mutable std::vector<double> rates_, momenta_;  // momenta are 0 between calls
};

}  // namespace atl::solver
