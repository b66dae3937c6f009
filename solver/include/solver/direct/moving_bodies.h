#pragma once

#include <solver/direct/island_members.h>
#include <solver/direct/island_problem.h>
#include <solver/direct/solve_input.h>
#include <solver/integrate/free_flight.h>

#include <cstdint>
#include <span>
#include <vector>

namespace atl::solver {

/// A body of an island that is solved at once, as it moves through the step.
struct MovingBody {
  BodyPose now, start;
  BodyPose before;                ///< a motion that may be taken back
  BodyPose next;                  ///< at the substep's end, if no impulse changed its velocity
  Vector3 acceleration;           ///< m/s^2
  Matrix3 body_inertia, inertia;  ///< kg m^2, body and world frame
  bool tumbles;                   ///< its moments of inertia differ
  SplitTop top;                   ///< by which it then turns, if it is joined
};

/// Fills in the problem's bodies and their velocities, as of the start of the step. Returns false if one tumbles too
/// fast.
bool load_bodies(const SolveInput& input, const IslandMembers& members, IslandProblem& problem,
                 std::vector<MovingBody>& bodies);

/// Sets the inertia of a body in a step, which it has half way through it.
void set_inertia_half_way(const BodyTable& table, DirectBody& body);

/// rad/s^2: what a torque (N m) makes of a body's spin, by its own inertia.
Vector3 turning(const DirectBody& body, const MovingBody& moving, const Vector3& torque);
/// Takes the free velocities on from the present ones by what the forces on bodies make of them in `time` seconds.
void free_velocities_of_kick(const BodyTable& table, double time, std::span<const MovingBody> bodies,
                             IslandProblem& problem);

/// Sets the bodies' own inertia at the present poses.
void turn_inertia(std::span<MovingBody> bodies);

/// Inertia at the poses of now, with what the tension in joints makes of it in h seconds.
void place_inertia(IslandProblem& problem, std::span<MovingBody> bodies, double h);

/// Adds to inertia and masses what the impulses of the last closing motion make of them: the curvature of gaps by which
/// these pull, as sequential quadratic programming has it (Nocedal and Wright, "Numerical Optimization", 2006, 18.1).
/// By the gaps' slopes alone a taut chain of light links, which is nearly singular, would turn them far sooner than
/// lift what hangs on it. Of rods a bound of it is added, the same along all axes and without their coupling of two
/// bodies.
void add_closing_stiffness(const Joint* joints, IslandProblem& problem);
/// Gives bodies their masses back; place_inertia() does so with the rest.
void restore_masses(const BodyTable& table, IslandProblem& problem);

/// Moves bodies by `share` times six numbers each, m or m/s and rad or rad/s.
void move(std::span<MovingBody> bodies, double share, const std::vector<double>& by);

/// Poses `time` seconds into the step: of an island's bodies those of now.
struct IslandPoses {
  const BodyTable& table;
  std::span<const MovingBody> bodies;
  double time;  ///< s

  /// The pose of a body, given by its number in the problem, if it has one, and in the world.
  BodyPose of(std::uint32_t local, std::uint32_t body) const {
    return local != no_body ? bodies[local].now : pose_after(table, body, time);
  }
};

}  // namespace atl::solver
