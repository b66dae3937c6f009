#include <jobs/assert.h>
#include <solver/sweep/group_bodies.h>
#include <solver/sweep/joint_inertia.h>
#include <solver/tuning.h>

#include "integrate/matrix3.h"
#include "integrate/rows3.h"

namespace atl::solver {

void JointInertia::stiffen(const SolveInput& input, std::span<const std::uint32_t> bodies, std::size_t begin,
                           std::size_t end, SolverBodies& rows) {
  constexpr double negligible = 1e-3;  // of the inertia
  const double h = input.dt / input.settings.substeps;
  for (std::size_t i = begin; i < end; ++i) {
    ATL_ASSERT(first_dynamic_ + i < stiffness_.size(), bodies[i], i, stiffness_.size());
    Matrix3& added = stiffness_[first_dynamic_ + i];
    added *= h * h;
    if (!(added.trace() > negligible * input.bodies.inertia[bodies[i]].trace())) {
      added.setZero();
      continue;
    }
    const Matrix3 inertia = resolved_inertia(input.bodies, bodies[i], input.bodies.orientation(bodies[i]), added);
    set_inverse_inertia(rows, first_dynamic_ + i, inverse_inertia_with(input.bodies.locks[bodies[i]], inertia));
  }
}

// Bodies of unequal moments of inertia in swept joints, whose inertia is to turn with them in the step. Contacts have
// made their matrices of it: what they touch is left as it is.
void JointInertia::find_followers(const SolveInput& input, std::span<const std::uint32_t> bodies,
                                  const JoinedMotion& joined) {
  followers_.clear();
  for (std::uint32_t i = 0; i < bodies.size(); ++i) {
    if (!input.bodies.gyroscopic[bodies[i]] || !joined.follows(i)) continue;
    followers_.push_back({i, resolved_inertia(input.bodies, bodies[i], input.bodies.orientation(bodies[i]),
                                              stiffness_[first_dynamic_ + i])});
  }
}

void JointInertia::follow(const SolveInput& input, std::span<const std::uint32_t> bodies, SolverBodies& rows) {
  for (Follower& follower : followers_) {
    const std::size_t local = first_dynamic_ + follower.place;
    ATL_ASSERT(follower.place < bodies.size(), follower.place, bodies.size());
    const std::uint32_t body = bodies[follower.place];
    const Vector3 spin = get3(rows.velocity[local].angular);
    if (!(spin_of(rows, local).squaredNorm() > tuning::min_spin * tuning::min_spin)) continue;
    const Quaternion turn = rotation_of(rows.displacement[local]) * input.bodies.orientation(body);
    const Matrix3 inertia = resolved_inertia(input.bodies, body, turn.normalized(), stiffness_[local]);
    const Matrix3 inverse = symmetric_inverse(inertia);
    // The joints' effect is carried over as a change of spin. The same angular impulse is another change with this
    // inertia.
    FreeVelocityRows& free = rows.free_velocity[local];
    const Vector3 done = spin - get3(free.angular);
    set3(free.angular, spin - product(inverse, product(follower.inertia, done)));
    set_inverse_inertia(rows, local, inverse);
    follower.inertia = inertia;
  }
}

}  // namespace atl::solver
