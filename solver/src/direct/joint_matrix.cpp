#include <solver/direct/joint_matrix.h>
#include <solver/tuning.h>

#include <algorithm>
#include <utility>

#include "integrate/matrix3.h"

namespace atl::solver {
namespace {

double dot(const double (&a)[3], const double (&b)[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// Whether joints make loops: more of them than a tree has.
bool has_loops(const JointAssembly& assembly) {
  const std::vector<JointMember>& members = assembly.members;
  const auto count = std::count_if(members.begin(), members.end(), [](const JointMember& m) { return m.dynamic; });
  const bool anchored = static_cast<std::size_t>(count) < members.size();
  return assembly.nodes.size() > static_cast<std::size_t>(anchored ? count : count - 1);
}

}  // namespace

bool JointMatrix::analyse(const JointAssembly& assembly) {
  const std::vector<JointNode>& nodes = assembly.nodes;
  std::vector<std::uint8_t> sizes;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  std::vector<std::vector<std::uint32_t>> at_member(assembly.members.size());
  couplings_.clear();
  for (std::uint32_t i = 0; i < nodes.size(); ++i) {
    const JointNode& node = nodes[i];
    for (const std::uint32_t member : {node.first, node.second}) {
      if (!assembly.members[member].dynamic) continue;
      for (const std::uint32_t other : at_member[member]) {
        couplings_.push_back({i, other, member, node.second == member, nodes[other].second == member, false, 0});
        pairs.emplace_back(i, other);
      }
      at_member[member].push_back(i);
    }
    sizes.push_back(static_cast<std::uint8_t>((node.point ? 3 : 0) + node.end - node.begin));
  }
  const std::size_t most_blocks = std::max(tuning::factor_blocks_per_joint * nodes.size(), tuning::small_factor);
  if (!system_.analyse(sizes, pairs, most_blocks)) return false;
  for (Coupling& coupling : couplings_) {
    coupling.block = system_.block_index(coupling.row, coupling.column);
    coupling.transposed = system_.is_earlier(coupling.row, coupling.column);
  }
  points_.resize(nodes.size());
  for (std::uint32_t i = 0; i < nodes.size(); ++i) points_[i].block = system_.block_index(i, i);
  node_rows_.resize(assembly.rows.empty() ? 0 : nodes.size());
  // Points alone, each two of which share one body at most, and no fill.
  assigns_all_ = assembly.rows.empty() && system_.factor_blocks() == couplings_.size();
  redundancy_ = has_loops(assembly) ? tuning::redundancy_of_loops : tuning::redundancy;
  return true;
}

void JointMatrix::factor(const JointAssembly& assembly) {
  if (!assigns_all_) system_.clear();
  for (std::uint32_t i = 0; i < assembly.nodes.size(); ++i) {
    const JointNode& node = assembly.nodes[i];
    if (!node_rows_.empty()) fill_rows(assembly, node, node_rows_[i]);
    if (node.is_point_only()) {
      fill_point(assembly, node, points_[i]);
    } else {
      fill_diagonal(assembly, node, points_[i].block, node_rows_[i]);
    }
  }
  for (const Coupling& coupling : couplings_) {
    if (assembly.nodes[coupling.row].is_point_only() && assembly.nodes[coupling.column].is_point_only()) {
      fill_point_coupling(assembly, coupling);
    } else {
      fill_coupling(assembly, coupling);
    }
  }
  factored_ = system_.factor();
}

bool JointMatrix::solve(std::span<double> b) const {
  if (factored_) system_.solve(b);
  return factored_;
}

void JointMatrix::fill_point(const JointAssembly& assembly, const JointNode& node, PointResponse& response) {
  const JointMember& a = assembly.members[node.first];
  const JointMember& b = assembly.members[node.second];
  response.first = crossed(node.arm_first, a.inverse_inertia);
  response.second = crossed(node.arm_second, b.inverse_inertia);
  const Matrix3 of_first = crossed_transpose(node.arm_first, response.first);
  const Matrix3 of_second = crossed_transpose(node.arm_second, response.second);
  const double inverse_mass = a.inverse_mass + b.inverse_mass;
  double* diagonal = system_.values(response.block);
  for (int k = 0; k < 3; ++k) {
    for (int row = 0; row < 3; ++row) diagonal[row + 3 * k] = of_first(row, k) + of_second(row, k);
    diagonal[4 * k] = (diagonal[4 * k] + inverse_mass) * (1 + redundancy_);
  }
}

// [r] W [s]^T + 1 / m, as the transpose of its transpose.
void JointMatrix::fill_point_coupling(const JointAssembly& assembly, const Coupling& coupling) {
  const PointResponse& of_row = points_[coupling.row];
  const JointNode& column = assembly.nodes[coupling.column];
  const Matrix3& response = coupling.row_second ? of_row.second : of_row.first;
  const Vector3& arm = coupling.column_second ? column.arm_second : column.arm_first;
  Matrix3 block = crossed_transpose(arm, response);
  for (int k = 0; k < 3; ++k) block(k, k) += assembly.members[coupling.member].inverse_mass;
  double* values = system_.values(coupling.block);
  const double sign = coupling.row_second == coupling.column_second ? 1 : -1;
  for (int k = 0; k < 3; ++k) {
    for (int i = 0; i < 3; ++i) {
      const double value = sign * (coupling.transposed ? block(i, k) : block(k, i));
      double& to = values[i + 3 * k];
      to = assigns_all_ ? value : to + value;
    }
  }
}

// Rows of a node's Jacobian, of its point first, and what bodies answer them with. Those whose impulse is given are
// zero.
void JointMatrix::fill_rows(const JointAssembly& assembly, const JointNode& node, NodeRows& rows) {
  const auto put = [](const Vector3& v, double(&to)[3]) {
    for (int k = 0; k < 3; ++k) to[k] = v[k];
  };
  const JointMember& a = assembly.members[node.first];
  const JointMember& b = assembly.members[node.second];
  rows.count = 0;
  const auto add = [&](const Vector3& linear, const Vector3& first, const Vector3& second) {
    put(linear, rows.linear[rows.count]);
    put(first, rows.first[rows.count]);
    put(second, rows.second[rows.count]);
    put(product(a.inverse_inertia, first), rows.answer_first[rows.count]);
    put(product(b.inverse_inertia, second), rows.answer_second[rows.count]);
    ++rows.count;
  };
  if (node.point) {
    for (int axis = 0; axis < 3; ++axis) {
      const Vector3 along = Vector3::Unit(axis);
      add(along, node.arm_first.cross(along), node.arm_second.cross(along));
    }
  }
  for (std::uint32_t r = node.begin; r < node.end; ++r) {
    const JointRow& at = assembly.rows[r].at;
    if (assembly.rows[r].mode.is_solved()) {
      add(at.linear, at.angular_first, at.angular_second);
    } else {
      add(Vector3::Zero(), Vector3::Zero(), Vector3::Zero());
    }
  }
}

void JointMatrix::fill_diagonal(const JointAssembly& assembly, const JointNode& node, std::size_t of_node,
                                const NodeRows& rows) {
  const double inverse_mass = assembly.members[node.first].inverse_mass + assembly.members[node.second].inverse_mass;
  const std::size_t n = rows.count;
  double* const block = system_.values(of_node);
  for (std::size_t c = 0; c < n; ++c) {
    for (std::size_t r = c; r < n; ++r) {
      block[r + n * c] = inverse_mass * dot(rows.linear[r], rows.linear[c]) + dot(rows.first[r], rows.answer_first[c]) +
                         dot(rows.second[r], rows.answer_second[c]);
    }
  }
  const std::size_t point = node.point ? 3 : 0;
  for (std::size_t k = 0; k < n; ++k) {
    double& value = block[k + n * k];
    value *= 1 + redundancy_;
    if (k < point) continue;
    const LawMode& mode = assembly.rows[node.begin + k - point].mode;
    value = mode.is_solved() ? value + mode.compliance() : 1;
  }
}

void JointMatrix::fill_coupling(const JointAssembly& assembly, const Coupling& coupling) {
  const NodeRows& of_row = node_rows_[coupling.row];
  const NodeRows& of_column = node_rows_[coupling.column];
  const auto& own = coupling.row_second ? of_row.second : of_row.first;
  const auto& answer = coupling.column_second ? of_column.answer_second : of_column.answer_first;
  const double sign = coupling.row_second == coupling.column_second ? 1 : -1;
  const double inverse_mass = sign * assembly.members[coupling.member].inverse_mass;
  // The block has the rows of what is eliminated later.
  const std::size_t by_row = coupling.transposed ? of_column.count : 1;
  const std::size_t by_column = coupling.transposed ? 1 : of_row.count;
  double* const block = system_.values(coupling.block);
  for (std::size_t c = 0; c < of_column.count; ++c) {
    for (std::size_t r = 0; r < of_row.count; ++r) {
      block[by_row * r + by_column * c] +=
          inverse_mass * dot(of_row.linear[r], of_column.linear[c]) + sign * dot(own[r], answer[c]);
    }
  }
}

}  // namespace atl::solver
