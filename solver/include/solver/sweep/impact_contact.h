#pragma once

#include <solver/constraints/friction_ellipse.h>
#include <solver/integrate/body_table.h>
#include <solver/solver_settings.h>
#include <solver/sweep/contact_block.h>
#include <solver/sweep/impact_system.h>

#include <array>
#include <cstdint>
#include <span>

namespace atl::solver {

/// A contact some of whose points hit.
struct ImpactContact {
  struct Point {
    bool hits = false;     ///< meets in the substep
    bool bounces = false;  ///< and fast enough for that
    double x = 0, y = 0;   ///< m, from the centre along the tangents
    double mass = 0;       ///< kg, effective
    double closing = 0;    ///< m/s at which it parts before: negative
    double parting = 0;    ///< m/s at which it is to part, at least
    double impulse = 0;    ///< N s
  };

  struct Friction {
    double coefficient = 0;
    double radius = 0;                       ///< m, of the points about the centre
    double torsional = 0;                    ///< m
    FrictionEllipse ellipse;                 ///< in the tangents, by the coefficient
    std::array<double, 3> runs = {};         ///< m/s, of the surfaces along the tangents, rad/s about the normal
    std::array<double, 3> mass = {};         ///< kg, effective: 11, 12, 22
    double twist_mass = 0;                   ///< kg m^2
    std::array<double, 3> slip_before = {};  ///< m/s along the tangents, rad/s about the normal
    std::array<double, 3> impulse = {};      ///< N s, N m s, likewise
  };

  ImpactContact(std::uint32_t of_block, std::uint32_t of_lane, std::uint32_t of_first, std::uint32_t of_second)
      : block(of_block), lane(of_lane), first(of_first), second(of_second) {}

  std::uint32_t block, lane;
  std::uint32_t first, second;    ///< places of the bodies
  std::uint32_t set = 0;          ///< of what hits together
  std::array<Vector3, 3> axes;    ///< the normal and two tangents
  Vector3 arm_first, arm_second;  ///< m
  std::array<Point, collision::max_points> points;
  Friction friction;
  bool is_complete = false;  ///< bodies are where it is hit, and what it answers with is known
  double time = 0;           ///< s into the substep, at which it is hit
  double pulled = 0;         ///< m/s, that forces add to its speed of parting until then

  /// m/s.
  double parting_speed(const Point& point, const ImpactBody& of_first, const ImpactBody& of_second) const {
    return along_normal(point, of_first.velocity, of_first.spin, of_second.velocity, of_second.spin);
  }
  /// kg, with which they answer at a point.
  double mass_of(const Point& point, const ImpactBody& of_first, const ImpactBody& of_second) const {
    const auto response = [&](const ImpactBody& body, const Vector3& arm) {
      const Vector3 angular = arm.cross(axes[0]) + point.y * axes[1] - point.x * axes[2];
      return axes[0].dot(body.inverse_mass.cwiseProduct(axes[0])) + angular.dot(body.inverse_inertia * angular);
    };
    const double all = response(of_first, arm_first) + response(of_second, arm_second);
    return all > 0 ? 1 / all : 0;
  }
  /// m, that a point is farther open by where the bodies are to begin.
  double shift_at(const Point& point, const ImpactBody& of_first, const ImpactBody& of_second) const {
    return along_normal(point, of_first.shift, of_first.turn, of_second.shift, of_second.turn);
  }

 private:
  double along_normal(const Point& point, const Vector3& v1, const Vector3& w1, const Vector3& v2,
                      const Vector3& w2) const {
    const Vector3 spin = w2 - w1;
    return axes[0].dot(v2 + w2.cross(arm_second) - v1 - w1.cross(arm_first)) + point.y * axes[1].dot(spin) -
           point.x * axes[2].dot(spin);
  }
};

/// Bodies that may be hit, with the systems of those that joints hold.
struct ImpactBodies {
  std::span<ImpactBody> bodies;
  std::span<ImpactSystem> systems;
};

/// Finds the effective masses of a contact some of whose bodies answer with all that joints hold to them.
void weigh_joined(const ImpactBodies& bodies, ImpactContact& contact);

/// Finds the impulses of contacts that hit together and gives them to their bodies: 0 <= P, parting <= u, and P = 0
/// where u is more; friction is bound by P and acts against the slip that is left. `joined`: the systems of bodies that
/// joints hold; ends of their ranges push as contacts do. By projected Gauss-Seidel, but for rounding. Friction makes
/// no energy: all impulses are scaled to what the normal ones make.
void reflect(std::span<ImpactContact> contacts, const ImpactBodies& bodies, std::span<const std::uint32_t> joined,
             solver::Friction friction);

}  // namespace atl::solver
