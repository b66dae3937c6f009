#include "direct/floating_momentum.h"

#include <algorithm>

#include "integrate/matrix3.h"

namespace atl::solver {
namespace {

bool floats(const Joint* joints, const IslandProblem& problem) {
  return std::all_of(problem.joints.begin(), problem.joints.end(), [&](const DirectJoint& joint) {
    const Joint& of = joints[joint.joint];
    return joint.first != no_body && joint.second != no_body &&
           std::none_of(of.coordinate.begin(), of.coordinate.begin() + of.rows, is_geared);
  });
}

Vector3 centre_of_mass(const IslandProblem& problem, std::span<const MovingBody> bodies) {
  const Vector3 origin = bodies.front().now.position;
  Vector3 sum = Vector3::Zero();
  double mass = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    sum += problem.bodies[i].mass * (bodies[i].now.position - origin);
    mass += problem.bodies[i].mass;
  }
  return origin + sum / mass;
}

// kg m^2, world frame: bodies may have moved since they had it last.
Matrix3 inertia_of(const MovingBody& body) {
  const Matrix3 rotation = body.now.orientation.toRotationMatrix();
  return symmetric_product(product(rotation, body.body_inertia), rotation);
}

Vector3 angular_momentum(const IslandProblem& problem, std::span<const MovingBody> bodies, const Vector3& about,
                         const std::vector<double>& velocity) {
  Vector3 sum = Vector3::Zero();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    sum += (bodies[i].now.position - about).cross(problem.bodies[i].mass * linear_part(velocity, i));
    const Vector3 spin = angular_part(velocity, i);
    sum += product(inertia_of(bodies[i]), spin);
  }
  return sum;
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

FloatingMomentum::FloatingMomentum(const Joint* joints, const IslandProblem& problem,
                                   std::span<const MovingBody> bodies)
    : floats_(floats(joints, problem)) {
  if (!floats_) return;
  about_ = centre_of_mass(problem, bodies);
  momentum_ = angular_momentum(problem, bodies, about_, problem.velocity);
}

void FloatingMomentum::add_forces(const IslandProblem& problem, std::span<const MovingBody> bodies) {
  if (!floats_) return;
  momentum_ += angular_momentum(problem, bodies, about_, problem.free) -
               angular_momentum(problem, bodies, about_, problem.velocity);
}

void FloatingMomentum::restore(std::span<const MovingBody> bodies, IslandProblem& problem) const {
  if (!floats_) return;
  const Vector3 lacking = momentum_ - angular_momentum(problem, bodies, about_, problem.velocity);
  const Vector3 centre = centre_of_mass(problem, bodies);
  const Vector3 turn = product(symmetric_inverse(inertia_about(centre, problem, bodies)), lacking);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    linear_part(problem.velocity, i) += turn.cross(bodies[i].now.position - centre);
    angular_part(problem.velocity, i) += turn;
  }
}

}  // namespace atl::solver
