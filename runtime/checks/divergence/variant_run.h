#pragma once

#include <atoll/scene.h>
#include <atoll/snapshot.h>
#include <atoll/world.h>

#include <cstdint>
#include <functional>
#include <vector>

namespace atl::divergence {

/// Tells if the state of a run is saved ahead of some of its steps and restored later, in which nothing may get lost.
enum class Restore {
  Never,
  SameWorld,   ///< by the world itself, after a few steps on, which are thus taken back
  FreshWorld,  ///< by a world that was empty, which goes on in its place
};

/// A way to run a scene that must not change a bit of what it comes to.
struct Variant {
  int threads = 1;
  Simd simd = Simd::Auto;
  Restore restore = Restore::Never;

  friend bool operator==(const Variant&, const Variant&) = default;
};

/// The instruction sets that a World can be made with on this machine, narrow ones first.
std::vector<Simd> supported_simds();

/// Changes a world ahead of a step (the first is 1): a test plants a fault with it.
using Meddle =
    std::function<void(World& world, const std::vector<BodyId>& ids, std::int64_t step, const Variant& variant)>;

/// A scene in a world of its own.
class VariantRun {
 public:
  /// Events are noted whatever the scene says: their order is part of what must not differ. Throws Error as World and
  /// build_scene() do. `scene` has to outlive the run.
  VariantRun(const Scene& scene, const Variant& variant, Meddle meddle = {});

  void step();
  std::int64_t steps() const { return steps_; }  ///< so far
  /// Hash of the state, and of the last step's events in order.
  std::uint64_t hash() const;

  const World& world() const { return world_; }
  const std::vector<BodyId>& ids() const { return ids_; }  ///< in the scene's order

 private:
  void advance();
  void save_and_restore();

  const Scene& scene_;
  Variant variant_;
  Meddle meddle_;
  World world_;
  std::vector<BodyId> ids_;
  std::int64_t steps_ = 0;
  Snapshot snapshot_;
};

}  // namespace atl::divergence
