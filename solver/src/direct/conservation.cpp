#include "direct/conservation.h"

#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

#include "direct/island_joints.h"
#include "integrate/matrix3.h"

namespace atl::solver {
namespace {

// Calls visit(number in the problem, body) with the ends of a joint, those of the joints that a tendon runs over too.
template <typename Visit>
bool all_ends(const DirectJoint& joint, const Visit& visit) {
  return visit(joint.first, joint.first_body) && visit(joint.second, joint.second_body) &&
         std::all_of(joint.term.begin(), joint.term.begin() + joint.terms, [&](const DirectTerm& term) {
           return visit(term.first, term.first_body) && visit(term.second, term.second_body);
         });
}

// A gear's bearings are elsewhere, and hold it, as motion locks hold a body.
bool floats(const Joint* joints, const IslandProblem& problem) {
  if (has_locks(problem)) return false;
  return std::all_of(problem.joints.begin(), problem.joints.end(), [&](const DirectJoint& joint) {
    const Joint& of = joints[joint.joint];
    return all_ends(joint, [](std::uint32_t number, std::uint32_t) { return number != no_body; }) &&
           std::none_of(of.coordinate.begin(), of.coordinate.begin() + of.rows, is_geared);
  });
}

bool stands(const BodyTable& table, std::uint32_t body) {
  return table.velocity(body).isZero(0) && table.angular_velocity(body).isZero(0);
}

// Tells joints that only hold, and turn rotors.
bool keep_energy(const Joint* joints, const IslandProblem& problem) {
  return std::all_of(problem.joints.begin(), problem.joints.end(), [&](const DirectJoint& joint) {
    const Joint& of = joints[joint.joint];
    return std::all_of(of.law.begin(), of.law.begin() + of.rows, [](const Law& law) {
      return law.locked() || !(law.limited() || law.drives() || law.springs() || law.friction > 0);
    });
  });
}

// Tells if bodies move as joints let them: who has been struck since the last step loses energy to them.
bool move_as_joined(const Joint* joints, const IslandProblem& problem) {
  double square = 0, square_of_spin = 0, radius = 0;
  for (std::size_t i = 0; i < problem.bodies.size(); ++i) {
    square = std::max(square, linear_part(problem.velocity, i).squaredNorm());
    square_of_spin = std::max(square_of_spin, angular_part(problem.velocity, i).squaredNorm());
    radius = std::max(radius, problem.bodies[i].radius);
  }
  const double max_spin = tuning::max_parting * std::sqrt(square_of_spin);
  const double max = tuning::max_parting * std::sqrt(square) + radius * max_spin;
  for (const DirectJoint& joint : problem.joints) {
    DirectJoint::Rows<double> rates;
    joint.rates_by(problem.velocity.data(), rates.data());
    for (std::size_t r = 0; r < joint.rows; ++r) {
      const bool turns = r >= joint.point_rows() && joint.at[r].linear.isZero(0);
      if (std::abs(rates[r]) > (turns ? max_spin : max) && law_of(joints[joint.joint], r).locked()) return false;
    }
  }
  return true;
}

// Tells islands that only forces on their bodies give energy or take it, but for what joints do.
bool is_closed(const SolveInput& input, const IslandProblem& problem) {
  const BodyTable& table = input.bodies;
  for (const DirectBody& body : problem.bodies) {
    if (table.linear_damping[body.body] != 0 || table.angular_damping[body.body] != 0) return false;
  }
  return std::all_of(problem.joints.begin(), problem.joints.end(), [&](const DirectJoint& joint) {
    return all_ends(joint,
                    [&](std::uint32_t number, std::uint32_t body) { return number != no_body || stands(table, body); });
  });
}

double mass_of(const IslandProblem& problem) {
  double sum = 0;
  for (const DirectBody& body : problem.bodies) sum += body.mass;
  return sum;
}

Vector3 centre_of_mass(const IslandProblem& problem, std::span<const MovingBody> bodies) {
  const Vector3 origin = bodies.front().now.position;
  Vector3 sum = Vector3::Zero();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    sum += problem.bodies[i].mass * (bodies[i].now.position - origin);
  }
  return origin + sum / mass_of(problem);
}

Vector3 angular_momentum(const IslandProblem& problem, std::span<const MovingBody> bodies, const Vector3& about,
                         const std::vector<double>& velocity) {
  Vector3 sum = Vector3::Zero();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Vector3 spin = angular_part(velocity, i);
    sum += (bodies[i].now.position - about).cross(problem.bodies[i].mass * linear_part(velocity, i));
    sum += product(bodies[i].inertia, spin);
  }
  return sum;
}

double energy_of_rotors(const Joint* joints, const IslandProblem& problem) {
  double sum = 0;
  for (const DirectJoint& joint : problem.joints) {
    for (std::size_t r = joint.point_rows(); r < joint.rows; ++r) {
      const Law& law = law_of(joints[joint.joint], r);
      if (law.armature == 0) continue;
      const double rate = joint.rate_by(problem.velocity, r, joint.given[r]);
      sum += 0.5 * law.armature * rate * rate;
    }
  }
  return sum;
}

// J, of the forces on bodies, which are what they are for all of the step.
double work_of_forces(const SolveInput& input, const IslandProblem& problem, std::span<const MovingBody> bodies) {
  double sum = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const MovingBody& body = bodies[i];
    sum += problem.bodies[i].mass * body.acceleration.dot(body.now.position - body.start.position);
    const Vector3 torque = input.bodies.torque(problem.bodies[i].body);
    if (torque.isZero(0)) continue;
    const Eigen::AngleAxisd turn(body.now.orientation * body.start.orientation.conjugate());
    sum += turn.angle() * torque.dot(turn.axis());
  }
  return sum;
}

// The motion of the whole as one body.
struct Drift {
  Vector3 centre, velocity, spin;
  double energy;  // J
};

Drift drift_of(const IslandProblem& problem, std::span<const MovingBody> bodies, const Matrix3& inertia,
               const Vector3& centre) {
  Drift drift{centre, Vector3::Zero(), Vector3::Zero(), 0};
  const double mass = mass_of(problem);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    drift.velocity += problem.bodies[i].mass * linear_part(problem.velocity, i);
  }
  drift.velocity /= mass;
  const Vector3 momentum = angular_momentum(problem, bodies, centre, problem.velocity);
  drift.spin = product(symmetric_inverse(inertia), momentum);
  drift.energy = 0.5 * (mass * drift.velocity.squaredNorm() + drift.spin.dot(momentum));
  return drift;
}

// kg m^2, of all bodies as one.
Matrix3 inertia_about(const Vector3& centre, const IslandProblem& problem, std::span<const MovingBody> bodies) {
  Matrix3 sum = Matrix3::Zero();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Vector3 arm = bodies[i].now.position - centre;
    sum +=
        bodies[i].inertia + problem.bodies[i].mass * (arm.squaredNorm() * Matrix3::Identity() - arm * arm.transpose());
  }
  return sum;
}

}  // namespace

double kinetic_energy(std::span<const MovingBody> bodies, const IslandProblem& problem,
                      const std::vector<double>& velocity) {
  double sum = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Vector3 spin = angular_part(velocity, i);
    sum += problem.bodies[i].mass * linear_part(velocity, i).squaredNorm() + spin.dot(product(bodies[i].inertia, spin));
  }
  return 0.5 * sum;
}

Conservation::Conservation(const SolveInput& input, const RowKinds& rows, const IslandProblem& problem,
                           std::span<const MovingBody> bodies)
    : all_locked_(rows.all_locked),
      floats_(floats(input.joints, problem)),
      keeps_energy_((all_locked_ || keep_energy(input.joints, problem)) && is_closed(input, problem) &&
                    move_as_joined(input.joints, problem)) {
  if (floats_) {
    about_ = centre_of_mass(problem, bodies);
    momentum_ = angular_momentum(problem, bodies, about_, problem.velocity);
  }
  if (keeps_energy_) {
    energy_ =
        kinetic_energy(bodies, problem, problem.velocity) + (all_locked_ ? 0 : energy_of_rotors(input.joints, problem));
  }
}

void Conservation::add_forces(const IslandProblem& problem, std::span<const MovingBody> bodies) {
  if (!floats_) return;
  momentum_ += angular_momentum(problem, bodies, about_, problem.free) -
               angular_momentum(problem, bodies, about_, problem.velocity);
}

void Conservation::restore(const SolveInput& input, std::span<const MovingBody> bodies, bool resolved,
                           IslandProblem& problem) const {
  const bool scales = keeps_energy_ && resolved;
  if (!floats_ && !scales) return;
  Drift drift{Vector3::Zero(), Vector3::Zero(), Vector3::Zero(), 0};
  if (floats_) {
    const Vector3 centre = centre_of_mass(problem, bodies);
    const Matrix3 inertia = inertia_about(centre, problem, bodies);
    const Vector3 lacking = momentum_ - angular_momentum(problem, bodies, about_, problem.velocity);
    const Vector3 turn = product(symmetric_inverse(inertia), lacking);
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      linear_part(problem.velocity, i) += turn.cross(bodies[i].now.position - centre);
      angular_part(problem.velocity, i) += turn;
    }
    if (scales) drift = drift_of(problem, bodies, inertia, centre);
  }
  if (!scales) return;
  const double rotors = all_locked_ ? 0 : energy_of_rotors(input.joints, problem);
  const double moving = kinetic_energy(bodies, problem, problem.velocity) + rotors - drift.energy;
  const double right = energy_ + work_of_forces(input, problem, bodies) - drift.energy;
  if (!(moving > tuning::min_energy * mass_of(problem))) return;
  const double square = std::clamp(right / moving, 1 - tuning::max_energy_restored, 1 + tuning::max_energy_restored);
  const double factor = std::sqrt(square);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Vector3 velocity = drift.velocity + drift.spin.cross(bodies[i].now.position - drift.centre);
    linear_part(problem.velocity, i) = velocity + factor * (linear_part(problem.velocity, i) - velocity);
    angular_part(problem.velocity, i) = drift.spin + factor * (angular_part(problem.velocity, i) - drift.spin);
  }
}

}  // namespace atl::solver
