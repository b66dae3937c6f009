#pragma once

#include <jobs/arrays.h>
#include <jobs/compact_array.h>
#include <solver/integrate/body_table.h>
#include <solver/islands/islands.h>

#include <array>
#include <cstdint>
#include <span>

namespace atl::solver {

/// How far from their paths bodies get, in m a second, by how their acceleration changes from step to step: the error
/// of a method of second order is its step's square times the change of acceleration a second (Hairer, Norsett and
/// Wanner, "Solving Ordinary Differential Equations I", II.4; here with a difference in place of an embedded method's
/// second answer, which costs no second solve). Of points at the body's radius, so turning counts.
class MotionError {
 public:
  using Acceleration = std::array<float, 6>;  ///< m/s^2, of the centre of mass, and of points at the radius by turning

  bool is_empty() const { return acceleration_.empty(); }
  void forget_all();
  void forget(std::uint32_t body);
  /// Records the velocities of these bodies as a step begins.
  void begin(const BodyTable& bodies, std::span<const std::uint32_t> of);
  /// The error (m/s) of a body as the step ends after dt seconds, taken in substeps of `substep` seconds. The body was
  /// given to begin(). 0 in its first step.
  double end(const BodyTable& bodies, std::uint32_t body, double dt, double substep);

  /// The acceleration that is kept from step to step: see end().
  const Acceleration& acceleration(std::uint32_t body) const { return acceleration_[body]; }
  bool is_known(std::uint32_t body) const { return body < acceleration_.size() && acceleration_[body] != unknown; }
  void restore(std::uint32_t body, std::size_t bodies, const Acceleration& acceleration);

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(acceleration_, before_); }

 private:
  // Beyond what a body can have.
  static constexpr Acceleration unknown = {3e38f, 3e38f, 3e38f, 3e38f, 3e38f, 3e38f};

  static void check_members(MotionError& motion) {
    auto& [acceleration, /**/ before] = motion;
    static_cast<void>(acceleration);
  }

  jobs::CompactArray<Acceleration> acceleration_;  // by body, of the last step; empty while nobody asks
  jobs::CompactArray<Acceleration> before_;        // by body: velocities
};

}  // namespace atl::solver
