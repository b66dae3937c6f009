#include <jobs/assert.h>
#include <solver/direct/joint_response.h>

#include <algorithm>
#include <utility>

#include "integrate/matrix3.h"

namespace atl::solver {
namespace {

double dot(const double (&a)[3], const double (&b)[3]) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
double dot(const Vector3& scale, const double (&a)[3], const double (&b)[3]) {
  return scale[0] * (a[0] * b[0]) + scale[1] * (a[1] * b[1]) + scale[2] * (a[2] * b[2]);
}

// Adds what a body makes of a momentum, `sign` times, and takes it away.
void answer(const DirectBody& body, double sign, double* momentum, double* velocity) {
  const Vector3 spin = product(body.inverse_inertia, Vector3(momentum[3], momentum[4], momentum[5]));
  for (int k = 0; k < 3; ++k) {
    velocity[k] += sign * body.inverse_mass[k] * momentum[k];
    velocity[3 + k] += sign * spin[k];
    momentum[k] = momentum[3 + k] = 0;
  }
}

bool is_point_alone(const DirectJoint& joint) { return joint.point && joint.rows == 3; }

}  // namespace

bool JointResponse::analyse(const IslandProblem& problem) {
  const std::vector<DirectJoint>& joints = problem.joints;
  constexpr std::size_t max_blocks = 2;  // a joint
  std::vector<std::uint8_t> sizes;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  std::vector<std::vector<std::uint32_t>> at_body(problem.bodies.size());
  couplings_.clear();
  nodes_.clear();
  for (std::uint32_t i = 0; i < joints.size(); ++i) {
    const DirectJoint& joint = joints[i];
    if (joint.is_tendon()) return false;
    const auto before = static_cast<std::ptrdiff_t>(couplings_.size());
    for (const std::uint32_t body : {joint.first, joint.second}) {
      if (body == no_body) continue;
      for (const std::uint32_t other : at_body[body]) {
        const bool again = std::any_of(couplings_.begin() + before, couplings_.end(),
                                       [&](const Coupling& coupling) { return coupling.column == other; });
        couplings_.push_back({i, other, body, joint.second == body, joints[other].second == body, false, again, 0});
        pairs.emplace_back(i, other);
      }
      at_body[body].push_back(i);
      if (couplings_.size() > max_blocks * joints.size()) return false;
    }
    sizes.push_back(static_cast<std::uint8_t>(joint.rows));
  }
  if (!system_.analyse(sizes, pairs, max_blocks * joints.size())) return false;
  for (Coupling& coupling : couplings_) {
    coupling.block = system_.block_index(coupling.row, coupling.column);
    coupling.transposed = system_.is_earlier(coupling.row, coupling.column);
  }
  plain_ = std::all_of(joints.begin(), joints.end(), is_point_alone);
  assigns_ = plain_ && system_.factor_blocks() == couplings_.size();
  nodes_.resize(joints.size());
  for (std::uint32_t i = 0; i < joints.size(); ++i) nodes_[i].block = system_.block_index(i, i);
  rates_.resize(system_.rows());
  momenta_.assign(6 * problem.bodies.size(), 0.0);
  return true;
}

bool JointResponse::factor(IslandProblem& problem) {
  if (plain_) {
    fill_points(problem);
  } else {
    if (!problem.filled) fill(problem);
    take_laws(problem);
  }
  return system_.factor();
}

void JointResponse::fill_points(const IslandProblem& problem) {
  if (!assigns_) system_.clear();
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    fill_point(problem, problem.joints[i], nodes_[i]);
    nodes_[i].idle = problem.joints[i].still;
    if (nodes_[i].idle != 0) leave_out_rows(3, nodes_[i]);
  }
  for (const Coupling& coupling : couplings_) {
    fill_point_coupling(problem, coupling);
    leave_out_coupling(problem, coupling);
  }
}

void JointResponse::fill(IslandProblem& problem) {
  system_.clear();
  for (std::size_t i = 0; i < nodes_.size(); ++i) fill_rows(problem, problem.joints[i], nodes_[i]);
  for (const Coupling& coupling : couplings_) fill_coupling(problem, coupling);
  system_.copy_values(response_);
  problem.filled = true;
}

void JointResponse::take_laws(IslandProblem& problem) {
  system_.set_values(response_);
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    DirectJoint& joint = problem.joints[i];
    double* diagonal = system_.values(nodes_[i].block);
    nodes_[i].idle = 0;
    for (std::size_t r = 0; r < joint.rows; ++r, diagonal += joint.rows + 1) {
      const RowLaw& law = joint.law[r];
      if (law.locked) {
        *diagonal += problem.lock_compliance * *diagonal;
        joint.factored[r] = 0;
        continue;
      }
      joint.factored[r] = law.pieces(joint.rate[r]);
      const double slope = law.slope(joint.rate[r]);
      ATL_ASSERT(!(slope < 0), joint.joint, r, slope);
      if (slope > 0) {
        *diagonal += 1 / slope;
      } else {
        nodes_[i].idle |= static_cast<std::uint8_t>(1 << r);
      }
    }
    if (nodes_[i].idle != 0) leave_out_rows(joint.rows, nodes_[i]);
  }
  for (const Coupling& coupling : couplings_) leave_out_coupling(problem, coupling);
}

// Calls `visit(row, column, value)` for the block of two joints, which has the rows of what is eliminated later.
template <typename Visit>
void JointResponse::for_each_value(const IslandProblem& problem, const Coupling& coupling, const Visit& visit) {
  const std::size_t rows = problem.joints[coupling.row].rows, columns = problem.joints[coupling.column].rows;
  const std::size_t by_row = coupling.transposed ? columns : 1;
  const std::size_t by_column = coupling.transposed ? 1 : rows;
  double* const block = system_.values(coupling.block);
  for (std::size_t c = 0; c < columns; ++c) {
    for (std::size_t r = 0; r < rows; ++r) visit(r, c, block[by_row * r + by_column * c]);
  }
}

// Rows that don't act give no rate and take none.
void JointResponse::leave_out_rows(std::size_t rows, const Node& node) {
  double* const block = system_.values(node.block);
  for (std::size_t c = 0; c < rows; ++c) {
    for (std::size_t r = c; r < rows; ++r) {
      if ((node.idle >> r | node.idle >> c) & 1) block[r + rows * c] = r == c ? 1 : 0;
    }
  }
}

void JointResponse::leave_out_coupling(const IslandProblem& problem, const Coupling& coupling) {
  const unsigned idle_row = nodes_[coupling.row].idle, idle_column = nodes_[coupling.column].idle;
  if ((idle_row | idle_column) == 0) return;
  for_each_value(problem, coupling, [=](std::size_t r, std::size_t c, double& value) {
    if ((idle_row >> r | idle_column >> c) & 1) value = 0;
  });
}

void JointResponse::solve(const IslandProblem& problem, std::span<double> b) const {
  const std::vector<DirectBody>& bodies = problem.bodies;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    double* momentum = &momenta_[6 * i];
    std::copy_n(&b[6 * i], 6, momentum);
    std::fill_n(&b[6 * i], 6, 0.0);
    answer(bodies[i], 1, momentum, &b[6 * i]);
  }
  double* rates = rates_.data();
  for (const DirectJoint& joint : problem.joints) {
    joint.rates_by(b.data(), rates);
    for (std::size_t r = 0; r < joint.rows; ++r) {
      if (!joint.law[r].locked && joint.law[r].slope(joint.rate[r]) == 0) rates[r] = 0;
    }
    rates += joint.rows;
  }
  ATL_ASSERT(rates == rates_.data() + rates_.size(), rates - rates_.data(), rates_.size());
  system_.solve(rates_);
  rates = rates_.data();
  for (const DirectJoint& joint : problem.joints) {
    joint.add_impulses(rates, momenta_.data());
    rates += joint.rows;
  }
  for (std::size_t i = 0; i < bodies.size(); ++i) answer(bodies[i], -1, &momenta_[6 * i], &b[6 * i]);
}

void JointResponse::add_answer(const IslandProblem& problem, const std::vector<double>& impulses,
                               std::vector<double>& velocities) const {
  if constexpr (jobs::with_asserts) {
    for (const double momentum : momenta_) ATL_ASSERT(momentum == 0, momentum);
  }
  const double* of_joint = impulses.data();
  for (const DirectJoint& joint : problem.joints) {
    joint.add_impulses(of_joint, momenta_.data());
    of_joint += joint.rows;
  }
  for (std::size_t i = 0; i < problem.bodies.size(); ++i) {
    answer(problem.bodies[i], 1, &momenta_[6 * i], &velocities[6 * i]);
  }
}

void JointResponse::fill_point(const IslandProblem& problem, const DirectJoint& joint, Node& node) {
  double diagonal[9] = {};
  Vector3 inverse_mass = Vector3::Zero();
  const auto add = [&](std::uint32_t body, const Vector3& arm, Matrix3& point) {
    if (body == no_body) return;
    point = crossed(arm, problem.bodies[body].inverse_inertia);
    const Matrix3 response = crossed_transpose(arm, point);
    for (int k = 0; k < 3; ++k) {
      for (int row = 0; row < 3; ++row) diagonal[row + 3 * k] += response(row, k);
    }
    inverse_mass += problem.bodies[body].inverse_mass;
  };
  add(joint.first, joint.arm_first, node.point_first);
  add(joint.second, joint.arm_second, node.point_second);
  for (Eigen::Index k = 0; k < 3; ++k) {
    diagonal[4 * k] += inverse_mass[k];
    diagonal[4 * k] += problem.lock_compliance * diagonal[4 * k];
  }
  std::copy_n(diagonal, 9, system_.values(node.block));
}

// [r] W [s]^T + 1 / m, as the transpose of its transpose.
void JointResponse::fill_point_coupling(const IslandProblem& problem, const Coupling& coupling) {
  const Node& of_row = nodes_[coupling.row];
  const DirectJoint& column = problem.joints[coupling.column];
  const Matrix3& response = coupling.row_second ? of_row.point_second : of_row.point_first;
  Matrix3 block = crossed_transpose(coupling.column_second ? column.arm_second : column.arm_first, response);
  for (int k = 0; k < 3; ++k) block(k, k) += problem.bodies[coupling.body].inverse_mass[k];
  double* values = system_.values(coupling.block);
  const double sign = coupling.row_second == coupling.column_second ? 1 : -1;
  for (int k = 0; k < 3; ++k) {
    for (int i = 0; i < 3; ++i) {
      const double value = sign * (coupling.transposed ? block(i, k) : block(k, i));
      double& to = values[i + 3 * k];
      to = assigns_ ? value : to + value;
    }
  }
}

void JointResponse::fill_rows(const IslandProblem& problem, const DirectJoint& joint, Node& node) {
  const DirectBody* const a = joint.first == no_body ? nullptr : &problem.bodies[joint.first];
  const DirectBody* const b = joint.second == no_body ? nullptr : &problem.bodies[joint.second];
  Vector3 inverse_mass = Vector3::Zero();
  if (a != nullptr) inverse_mass += a->inverse_mass;
  if (b != nullptr) inverse_mass += b->inverse_mass;
  const auto put = [](const Vector3& v, double(&to)[3]) {
    for (int k = 0; k < 3; ++k) to[k] = v[k];
  };
  const auto put_row = [&](std::size_t r, const Vector3& linear, const Vector3& first, const Vector3& second) {
    put(linear, node.linear[r]);
    put(first, node.first[r]);
    put(second, node.second[r]);
    put(a != nullptr ? product(a->inverse_inertia, first) : Vector3(0, 0, 0), node.answer_first[r]);
    put(b != nullptr ? product(b->inverse_inertia, second) : Vector3(0, 0, 0), node.answer_second[r]);
  };
  const std::size_t n = joint.rows, points = joint.point_rows();
  const Vector3 &p = joint.arm_first, &q = joint.arm_second;
  if (joint.point) {
    put_row(0, {1, 0, 0}, {0, p[2], -p[1]}, {0, q[2], -q[1]});
    put_row(1, {0, 1, 0}, {-p[2], 0, p[0]}, {-q[2], 0, q[0]});
    put_row(2, {0, 0, 1}, {p[1], -p[0], 0}, {q[1], -q[0], 0});
  }
  for (std::size_t r = points; r < n; ++r) {
    const JointRow& at = joint.at[r];
    put_row(r, at.linear, at.angular_first, at.angular_second);
  }
  double* const block = system_.values(node.block);
  for (std::size_t c = 0; c < n; ++c) {
    for (std::size_t r = c; r < n; ++r) {
      block[r + n * c] = dot(inverse_mass, node.linear[r], node.linear[c]) + dot(node.first[r], node.answer_first[c]) +
                         dot(node.second[r], node.answer_second[c]);
    }
  }
}

void JointResponse::fill_coupling(const IslandProblem& problem, const Coupling& coupling) {
  const Node& of_row = nodes_[coupling.row];
  const Node& of_column = nodes_[coupling.column];
  const auto& own = coupling.row_second ? of_row.second : of_row.first;
  const auto& answer = coupling.column_second ? of_column.answer_second : of_column.answer_first;
  const double sign = coupling.row_second == coupling.column_second ? 1 : -1;
  const Vector3 inverse_mass = sign * problem.bodies[coupling.body].inverse_mass;
  for_each_value(problem, coupling, [&](std::size_t r, std::size_t c, double& value) {
    value += dot(inverse_mass, of_row.linear[r], of_column.linear[c]) + sign * dot(own[r], answer[c]);
  });
}

}  // namespace atl::solver
