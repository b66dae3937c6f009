#pragma once

#include <atoll/forces.h>
#include <atoll/world.h>

#include <cstdint>
#include <span>
#include <vector>

#include "world/world_impl.h"

namespace atl {

/// A step under a force law. Each substep is a step of its own, contacts and all, so that the law sees bodies as they
/// are, and forces are of second order where nothing touches: half of the difference that a law finds at the end of a
/// substep is made up for there, and joints answer to it. With the kick of half a step on either side that is the
/// velocity Verlet method, and with forces by velocity its variant with predicted ones (Groot and Warren, "Dissipative
/// particle dynamics", J. Chem. Phys. 107, 1997, eq. 13 with lambda = 1/2).
class ForcedStep {
 public:
  ForcedStep(World& world, const ForceLaw& law, double dt);

  /// Passes on an exception of the law, once the world is back in the state after the last whole substep.
  StepReport run();

 private:
  struct Applied {
    std::uint32_t body;
    Vector3 force, torque;
  };

  void ask(double time);
  void record(bool given);
  void apply(bool again);
  void make_up(double substep);
  void make_up_free(double substep);
  void make_up_joined(double substep);
  bool changes(std::span<const std::uint32_t> bodies) const;

  World::Impl& impl_;
  Stores& world_;
  const ForceLaw& law_;
  double dt_;
  std::vector<Applied> steady_;  // that were on bodies as the step began
  Forces now_, before_;          // what the law asks for, and asked for a substep ago; or the change since
};

}  // namespace atl
