#pragma once

#include <solver/integrate/body_table.h>

#include <array>
#include <vector>

namespace atl::solver {

/// The problem that the last substep's sweeps solved and their answer, before restitution, for the error audit. Groups
/// write the entries of their own bodies and contacts.
struct ContactCapture {
  struct Answer {
    double step = 0;                    ///< s, of what it is the answer to
    std::array<float, 3> anchor_first;  ///< m, world frame, from the centres of mass
    std::array<float, 3> anchor_second;
    std::array<float, 4> separation;      ///< m, as the sweeps saw it
    std::array<float, 4> normal_impulse;  ///< N s
    std::array<float, 3> friction_impulse;
    float torsional_impulse;                           ///< N m s
    std::array<float, 3> rolling_impulse = {0, 0, 0};  ///< N m s
    std::array<float, 3> normal;                       ///< as it was solved: the planes of faces turn
    std::array<float, 3> tangent;                      ///< the first
    /// True if it was solved in the plane that its bodies stay in, with two points on the tangent, and not by its
    /// manifold.
    bool planar = false;
    std::array<float, 2> x;  ///< m, of these
  };
  struct Motion {
    Vector3 free_velocity;  ///< after forces, before contact impulses
    Vector3 free_angular_velocity;
    Matrix3 inverse_inertia;  ///< world frame
  };

  std::vector<Answer> answers;  ///< by contact slot
  std::vector<Motion> motions;  ///< by body, of the dynamic ones that contacts touch

  void resize(std::size_t slots, std::size_t bodies) {
    answers.resize(slots);
    motions.resize(bodies);
  }
};

}  // namespace atl::solver
