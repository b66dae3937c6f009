#pragma once
/// What callers ask for after a step, made when asked for: a step that nobody asks pays nothing.

#include <atoll/contact_problem.h>
#include <atoll/memory.h>
#include <atoll/world.h>

#include <span>
#include <vector>

#include "step/pipeline.h"
#include "world/stores.h"

namespace atl {

/// Where the points of a manifold are in the world.
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
/// Of a step whose substeps took so many seconds.
ContactProblem contact_problem(const Stores& world, std::span<const solver::TouchingPair> touching,
                               const solver::ContactCapture& capture, double substep);
/// As ResidualReport::relative, by island.
std::vector<double> island_residuals(const ContactProblem& problem, const solver::Islands& islands);
/// What of a world's memory is for what.
std::vector<MemoryUse> memory_of(const Stores& world, const StepPipeline& pipeline);
/// Asks for the memory of a small world that is about to be stepped.
void prefetch(const Stores& world, const StepPipeline& pipeline);

}  // namespace atl
