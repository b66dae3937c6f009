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

// 1/kg, of an impulse along a direction at an arm from the centre of mass.
double response(const BodyTable& bodies, std::uint32_t body, const Vector3& arm, const Vector3& direction) {
  if (!(bodies.inverse_mass[body] > 0)) return 0;
  const Vector3 moment = bodies.orientation(body).conjugate() * arm.cross(direction);
  return bodies.inverse_mass[body] * direction.squaredNorm() + moment.dot(bodies.inverse_inertia[body] * moment);
}

// What is to be known of an overlap that is too large.
struct Overlap {
  double explained = 0;  // m, by the load, of the point where that is most
  bool rests = false;    // the bodies move less against each other in a step than they overlap
};

// `by_impulse` is m by N s and 1/kg, of contacts between bodies that move.
Overlap look_at(const ErrorInput& input, const TouchingPair& pair, double by_impulse) {
  const BodyTable& bodies = input.bodies;
  const collision::ContactManifold& manifold = input.manifolds[pair.slot];
  const Vector3 normal = get3(manifold.normal);
  const collision::Tangents tangents = collision::tangents(manifold.normal);
  const bool both_move = bodies.inverse_mass[pair.first] > 0 && bodies.inverse_mass[pair.second] > 0;
  const double scale = both_move ? by_impulse : by_impulse / 4;  // at twice the frequency
  Overlap found;
  for (std::size_t i = 0; i < collision::max_points; ++i) {
    if (!(manifold.separation[i] < 0)) continue;
    const Vector3 off = manifold.x[i] * get3(tangents.first) + manifold.y[i] * get3(tangents.second);
    const Vector3 first = get3(manifold.anchor_first) + off, second = get3(manifold.anchor_second) + off;
    const double by_load =
        manifold.normal_impulse[i] * scale *
        (response(bodies, pair.first, first, normal) + response(bodies, pair.second, second, normal));
    const double overlap = -manifold.separation[i];
    const double passed =
        input.dt * (bodies.velocity_at(pair.second, second) - bodies.velocity_at(pair.first, first)).norm();
    found.rests |= passed < overlap;
    if (passed < std::min(overlap, by_load)) found.explained = std::max(found.explained, std::min(overlap, by_load));
  }
  return found;
}

int made_in(std::span<const std::uint16_t> substeps, std::uint32_t first, std::uint32_t second, int otherwise) {
  const int made = std::max(substeps[first], substeps[second]);
  return made > 0 ? made : otherwise;
}

// m, of the locked offsets of a joint; and the part of it that the force in the joint explains, where it is solved by
// sweeps: `by_impulse` as above.
struct Gap {
  double error, explained;
};
Gap gap(const BodyTable& bodies, const Joint& joint, double by_impulse) {
  const JointFrames frames = joint_frames(joint, bodies.position(joint.first), bodies.orientation(joint.first),
                                          bodies.position(joint.second), bodies.orientation(joint.second));
  double square = 0, explained = 0;
  const auto add = [&](const JointRow& row, double off, double impulse) {
    square += off * off;
    const auto turned = [&](std::uint32_t body, const Vector3& moment) -> double {
      if (!(bodies.inverse_mass[body] > 0)) return 0;
      const Vector3 own = bodies.orientation(body).conjugate() * moment;
      return own.dot(bodies.inverse_inertia[body] * own);
    };
    const double response =
        (bodies.inverse_mass[joint.first] + bodies.inverse_mass[joint.second]) * row.linear.squaredNorm() +
        turned(joint.first, row.angular_first) + turned(joint.second, row.angular_second);
    const double by_load = std::abs(impulse) * response * by_impulse;
    explained += by_load * by_load;
  };
  for (int axis = 0; joint.point && axis < 3; ++axis) {
    const JointRow row = offset_along(frames, axis);
    add(row, row.value, row.linear.dot(joint.point_impulse));
  }
  for (std::size_t row = 0; row < joint.rows; ++row) {
    if (joint.coordinate[row] > Coordinate::Distance || !joint.law[row].locked()) continue;
    const JointRow at = joint_row(joint, row, frames);
    add(at, at.value - joint.law[row].lower, joint.impulse[row]);
  }
  return {std::sqrt(square), std::sqrt(explained)};
}

// Of what is more than `least`: nearest rank.
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
  const double least = std::min(target, tuning::least_overlap);
  const double by_impulse = softness(input, tuning::contact_hertz_share);
  for (const TouchingPair& pair : contacts) {
    const collision::ContactManifold& manifold = input.manifolds[pair.slot];
    const double error = overlap(manifold);
    if (!(error > least)) continue;
    const double made = made_in(substeps, pair.first, pair.second, input.asked * input.parts);
    if (error > target) {
      const Overlap found = look_at(input, pair, by_impulse / (made * made));
      counts.add_missed({.following = found.explained, .rests = found.rests}, made, target);
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
    const Gap of_joint = gap(input.bodies, input.joints[link.joint], by_impulse / (made * made));
    if (of_joint.error > target) {
      counts.add_missed({.following = std::min(of_joint.error, of_joint.explained), .rests = false}, made, target);
    } else {
      counts.add(of_joint.error, made, target);
    }
  }
}

int substeps_at_first(const ErrorInput& input, const ErrorTarget& target) {
  const double force = tuning::first_load * input.gravity;  // N/kg
  const double square = std::max(force / stiffness(input, tuning::contact_hertz_share) / target.penetration,
                                 force / stiffness(input, tuning::joint_hertz_limit) / target.joint_gap);
  if (!(square > 0)) return input.asked * input.parts;
  return rung_of(square);
}

double overlap_of(const ErrorInput& input, std::span<const TouchingPair> contacts) {
  std::vector<double> overlaps;
  for (const TouchingPair& pair : contacts) {
    const double error = overlap(input.manifolds[pair.slot]);
    if (error > tuning::least_overlap) overlaps.push_back(error);
  }
  return exceeded_by_one_in_a_hundred(overlaps);
}

double gap_of(const ErrorInput& input, std::span<const JointLink> links) {
  std::vector<double> gaps;
  for (const JointLink& link : links) gaps.push_back(gap(input.bodies, input.joints[link.joint], 0).error);
  return exceeded_by_one_in_a_hundred(gaps);
}

}  // namespace atl::solver
