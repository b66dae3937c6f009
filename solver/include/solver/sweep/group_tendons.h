#pragma once

#include <jobs/arrays.h>
#include <solver/constraints/row_law.h>
#include <solver/constraints/tendon.h>
#include <solver/sweep/group_joints.h>
#include <solver/sweep/kernels.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace atl::solver {

/// The tendons of an island group whose joints are swept. They come after the joints in each sweep, in double and one
/// by one, since there are few. A tendon that would bounce at an end of its range stops there.
class GroupTendons {
 public:
  void clear() { tendons_.clear(); }
  /// `local(body)`: an index into SolverBodies.
  template <typename Local>
  void add(std::uint32_t tendon, const Joint* joints, const Local& local) {
    tendons_.push_back({.joint = tendon});
    for_each_term(joints, tendon, [&](const Joint& of) {
      tendons_.back().ends[tendons_.back().terms++] = {local(of.first), local(of.second)};
    });
  }
  bool empty() const { return tendons_.empty(); }

  /// The start of a step, with the impulses of the last.
  void begin_step(const JointStep& step);
  /// Laws, from the rates before the forces of the substep.
  void begin_substep(const JointStep& step);
  /// Applies a part of the impulses and keeps a part. `carried`: velocities have them already, along the rows before
  /// bodies moved.
  void warm_start(SolverBodies& bodies, double applied, double kept, bool carried);
  void clear_impulses();
  /// Updates tendons once bodies have moved.
  void move(const JointStep& step);
  /// Returns the largest change of a rate.
  float sweep(const JointStep& step, SolverBodies& bodies, Push push);
  /// Impulses, coordinates and forces, back to the joints. Bodies have their new poses.
  void store(const JointStep& step) const;

  bool has_forces(const JointStep& step) const {
    return std::any_of(tendons_.begin(), tendons_.end(),
                       [&](const Tendon& tendon) { return law_of(step, tendon).acts_as_force(); });
  }
  /// Calls act(body, impulse, angular impulse) for each body of tendons that act as forces.
  template <typename Act>
  void each_force(const JointStep& step, const Act& act) const {
    for (const Tendon& tendon : tendons_) {
      if (!law_of(step, tendon).acts_as_force()) continue;
      for (const PulledBody& body : tendon.pulled) {
        act(static_cast<std::int32_t>(body.body), tendon.impulse * body.linear, tendon.impulse * body.angular);
      }
    }
  }
  /// Scales impulses of all others by scale(body), of a body that moves.
  template <typename Scale>
  void scale_held(const JointStep& step, const Scale& scale) {
    for (Tendon& tendon : tendons_) {
      if (!law_of(step, tendon).acts_as_force()) tendon.impulse *= scale(static_cast<std::int32_t>(tendon.moving));
    }
  }

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(tendons_); }

 private:
  struct Ends {
    std::uint32_t first = 0, second = 0;  // in SolverBodies
  };
  struct Tendon {
    std::uint32_t joint = 0;
    std::size_t terms = 0;
    std::array<Ends, max_tendon_terms> ends = {};
    std::array<double, max_tendon_terms> position = {};  // of the coordinates of its terms
    PulledBodies pulled = {};
    PulledBodies pulled_before = {};  // by what is carried over
    double carried = 0;               // N s or N m s
    std::uint32_t moving = 0;         // a body that does
    double length = 0;
    double response = 0;  // J M^-1 J^T
    RowLaw law = {};
    double impulse = 0;  // N s or N m s
    double split = 0;    // likewise, of this substep
  };

  static const Law& law_of(const JointStep& step, const Tendon& tendon) { return step.joints[tendon.joint].law[0]; }
  static void place(const JointStep& step, Tendon& tendon);

  std::vector<Tendon> tendons_;
};

}  // namespace atl::solver
