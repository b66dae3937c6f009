#include <jobs/assert.h>

#include <algorithm>
#include <numeric>

#include "direct/island_solves.h"
#include "integrate/rows3.h"

namespace atl::solver {

void write_back_contacts(const SolveInput& input, double share, const std::vector<DirectContact>& contacts) {
  for (const DirectContact& contact : contacts) {
    collision::ContactManifold& manifold = input.manifolds[contact.slot];
    int point = 0;
    for (int i = 0; i < collision::max_points; ++i) {
      const bool there = manifold.separation[i] < collision::no_point;
      manifold.normal_impulse[i] = there ? static_cast<float>(share * contact.lasting.normal[point++]) : 0;
    }
    ATL_ASSERT(point == contact.law.points, contact.slot, point, contact.law.points);
    set3(manifold.friction_impulse, share * contact.in_plane(contact.lasting.friction));
    manifold.torsional_impulse = static_cast<float>(share * contact.lasting.torsional);
    if (input.surface_contacts == nullptr) continue;
    set3(input.surface_contacts[contact.slot].rolling_impulse, share * contact.in_plane(contact.lasting.rolling));
  }
}

void capture_contacts(ContactCapture& capture, const collision::ContactManifold* manifolds, double step,
                      const IslandProblem& problem) {
  for (const DirectContact& contact : problem.contacts) {
    const collision::ContactManifold& manifold = manifolds[contact.slot];
    ContactCapture::Answer& answer = capture.answers[contact.slot];
    answer.planar = false;
    // Its points are along the manifold's tangents, as far as the plane has turned.
    const Vector3 &normal = contact.axes[0], first_normal = get3(manifold.normal).normalized();
    const Vector3 first_tangent = get3(collision::tangents(manifold.normal).first), turn = first_normal.cross(normal);
    const Vector3 moved = turn.cross(first_tangent);
    const Vector3 tangent = first_tangent + moved + turn.cross(moved) / (1 + first_normal.dot(normal));
    answer.step = step;
    int point = 0;
    for (std::size_t i = 0; i < collision::max_points; ++i) {
      answer.separation[i] = manifold.separation[i];
      const bool there = manifold.separation[i] < collision::no_point;
      answer.normal_impulse[i] = there ? static_cast<float>(contact.lasting.normal[point++]) : 0;
    }
    const Vector3 friction = contact.in_plane(contact.lasting.friction);
    const Vector3 rolling = contact.in_plane(contact.lasting.rolling);
    for (int k = 0; k < 3; ++k) {
      answer.normal[k] = static_cast<float>(normal[k]);
      answer.tangent[k] = static_cast<float>(tangent[k]);
      answer.anchor_first[k] = static_cast<float>(contact.arm_first[k]);
      answer.anchor_second[k] = static_cast<float>(contact.arm_second[k]);
      answer.friction_impulse[k] = static_cast<float>(friction[k]);
      answer.rolling_impulse[k] = static_cast<float>(rolling[k]);
    }
    answer.torsional_impulse = static_cast<float>(contact.lasting.torsional);
  }
  for (std::size_t i = 0; i < problem.bodies.size(); ++i) {
    ContactCapture::Motion& motion = capture.motions[problem.bodies[i].body];
    motion.free_velocity = linear_part(problem.free, i);
    motion.free_angular_velocity = angular_part(problem.free, i);
    motion.inverse_inertia = problem.bodies[i].inverse_inertia;
  }
}

void record_pushes(const IslandProblem& problem, bool first, float* pushed) {
  for (const DirectContact& contact : problem.contacts) {
    const auto& normal = contact.lasting.normal;
    const double impulse = std::accumulate(normal.begin(), normal.begin() + contact.law.points, 0.0);
    float& sum = pushed[contact.slot];
    if (first) sum = not_pushed;
    if (impulse > 0) sum = static_cast<float>(std::max(0.0f, sum) + impulse);
  }
}

}  // namespace atl::solver
