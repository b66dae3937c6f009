#pragma once

#include <features/with_joints.h>
#include <solver/direct/direct_joints.h>
#include <solver/sweep/group_parts.h>
#include <solver/sweep/group_report.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>

namespace atl::solver {

// The values that are the same in all substeps of a group's step.
struct GroupSetup {
  // The bodies, contacts and joints of the group are gathered in `parts`; `report` says what it needs.
  GroupSetup(const SolveInput& of, const IslandGroup& islands, const SubstepConstants& of_substeps,
             const GroupReport& report, GroupParts& parts)
      : input(of),
        group(islands),
        settings(of.settings),
        kernels(of.kernels),
        constants(of_substeps),
        body_ids(of.islands.bodies(islands.begin, islands.end)),
        block_count(parts.contacts.block_count()),
        splits(settings.stabilisation == Stabilisation::SplitImpulse),
        relaxes(settings.stabilisation == Stabilisation::Soft && settings.relax_iterations > 0),
        joined(with_joints && report.joints > 0),
        sweeps_joints(with_joints && !parts.joints.empty()),
        sweeps_tendons(with_joints && !parts.tendons.empty()),
        bounds_joints(sweeps_joints && relaxes),
        watches_energy(sweeps_joints || block_count > 0),
        struck_speed(of_substeps.gravity *
                     static_cast<float>(std::max(of.dt, tuning::struck_substeps * of_substeps.h))),
        friction(!report.friction   ? Friction::None
                 : settings.pyramid ? Friction::Pyramid
                                    : Friction::Cone),
        joint_step{of.joints, of.joint_graph, of.bodies, parts.bodies, constants, of.dt / settings.substeps},
        contact_data(parts.contacts.kernel_data(of, report, constants, splits, parts.bodies, parts.joined)),
        joint_data(parts.joints.kernel_data(parts.bodies, constants, splits)) {}

  const SolveInput& input;
  const IslandGroup& group;
  const SolverSettings& settings;
  const Kernels& kernels;
  const SubstepConstants& constants;
  const std::span<const std::uint32_t> body_ids;  // of its dynamic bodies
  const std::size_t block_count;                  // of contacts
  const bool splits;                              // impulses that push apart are kept from those that last
  const bool relaxes;                             // the push of soft contacts is taken back
  const bool joined;                              // there are joints
  const bool sweeps_joints;                       // some are solved one by one
  const bool sweeps_tendons;                      // between these
  const bool bounds_joints;                       // whose velocities end a substep without what pushes
  const bool watches_energy;                      // of islands that only hold, over the step
  const float struck_speed;                       // m/s, a change by more than a load makes
  const Friction friction;
  const JointStep joint_step;
  const ContactKernelData contact_data;
  const JointKernelData joint_data;
};

}  // namespace atl::solver
