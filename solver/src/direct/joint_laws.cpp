#include "direct/joint_laws.h"

#include <solver/integrate/motion.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

namespace atl::solver {
namespace {

// Where bodies would turn to in the substep.
void turn_on(std::vector<JointMember>& members, const BodyTable& table, double h) {
  for (JointMember& member : members) {
    member.next_turn = member.turn;
    if (member.spin.isZero(0)) continue;
    Vector3 spin = member.turn.conjugate() * member.spin;
    if (member.dynamic && table.gyroscopic[member.body]) {
      const Vector3 torque = (table.inertia[member.body] * spin).cross(spin);
      spin += (0.5 * h) * (table.inverse_inertia[member.body] * torque);
    }
    member.next_turn = turned(h * (member.turn * spin), member.turn);
  }
}

bool bends_notably(const JointMember& member) {
  constexpr double least_square = tuning::least_bend_spin * tuning::least_bend_spin;
  return member.spin.squaredNorm() > least_square;
}

bool has_limits(const Joint& joint) {
  return std::any_of(joint.law.begin(), joint.law.begin() + joint.rows,
                     [](const Law& law) { return law.limited() && !law.locked(); });
}

}  // namespace

void weigh_rows(JointAssembly& assembly) {
  for (const JointNode& node : assembly.nodes) {
    const JointMember& a = assembly.members[node.first];
    const JointMember& b = assembly.members[node.second];
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      AssemblyRow& row = assembly.rows[r];
      const double response = row.at.response(a.inverse_mass + b.inverse_mass, a.inverse_inertia, b.inverse_inertia);
      row.mass = response > 0 ? 1 / response : 0;
    }
  }
}

void begin_laws(JointAssembly& assembly, const Joint* joints, double h) {
  for (const JointNode& node : assembly.nodes) {
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      AssemblyRow& row = assembly.rows[r];
      row.mode.begin(joints[node.joint].law[r - node.begin], row.at, row.mass, h);
    }
  }
}

void forget_bends(JointAssembly& assembly) {
  for (JointNode& node : assembly.nodes) node.bend.setZero();
  for (AssemblyRow& row : assembly.rows) row.bend = 0;
}

void begin_kick(JointAssembly& assembly, const Joint* joints, double h, int sign) {
  forget_bends(assembly);
  for (const JointNode& node : assembly.nodes) {
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      AssemblyRow& row = assembly.rows[r];
      const double end_rate = sign < 0 ? row.rate_before : row.bounces ? row.impact.leaving : 0;
      row.mode.begin_kick(joints[node.joint].law[r - node.begin], row.at, row.mass, h, sign, row.rate_before, end_rate);
    }
  }
}

void correct_kick(JointAssembly& assembly, const Joint* joints, double h, int sign) {
  for (const JointNode& node : assembly.nodes) {
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      AssemblyRow& row = assembly.rows[r];
      const Law& law = joints[node.joint].law[r - node.begin];
      if (!law.looks_back() || law.locked()) continue;
      const double rate = assembly.row_speed(node, row);
      const double acceleration = sign * (rate - row.rate_before) / (0.5 * h);
      row.mode.add_impulse(sign *
                           kick_correction(law, row.at, row.mass, h, sign < 0 ? row.rate_before : rate, acceleration));
    }
  }
}

void note_rates(JointAssembly& assembly) {
  for (const JointNode& node : assembly.nodes) {
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      assembly.rows[r].rate_before = assembly.row_speed(node, assembly.rows[r]);
    }
  }
}

void start_laws(JointAssembly& assembly, const Joint* joints) {
  note_rates(assembly);
  for (const JointNode& node : assembly.nodes) {
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      AssemblyRow& row = assembly.rows[r];
      if (joints[node.joint].law[r - node.begin].looks_back()) row.mode.start_at(row.rate_before);
    }
  }
}

void add_armature(JointAssembly& assembly, const Joint* joints, double times) {
  for (const JointNode& node : assembly.nodes) {
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      AssemblyRow& row = assembly.rows[r];
      row.unpaid += times * joints[node.joint].law[r - node.begin].armature * assembly.row_speed(node, row);
    }
  }
}

void note_impacts(JointAssembly& assembly, const Joint* joints, double h) {
  for (const JointNode& node : assembly.nodes) {
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      const Law& law = joints[node.joint].law[r - node.begin];
      AssemblyRow& row = assembly.rows[r];
      row.bounces = false;
      row.impact = row.mode.holds() || law.restitution == 0
                       ? LimitImpact{}
                       : LimitImpact::of(law, row.at.value, row.rate_before, assembly.row_speed(node, row), h);
    }
  }
}

void note_bends(JointAssembly& assembly, const Joint* joints, const BodyTable& table, double h) {
  turn_on(assembly.members, table, h);
  bool goes_far = false;
  for (JointNode& node : assembly.nodes) {
    const JointMember& a = assembly.members[node.first];
    const JointMember& b = assembly.members[node.second];
    node.bend.setZero();
    for (std::uint32_t r = node.begin; r < node.end; ++r) assembly.rows[r].bend = 0;
    if (!bends_notably(a) && !bends_notably(b)) continue;
    const Joint& joint = joints[node.joint];
    const Vector3 turned_first = a.next_turn * joint.anchor_first - node.arm_first;
    const Vector3 turned_second = b.next_turn * joint.anchor_second - node.arm_second;
    goes_far |= turned_first.norm() > tuning::most_bend * node.arm_first.norm() ||
                turned_second.norm() > tuning::most_bend * node.arm_second.norm();
    node.bend = (turned_second - turned_first) / h - (b.spin.cross(node.arm_second) - a.spin.cross(node.arm_first));
    if (node.begin == node.end) continue;
    const JointFrames frames =
        joint_frames(joint, a.position + h * a.velocity, a.next_turn, b.position + h * b.velocity, b.next_turn);
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      AssemblyRow& row = assembly.rows[r];
      const double change = h * assembly.row_speed(node, row);
      const LawRow there = law_row(joint, r - node.begin, frames, row.position + change);
      row.bend = (there.at.value - (row.at.value + change)) / h;
    }
  }
  if (goes_far) forget_bends(assembly);
}

bool update_laws(JointAssembly& assembly) {
  bool changed = false;
  for (const JointNode& node : assembly.nodes) {
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      AssemblyRow& row = assembly.rows[r];
      changed |= row.mode.update(assembly.row_speed(node, row), row.impulse);
    }
  }
  return changed;
}

bool catch_limits(JointAssembly& assembly, const Joint* joints, double h) {
  if (assembly.rows.empty()) return false;
  bool caught = false;
  for (const JointNode& node : assembly.nodes) {
    const Joint& joint = joints[node.joint];
    if (!has_limits(joint)) continue;
    const JointFrames frames = assembly.frames_of(joint, node);
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      const Law& law = joint.law[r - node.begin];
      if (!law.limited() || law.locked()) continue;
      caught |= assembly.rows[r].mode.catch_at_end(law, position_of(assembly, node, r, joint, frames, h));
    }
  }
  return caught;
}

bool catch_limits_here(JointAssembly& assembly, const Joint* joints) {
  bool caught = false;
  for (const JointNode& node : assembly.nodes) {
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      AssemblyRow& row = assembly.rows[r];
      const Law& law = joints[node.joint].law[r - node.begin];
      if (law.limited()) caught |= row.mode.catch_at_end(law, row.at.value);
    }
  }
  return caught;
}

double position_of(const JointAssembly& assembly, const JointNode& node, std::uint32_t r, const Joint& joint,
                   const JointFrames& frames, double h) {
  const AssemblyRow& row = assembly.rows[r];
  const double moved = row.position + h * assembly.row_speed(node, row);  // what is a rate only is there
  return law_row(joint, r - node.begin, frames, moved).at.value;
}

}  // namespace atl::solver
