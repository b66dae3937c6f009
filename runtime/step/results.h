#pragma once
/// Results that callers ask for after a step. They are computed on demand, so a step without readers pays nothing.

#include <atoll/contact_problem.h>
#include <atoll/memory.h>
#include <atoll/world.h>

#include <span>
#include <vector>

#include "step/pipeline.h"
#include "world/stores.h"

namespace atl {

/// The frame of a manifold in the world.
struct ManifoldPlace {
  Vector3 centre;       ///< m
  Vector3 tangents[2];  ///< unit
  Vector3 normal;       ///< unit, from the first body to the second

  Vector3 point(const collision::ContactManifold& manifold, std::size_t i) const;  ///< m
};
ManifoldPlace place_of(const Stores& world, const collision::Contact& contact,
                       const collision::ContactManifold& manifold);

std::span<const ContactForce> contact_forces(Stores& world, const ContactPhase& phase,
                                             const collision::NarrowphaseKernels& kernels, jobs::Arena& arena);
std::span<const PairForce> pair_forces(Stores& world, const ContactPhase& phase,
                                       const collision::NarrowphaseKernels& kernels, jobs::Arena& arena);
/// The sum of the wrenches that a body's contacts exert on it.
Wrench contact_wrench(Stores& world, std::uint32_t body, const ContactPhase& phase,
                      const collision::NarrowphaseKernels& kernels, jobs::Arena& arena);
/// The same for all bodies.
Eigen::Matrix<double, 6, Eigen::Dynamic> contact_wrenches(Stores& world, const ContactPhase& phase,
                                                          const collision::NarrowphaseKernels& kernels,
                                                          jobs::Arena& arena);
/// Keeps the velocities with which a step begins, where accelerations are asked for.
void begin_accelerations(Stores& world);
/// Makes accelerations of them as the step of dt seconds ends.
void end_accelerations(Stores& world, double dt);
/// The linear ones, or the angular ones. Throws Error, in the name of the call, if there are none.
Eigen::Map<const Eigen::Matrix3Xd> accelerations(const Stores& world, bool angular, const char* call);
/// m/s^2, along the axes of the body's frame, at a point of it.
Vector3 proper_acceleration(const Stores& world, std::uint32_t body, const Vector3& point);
/// The contact problem of the last step, whose substeps took `substep` seconds each.
ContactProblem contact_problem(const Stores& world, std::span<const solver::TouchingPair> touching,
                               const solver::ContactCapture& capture, double substep);
/// The residual of each island, defined like ResidualReport::relative.
std::vector<double> island_residuals(const ContactProblem& problem, const solver::Islands& islands);
/// The memory of a world, by use.
std::vector<MemoryUse> memory_of(const Stores& world, const StepPipeline& pipeline);
/// Asks for the memory of a small world that is about to be stepped.
void prefetch(const Stores& world, const StepPipeline& pipeline);

}  // namespace atl
