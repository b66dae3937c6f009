#pragma once

#include <solver/sweep/contact_block.h>

#include <array>
#include <cstddef>
#include <cstdint>

namespace atl::solver {

/// The phases by which the time of a group is measured; see atoll/report.h.
enum class SolverPhase { Colour, Prepare, WarmStart, Solve, Relax, Integrate, Restitution, Store };
inline constexpr std::size_t solver_phase_count = 8;

struct GroupReport {
  std::size_t colours = 0;                               ///< of contacts or of joints, whichever has more
  std::size_t joints = 0;                                ///< all that act, however they are solved
  std::int64_t sweeps = 0;                               ///< over its contacts and joints
  std::array<double, solver_phase_count> phase_ms = {};  ///< with SolverSettings::profile
  ContactWork work;
  std::int64_t gyroscopic_bodies = 0;  ///< whose moments of inertia differ
  std::int64_t locked_bodies = 0;      ///< bodies that have motion locks
  bool friction = false;               ///< some contact has it
  bool restitution = false;
  bool surfaces = false;  ///< some surface runs, or holds back rolling or spinning
};

}  // namespace atl::solver
