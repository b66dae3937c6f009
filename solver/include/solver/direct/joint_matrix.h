#pragma once

#include <jobs/arrays.h>
#include <solver/direct/block_ldlt.h>
#include <solver/direct/joint_assembly.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace atl::solver {

/// J M^-1 J^T of an assembly, with the compliances of springs on its diagonal: a block-sparse system with a node a
/// joint, and its factor L D L^T. Vectors have the rows of each joint, those of its point first.
class JointMatrix {
 public:
  /// For the joints of an assembly. Returns false if loops would fill the factor to more than a few blocks a joint.
  bool analyse(const JointAssembly& assembly);

  /// Of the poses that the assembly has been placed at, and the pieces of their laws that rows are on.
  void factor(const JointAssembly& assembly);

  /// Replaces changes of rates by the impulses along the rows that make them. Returns false if there is no factor.
  [[nodiscard]] bool solve(std::span<double> b) const;

  std::size_t rows() const { return system_.rows(); }
  std::size_t row(std::uint32_t node) const { return system_.row(node); }

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(couplings_, points_, node_rows_, system_); }

 private:
  // Two joints at one member.
  struct Coupling {
    std::uint32_t row, column;  // nodes
    std::uint32_t member;
    bool row_second, column_second;  // the member is the second body of the node
    bool transposed;                 // in the system
    std::size_t block;
  };

  // What the members of a point alone make of it: its arms' cross matrix times the inverse inertia.
  struct PointResponse {
    Matrix3 first, second;
    std::size_t block;  // of the node, diagonal
  };

  // A node's rows of the Jacobian, and what the inverse inertia makes of them.
  struct NodeRows {
    std::size_t count = 0;
    double linear[BlockLdlt::max_size][3];
    double first[BlockLdlt::max_size][3], second[BlockLdlt::max_size][3];                // angular
    double answer_first[BlockLdlt::max_size][3], answer_second[BlockLdlt::max_size][3];  // 1/(kg m^2) times these
  };

  void fill_point(const JointAssembly& assembly, const JointNode& node, PointResponse& response);
  void fill_point_coupling(const JointAssembly& assembly, const Coupling& coupling);
  static void fill_rows(const JointAssembly& assembly, const JointNode& node, NodeRows& rows);
  void fill_diagonal(const JointAssembly& assembly, const JointNode& node, std::size_t of_node, const NodeRows& rows);
  void fill_coupling(const JointAssembly& assembly, const Coupling& coupling);

  BlockLdlt system_;
  std::vector<Coupling> couplings_;
  std::vector<PointResponse> points_;  // by node
  std::vector<NodeRows> node_rows_;    // by node, where there are rows
  double redundancy_ = 0;              // of the diagonal, that joints share which ask for the same
  bool assigns_all_ = false;           // every value is written once
  bool factored_ = false;
};

}  // namespace atl::solver
