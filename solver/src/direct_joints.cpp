#include <solver/arm_stiffness.h>
#include <solver/direct_joints.h>

#include <algorithm>
#include <cmath>

#include "matrix3.h"

namespace atl::solver {
namespace {

// Loops fill the factor in; where they do by more than this it is cheaper to solve joint by joint.
constexpr std::size_t factor_blocks_per_joint = 6;

// Rounds of finding out which limits, motors and springs hold, in one substep. What is not found then is in the next.
constexpr int rounds = 12;

// Of the force in a joint, by which the one that stiffness is made of follows it in a substep: what light links pull is
// noise from substep to substep. A chain of 100 links with 100,000 times the mass at its end holds to 1e-9 m with 0.2,
// and to no better than 1e-5 m with 1.
constexpr double smoothing = 0.2;

// m or rad: what closes joints moves no body farther than this, or the rows are near where they are singular. The tip
// of a whip gets far within a substep; what is closed without velocity has come apart by little.
constexpr double far_in_motion = 2;
constexpr double far_at_rest = 0.3;

// Of the diagonal, so that joints that ask for the same twice (two hinges of one door) share it.
constexpr double redundancy = 1e-10;
constexpr double redundancy_of_loops = 1e-6;

Vector3 get3(const float (&from)[3]) { return {from[0], from[1], from[2]}; }

void set3(float (&to)[3], const Vector3& from) {
  for (int i = 0; i < 3; ++i) to[i] = static_cast<float>(from[i]);
}

void add3(float (&to)[3], const Vector3& gain) {
  for (int i = 0; i < 3; ++i) to[i] = static_cast<float>(to[i] + gain[i]);
}

Matrix3 cross_matrix(const Vector3& v) {
  Matrix3 m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

// A turn by the vector `turn`, of a small angle, after an orientation.
Quaternion turned(const Vector3& turn, const Quaternion& orientation) {
  return (Quaternion(1, 0.5 * turn.x(), 0.5 * turn.y(), 0.5 * turn.z()) * orientation).normalized();
}

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
  if (!system_.analyse(sizes, pairs, factor_blocks_per_joint * nodes_.size())) return false;
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) nodes_[i].block = system_.block_index(i, i);
  for (Coupling& coupling : couplings_) {
    coupling.block = system_.block_index(coupling.row, coupling.column);
    coupling.transposed = system_.is_earlier(coupling.row, coupling.column);
  }
  b_.assign(system_.rows(), 0.0);
  // Points alone, each two of which share one body at most, and no fill: every value is written once.
  assigns_all_ = rows_.empty() && system_.factor_blocks() == couplings_.size();
  const auto count = std::count_if(members_.begin(), members_.end(), [](const Member& m) { return m.dynamic; });
  const bool anchored = static_cast<std::size_t>(count) < members_.size();
  redundancy_ =
      nodes_.size() > static_cast<std::size_t>(anchored ? count : count - 1) ? redundancy_of_loops : redundancy;
  return true;
}

void DirectJoints::begin_step(const DirectInput& input) {
  for (Member& member : members_) {
    member.start = input.table.position(member.body);
    member.start_turn = input.table.orientation(member.body);
  }
  for (Node& node : nodes_) {
    const Joint& joint = input.joints[node.joint];
    node.tension = joint.tension;
    node.impulse = joint.point_impulse;
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      rows_[r].impulse = joint.impulse[r - node.begin];
      rows_[r].position = joint.position[r - node.begin];
    }
  }
  prepare(input);
}

// For the poses that bodies have now.
void DirectJoints::prepare(const DirectInput& input) {
  place_members(input);
  place_frames(input.joints);
  place_inertia(input.table, input.h);
  begin_laws(input.joints, input.h);
  factor();
}

// Where bodies are now.
void DirectJoints::place_members(const DirectInput& input) {
  for (Member& member : members_) {
    const DisplacementRows& moved = input.bodies.displacement[member.local];
    const float(&q)[4] = moved.rotation;
    member.position = member.start + get3(moved.linear);
    member.turn = (Quaternion(q[3], q[0], q[1], q[2]) * member.start_turn).normalized();
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

// The pieces of their laws that rows were on still hold as a guess.
void DirectJoints::begin_laws(const Joint* joints, double h) {
  if (rows_.empty()) return;
  for (const Node& node : nodes_) {
    const Joint& joint = joints[node.joint];
    const Member& a = members_[node.first];
    const Member& b = members_[node.second];
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      Row& row = rows_[r];
      const double response = (a.inverse_mass + b.inverse_mass) * row.at.linear.squaredNorm() +
                              row.at.angular_first.dot(a.inverse_inertia * row.at.angular_first) +
                              row.at.angular_second.dot(b.inverse_inertia * row.at.angular_second);
      row.mode.begin(joint.law[r - node.begin], row.position, response > 0 ? 1 / response : 0, h);
    }
  }
}

bool DirectJoints::update_laws(const Joint* joints) {
  bool changed = false;
  for (const Node& node : nodes_) {
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      Row& row = rows_[r];
      changed |= row.mode.update(joints[node.joint].law[r - node.begin], row_speed(node, row), row.impulse);
    }
  }
  return changed;
}

// Rows of a node's Jacobian: of its point first. Those whose impulse is given are zero.
void DirectJoints::fill_rows(const Node& node, SideRows& linear, SideRows& angular_first,
                             SideRows& angular_second) const {
  const Eigen::Index point = node.point ? 3 : 0;
  const Eigen::Index count = point + (node.end - node.begin);
  for (SideRows* rows : {&linear, &angular_first, &angular_second}) rows->resize(count, 3);
  if (node.point) {
    linear.topRows<3>().setIdentity();
    angular_first.topRows<3>() = -cross_matrix(node.arm_first);
    angular_second.topRows<3>() = -cross_matrix(node.arm_second);
  }
  for (std::uint32_t r = node.begin; r < node.end; ++r) {
    const Row& row = rows_[r];
    const double solved = row.mode.is_solved() ? 1 : 0;
    const Eigen::Index at = point + (r - node.begin);
    linear.row(at) = solved * row.at.linear;
    angular_first.row(at) = solved * row.at.angular_first;
    angular_second.row(at) = solved * row.at.angular_second;
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
      const Matrix3 of_first = crossed_transpose(node.arm_first, node.response_first);
      const Matrix3 of_second = crossed_transpose(node.arm_second, node.response_second);
      const double inverse_mass = a.inverse_mass + b.inverse_mass;
      double* diagonal = system_.values(node.block);
      for (int k = 0; k < 3; ++k) {
        for (int row = 0; row < 3; ++row) diagonal[row + 3 * k] = of_first(row, k) + of_second(row, k);
        diagonal[4 * k] = (diagonal[4 * k] + inverse_mass) * (1 + redundancy_);
      }
    } else {
      fill_diagonal(node, i);
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

void DirectJoints::fill_diagonal(const Node& node, std::uint32_t index) {
  const Member& a = members_[node.first];
  const Member& b = members_[node.second];
  auto diagonal = system_.diagonal(index);
  SideRows linear, first, second;
  fill_rows(node, linear, first, second);
  diagonal.noalias() = (a.inverse_mass + b.inverse_mass) * linear.lazyProduct(linear.transpose());
  if (a.dynamic) diagonal.noalias() += SideRows(first * a.inverse_inertia).lazyProduct(first.transpose());
  if (b.dynamic) diagonal.noalias() += SideRows(second * b.inverse_inertia).lazyProduct(second.transpose());
  const Eigen::Index point = node.point ? 3 : 0;
  for (Eigen::Index k = 0; k < diagonal.rows(); ++k) {
    diagonal(k, k) *= 1 + redundancy_;
    if (k < point) continue;
    const LawMode& mode = rows_[node.begin + static_cast<std::uint32_t>(k - point)].mode;
    diagonal(k, k) = mode.is_solved() ? diagonal(k, k) + mode.compliance() : 1;
  }
}

void DirectJoints::fill_coupling(const Coupling& coupling) {
  const Member& member = members_[coupling.member];
  SideRows linear, first, second, linear_other, first_other, second_other;
  fill_rows(nodes_[coupling.row], linear, first, second);
  fill_rows(nodes_[coupling.column], linear_other, first_other, second_other);
  const SideRows& own = coupling.row_second ? second : first;
  const SideRows& other = coupling.column_second ? second_other : first_other;
  const double sign = coupling.row_second == coupling.column_second ? 1 : -1;
  BlockLdlt::Block block = (sign * member.inverse_mass) * linear.lazyProduct(linear_other.transpose());
  block.noalias() += sign * SideRows(own * member.inverse_inertia).lazyProduct(other.transpose());
  system_.add(coupling.row, coupling.column, block);
}

void DirectJoints::load_velocities(const SolverBodies& bodies) {
  for (Member& member : members_) {
    member.velocity = member.velocity_before = get3(bodies.velocity[member.local].linear);
    member.spin = member.spin_before = get3(bodies.velocity[member.local].angular);
  }
}

// Not to be carried over into the next substep: there the impulses act along other rows.
void DirectJoints::store_velocities(SolverBodies& bodies) const {
  for (const Member& member : members_) {
    if (!member.dynamic) continue;
    set3(bodies.velocity[member.local].linear, member.velocity);
    set3(bodies.velocity[member.local].angular, member.spin);
    add3(bodies.free_velocity[member.local].linear, member.velocity - member.velocity_before);
    add3(bodies.free_velocity[member.local].angular, member.spin - member.spin_before);
  }
}

Vector3 DirectJoints::point_speed(const Node& node) const {
  const Member& a = members_[node.first];
  const Member& b = members_[node.second];
  return (b.velocity + b.spin.cross(node.arm_second)) - (a.velocity + a.spin.cross(node.arm_first));
}

double DirectJoints::row_speed(const Node& node, const Row& row) const {
  const Member& a = members_[node.first];
  const Member& b = members_[node.second];
  return row.at.rate(a.velocity, a.spin, b.velocity, b.spin);
}

void DirectJoints::apply(const Node& node, const JointRow& row, double impulse) {
  Member& a = members_[node.first];
  Member& b = members_[node.second];
  if (a.dynamic) {
    a.velocity -= (a.inverse_mass * impulse) * row.linear;
    a.spin -= a.inverse_inertia * (impulse * row.angular_first);
  }
  if (b.dynamic) {
    b.velocity += (b.inverse_mass * impulse) * row.linear;
    b.spin += b.inverse_inertia * (impulse * row.angular_second);
  }
}

// Impulses that change the rates of all rows by b.
void DirectJoints::solve_and_apply() {
  if (!solvable_) return;
  system_.solve(b_);
  for (Member& member : members_) {
    member.impulse.setZero();
    member.angular_impulse.setZero();
  }
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    Node& node = nodes_[i];
    Member& a = members_[node.first];
    Member& b = members_[node.second];
    const double* impulse = &b_[system_.row(i)];
    if (node.point) {
      const Vector3 of_point(impulse[0], impulse[1], impulse[2]);
      node.impulse += of_point;
      a.impulse -= of_point;
      a.angular_impulse -= node.arm_first.cross(of_point);
      b.impulse += of_point;
      b.angular_impulse += node.arm_second.cross(of_point);
      impulse += 3;
    }
    for (std::uint32_t r = node.begin; r < node.end; ++r, ++impulse) {
      Row& row = rows_[r];
      if (!row.mode.is_solved()) continue;
      row.impulse += *impulse;
      a.impulse -= *impulse * row.at.linear;
      a.angular_impulse -= *impulse * row.at.angular_first;
      b.impulse += *impulse * row.at.linear;
      b.angular_impulse += *impulse * row.at.angular_second;
    }
  }
  for (Member& member : members_) {
    if (!member.dynamic) continue;
    member.velocity += member.inverse_mass * member.impulse;
    member.spin += product(member.inverse_inertia, member.angular_impulse);
  }
}

void DirectJoints::begin_substep() {
  for (Node& node : nodes_) node.impulse.setZero();
  for (Row& row : rows_) row.impulse = 0;
}

void DirectJoints::solve_velocities(const DirectInput& input) {
  load_velocities(input.bodies);
  for (int round = 0; round < rounds; ++round) {
    for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
      const Node& node = nodes_[i];
      for (std::uint32_t r = node.begin; r < node.end; ++r) {
        Row& row = rows_[r];
        if (row.mode.is_solved()) continue;
        apply(node, row.at, row.mode.given() - row.impulse);
        row.impulse = row.mode.given();
      }
    }
    for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
      const Node& node = nodes_[i];
      double* b = &b_[system_.row(i)];
      if (node.point) {
        const Vector3 speed = point_speed(node);
        for (int k = 0; k < 3; ++k) *b++ = -speed[k];
      }
      for (std::uint32_t r = node.begin; r < node.end; ++r) {
        const Row& row = rows_[r];
        const LawMode& mode = row.mode;
        *b++ = mode.is_solved()
                   ? mode.target() - row_speed(node, row) - mode.compliance() * (row.impulse - mode.given())
                   : 0;
      }
    }
    solve_and_apply();
    // The system must be that of the pieces the rows are on.
    if (rows_.empty() || round + 1 == rounds || !update_laws(input.joints)) break;
    factor();
  }
  store_velocities(input.bodies);
}

void DirectJoints::solve_positions(const DirectInput& input) {
  place_members(input);
  load_velocities(input.bodies);
  if (catch_limits(input.joints, input.h)) factor();
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    measure(input.joints[nodes_[i].joint], nodes_[i], &b_[system_.row(i)], input.h);
  }
  const bool torn = torn_ = set_tears_aside(input.joints, input.h);
  solve_and_apply();
  if (moves_far(input.h, far_in_motion)) take_back();
  move_members(input);
  store_velocities(input.bodies);
  if (!torn) return;
  load_velocities(input.bodies);
  b_.swap(tears_);
  solve_and_apply();
  if (!moves_far(input.h, far_at_rest)) move_members(input);
}

// Holds what an impact has pushed beyond its range. Whether there is such a row.
bool DirectJoints::catch_limits(const Joint* joints, double h) {
  if (rows_.empty()) return false;
  bool caught = false;
  for (const Node& node : nodes_) {
    const Joint& joint = joints[node.joint];
    if (std::none_of(joint.law.begin(), joint.law.begin() + joint.rows,
                     [](const Law& law) { return law.limited() && !law.locked(); })) {
      continue;
    }
    const JointFrames frames = frames_of(joint, node);
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      const Law& law = joint.law[r - node.begin];
      if (!law.limited() || law.locked()) continue;
      caught |= rows_[r].mode.catch_at_end(law, position_of(joint, frames, node, r, h));
    }
  }
  return caught;
}

// The position of a row's coordinate at the frames, after h seconds at the velocities that are loaded.
double DirectJoints::position_of(const Joint& joint, const JointFrames& frames, const Node& node, std::uint32_t r,
                                 double h) const {
  const double moved = rows_[r].position + h * row_speed(node, rows_[r]);  // what is a rate only is there
  return continued(joint.coordinate[r - node.begin], joint_row(joint, r - node.begin, frames).value, moved);
}

JointFrames DirectJoints::frames_of(const Joint& joint, const Node& node) const {
  const Member& first = members_[node.first];
  const Member& second = members_[node.second];
  return joint_frames(joint, first.position, first.turn, second.position, second.turn);
}

// What was apart when the substep began, as no substep leaves it, was put apart from outside. It is closed, too, but by
// no velocity: bodies would fly. Takes it out of b_, and leaves in tears_ the rates that close it. Whether there is
// any.
bool DirectJoints::set_tears_aside(const Joint* joints, double h) {
  constexpr double least = 1e-3;         // m or rad
  constexpr double least_beyond = 0.05;  // of a range: there impacts may leave them
  constexpr double most_speed = 3;       // m/s or rad/s
  bool torn = false;
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    const Node& node = nodes_[i];
    std::size_t at = system_.row(i);
    const auto set_aside = [&](double apart) {
      if (!torn) tears_.assign(b_.size(), 0.0);
      torn = true;
      b_[at] -= apart / h;
      tears_[at] = std::clamp(apart / h, -most_speed, most_speed);
    };
    if (node.point) {
      const bool apart = node.offset.squaredNorm() > least * least;
      for (int k = 0; k < 3; ++k, ++at) {
        if (apart) set_aside(-node.offset[k]);
      }
    }
    for (std::uint32_t r = node.begin; r < node.end; ++r, ++at) {
      const Row& row = rows_[r];
      if (!row.mode.holds()) continue;
      const double apart = bound(row, joints[node.joint].law[r - node.begin]) - row.position;
      // To an end that it is still on its way to it goes as fast as it goes.
      const bool beyond = row.mode.is_locked() || (row.mode.limit() < 0 ? apart > 0 : apart < 0);
      if (beyond && std::abs(apart) > (row.mode.is_locked() ? least : least_beyond)) set_aside(apart);
    }
  }
  return torn;
}

// Whether what was gained since velocities were loaded would take a body so far that no row is true there: near where
// rows are singular the solution of the linear system says nothing of where joints close.
bool DirectJoints::moves_far(double h, double far) const {
  return std::any_of(members_.begin(), members_.end(), [=](const Member& member) {
    return !(h * (member.velocity - member.velocity_before).norm() <= far &&
             h * (member.spin - member.spin_before).norm() <= far);
  });
}

// What was gained since velocities were loaded.
void DirectJoints::take_back() {
  for (Member& member : members_) {
    member.velocity = member.velocity_before;
    member.spin = member.spin_before;
  }
}

// By the velocities that were gained since they were loaded.
void DirectJoints::move_members(const DirectInput& input) {
  for (Member& member : members_) {
    if (!member.dynamic) continue;
    DisplacementRows& moved = input.bodies.displacement[member.local];
    add3(moved.linear, input.h * (member.velocity - member.velocity_before));
    float(&q)[4] = moved.rotation;
    const Quaternion turn = turned(input.h * (member.spin - member.spin_before), Quaternion(q[3], q[0], q[1], q[2]));
    for (int k = 0; k < 4; ++k) q[k] = static_cast<float>(turn.coeffs()[k]);
  }
}

// How far the joint's rows are from where they should be, as rates that take them there in h seconds.
void DirectJoints::measure(const Joint& joint, const Node& node, double* b, double h) const {
  const Member& first = members_[node.first];
  const Member& second = members_[node.second];
  if (node.point) {
    const Vector3 offset =
        (second.position - first.position) + (second.turn * joint.anchor_second - first.turn * joint.anchor_first);
    for (int k = 0; k < 3; ++k) *b++ = -offset[k] / h;
  }
  if (node.begin == node.end) return;
  const JointFrames frames = frames_of(joint, node);
  for (std::uint32_t r = node.begin; r < node.end; ++r) {
    const Row& row = rows_[r];
    *b++ = row.mode.holds() ? (bound(row, joint.law[r - node.begin]) - position_of(joint, frames, node, r, h)) / h : 0;
  }
}

void DirectJoints::relax(const DirectInput& input) {
  const double over_h = 1 / input.h;
  for (Node& node : nodes_) {
    Vector3 force = over_h * node.impulse;
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      Row& row = rows_[r];
      force += over_h * row.impulse * row.at.linear;
      row.position += input.h * row_speed(node, row);
    }
    node.tension += smoothing * (force - node.tension);
  }
  prepare(input);
  close_gaps(input);
  project(input);
}

// One round of Newton's method is all that positions get where bodies turn by little in a substep. After an impact it
// takes more, at rows that are true there.
void DirectJoints::close_gaps(const DirectInput& input) {
  constexpr double tolerance = 1e-4;  // m or rad
  for (int round = 1; round < rounds && !torn_; ++round) {
    for (Member& member : members_) {
      member.velocity = member.velocity_before = Vector3::Zero();
      member.spin = member.spin_before = Vector3::Zero();
    }
    bool closed = true;
    for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
      const Node& node = nodes_[i];
      double* b = &b_[system_.row(i)];
      if (node.point) {
        closed &= node.offset.squaredNorm() <= tolerance * tolerance;
        for (int k = 0; k < 3; ++k) *b++ = -node.offset[k] / input.h;
      }
      for (std::uint32_t r = node.begin; r < node.end; ++r, ++b) {
        const Row& row = rows_[r];
        const double apart =
            row.mode.holds() ? bound(row, input.joints[node.joint].law[r - node.begin]) - row.position : 0;
        closed &= std::abs(apart) <= tolerance;
        *b = apart / input.h;
      }
    }
    if (closed) return;
    solve_and_apply();
    if (moves_far(input.h, far_at_rest)) return;
    move_members(input);
    prepare(input);
  }
}

void DirectJoints::project(const DirectInput& input) {
  load_velocities(input.bodies);
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    const Node& node = nodes_[i];
    double* b = &b_[system_.row(i)];
    if (node.point) {
      const Vector3 speed = point_speed(node);
      for (int k = 0; k < 3; ++k) *b++ = -speed[k];
    }
    // Springs and motors have had their impulse, and answer to changes only.
    for (std::uint32_t r = node.begin; r < node.end; ++r) *b++ = rows_[r].mode.holds() ? -row_speed(node, rows_[r]) : 0;
  }
  solve_and_apply();
  store_velocities(input.bodies);
}

void DirectJoints::end_step(const DirectInput& input) {
  const double over_h = 1 / input.h;
  for (const Node& node : nodes_) {
    Joint& joint = input.joints[node.joint];
    joint.point_impulse = node.impulse;
    joint.tension = node.tension;
    joint.force = over_h * node.impulse;
    joint.torque.setZero();
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      const Row& row = rows_[r];
      const std::uint32_t k = r - node.begin;
      joint.impulse[k] = row.impulse;
      joint.position[k] = row.position;
      joint.limit[k] = static_cast<std::int8_t>(row.mode.limit());
      joint.force += over_h * row.impulse * row.at.linear;
      joint.torque += over_h * row.impulse * (row.at.angular_second - node.arm_second.cross(row.at.linear));
    }
  }
}

void DirectJoints::settle(const DirectInput& input, BodyTable& table, double dt, FastBodies& fast) {
  constexpr double tolerance = 1e-7;  // m or rad: displacements are known no better
  for (Member& member : members_) {
    member.position = table.position(member.body);
    member.turn = table.orientation(member.body);
    member.velocity.setZero();
    member.spin.setZero();
  }
  for (std::uint32_t i = 0; i < nodes_.size(); ++i) {
    measure(input.joints[nodes_[i].joint], nodes_[i], &b_[system_.row(i)], 1);
  }
  bool holds = std::all_of(b_.begin(), b_.end(), [](double b) { return std::abs(b) <= tolerance; });
  if (!holds) {
    for (Member& member : members_) {
      member.velocity_before.setZero();
      member.spin_before.setZero();
    }
    solve_and_apply();
    holds = moves_far(1, far_at_rest);
  }
  for (const Member& member : members_) {
    if (!member.dynamic) continue;
    if (!holds) {
      table.position(member.body) += member.velocity;
      table.set_orientation(member.body, turned(member.spin, member.turn));
    }
    note_motion(table, member.body, {member.start, member.start_turn}, dt, fast);
  }
}

}  // namespace atl::solver
