#include "direct/joint_targets.h"

#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

#include "direct/joint_laws.h"

namespace atl::solver {
namespace {

// What takes a vector to zero. Returns where the next number goes.
double* put_negative(const Vector3& v, double* to) {
  for (int k = 0; k < 3; ++k) *to++ = -v[k];
  return to;
}

// How far the joint's rows are from where they should be, as rates that take them there in h seconds.
void set_node_targets(const JointAssembly& assembly, const JointNode& node, const Joint& joint, double h, double* b) {
  const JointMember& first = assembly.members[node.first];
  const JointMember& second = assembly.members[node.second];
  if (node.point) {
    const Vector3 offset =
        (second.position - first.position) + (second.turn * joint.anchor_second - first.turn * joint.anchor_first);
    b = put_negative(offset / h, b);
  }
  if (node.begin == node.end) return;
  const JointFrames frames = assembly.frames_of(joint, node);
  for (std::uint32_t r = node.begin; r < node.end; ++r) {
    const AssemblyRow& row = assembly.rows[r];
    const Law& law = joint.law[r - node.begin];
    *b++ = row.mode.holds() ? (row.bound(law) - position_of(assembly, node, r, joint, frames, h)) / h : 0;
  }
}

}  // namespace

void set_velocity_targets(const JointAssembly& assembly, const JointMatrix& matrix, std::vector<double>& all) {
  for (std::uint32_t i = 0; i < assembly.nodes.size(); ++i) {
    const JointNode& node = assembly.nodes[i];
    double* b = &all[matrix.row(i)];
    if (node.point) b = put_negative(assembly.point_speed(node) + node.bend, b);
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      const AssemblyRow& row = assembly.rows[r];
      const LawMode& mode = row.mode;
      const double speed = assembly.row_speed(node, row) + (mode.is_locked() ? row.bend : 0);
      *b++ = mode.is_solved() ? mode.target() - speed - mode.compliance() * (row.impulse - mode.given()) : 0;
    }
  }
}

void set_projection_targets(const JointAssembly& assembly, const JointMatrix& matrix, bool late,
                            std::vector<double>& all) {
  for (std::uint32_t i = 0; i < assembly.nodes.size(); ++i) {
    const JointNode& node = assembly.nodes[i];
    double* b = &all[matrix.row(i)];
    if (node.point) b = put_negative(assembly.point_speed(node), b);
    for (std::uint32_t r = node.begin; r < node.end; ++r) {
      const AssemblyRow& row = assembly.rows[r];
      const double leaving = !row.bounces ? 0 : late ? row.impact.leaving_late : row.impact.leaving;
      *b++ = row.mode.holds() ? leaving - assembly.row_speed(node, row) : row.mode.compliance() * row.unpaid;
    }
  }
}

void set_position_targets(const JointAssembly& assembly, const JointMatrix& matrix, const Joint* joints, double h,
                          std::vector<double>& all) {
  for (std::uint32_t i = 0; i < assembly.nodes.size(); ++i) {
    const JointNode& node = assembly.nodes[i];
    set_node_targets(assembly, node, joints[node.joint], h, &all[matrix.row(i)]);
  }
}

bool set_position_targets_here(const JointAssembly& assembly, const JointMatrix& matrix, const Joint* joints, double h,
                               std::vector<double>& all) {
  bool closed = true;
  for (std::uint32_t i = 0; i < assembly.nodes.size(); ++i) {
    const JointNode& node = assembly.nodes[i];
    double* b = &all[matrix.row(i)];
    if (node.point) {
      closed &= node.offset.squaredNorm() <= tuning::open_gap * tuning::open_gap;
      b = put_negative(node.offset / h, b);
    }
    for (std::uint32_t r = node.begin; r < node.end; ++r, ++b) {
      const AssemblyRow& row = assembly.rows[r];
      const Law& law = joints[node.joint].law[r - node.begin];
      const double apart = row.mode.holds() ? row.bound(law) - row.at.value : 0;
      closed &= std::abs(apart) <= tuning::open_gap;
      *b = apart / h;
    }
  }
  return closed;
}

bool set_tears_aside(const JointAssembly& assembly, const JointMatrix& matrix, const Joint* joints, double h,
                     std::vector<double>& b, std::vector<double>& tears) {
  bool torn = false;
  for (std::uint32_t i = 0; i < assembly.nodes.size(); ++i) {
    const JointNode& node = assembly.nodes[i];
    std::size_t at = matrix.row(i);
    const auto set_aside = [&](double apart) {
      if (!torn) tears.assign(b.size(), 0.0);
      torn = true;
      b[at] -= apart / h;
      tears[at] = std::clamp(apart / h, -tuning::closing_speed, tuning::closing_speed);
    };
    if (node.point) {
      const bool apart = node.offset.squaredNorm() > tuning::torn * tuning::torn;
      for (int k = 0; k < 3; ++k, ++at) {
        if (apart) set_aside(-node.offset[k]);
      }
    }
    for (std::uint32_t r = node.begin; r < node.end; ++r, ++at) {
      const AssemblyRow& row = assembly.rows[r];
      if (!row.mode.holds()) continue;
      const double apart = row.bound(joints[node.joint].law[r - node.begin]) - row.at.value;
      // To an end that it is still on its way to it goes as fast as it goes.
      const bool beyond = row.mode.is_locked() || (row.mode.limit() < 0 ? apart > 0 : apart < 0);
      if (beyond && std::abs(apart) > tuning::torn) set_aside(apart);
    }
  }
  return torn;
}

}  // namespace atl::solver
