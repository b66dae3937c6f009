#include <atoll/error.h>
#include <atoll/errors.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "friction_cone.h"

namespace atl {
namespace {

using audit::PatchVector;

struct Velocity {
  Vector3 linear = Vector3::Zero();
  Vector3 angular = Vector3::Zero();
};

[[noreturn]] void refuse(std::size_t patch, const std::string& found) {
  throw Error("contact problem: patch " + std::to_string(patch) + ": " + found);
}

// m, by which angular impulses about the normal are divided.
double torsional_arm(const ContactProblem::Patch& patch) { return patch.radius + patch.torsional_friction; }

audit::FrictionBounds bounds_of(const ContactProblem::Patch& patch) {
  const double arm = torsional_arm(patch);
  return {.tangential = patch.friction,
          .torsional = arm > 0 ? (patch.friction * patch.radius + patch.torsional_friction) / arm : 0,
          .rolling = patch.rolling_friction > 0 ? 1.0 : 0.0};  // their arm is the bound
}

void check(const ContactProblem& problem) {
  if (!problem.patches.empty() && !(problem.substep > 0)) {
    throw Error("contact problem: substep: found " + std::to_string(problem.substep) + ", expected a time > 0");
  }
  for (std::size_t i = 0; i < problem.patches.size(); ++i) {
    const ContactProblem::Patch& patch = problem.patches[i];
    for (const std::size_t body : {patch.first, patch.second}) {
      if (body == ContactProblem::fixed || body < problem.bodies.size()) continue;
      refuse(i, "found body " + std::to_string(body) + ", expected one of " + std::to_string(problem.bodies.size()) +
                    " or fixed");
    }
    if (patch.points.empty() || patch.points.size() > 4) {
      refuse(i, "found " + std::to_string(patch.points.size()) + " points, expected 1 to 4");
    }
    if (!(patch.friction >= 0)) {
      refuse(i, "found friction " + std::to_string(patch.friction) + ", expected a number >= 0");
    }
    const auto check_length = [&](const char* name, double value) {
      if (!(value >= 0))
        refuse(i, std::string("found ") + name + " " + std::to_string(value) + " m, expected a length >= 0");
    };
    if (!(patch.friction_ratio > 0 && patch.friction_ratio <= 1)) {
      refuse(i, "found a friction ratio of " + std::to_string(patch.friction_ratio) + ", expected one in (0, 1]");
    }
    check_length("radius", patch.radius);
    check_length("torsional friction", patch.torsional_friction);
    check_length("rolling friction", patch.rolling_friction);
    if (torsional_arm(patch) == 0 && patch.torsional_impulse != 0) {
      refuse(i, "found a torsional impulse of " + std::to_string(patch.torsional_impulse) +
                    " N m s with neither a radius nor torsional friction, expected 0");
    }
    if (patch.rolling_friction == 0 && !patch.rolling_impulse.isZero(0)) {
      refuse(i, "found a rolling impulse of " + std::to_string(patch.rolling_impulse.norm()) +
                    " N m s without rolling friction, expected 0");
    }
  }
}

// One patch with its bodies. Velocities are of the second body against the first.
class Rows {
 public:
  Rows(const ContactProblem& problem, const ContactProblem::Patch& patch)
      : patch_(patch),
        tangents_{patch.tangent, patch.normal.cross(patch.tangent)},
        sliding_{tangents_[0], tangents_[1]} {
    if (!patch.friction_axis.isZero(0)) {
      sliding_[0] = patch.friction_axis;
      sliding_[1] = patch.friction_ratio * patch.normal.cross(patch.friction_axis);
    }
    if (patch.first != ContactProblem::fixed) first_ = &problem.bodies[patch.first];
    if (patch.second != ContactProblem::fixed) second_ = &problem.bodies[patch.second];
  }

  // Adds M^-1 J^T r.
  void accelerate(std::vector<Velocity>& velocities) const {
    Vector3 impulse = patch_.friction_impulse;
    Vector3 angular = patch_.torsional_impulse * patch_.normal + patch_.rolling_impulse;
    for (const ContactProblem::Point& point : patch_.points) {
      impulse += point.impulse * patch_.normal;
      angular += arm(point).cross(point.impulse * patch_.normal);
    }
    const auto add = [&](const ContactProblem::Body* body, std::size_t index, const Vector3& anchor, double sign) {
      if (body == nullptr) return;
      velocities[index].linear += sign * body->inverse_mass * body->free_axes.cwiseProduct(impulse);
      velocities[index].angular += sign * (body->inverse_inertia * (anchor.cross(impulse) + angular));
    };
    add(first_, patch_.first, patch_.anchor_first, -1);
    add(second_, patch_.second, patch_.anchor_second, 1);
  }

  PatchVector velocity(const std::vector<Velocity>& velocities) const {
    const Velocity first = first_ == nullptr ? Velocity{} : velocities[patch_.first];
    const Velocity second = second_ == nullptr ? Velocity{} : velocities[patch_.second];
    const Vector3 at_centre = second.linear + second.angular.cross(patch_.anchor_second) - first.linear -
                              first.angular.cross(patch_.anchor_first);
    const Vector3 spin = second.angular - first.angular;
    const Vector3 sliding = at_centre + patch_.slip, turning = spin + patch_.spin;
    PatchVector u{.points = patch_.points.size(),
                  .tangential = {sliding_[0].dot(sliding), sliding_[1].dot(sliding)},
                  .torsional = torsional_arm(patch_) * patch_.normal.dot(turning),
                  .rolling = patch_.rolling_friction * along_tangents(turning)};
    for (std::size_t i = 0; i < u.points; ++i) {
      u.normal[i] = patch_.normal.dot(at_centre + spin.cross(arm(patch_.points[i])));
    }
    return u;
  }

  PatchVector impulse() const {
    PatchVector r{.points = patch_.points.size(),
                  .tangential = {sliding_[0].dot(patch_.friction_impulse),
                                 sliding_[1].dot(patch_.friction_impulse) / sliding_[1].squaredNorm()},
                  .torsional = per_arm(patch_.torsional_impulse, torsional_arm(patch_)),
                  .rolling = {per_arm(tangents_[0].dot(patch_.rolling_impulse), patch_.rolling_friction),
                              per_arm(tangents_[1].dot(patch_.rolling_impulse), patch_.rolling_friction)}};
    for (std::size_t i = 0; i < r.points; ++i) r.normal[i] = patch_.points[i].impulse;
    return r;
  }

  // Harmonic mean of the rows' effective masses, kg; infinite where nothing can move.
  double effective_mass() const {
    double sum = 0, rows = 0;
    const auto add = [&](const Vector3& direction, const Vector3& arm, double scale) {
      sum += scale * (response(first_, direction, patch_.anchor_first + arm) +
                      response(second_, direction, patch_.anchor_second + arm));
      rows += 1;
    };
    for (const ContactProblem::Point& point : patch_.points) add(patch_.normal, arm(point), 1);
    const auto add_turn = [&](const Vector3& axis, double arm) {
      for (const ContactProblem::Body* body : {first_, second_}) {
        if (body != nullptr) sum += arm * arm * axis.dot(body->inverse_inertia * axis);
      }
      rows += 1;
    };
    const audit::FrictionBounds bounds = bounds_of(patch_);
    if (bounds.tangential > 0) {
      for (const Vector3& tangent : tangents_) add(tangent, Vector3::Zero(), 1);
    }
    if (bounds.torsional > 0) add_turn(patch_.normal, torsional_arm(patch_));
    if (bounds.rolling > 0) {
      for (const Vector3& tangent : tangents_) add_turn(tangent, patch_.rolling_friction);
    }
    return rows / sum;
  }

 private:
  Eigen::Vector2d along_tangents(const Vector3& v) const { return {tangents_[0].dot(v), tangents_[1].dot(v)}; }
  static double per_arm(double angular, double arm) { return arm > 0 ? angular / arm : 0; }
  Vector3 arm(const ContactProblem::Point& point) const { return point.x * tangents_[0] + point.y * tangents_[1]; }

  static double response(const ContactProblem::Body* body, const Vector3& direction, const Vector3& anchor) {
    if (body == nullptr) return 0;
    const Vector3 moment = anchor.cross(direction);
    const double locked = direction.cwiseAbs2().dot(Vector3::Ones() - body->free_axes);
    return body->inverse_mass * (1 - locked) + moment.dot(body->inverse_inertia * moment);
  }

  const ContactProblem::Patch& patch_;
  Vector3 tangents_[2];
  Vector3 sliding_[2];  // in which the bound of friction is a disc
  const ContactProblem::Body* first_ = nullptr;
  const ContactProblem::Body* second_ = nullptr;
};

// Closing as much of the gap as is there is no approach.
void allow_gaps(PatchVector& u, const ContactProblem::Patch& patch, double substep) {
  const double h = patch.step > 0 ? patch.step : substep;
  for (std::size_t i = 0; i < u.points; ++i) u.normal[i] += std::max(0.0, patch.points[i].gap) / h;
}

// In m/s.
double natural_map(const Rows& rows, const PatchVector& u, const audit::FrictionBounds& friction) {
  const double mass = rows.effective_mass();
  if (!std::isfinite(mass)) return 0;
  // De Saxce and Feng's correction makes sliding along the cone normal to it.
  const double correction = friction.tangential * u.tangential.norm() + friction.torsional * std::abs(u.torsional) +
                            friction.rolling * u.rolling.norm();
  const PatchVector r = rows.impulse();
  PatchVector z = r;
  for (std::size_t i = 0; i < z.points; ++i) z.normal[i] -= mass * (u.normal[i] + correction);
  z.tangential -= mass * u.tangential;
  z.torsional -= mass * u.torsional;
  z.rolling -= mass * u.rolling;
  return std::sqrt((r - audit::project_on_cone(z, friction)).squared_norm()) / mass;
}

// Square of the speeds at the rows of a patch some point of which would close without impulses.
double square_within_reach(const PatchVector& u, const audit::FrictionBounds& friction) {
  double closing = 0;
  for (std::size_t i = 0; i < u.points; ++i) closing += std::pow(std::min(0.0, u.normal[i]), 2);
  if (closing == 0) return closing;
  if (friction.tangential > 0) closing += u.tangential.squaredNorm();
  if (friction.torsional > 0) closing += u.torsional * u.torsional;
  if (friction.rolling > 0) closing += u.rolling.squaredNorm();
  return closing;
}

}  // namespace

ResidualReport measure_contact_residual(const ContactProblem& problem) {
  check(problem);
  std::vector<Velocity> free, after;
  for (const ContactProblem::Body& body : problem.bodies) {
    free.push_back({body.free_velocity, body.free_angular_velocity});
  }
  after = free;
  for (const ContactProblem::Patch& patch : problem.patches) Rows(problem, patch).accelerate(after);

  ResidualReport report;
  double sum = 0, free_scale = 0, response_scale = 0;
  for (std::size_t i = 0; i < problem.patches.size(); ++i) {
    const ContactProblem::Patch& patch = problem.patches[i];
    const Rows rows(problem, patch);
    PatchVector u_free = rows.velocity(free);
    PatchVector u = rows.velocity(after);
    const double change = (u - u_free).squared_norm();
    response_scale += change;
    report.change_by_patch.push_back(std::sqrt(change));
    allow_gaps(u_free, patch, problem.substep);
    allow_gaps(u, patch, problem.substep);
    const double within_reach = square_within_reach(u_free, bounds_of(patch));
    free_scale += within_reach;
    report.free_by_patch.push_back(std::sqrt(within_reach));

    const double residual = natural_map(rows, u, bounds_of(patch));
    report.by_patch.push_back(residual);
    sum += residual * residual;
    if (residual > report.worst) {
      report.worst = residual;
      report.worst_patch = i;
    }
  }
  report.absolute = std::sqrt(sum);
  // If nothing would close without impulses, none should act: errors are then relative to the velocities that they
  // cause.
  const double scale = free_scale > 0 ? free_scale : response_scale;
  if (scale > 0) report.relative = std::sqrt(sum / scale);
  return report;
}

}  // namespace atl
