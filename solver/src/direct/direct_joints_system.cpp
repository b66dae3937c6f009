// The system of joints that hang together: where bodies and rows are, and J M^-1 J^T.

#include <solver/constraints/arm_stiffness.h>
#include <solver/direct/direct_joints.h>
#include <solver/tuning.h>

#include <algorithm>

#include "integrate/matrix3.h"
#include "integrate/rows3.h"

namespace atl::solver {
namespace {

double dot(const double (&a)[3], const double (&b)[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

}  // namespace

bool DirectJoints::analyse(std::span<const JointLink> links, std::span<const Joint> joints, const BodyTable& table) {
  members_.clear();
  nodes_.clear();
  rows_.clear();
  couplings_.clear();
  std::vector<std::uint32_t> bodies;
  for (const JointLink& link : links) {
    bodies.push_back(link.first);
    bodies.push_back(link.second);
  }
  std::sort(bodies.begin(), bodies.end());
  bodies.erase(std::unique(bodies.begin(), bodies.end()), bodies.end());
  for (const std::uint32_t body : bodies) {
    Member member{};
    member.body = body;
    member.dynamic = table.mobility[body] == Mobility::Dynamic;
    member.inverse_mass = table.inverse_mass[body];
    members_.push_back(member);
  }
  const auto member_of = [&](std::uint32_t body) {
    return static_cast<std::uint32_t>(std::lower_bound(bodies.begin(), bodies.end(), body) - bodies.begin());
  };

  std::vector<std::uint8_t> sizes;
  std::vector<std::vector<std::uint32_t>> at_member(members_.size());
  for (const JointLink& link : links) {
    const Joint& joint = joints[link.joint];
    Node node{};
    node.joint = link.joint;
    node.first = member_of(link.first);
    node.second = member_of(link.second);
    node.point = joint.point;
    node.begin = static_cast<std::uint32_t>(rows_.size());
    rows_.resize(rows_.size() + joint.rows);
    node.end = static_cast<std::uint32_t>(rows_.size());
    const auto index = static_cast<std::uint32_t>(nodes_.size());
    for (const std::uint32_t member : {node.first, node.second}) {
      if (!members_[member].dynamic) continue;
      for (const std::uint32_t other : at_member[member]) {
        couplings_.push_back({index, other, member, node.second == member, nodes_[other].second == member, false, 0});
      }
      at_member[member].push_back(index);
    }
    nodes_.push_back(node);
    sizes.push_back(static_cast<std::uint8_t>(joint.row_count()));
  }
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (const Coupling& coupling : couplings_) pairs.emplace_back(coupling.row, coupling.column);
  if (!system_.analyse(sizes, pairs, tuning::factor_blocks_per_joint * nodes_.size())) return false;
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) nodes_[i].block = system_.block_index(i, i);
  for (Coupling& coupling : couplings_) {
    coupling.block = system_.block_index(coupling.row, coupling.column);
    coupling.transposed = system_.is_earlier(coupling.row, coupling.column);
  }
  b_.assign(system_.rows(), 0.0);
  node_rows_.resize(rows_.empty() ? 0 : nodes_.size());
  // Points alone, each two of which share one body at most, and no fill: every value is written once.
  assigns_all_ = rows_.empty() && system_.factor_blocks() == couplings_.size();
  const auto count = std::count_if(members_.begin(), members_.end(), [](const Member& m) { return m.dynamic; });
  const bool anchored = static_cast<std::size_t>(count) < members_.size();
  redundancy_ = nodes_.size() > static_cast<std::size_t>(anchored ? count : count - 1) ? tuning::redundancy_of_loops
                                                                                       : tuning::redundancy;
  return true;
}

// Where bodies are now.
void DirectJoints::place_members(const DirectInput& input) {
  for (Member& member : members_) {
    const DisplacementRows& moved = input.bodies.displacement[member.local];
    member.position = member.start + get3(moved.linear);
    member.turn = (rotation_of(moved) * member.start_turn).normalized();
  }
}

void DirectJoints::place_frames(const Joint* joints) {
  for (Node& node : nodes_) {
    const Joint& joint = joints[node.joint];
    const Member& first = members_[node.first];
    const Member& second = members_[node.second];
    node.arm_first = first.turn * joint.anchor_first;
    node.arm_second = second.turn * joint.anchor_second;
    node.offset = (second.position - first.position) + (node.arm_second - node.arm_first);
    if (node.begin == node.end) continue;
    const JointFrames frames = frames_of(joint, node);
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      Row& row = rows_[r];
      row.at = joint_row(joint, r - node.begin, frames);
      row.position = continued(joint.coordinate[r - node.begin], row.at.value, row.position);
    }
  }
}

// World frame, with what tension adds.
void DirectJoints::place_inertia(const BodyTable& table, double h) {
  for (Member& member : members_) member.stiffness.setZero();
  for (const Node& node : nodes_) {
    add_scaled(members_[node.first].stiffness, 1, arm_stiffness(node.arm_first, -node.tension));
    add_scaled(members_[node.second].stiffness, 1, arm_stiffness(node.arm_second, node.tension));
  }
  for (Member& member : members_) {
    if (!member.dynamic) continue;
    const Matrix3 rotation = member.turn.toRotationMatrix();
    Matrix3 inertia = symmetric_product(product(rotation, table.inertia[member.body]), rotation);
    add_scaled(inertia, h * h, member.stiffness);
    member.inverse_inertia = symmetric_inverse(inertia);
  }
}

// Rows of a node's Jacobian, of its point first, and what bodies answer them with. Those whose impulse is given are
// zero.
void DirectJoints::fill_rows(const Node& node, NodeRows& rows) const {
  const auto put = [](const Vector3& v, double(&to)[3]) {
    for (int k = 0; k < 3; ++k) to[k] = v[k];
  };
  const Member& a = members_[node.first];
  const Member& b = members_[node.second];
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
    const JointRow& at = rows_[r].at;
    if (rows_[r].mode.is_solved()) {
      add(at.linear, at.angular_first, at.angular_second);
    } else {
      add(Vector3::Zero(), Vector3::Zero(), Vector3::Zero());
    }
  }
}

// J M^-1 J^T with compliances on the diagonal, and its factor.
void DirectJoints::factor() {
  if (!assigns_all_) system_.clear();
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    Node& node = nodes_[i];
    const Member& a = members_[node.first];
    const Member& b = members_[node.second];
    if (node.is_point_only()) {
      node.response_first = crossed(node.arm_first, a.inverse_inertia);
      node.response_second = crossed(node.arm_second, b.inverse_inertia);
      if (!rows_.empty()) fill_rows(node, node_rows_[i]);
      const Matrix3 of_first = crossed_transpose(node.arm_first, node.response_first);
      const Matrix3 of_second = crossed_transpose(node.arm_second, node.response_second);
      const double inverse_mass = a.inverse_mass + b.inverse_mass;
      double* diagonal = system_.values(node.block);
      for (int k = 0; k < 3; ++k) {
        for (int row = 0; row < 3; ++row) diagonal[row + 3 * k] = of_first(row, k) + of_second(row, k);
        diagonal[4 * k] = (diagonal[4 * k] + inverse_mass) * (1 + redundancy_);
      }
    } else {
      fill_rows(node, node_rows_[i]);
      fill_diagonal(node, node_rows_[i]);
    }
  }
  for (const Coupling& coupling : couplings_) {
    const Node& row = nodes_[coupling.row];
    const Node& column = nodes_[coupling.column];
    const Member& member = members_[coupling.member];
    if (row.is_point_only() && column.is_point_only()) {
      // [r] W [s]^T + 1 / m, as the transpose of its transpose.
      const Matrix3& response = coupling.row_second ? row.response_second : row.response_first;
      const Vector3& arm = coupling.column_second ? column.arm_second : column.arm_first;
      Matrix3 block = crossed_transpose(arm, response);
      for (int k = 0; k < 3; ++k) block(k, k) += member.inverse_mass;
      double* values = system_.values(coupling.block);
      const double sign = coupling.row_second == coupling.column_second ? 1 : -1;
      for (int k = 0; k < 3; ++k) {
        for (int i = 0; i < 3; ++i) {
          const double value = sign * (coupling.transposed ? block(i, k) : block(k, i));
          double& to = values[i + 3 * k];
          to = assigns_all_ ? value : to + value;
        }
      }
    } else {
      fill_coupling(coupling);
    }
  }
  solvable_ = system_.factor();
}

void DirectJoints::fill_diagonal(const Node& node, const NodeRows& rows) {
  const double inverse_mass = members_[node.first].inverse_mass + members_[node.second].inverse_mass;
  const std::size_t n = rows.count;
  double* const block = system_.values(node.block);
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
    const LawMode& mode = rows_[node.begin + k - point].mode;
    value = mode.is_solved() ? value + mode.compliance() : 1;
  }
}

void DirectJoints::fill_coupling(const Coupling& coupling) {
  const NodeRows& of_row = node_rows_[coupling.row];
  const NodeRows& of_column = node_rows_[coupling.column];
  const auto& own = coupling.row_second ? of_row.second : of_row.first;
  const auto& answer = coupling.column_second ? of_column.answer_second : of_column.answer_first;
  const double sign = coupling.row_second == coupling.column_second ? 1 : -1;
  const double inverse_mass = sign * members_[coupling.member].inverse_mass;
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
