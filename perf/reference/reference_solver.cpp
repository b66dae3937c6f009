#include "reference_solver.h"

#include <atoll/error.h>
#include <atoll/errors.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>

#include "contact_rows.h"
#include "gauss_seidel.h"
#include "newton.h"

namespace atl::reference {
namespace {

// Newton's method where it gets nearer, sweeps where it doesn't.
class Search {
 public:
  Search(const ContactProblem& problem, double tolerance)
      : rows_(problem), newton_(rows_), tolerance_(tolerance), solution_{.problem = problem} {
    impulses_ = rows_.impulses_of(problem);
  }

  ReferenceSolution run() {
    constexpr int rounds = 12;
    int sweeps = 50;
    solution_.residual = std::numeric_limits<double>::infinity();
    note();
    for (int round = 0; round < rounds && !solution_.solved; ++round) {
      sweep_gauss_seidel(rows_, impulses_, sweeps);
      solution_.sweeps += sweeps;
      sweeps = std::min(2 * sweeps, 5000);
      note();
      if (!solution_.solved) descend();
      if (!solution_.solved) leap();
    }
    return solution_;
  }

 private:
  // Keeps the impulses if they are the best so far.
  void note() {
    ContactProblem problem = solution_.problem;
    rows_.write(impulses_, problem);
    const double residual = measure_contact_residual(problem).relative;
    if (!(residual < solution_.residual)) return;
    solution_.problem = std::move(problem);
    solution_.residual = residual;
    solution_.solved = residual <= tolerance_;
  }

  // Newton steps with a line search on |F|, the proximal term heavier after a step that was cut short. Ends where no
  // step gets nearer.
  void descend() {
    constexpr int max_steps = 40;
    constexpr double lightest = 1e-9, heaviest = 1e2;
    double proximal = 1e-6;
    double error = newton_.error(impulses_);
    for (int i = 0; i < max_steps && !solution_.solved; ++i) {
      Eigen::VectorXd change;
      ++solution_.newton_steps;
      const double length = newton_.step(impulses_, proximal, change) ? search_line(change, error) : 0;
      if (length == 1) {
        proximal = std::max(lightest, 0.1 * proximal);
      } else if (length < 0.2) {
        proximal *= 100;
        if (proximal > heaviest) return;
      }
      if (length > 0) note();
    }
  }

  // Full Newton steps, whether |F| falls or not. Where four points carry a flat body whose gaps disagree in the last
  // digits, |F| is a plateau that ends only where a point lets go, and the way across it leads uphill.
  void leap() {
    constexpr int max_steps = 20;
    for (const double proximal : {1e-4, 1e-6, 1e-8, 1e-10}) {
      const Eigen::VectorXd start = impulses_;
      const double error = newton_.error(start);
      Eigen::VectorXd change;
      for (int i = 0; i < max_steps && !solution_.solved; ++i) {
        ++solution_.newton_steps;
        if (!newton_.step(impulses_, proximal, change)) break;
        impulses_ += change;
        note();
      }
      if (solution_.solved) return;
      if (!(newton_.error(impulses_) < error)) impulses_ = start;
    }
  }

  // Moves as far as |F| falls enough and returns how far: 0 if it doesn't.
  double search_line(const Eigen::VectorXd& change, double& error) {
    for (double length = 1; length > 0.01; length /= 2) {
      const Eigen::VectorXd there = impulses_ + length * change;
      const double error_there = newton_.error(there);
      if (!(error_there < (1 - 1e-3 * length) * error)) continue;
      impulses_ = there;
      error = error_there;
      return length;
    }
    return 0;
  }

  ContactRows rows_;
  NewtonSolver newton_;
  double tolerance_;
  ReferenceSolution solution_;
  Eigen::VectorXd impulses_;
};

}  // namespace

ReferenceSolution solve_contact_problem(const ContactProblem& problem, double tolerance) {
  for (const ContactProblem::Patch& patch : problem.patches) {
    if (patch.torsional_friction > 0 || patch.rolling_friction > 0 || !patch.slip.isZero(0) || !patch.spin.isZero(0) ||
        patch.friction_ratio != 1) {
      throw Error(
          "contact problem: found a patch with rolling, torsional or uneven friction or a running surface, expected "
          "plain friction");
    }
  }
  ReferenceSolution given{.problem = problem, .residual = measure_contact_residual(problem).relative};
  given.solved = given.residual <= tolerance;
  return given.solved ? given : Search(problem, tolerance).run();
}

std::vector<BodyVelocity> free_velocities(const ContactProblem& problem) {
  std::vector<BodyVelocity> velocities;
  for (const ContactProblem::Body& body : problem.bodies) {
    velocities.push_back({body.free_velocity, body.free_angular_velocity});
  }
  return velocities;
}

std::vector<BodyVelocity> velocities_after(const ContactProblem& problem) {
  std::vector<BodyVelocity> velocities = free_velocities(problem);
  for (const ContactProblem::Patch& patch : problem.patches) {
    Vector3 impulse = patch.friction_impulse;
    Vector3 moment = patch.torsional_impulse * patch.normal;  // about the centre
    for (const ContactProblem::Point& point : patch.points) {
      const Vector3 arm = point.x * patch.tangent + point.y * patch.normal.cross(patch.tangent);
      impulse += point.impulse * patch.normal;
      moment += arm.cross(point.impulse * patch.normal);
    }
    const auto push = [&](std::size_t index, const Vector3& anchor, double sign) {
      if (index == ContactProblem::fixed) return;
      const ContactProblem::Body& body = problem.bodies[index];
      velocities[index].linear += sign * body.inverse_mass * body.free_axes.cwiseProduct(impulse);
      velocities[index].angular += sign * (body.inverse_inertia * (anchor.cross(impulse) + moment));
    };
    push(patch.first, patch.anchor_first, -1);
    push(patch.second, patch.anchor_second, 1);
  }
  return velocities;
}

double energy_distance(const ContactProblem& problem, const std::vector<BodyVelocity>& a,
                       const std::vector<BodyVelocity>& b) {
  double sum = 0;
  for (std::size_t i = 0; i < problem.bodies.size(); ++i) {
    const ContactProblem::Body& body = problem.bodies[i];
    if (body.inverse_mass == 0) continue;
    const Vector3 spin = a[i].angular - b[i].angular;
    sum += (a[i].linear - b[i].linear).squaredNorm() / body.inverse_mass;
    if (!body.inverse_inertia.isZero(0)) sum += spin.dot(body.inverse_inertia.inverse() * spin);
  }
  return std::sqrt(sum);
}

double velocity_error(const ContactProblem& problem, const ReferenceSolution& solution) {
  const std::vector<BodyVelocity> exact = velocities_after(solution.problem);
  const double distance = energy_distance(problem, velocities_after(problem), exact);
  if (distance == 0) return 0;
  return distance / energy_distance(problem, exact, free_velocities(problem));
}

}  // namespace atl::reference
