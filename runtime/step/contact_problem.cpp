#include <atoll/errors.h>
#include <jobs/assert.h>
#include <solver/integrate/motion_locks.h>

#include <cmath>

#include "step/results.h"

namespace atl {
namespace {

template <typename Floats>
Vector3 vector(const Floats& v) {
  return {v[0], v[1], v[2]};
}

}  // namespace

ContactProblem contact_problem(const Stores& world, std::span<const solver::TouchingPair> touching,
                               const solver::ContactCapture& capture, double substep) {
  ContactProblem problem;
  problem.substep = substep;

  std::vector<std::size_t> place(world.bodies.size(), ContactProblem::fixed);
  const auto place_of = [&](std::uint32_t body) {
    if (world.bodies.mobility[body] == solver::Mobility::Fixed || place[body] != ContactProblem::fixed)
      return place[body];
    ContactProblem::Body entry{.index = body};
    if (world.bodies.mobility[body] == solver::Mobility::Dynamic) {
      const solver::ContactCapture::Motion& motion = capture.motions[body];
      entry.inverse_mass = world.bodies.inverse_mass[body];
      entry.free_axes = solver::without(solver::linear_locks(world.bodies.locks[body]), Vector3::Ones());
      entry.inverse_inertia = motion.inverse_inertia;
      entry.free_velocity = motion.free_velocity;
      entry.free_angular_velocity = motion.free_angular_velocity;
    } else {
      entry.free_velocity = world.bodies.velocity(body);
      entry.free_angular_velocity = world.bodies.angular_velocity(body);
    }
    problem.bodies.push_back(entry);
    return place[body] = problem.bodies.size() - 1;
  };

  for (const solver::TouchingPair& pair : touching) {
    const collision::ContactManifold& manifold = world.cache.manifolds[pair.slot];
    const solver::ContactCapture::Answer& answer = capture.answers[pair.slot];
    // Makes the axes orthonormal in double precision, since the solver's are so in single precision only.
    const Vector3 normal = vector(answer.normal).normalized();
    const Vector3 first_tangent = vector(answer.tangent);
    const Vector3 tangent = (first_tangent - normal.dot(first_tangent) * normal).normalized();
    const Vector3 friction = vector(answer.friction_impulse);
    ContactProblem::Patch patch{.first = place_of(pair.first),
                                .second = place_of(pair.second),
                                .normal = normal,
                                .tangent = tangent,
                                .anchor_first = vector(answer.anchor_first),
                                .anchor_second = vector(answer.anchor_second),
                                .friction = manifold.friction,
                                .radius = manifold.friction_radius,
                                .friction_impulse = friction - normal.dot(friction) * normal,
                                .torsional_impulse = answer.torsional_impulse,
                                .step = answer.step == substep ? 0 : answer.step};
    ATL_ASSERT(patch.first != patch.second, pair.slot, pair.first, pair.second);
    if (!world.surface_contacts.empty()) {
      const solver::SurfaceContact& surface = world.surface_contacts[pair.slot];
      const Vector3 rolling = vector(answer.rolling_impulse);
      patch.torsional_friction = surface.torsional_friction;
      patch.rolling_friction = surface.rolling_friction;
      patch.slip = vector(surface.slip);
      patch.spin = vector(surface.spin);
      if (solver::is_uneven(surface)) {
        const Vector3 grip = vector(surface.grip);
        patch.friction *= grip.norm();
        patch.radius *= surface.twist / grip.norm();
        patch.friction_axis = (grip - normal.dot(grip) * normal).normalized();
        patch.friction_ratio = surface.ratio;
      }
      patch.rolling_impulse = rolling - normal.dot(rolling) * normal;
    }
    if (answer.planar) {
      for (std::size_t i = 0; i < answer.x.size(); ++i) {
        if (!(answer.separation[i] < collision::no_point)) continue;
        patch.points.push_back({answer.x[i], 0, answer.separation[i], answer.normal_impulse[i]});
      }
      if (!patch.points.empty()) problem.patches.push_back(std::move(patch));
      continue;
    }
    for (std::size_t i = 0; i < world.cache.contacts[pair.slot].count; ++i) {
      if (manifold.separation[i] >= collision::no_point) continue;  // switched off
      patch.points.push_back({manifold.x[i], manifold.y[i], answer.separation[i], answer.normal_impulse[i]});
    }
    problem.patches.push_back(std::move(patch));
  }
  return problem;
}

std::vector<double> island_residuals(const ContactProblem& problem, const solver::Islands& islands) {
  struct Sums {
    double residual = 0, free = 0, change = 0;
  };
  const ResidualReport report = measure_contact_residual(problem);
  ATL_ASSERT(report.by_patch.size() == problem.patches.size(), report.by_patch.size(), problem.patches.size());
  std::vector<Sums> sums(islands.count());
  for (std::size_t i = 0; i < problem.patches.size(); ++i) {
    for (const std::size_t body : {problem.patches[i].first, problem.patches[i].second}) {
      if (body == ContactProblem::fixed) continue;
      const std::uint32_t island = islands.island_of(static_cast<std::uint32_t>(problem.bodies[body].index));
      if (island == solver::Islands::none) continue;
      sums[island].residual += report.by_patch[i] * report.by_patch[i];
      sums[island].free += report.free_by_patch[i] * report.free_by_patch[i];
      sums[island].change += report.change_by_patch[i] * report.change_by_patch[i];
      break;
    }
  }
  std::vector<double> relative(islands.count(), 0);
  for (std::size_t island = 0; island < sums.size(); ++island) {
    const double scale = sums[island].free > 0 ? sums[island].free : sums[island].change;
    if (scale > 0) relative[island] = std::sqrt(sums[island].residual / scale);
  }
  return relative;
}

}  // namespace atl
