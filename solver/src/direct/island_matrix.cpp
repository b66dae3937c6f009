#include <jobs/assert.h>
#include <solver/direct/island_matrix.h>
#include <solver/direct/island_members.h>
#include <solver/tuning.h>

#include <algorithm>
#include <bit>
#include <tuple>

#include "integrate/matrix3.h"

namespace atl::solver {
namespace {

// Adds k times the product of a row's motions of the block's two bodies. Most rows are of turning alone.
void add_square(double* block, const Vector3& row, const Vector3& column, const Vector3& linear, double k) {
  if (block == nullptr) return;
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r) block[3 + r + 6 * (3 + c)] += k * row[r] * column[c];
  }
  if (linear.isZero(0)) return;
  for (int c = 0; c < 3; ++c) {
    for (int r = 0; r < 3; ++r) {
      block[r + 6 * c] += k * linear[r] * linear[c];
      block[3 + r + 6 * c] += k * row[r] * linear[c];
      block[r + 6 * (3 + c)] += k * linear[r] * column[c];
    }
  }
}

// The stiffness of what slides or rolls is another at each motion, but for what nothing presses on.
bool has_turning_stiffness(const DirectContact& contact) {
  const ContactPieces& pieces = contact.answer.pieces;
  const bool slides = pieces.slides != 0 && !contact.law.pyramid && contact.law.friction_bound > 0;
  return slides || (pieces.rolls && contact.law.rolling_bound > 0);
}

}  // namespace

std::size_t max_factor_blocks(std::size_t body_count, bool touch) {
  return (touch ? tuning::factor_blocks_per_body : tuning::factor_blocks_per_joined_body) * body_count;
}

bool IslandMatrix::analyse(std::size_t body_count, std::span<const std::pair<std::uint32_t, std::uint32_t>> pairs,
                           std::size_t max_blocks) {
  joints_.clear();
  const std::vector<std::uint8_t> sizes(body_count, 6);
  return system_.analyse(sizes, pairs, max_blocks);
}

bool IslandMatrix::analyse_joints(const IslandProblem& problem, std::size_t max_blocks) {
  if (joints_.analyse(problem)) return true;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> pairs;
  for (const DirectJoint& joint : problem.joints) {
    if (joint.is_tendon()) {
      couple_all(std::span(joint.term).first(joint.terms), pairs);
    } else if (joint.first != no_body && joint.second != no_body) {
      pairs.emplace_back(joint.first, joint.second);
    }
  }
  return analyse(problem.bodies.size(), pairs, max_blocks);
}

bool IslandMatrix::factor(IslandProblem& problem) {
  if (!joints_.empty()) return problem.factored = joints_.factor(problem);
  if (problem.joints.empty()) {
    add_masses(problem.bodies);
  } else {
    if (!problem.filled) fill(problem);
    system_.set_values(placed_);
  }
  for (DirectContact& contact : problem.contacts) {
    add_stiffness(contact, contact.law.derivative(contact.motion, contact.answer.pieces));
    contact.factored = contact.answer.pieces;
    contact.factored_in_motion = has_turning_stiffness(contact);
  }
  for (DirectJoint& joint : problem.joints) add_stiffness(joint, Rows::Others);
  return problem.factored = system_.factor();
}

void IslandMatrix::fill(IslandProblem& problem) {
  add_masses(problem.bodies);
  for (DirectJoint& joint : problem.joints) add_stiffness(joint, Rows::Locks);
  system_.copy_values(placed_);
  problem.filled = true;
}

void IslandMatrix::add_masses(std::span<const DirectBody> bodies) {
  system_.clear();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const auto node = static_cast<std::uint32_t>(i);
    ATL_ASSERT(bodies[i].mass > 0, bodies[i].body, bodies[i].mass);
    double* block = system_.values(system_.block_index(node, node));
    for (int k = 0; k < 3; ++k) {
      block[7 * k] = bodies[i].mass;
      for (int r = 0; r < 3; ++r) block[(3 + r) + 6 * (3 + k)] = bodies[i].inertia(r, k);
    }
    constexpr double immovable = 1e12;  // times as heavy
    for (unsigned rest = bodies[i].locks; rest != 0; rest &= rest - 1) block[7 * std::countr_zero(rest)] *= immovable;
  }
}

void IslandMatrix::solve_by_bodies(const IslandProblem& problem, std::span<double> b) const {
  system_.solve(b);
  leave_out_locked(problem.bodies, b);
}

// J^T K J, with K the derivative of the contact's impulses by its motion and J that of its motion by the velocities. K
// is put into the world's frame at the contact's centre, [P Q; Q^T S] of forces and couples by speeds and spins, and
// moved to the bodies' centres by their arms.
void IslandMatrix::add_stiffness(const DirectContact& contact, const std::array<Six, 6>& k) {
  ATL_ASSERT(contact.first != contact.second, contact.slot, contact.first_body, contact.second_body);
  const auto& [n, t1, t2] = contact.axes;
  const Vector3 leans = k[0][1] * t1 + k[0][2] * t2;
  Matrix3 p, q, s;
  for (int c = 0; c < 3; ++c) {
    const double p_n = k[0][0] * n[c], p_1 = k[3][3] * t1[c] + k[3][4] * t2[c], p_2 = k[3][4] * t1[c] + k[4][4] * t2[c];
    const double s_n = k[5][5] * n[c], s_1 = k[1][1] * t1[c] + k[1][2] * t2[c], s_2 = k[1][2] * t1[c] + k[2][2] * t2[c];
    for (int r = 0; r < 3; ++r) {
      p(r, c) = p_n * n[r] + p_1 * t1[r] + p_2 * t2[r];
      q(r, c) = leans[c] * n[r];
      s(r, c) = s_n * n[r] + s_1 * t1[r] + s_2 * t2[r];
    }
  }
  struct Side {
    Vector3 arm;
    Matrix3 forces;   // by spins
    Matrix3 crossed;  // [arm] q
  };
  const auto side_of = [&](const Vector3& arm) { return Side{arm, q + crossed(arm, p).transpose(), crossed(arm, q)}; };
  const auto add = [&](std::uint32_t row, const Side& of_row, std::uint32_t column, const Side& of_column,
                       double sign) {
    double* block = system_.values(system_.block_index(row, column));
    const Matrix3 turns = crossed(of_row.arm, of_column.forces);
    for (int c = 0; c < 3; ++c) {
      for (int r = 0; r < 3; ++r) {
        block[r + 6 * c] += sign * p(r, c);
        block[3 + r + 6 * c] += sign * of_row.forces(c, r);
        block[r + 6 * (3 + c)] += sign * of_column.forces(r, c);
        block[3 + r + 6 * (3 + c)] += sign * (turns(r, c) + of_column.crossed(c, r) + s(r, c));
      }
    }
  };
  const Side first = side_of(contact.arm_first);
  const Side second = side_of(contact.arm_second);
  if (contact.first != no_body) add(contact.first, first, contact.first, first, 1);
  if (contact.second != no_body) add(contact.second, second, contact.second, second, 1);
  if (contact.first == no_body || contact.second == no_body) return;
  // A block has the rows of what is eliminated later.
  if (system_.is_earlier(contact.first, contact.second)) {
    add(contact.second, second, contact.first, first, -1);
  } else {
    add(contact.first, first, contact.second, second, -1);
  }
}

// J^T K J of a tendon: a block of each two of its bodies.
void IslandMatrix::add_tendon(DirectJoint& tendon) {
  tendon.factored[0] = tendon.law[0].pieces(tendon.rate[0]);
  const double k = tendon.law[0].slope(tendon.rate[0]);
  ATL_ASSERT(!(k < 0), tendon.joint, k);
  if (k == 0) return;
  const auto entry = [](const PulledBody& body, int i) { return i < 3 ? body.linear[i] : body.angular[i - 3]; };
  const PulledBodies bodies = tendon.pulled();
  for (const PulledBody& row : bodies) {
    for (const PulledBody& column : bodies) {
      if (row.body == no_body || column.body == no_body) continue;
      // A block has the rows of what is eliminated later.
      if (row.body != column.body && system_.is_earlier(row.body, column.body)) continue;
      double* block = system_.values(system_.block_index(row.body, column.body));
      for (int c = 0; c < 6; ++c) {
        for (int r = 0; r < 6; ++r) block[r + 6 * c] += k * entry(row, r) * entry(column, c);
      }
    }
  }
}

// J^T K J of a joint: a row's motion is one of each body.
void IslandMatrix::add_stiffness(DirectJoint& joint, Rows rows) {
  if (joint.is_tendon()) {
    if (joint.is_lock(0) == (rows == Rows::Locks)) add_tendon(joint);
    return;
  }
  const std::uint32_t a = joint.first, b = joint.second;
  const auto block_of = [&](std::uint32_t row, std::uint32_t column) {
    return row == no_body || column == no_body ? nullptr : system_.values(system_.block_index(row, column));
  };
  double* const of_first = block_of(a, a);
  double* const of_second = block_of(b, b);
  double* const of_both = block_of(a, b);
  // A block has the rows of what is eliminated later.
  const bool first_later = of_both != nullptr && !system_.is_earlier(a, b);
  for (std::size_t i = 0; i < joint.rows; ++i) {
    if (joint.is_lock(i) != (rows == Rows::Locks)) continue;
    joint.factored[i] = joint.law[i].pieces(joint.rate[i]);
    const double k = joint.law[i].slope(joint.rate[i]);
    ATL_ASSERT(!(k < 0), joint.joint, i, k);  // or the matrix might have no factor
    if (k == 0) continue;
    const JointRow at = joint.row(i);
    add_square(of_first, at.angular_first, at.angular_first, at.linear, k);
    add_square(of_second, at.angular_second, at.angular_second, at.linear, k);
    const auto& [later, earlier] =
        first_later ? std::tie(at.angular_first, at.angular_second) : std::tie(at.angular_second, at.angular_first);
    add_square(of_both, later, earlier, at.linear, -k);
  }
}

bool is_factored(const IslandProblem& problem) {
  if (!problem.factored) return false;
  return std::all_of(problem.contacts.begin(), problem.contacts.end(),
                     [](const DirectContact& contact) {
                       return contact.factored == contact.answer.pieces && !contact.factored_in_motion &&
                              !has_turning_stiffness(contact);
                     }) &&
         std::all_of(problem.joints.begin(), problem.joints.end(), [](const DirectJoint& joint) {
           for (std::size_t r = joint.point_rows(); r < joint.rows; ++r) {
             if (joint.factored[r] != joint.law[r].pieces(joint.rate[r])) return false;
           }
           return true;
         });
}

void forget_factor(IslandProblem& problem) { problem.factored = false; }

void forget_rows(IslandProblem& problem) { problem.filled = problem.factored = false; }

}  // namespace atl::solver
