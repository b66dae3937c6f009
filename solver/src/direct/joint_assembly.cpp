#include <solver/constraints/arm_stiffness.h>
#include <solver/direct/joint_assembly.h>
#include <solver/integrate/motion.h>
#include <solver/tuning.h>

#include <algorithm>

#include "integrate/matrix3.h"
#include "integrate/rows3.h"

namespace atl::solver {
namespace {

// The bodies of joints, in order.
std::vector<std::uint32_t> bodies_of(std::span<const JointLink> links) {
  std::vector<std::uint32_t> bodies;
  for (const JointLink& link : links) {
    bodies.push_back(link.first);
    bodies.push_back(link.second);
  }
  std::sort(bodies.begin(), bodies.end());
  bodies.erase(std::unique(bodies.begin(), bodies.end()), bodies.end());
  return bodies;
}

// World frame, with what tension adds.
void place_member_inertia(JointAssembly& assembly, const BodyTable& table, double h) {
  for (JointMember& member : assembly.members) member.stiffness.setZero();
  for (const JointNode& node : assembly.nodes) {
    add_scaled(assembly.members[node.first].stiffness, 1, arm_stiffness(node.arm_first, -node.tension));
    add_scaled(assembly.members[node.second].stiffness, 1, arm_stiffness(node.arm_second, node.tension));
  }
  for (JointMember& member : assembly.members) {
    if (!member.dynamic) continue;
    const Matrix3 rotation = member.turn.toRotationMatrix();
    member.inertia = symmetric_product(product(rotation, table.inertia[member.body]), rotation);
    Matrix3 stiffened = member.inertia;
    add_scaled(stiffened, h * h, member.stiffness);
    member.inverse_inertia = symmetric_inverse(stiffened);
  }
}

}  // namespace

JointAssembly JointAssembly::of(std::span<const JointLink> links, std::span<const Joint> joints,
                                const BodyTable& table) {
  JointAssembly assembly;
  const std::vector<std::uint32_t> bodies = bodies_of(links);
  for (const std::uint32_t body : bodies) {
    JointMember member{};
    member.body = body;
    member.dynamic = table.mobility[body] == Mobility::Dynamic;
    member.inverse_mass = table.inverse_mass[body];
    assembly.members.push_back(member);
  }
  const auto member_of = [&](std::uint32_t body) {
    return static_cast<std::uint32_t>(std::lower_bound(bodies.begin(), bodies.end(), body) - bodies.begin());
  };
  for (const JointLink& link : links) {
    const Joint& joint = joints[link.joint];
    JointNode node{};
    node.joint = link.joint;
    node.first = member_of(link.first);
    node.second = member_of(link.second);
    node.point = joint.point;
    node.begin = static_cast<std::uint32_t>(assembly.rows.size());
    assembly.rows.resize(assembly.rows.size() + joint.rows);
    node.end = static_cast<std::uint32_t>(assembly.rows.size());
    assembly.nodes.push_back(node);
  }
  return assembly;
}

void JointAssembly::apply(const JointNode& node, const JointRow& row, double impulse) {
  JointMember& a = members[node.first];
  JointMember& b = members[node.second];
  if (a.dynamic) {
    a.velocity -= (a.inverse_mass * impulse) * row.linear;
    a.spin -= a.inverse_inertia * (impulse * row.angular_first);
  }
  if (b.dynamic) {
    b.velocity += (b.inverse_mass * impulse) * row.linear;
    b.spin += b.inverse_inertia * (impulse * row.angular_second);
  }
}

void JointAssembly::load_velocities(const SolverBodies& bodies) {
  for (JointMember& member : members) {
    member.velocity = member.velocity_before = get3(bodies.velocity[member.local].linear);
    member.spin = member.spin_before = get3(bodies.velocity[member.local].angular);
  }
  for (JointNode& node : nodes) node.impulse_before = node.impulse;
  for (AssemblyRow& row : rows) row.impulse_before = row.impulse;
}

void JointAssembly::load_no_velocities() {
  for (JointMember& member : members) {
    member.velocity = member.velocity_before = Vector3::Zero();
    member.spin = member.spin_before = Vector3::Zero();
  }
}

void JointAssembly::store_velocities(SolverBodies& bodies) const {
  for (const JointMember& member : members) {
    if (!member.dynamic) continue;
    set3(bodies.velocity[member.local].linear, member.velocity);
    set3(bodies.velocity[member.local].angular, member.spin);
    add3(bodies.free_velocity[member.local].linear, member.velocity - member.velocity_before);
    add3(bodies.free_velocity[member.local].angular, member.spin - member.spin_before);
  }
}

bool JointAssembly::moves_far(double h, double far) const {
  return std::any_of(members.begin(), members.end(), [=](const JointMember& member) {
    return !(h * (member.velocity - member.velocity_before).norm() <= far &&
             h * (member.spin - member.spin_before).norm() <= far);
  });
}

void JointAssembly::take_back() {
  for (JointMember& member : members) {
    member.velocity = member.velocity_before;
    member.spin = member.spin_before;
  }
  for (JointNode& node : nodes) node.impulse = node.impulse_before;
  for (AssemblyRow& row : rows) row.impulse = row.impulse_before;
}

bool JointAssembly::makes_energy(const Joint* joints, bool owes_before, bool owes_after) const {
  // J, from differences: most solves take energy, and no more is asked of these.
  double made = 0;
  for (const JointMember& member : members) {
    if (!member.dynamic) continue;
    made +=
        0.5 * (member.velocity - member.velocity_before).dot(member.velocity + member.velocity_before) /
            member.inverse_mass +
        0.5 *
            (member.spin - member.spin_before).dot(product(member.inertia, Vector3(member.spin + member.spin_before)));
  }
  double of_rotors = 0;
  for (const JointNode& node : nodes) {
    const JointMember& a = members[node.first];
    const JointMember& b = members[node.second];
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      const AssemblyRow& row = rows[r];
      const Law& law = joints[node.joint].law[r - node.begin];
      if (!law.drives() && !law.looks_back()) continue;
      const double rate = row_speed(node, row);
      const double before = row.at.rate(a.velocity_before, a.spin_before, b.velocity_before, b.spin_before);
      made -= std::max(0.5 * (row.impulse - row.impulse_before) * (rate + before), 0.0);
      if (law.armature == 0) continue;
      const double owed = row.unpaid / law.armature;
      const double turned = before + (owes_before ? owed : 0), turns = rate + (owes_after ? owed : 0);
      made += 0.5 * law.armature * (turns * turns - turned * turned);
      of_rotors += 0.5 * law.armature * turned * turned;
    }
  }
  if (made <= 0) return false;
  double there = of_rotors;
  for (const JointMember& member : members) {
    if (!member.dynamic) continue;
    there += 0.5 * member.velocity_before.squaredNorm() / member.inverse_mass +
             0.5 * member.spin_before.dot(product(member.inertia, member.spin_before)) +
             tuning::least_energy / member.inverse_mass;
  }
  return made > tuning::energy_tolerance * there;
}

void JointAssembly::leave_out_tension() {
  for (JointMember& member : members) {
    if (member.dynamic) member.inverse_inertia = symmetric_inverse(member.inertia);
  }
}

void JointAssembly::move_bodies(SolverBodies& bodies, double h) const {
  for (const JointMember& member : members) {
    if (!member.dynamic) continue;
    DisplacementRows& moved = bodies.displacement[member.local];
    add3(moved.linear, h * (member.velocity - member.velocity_before));
    const Vector3 turn = h * (member.spin - member.spin_before);
    const auto turn_rows = [&](float(&rotation)[4]) {
      const Quaternion now = turned(turn, {rotation[3], rotation[0], rotation[1], rotation[2]});
      for (int k = 0; k < 4; ++k) rotation[k] = static_cast<float>(now.coeffs()[k]);
    };
    turn_rows(moved.rotation);
    if (bodies.round_shapes) turn_rows(bodies.shape[member.local].rotation);
  }
}

void JointAssembly::place_members(const SolverBodies& bodies) {
  for (JointMember& member : members) {
    const DisplacementRows& moved = bodies.displacement[member.local];
    member.position = member.start + get3(moved.linear);
    member.turn = (rotation_of(moved) * member.start_turn).normalized();
  }
}

void JointAssembly::place_joints(const Joint* joints, const BodyTable& table, double h) {
  for (JointNode& node : nodes) {
    const Joint& joint = joints[node.joint];
    const JointMember& first = members[node.first];
    const JointMember& second = members[node.second];
    node.arm_first = first.turn * joint.anchor_first;
    node.arm_second = second.turn * joint.anchor_second;
    node.offset = (second.position - first.position) + (node.arm_second - node.arm_first);
    if (node.begin == node.end) continue;
    const JointFrames frames = frames_of(joint, node);
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      AssemblyRow& row = rows[r];
      const LawRow now = law_row(joint, r - node.begin, frames, row.position);
      row.at = now.at;
      row.position = now.position;
    }
  }
  place_member_inertia(*this, table, h);
}

}  // namespace atl::solver
