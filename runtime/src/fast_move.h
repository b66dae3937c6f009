#pragma once

#include <collision/contacts/refresh.h>
#include <collision/shapes/pose.h>
#include <solver/integrate/motion.h>

#include <compare>
#include <cstdint>
#include <vector>

namespace atl {

/// How a body moved in a step in which it was fast.
struct FastMove {
  static constexpr std::uint32_t alone = ~std::uint32_t{0};

  std::uint32_t body;
  std::uint32_t assembly;  ///< of bodies that joints connect, or alone
  solver::BodyPose start;
  Vector3 shift;         ///< m, of the centre of mass
  double turn;           ///< m: no point of it got farther by turning
  double bulge;          ///< m: nor farther off the straight line from where it was to where it is
  bool rushed = false;   ///< it left its fat boxes
  bool queried = false;  ///< what is near it is asked of the tree

  collision::Pose start_pose() const { return {start.position, start.orientation}; }
};

/// A body that was not fast, but belongs to an assembly of which a body was.
struct Carried {
  std::uint32_t assembly;
  std::uint32_t body;
  collision::Pose start;
};

/// How near a body is put to what it met, as part of its inner radius: well within the margin in which a contact
/// has points. Sweeps end that near but for their tolerance, a part as well.
inline constexpr double stop_share = 0.25 * static_cast<double>(collision::margin_share);
inline constexpr double sweep_tolerance = 1e-3;

/// What is touched already is left to its contact, unless the core gets to it: the shape with this part of its
/// inner radius taken off.
inline constexpr double core_share = 0.5;

/// A collider of a fast body and one near it. In order, so that of several contacts of the two one that touches is
/// first.
struct Nearby {
  std::uint32_t own;
  std::uint32_t other;
  bool apart;  ///< they have no contact with points

  auto operator<=>(const Nearby&) const = default;
};

/// Something near a fast body, which goes by its number.
struct NearFast {
  std::uint32_t fast;
  Nearby nearby;
};

/// A contact of fast bodies, by its entry in the order of contacts. Numbers + 1, or 0.
struct FastContact {
  std::uint32_t entry;
  std::uint32_t fast_first;
  std::uint32_t fast_second;
};

/// Something that a fast body's shape may meet in the step.
struct Approach {
  std::uint32_t other;  ///< collider
  bool apart;           ///< they have no contact with points
  Vector3 shift;        ///< m, of the fast body against the other one
  double closing;       ///< m, how far their surfaces come towards each other at most
  double size;          ///< m, inner radius of the smaller shape
  bool passes_core;     ///< the shape's core is kept apart from it
};

/// A surface that a fast body's core touches as the step starts.
struct HeldBy {
  Vector3 normal;  ///< unit, from the core to the surface
  double excess;   ///< m, how far the core ends beyond it
  double slack;    ///< m, it is to end before the surface by a part of this
};

/// How far a fast body gets, or an assembly.
struct FastStop {
  double t = 1;                     ///< part of its motion
  Vector3 aside = Vector3::Zero();  ///< m, added to its end

  bool stops() const { return t < 1 || !aside.isZero(0); }
};

/// Memory of a worker that sweeps fast bodies.
struct FastSweep {
  std::vector<FastContact> contacts;
  std::vector<NearFast> near_fast;
  std::vector<Nearby> nearby;  // of one body
  std::vector<Approach> approaching;
  std::vector<HeldBy> held;
};

}  // namespace atl
