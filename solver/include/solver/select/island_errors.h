#pragma once

#include <collision/contacts/contact.h>
#include <solver/constraints/joint.h>
#include <solver/direct/joint_systems.h>
#include <solver/integrate/body_table.h>
#include <solver/islands/islands.h>
#include <solver/islands/joint_graph.h>
#include <solver/select/error_target.h>

#include <cstddef>
#include <cstdint>
#include <span>

namespace atl::solver {

/// The state as a step begins, from which the errors of islands after the last step are measured.
struct ErrorInput {
  const Islands& islands;
  const BodyTable& bodies;
  const collision::ContactManifold* manifolds;  ///< by slot
  const Joint* joints;                          ///< by index of joint
  const JointGraph* joint_graph;                ///< null where there are no joints
  const JointSystems* joint_systems;            ///< likewise
  double gravity;                               ///< m/s^2
  double dt;                                    ///< s, of what is solved now: a step, or under a force law a part of it
  int asked;                                    ///< substeps of it, by which impulses are kept
  int parts;                                    ///< of which a step is made: 1, or under a force law its substeps
};

/// Adds the overlaps of contacts, by their manifolds. `substeps` by body: of the step that made them, 0 of bodies that
/// had none. Of an overlap beyond the target that part follows the substeps which its load explains, the force over the
/// stiffness of a soft contact (Catto, "Soft Constraints", GDC 2011), with tuning::explained_error to spare. The rest
/// is what bodies met with, and on its way out whatever the substeps.
void add_overlaps(const ErrorInput& input, std::span<const TouchingPair> contacts,
                  std::span<const std::uint16_t> substeps, double target, ErrorCounts& counts);

/// Adds what joints are open by, likewise: the length of the vector of locked offsets, as `JointDriftReport::max`.
void add_gaps(const ErrorInput& input, std::span<const JointLink> links, std::span<const std::uint16_t> substeps,
              double target, ErrorCounts& counts);

/// The number of substeps of an island without history. With it, its contacts hold tuning::first_load times the weight
/// of a body, and its swept joints the weight of all of its bodies.
int substeps_at_first(const ErrorInput& input, const ErrorTarget& target, std::size_t island);

/// m, the overlap that one in a hundred of these contacts exceeds, and the gap that one in a hundred of these joints
/// does.
double overlap_of(const ErrorInput& input, std::span<const TouchingPair> contacts);
double gap_of(const ErrorInput& input, std::span<const JointLink> links);

}  // namespace atl::solver
