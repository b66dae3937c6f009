#include <jobs/assert.h>
#include <solver/integrate/motion_locks.h>
#include <solver/select/island_errors.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "integrate/rows3.h"

namespace atl::solver {
namespace {

// m, of the deepest point.
double overlap(const collision::ContactManifold& manifold) {
  return -static_cast<double>(*std::min_element(std::begin(manifold.separation), std::end(manifold.separation)));
}

// The response of two bodies to impulses.
struct Pair {
  double inverse_mass;
  Matrix3 first, second;  // inverse inertia, world

  Pair(const BodyTable& bodies, std::uint32_t a, std::uint32_t b)
      : inverse_mass(bodies.inverse_mass[a] + bodies.inverse_mass[b]),
        first(world_inverse_inertia(bodies, a)),
        second(world_inverse_inertia(bodies, b)) {}
  double response(const JointRow& row) const { return row.response(inverse_mass, first, second); }
};

// The overlap (m) that the load explains, at the point where it is largest. A point that moves by more in a step than
// it overlaps has just met, or is on its way out. `by_impulse` is m by N s and 1/kg, of contacts between bodies that
// move.
double explained_overlap(const ErrorInput& input, const TouchingPair& pair, double by_impulse) {
  const BodyTable& bodies = input.bodies;
  const collision::ContactManifold& manifold = input.manifolds[pair.slot];
  const Vector3 normal = get3(manifold.normal);
  const collision::Tangents tangents = collision::tangents(manifold.normal);
  const bool both_move = bodies.inverse_mass[pair.first] > 0 && bodies.inverse_mass[pair.second] > 0;
  const double scale = both_move ? by_impulse : by_impulse / 4;  // at twice the frequency
  const Pair answers(bodies, pair.first, pair.second);
  double explained = 0;
  for (std::size_t i = 0; i < collision::max_points; ++i) {
    if (!(manifold.separation[i] < 0)) continue;
    const Vector3 off = manifold.x[i] * get3(tangents.first) + manifold.y[i] * get3(tangents.second);
    const Vector3 first = get3(manifold.anchor_first) + off, second = get3(manifold.anchor_second) + off;
    const JointRow row{.linear = normal, .angular_first = first.cross(normal), .angular_second = second.cross(normal)};
    const double by_load = collision::kept_impulse(manifold.normal_impulse[i]) * scale * answers.response(row);
    const double overlap = -manifold.separation[i];
    const double passed =
        input.dt *
        std::abs(normal.dot(bodies.velocity_at(pair.second, second) - bodies.velocity_at(pair.first, first)));
    const double here = std::min(overlap, by_load);
    if (passed < here) explained = std::max(explained, here);
  }
  return explained;
}

int made_in(std::span<const std::uint16_t> substeps, std::uint32_t first, std::uint32_t second, int otherwise) {
  const int made = std::max(substeps[first], substeps[second]);
  return made > 0 ? made : otherwise;
}

// Calls visit(row, off, impulse) for the offsets that a joint locks: m, and N s.
template <typename Visit>
void for_each_locked_offset(const BodyTable& bodies, const Joint& joint, const Visit& visit) {
  const JointFrames frames = joint_frames(joint, bodies);
  for (int axis = 0; joint.point && axis < 3; ++axis) {
    const JointRow row = offset_along(frames, axis);
    visit(row, row.value, row.linear.dot(joint.point_impulse));
  }
  for (std::size_t row = 0; row < joint.rows; ++row) {
    if (joint.coordinate[row] > Coordinate::Distance || !joint.law[row].locked()) continue;
    const JointRow at = joint_row(joint, row, frames);
    visit(at, at.value - joint.law[row].lower, joint.impulse[row]);
  }
}

// m, of the locked offsets of a joint.
double gap(const BodyTable& bodies, const Joint& joint) {
  if (joint.point) {
    return (bodies.position(joint.second) + bodies.orientation(joint.second) * joint.anchor_second -
            bodies.position(joint.first) - bodies.orientation(joint.first) * joint.anchor_first)
        .norm();
  }
  double square = 0;
  for_each_locked_offset(bodies, joint, [&](const JointRow&, double off, double) { square += off * off; });
  return std::sqrt(square);
}

// m, of that the part which the force in the joint explains where it is solved by sweeps. `by_impulse` is m by N s and
// 1/kg.
double explained_gap(const BodyTable& bodies, const Joint& joint, double by_impulse) {
  const Pair answers(bodies, joint.first, joint.second);
  double square = 0;
  for_each_locked_offset(bodies, joint, [&](const JointRow& row, double, double impulse) {
    square += std::pow(impulse * answers.response(row) * by_impulse, 2);
  });
  return std::sqrt(square);
}

// Nearest rank.
double exceeded_by_one_in_a_hundred(std::vector<double>& values) {
  if (values.empty()) return 0;
  const auto rank = values.end() - static_cast<std::ptrdiff_t>(values.size() / 100) - 1;
  std::nth_element(values.begin(), rank, values.end());
  return *rank;
}

// 1/s^2, of a spring of a share of the substep rate, in steps of one substep.
double stiffness(const ErrorInput& input, double share) {
  const double omega = 2 * 3.14159265358979323846 * share / (input.dt * input.parts);
  return omega * omega;
}

// m by N s and 1/kg.
double softness(const ErrorInput& input, double share) {
  return tuning::explained_error * input.asked / input.dt / stiffness(input, share);
}

}  // namespace

void add_overlaps(const ErrorInput& input, std::span<const TouchingPair> contacts,
                  std::span<const std::uint16_t> substeps, double target, ErrorCounts& counts) {
  const double min = std::min(target, tuning::min_overlap);
  const double by_impulse = softness(input, tuning::contact_hertz_share);
  for (const TouchingPair& pair : contacts) {
    const collision::ContactManifold& manifold = input.manifolds[pair.slot];
    const double error = overlap(manifold);
    if (!(error > 0)) continue;
    const double made = made_in(substeps, pair.first, pair.second, input.asked * input.parts);
    ATL_ASSERT(made >= 1, pair.slot, made);
    if (error <= min) {
      counts.add_small(error, made);
    } else if (error > target) {
      const double explained = explained_overlap(input, pair, by_impulse / (made * made));
      counts.add_missed(error, explained, made, target);
    } else {
      counts.add(error, made, target);
    }
  }
}

void add_gaps(const ErrorInput& input, std::span<const JointLink> links, std::span<const std::uint16_t> substeps,
              double target, ErrorCounts& counts) {
  const double by_impulse = softness(input, tuning::joint_hertz_limit);
  for (const JointLink& link : links) {
    const double made = made_in(substeps, link.first, link.second, input.asked * input.parts);
    const Joint& joint = input.joints[link.joint];
    const double error = gap(input.bodies, joint);
    if (error > target) {
      const double explained = explained_gap(input.bodies, joint, by_impulse / (made * made));
      counts.add_missed(error, std::min(error, explained), made, target);
    } else {
      counts.add(error, made, target);
    }
  }
}

int substeps_at_first(const ErrorInput& input, const ErrorTarget& target, std::size_t island) {
  const std::span<const JointLink> links = input.islands.joints(island, island + 1);
  const bool sweeps_joints = std::any_of(links.begin(), links.end(), [&](const JointLink& link) {
    return !input.joint_systems->is_direct(input.joint_graph->component_of(link.joint));
  });
  const double force = tuning::first_load * input.gravity;  // N/kg
  const double all = static_cast<double>(input.islands.body_count(island)) * input.gravity;
  double square = 0;
  if (input.islands.contact_count(island) > 0) {
    square = force / stiffness(input, tuning::contact_hertz_share) / target.penetration;
  }
  // The whole island may hang on one joint.
  if (sweeps_joints) square = std::max(square, all / stiffness(input, tuning::joint_hertz_limit) / target.joint_gap);
  // The other errors can't be predicted.
  const bool others = target.residual < ErrorTarget::none || target.motion < ErrorTarget::none;
  return std::max(rung_of(square), others ? input.asked * input.parts : 1);
}

double overlap_of(const ErrorInput& input, std::span<const TouchingPair> contacts) {
  std::vector<double> overlaps;
  for (const TouchingPair& pair : contacts) {
    const double error = overlap(input.manifolds[pair.slot]);
    if (error > tuning::min_overlap) overlaps.push_back(error);
  }
  return exceeded_by_one_in_a_hundred(overlaps);
}

double gap_of(const ErrorInput& input, std::span<const JointLink> links) {
  std::vector<double> gaps;
  for (const JointLink& link : links) gaps.push_back(gap(input.bodies, input.joints[link.joint]));
  return exceeded_by_one_in_a_hundred(gaps);
}

}  // namespace atl::solver
