#pragma once

#include <collision/contacts/body_aabbs.h>
#include <collision/contacts/contact_cache.h>
#include <collision/contacts/narrowphase_kernels.h>
#include <collision/contacts/refresh.h>
#include <collision/continuous/sweep.h>
#include <collision/shapes/function_ref.h>

#include <algorithm>
#include <cstdint>
#include <span>

namespace atl::collision {

/// A body that was fast in a step, and its motion.
struct FastBody {
  static constexpr std::uint32_t alone = ~std::uint32_t{0};

  std::uint32_t body;
  std::uint32_t assembly;  ///< of bodies that joints connect, or alone
  Pose start;
  Vector3 shift;            ///< m, of the centre of mass
  double turn;              ///< m: no point of it got farther by turning
  double bulge;             ///< m: nor farther off the straight line from where it was to where it is
  bool stops;               ///< a shape on its path stops it
  bool always_swept;        ///< by its user's setting
  bool on_surface = false;  ///< it touches a surface, which its core may get to by moving little
  double aside_limit;       ///< m: it may end so far from where the step took it; below 0, not at all
  bool left_aabb = false;   ///< it left its fat AABBs
  bool queried = false;     ///< the broadphase is asked for shapes near it
};

/// The step after which fast bodies are followed: where all bodies are now, and how the fast ones got there.
struct CcdStep {
  const BodyMotions& motions;
  std::span<const double> turned;           ///< by body, see ContactUpdateInput
  std::span<const std::uint8_t> joined;     ///< by body: 1 if joints act on it
  std::span<const std::uint8_t> dynamic;    ///< by body: 1 if it is
  std::span<const std::uint32_t> assembly;  ///< by joined body
  const ContactCache& cache;
  const NarrowphaseKernels& kernels;
  std::size_t active_bodies;
  /// Pairs of colliders that pass through each other in this step, in order.
  std::span<const Pair> passing = {};
  /// Decides about pairs, in order, that have no contact and don't pass: it returns `passing` with those that do. Asked
  /// on the calling thread. Null where all that filters let meet may touch.
  const FunctionRef<std::span<const Pair>(std::span<const Pair>)>* decide = nullptr;

  /// In order of assemblies, those alone last, then of bodies.
  std::span<FastBody> fast = {};
  std::span<const std::uint32_t> places = {};  ///< by body: its number in `fast` + 1, or 0

  bool passes(Pair pair) const { return !passing.empty() && std::binary_search(passing.begin(), passing.end(), pair); }
  /// Null for a body that was not fast: it counts as being where it is now.
  const FastBody* find_fast(std::uint32_t body) const { return places[body] == 0 ? nullptr : &fast[places[body] - 1]; }
  std::uint32_t assembly_of(std::uint32_t body) const { return joined[body] ? assembly[body] : FastBody::alone; }

  /// Everywhere that a collider of a fast body has been in this step, if it ends `aside` of where it did.
  Aabb swept_aabb(const FastBody& body, std::uint32_t collider, const Vector3& aside) const;
  /// The collider's motion in this step, of its shape or of a part of it that is centred at `centre`, if its body ends
  /// `aside` of where it did.
  Motion motion_of(std::uint32_t collider, const Vector3& centre, const Vector3& aside) const;
};

/// How near a body is put to what it met, as part of its inner radius: well within the margin in which a contact
/// has points. Sweeps end that near but for their tolerance, a part as well.
inline constexpr double ccd_gap_share = 0.25 * static_cast<double>(margin_share);
inline constexpr double ccd_tolerance = 1e-3;

/// Part of the inner radius that is taken off a shape to make its core. A pair that touches at the start of the step is
/// left to its contact, unless the core comes to touch.
inline constexpr double core_share = 0.5;

/// True if any motion of a fast body, however small, must be swept against another shape. Other bodies may press its
/// core through a surface that it touches. Solids need no such care: contacts push a shape out of a solid again.
inline bool presses(const FastBody& fast, bool touching, ShapeKind other) {
  return fast.on_surface && touching && is_surface(other);
}

}  // namespace atl::collision
