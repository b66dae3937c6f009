#pragma once

#include <jobs/arrays.h>
#include <solver/direct/solve_input.h>
#include <solver/integrate/solver_bodies.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace atl::solver {

/// The bodies of an island group under numbers of its own: 0 stands for every fixed body, then come the kinematic
/// bodies that its contacts touch or joints join, in order, then the islands' dynamic ones.
class GroupBodies {
 public:
  void collect(const SolveInput& input, const IslandGroup& group);

  /// The group's own number of a body, an index into SolverBodies.
  std::uint32_t local(const SolveInput& input, const IslandGroup& group, std::uint32_t body) const;
  std::span<const std::uint32_t> kinematic() const { return kinematic_; }
  /// The number of the first dynamic body, and the end of the numbers.
  std::uint32_t first_dynamic() const { return first_dynamic_; }
  std::uint32_t count() const { return count_; }

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(kinematic_); }

 private:
  std::vector<std::uint32_t> kinematic_;
  std::uint32_t first_dynamic_ = 1;
  std::uint32_t count_ = 1;
};

inline std::uint32_t GroupBodies::local(const SolveInput& input, const IslandGroup& group, std::uint32_t body) const {
  switch (input.bodies.mobility[body]) {
    case Mobility::Fixed:
      return 0;
    case Mobility::Kinematic:
      return 1 + static_cast<std::uint32_t>(std::lower_bound(kinematic_.begin(), kinematic_.end(), body) -
                                            kinematic_.begin());
    case Mobility::Dynamic:
      break;
  }
  return first_dynamic_ + input.islands.rank(body) - input.islands.first_rank(group.begin);
}

// Rows of SolverBodies, which were reset, as the step begins.

/// m/s, by the group's numbers: the fastest that what touches a body moves against it. Empty where no body of the world
/// is one that contacts may see heavier.
std::vector<double> approach_speeds(const SolveInput& input, const IslandGroup& group, const GroupBodies& numbers);

/// Loads the group's dynamic bodies [begin, end). The first of the group has the number `first_dynamic`.
void load_bodies(const SolveInput& input, std::span<const std::uint32_t> bodies, std::size_t begin, std::size_t end,
                 std::uint32_t first_dynamic, std::span<const double> approaches, SolverBodies& rows);
void load_kinematic_bodies(const SolveInput& input, std::span<const std::uint32_t> kinematic, SolverBodies& rows);
/// Part of the sum of its moments that a body's least one is raised by where it is less, in sweeps of joints. Rounding
/// the inverse to single precision then changes no moment by more than 1%. Four needles of 1:10^4 on joints came
/// apart with less, at 1e-6 by 6 m within 10 s; at 1e-5 gaps are those of rods of 1:100.
inline constexpr double swept_share = 1e-5;

/// The inertia of a body in an orientation, and what else counts as such (kg m^2, world frame), as sweeps of joints
/// take it.
Matrix3 resolved_inertia(const BodyTable& bodies, std::uint32_t body, const Quaternion& orientation,
                         const Matrix3& added);
/// 1/(kg m^2), world frame.
void set_inverse_inertia(SolverBodies& rows, std::size_t local, const Matrix3& inverse);

}  // namespace atl::solver
