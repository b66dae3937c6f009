#pragma once

#include <jobs/arrays.h>
#include <solver/integrate/solver_bodies.h>
#include <solver/sweep/group_bodies.h>
#include <solver/sweep/group_contacts.h>
#include <solver/sweep/group_joints.h>
#include <solver/sweep/group_tendons.h>
#include <solver/sweep/impacts.h>
#include <solver/sweep/joined_motion.h>
#include <solver/sweep/joint_energy.h>
#include <solver/sweep/joint_inertia.h>
#include <solver/sweep/passive_energy.h>

#include <cstdint>
#include <vector>

namespace atl::solver {

/// The data of a group while it is solved.
struct GroupParts {
  GroupBodies numbers;
  SolverBodies bodies;  ///< by these numbers
  GroupContacts contacts;
  Impacts impacts;
  GroupJoints joints;    ///< joints that are swept
  GroupTendons tendons;  ///< between these
  JointInertia joint_inertia;
  JointEnergy joint_energy;
  JoinedMotion joined_motion;
  PassiveEnergy passive_energy;
  std::vector<std::uint8_t> joined;  ///< by number of a body; empty without joints

  /// See jobs/arrays.h.
  auto arrays() const {
    return std::tie(numbers, bodies, contacts, impacts, joints, tendons, joint_inertia, joint_energy, joined_motion,
                    passive_energy, joined);
  }
};

}  // namespace atl::solver
