#pragma once

#include <collision/continuous/continuous_collision.h>
#include <solver/integrate/motion.h>

#include <cstdint>
#include <span>
#include <vector>

#include "step/island_phase.h"
#include "step/step_context.h"
#include "world/containment.h"
#include "world/stores.h"

namespace atl {

/// Continuous collision: bodies that moved far in a step are put back to where they first met something in their
/// way. They keep their velocity. What joints connect is put back together: if one of an assembly's fast bodies meets
/// something at a part of the step, all its bodies are put where they were then. Static and kinematic bodies connect
/// nothing.
class ContinuousPhase {
 public:
  explicit ContinuousPhase(int threads) : continuous_(threads) {}
  /// Makes it do for so many workers, if it is for fewer.
  void reach(int threads) { continuous_.reach(threads); }

  /// Ahead of the solve: bodies that something kinematic may pass over count as fast. Those that touch a mesh or height
  /// field do if they move as far as their cores are from it: contacts give way to what presses on them, and behind its
  /// front a surface pushes nobody.
  void watch_surface_contacts(Stores& world, const ContactPhase& contacts);
  /// `moved` are bodies that moved far by the solve, by worker; it is empty after this.
  void sweep(Stores& world, const StepContext& step, const ContactPhase& contacts, const IslandPhase& islands,
             solver::FastBodies& moved);

 private:
  void watch(Stores& world, std::uint32_t body, double distance);
  void watch_what_is_passed(Stores& world);
  // A body that was watched, and what its motion was held against before.
  struct OnSurface {
    std::uint32_t body;
    double sweep_distance;
  };

  void unwatch(Stores& world);
  collision::FastBody fast_body(const Stores& world, const IslandPhase& islands, const solver::MovedBody& moved) const;
  void list_fast_bodies(const Stores& world, const IslandPhase& islands, solver::FastBodies& moved);
  void list_carried(const Stores& world, const IslandPhase& islands, solver::FastBodies& moved,
                    std::span<const collision::CcdStop> stops);
  void stop(Stores& world, const IslandPhase& islands, const collision::CcdStop& stop, StepCounts& counts) const;

  std::vector<collision::FastBody> fast_in_order_;  // of assemblies, then of bodies
  std::vector<collision::FastBody> carried_;        // likewise: not fast, but joined to what stops
  std::vector<OnSurface> on_surfaces_;              // in order of bodies, once the solve is done
  collision::ContinuousCollision continuous_;
};

}  // namespace atl
