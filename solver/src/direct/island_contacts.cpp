#include <jobs/assert.h>
#include <solver/constraints/contact_arm.h>
#include <solver/direct/island_matrix.h>
#include <solver/integrate/free_flight.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

#include "direct/contact_sides.h"
#include "direct/island_solves.h"
#include "integrate/rows3.h"

namespace atl::solver {
namespace {

// Part of a bound from which on an impulse counts as at the bound: 1 less the rounding of single precision.
constexpr double at_bound = 1 - 1e-6;

// The contact's frame, and its places on its bodies. The plane of a face has turned with that half way.
void load_frame(const SolveInput& input, const std::vector<DirectBody>& bodies, bool half_way, DirectContact& contact) {
  const collision::ContactManifold& manifold = input.manifolds[contact.slot];
  const collision::Tangents tangents = collision::tangents(manifold.normal);
  const Vector3 normal = get3(manifold.normal).normalized();
  const bool uneven = contact.law.friction_ratio != 1;
  const Vector3 nearly = uneven ? get3(input.surface_contacts[contact.slot].grip) : get3(tangents.first);
  const Vector3 tangent = (nearly - normal.dot(nearly) * normal).normalized();
  contact.axes = {normal, tangent, normal.cross(tangent)};
  ATL_ASSERT(!(std::abs(contact.axes[2].squaredNorm() - 1) > 1e-9), contact.slot, contact.axes[2].norm());
  place_sides(input, bodies, half_way, contact);
  const collision::Contact& of = input.contacts[contact.slot];
  if (!half_way || !of.on_face) return;
  const std::uint32_t body = of.reference_is_second ? contact.second_body : contact.first_body;
  const std::uint32_t local = of.reference_is_second ? contact.second : contact.first;
  const Vector3 turn = local == no_body ? half_turn(input.bodies, body, input.dt) : bodies[local].half_turn;
  const Quaternion swing = rotation_by(turn - turn.dot(normal) * normal);
  for (Vector3& axis : contact.axes) axis = swing * axis;
}

// 1/kg and the like: how a contact's bodies answer impulses.
struct ContactResponse {
  const std::vector<DirectBody>& bodies;
  const DirectContact& contact;
  double inverse_mass;  // 1/kg, of both

  // The response to a pair of couples that turn the bodies.
  double turning(const Vector3& first, const Vector3& second) const {
    double sum = 0;
    if (contact.first != no_body) sum += first.dot(bodies[contact.first].inverse_inertia * first);
    if (contact.second != no_body) sum += second.dot(bodies[contact.second].inverse_inertia * second);
    return sum;
  }
  double turning(const Vector3& about) const { return turning(about, about); }
  // The response to an impulse at the centre.
  double along(const Vector3& axis) const {
    return inverse_mass + turning(contact.arm_first.cross(axis), contact.arm_second.cross(axis));
  }
};

void load_points(const collision::ContactManifold& manifold, const ContactResponse& response, DirectContact& contact) {
  ContactLaw& law = contact.law;
  // A load on one end of a line that lags behind the axis above it would drive the rolling.
  const double tangent = contact.line_turn;
  const double cosine = 1 / std::sqrt(1 + tangent * tangent);
  const collision::Tangents of_manifold = collision::tangents(manifold.normal);
  const auto in_axes = [&](double x, double y) -> std::array<double, 2> {
    if (law.friction_ratio == 1 && contact.middle.isZero(0)) return {x, y};
    const Vector3 place = x * get3(of_manifold.first) + y * get3(of_manifold.second) - contact.middle;
    return {place.dot(contact.axes[1]), place.dot(contact.axes[2])};
  };
  for (int i = 0; i < collision::max_points; ++i) {
    if (manifold.separation[i] >= collision::no_point) continue;
    const int p = law.points++;
    const auto [at_x, at_y] = in_axes(manifold.x[i], manifold.y[i]);
    const double x = cosine * (at_x - tangent * at_y), y = cosine * (at_y + tangent * at_x);
    law.x[p] = x;
    law.y[p] = y;
    // (arm + x t1 + y t2) x n, of which t1 x n = -t2 and t2 x n = t1
    const Vector3 offset = y * contact.axes[1] - x * contact.axes[2];
    const double k = response.inverse_mass + response.turning(contact.arm_first.cross(contact.axes[0]) + offset,
                                                              contact.arm_second.cross(contact.axes[0]) + offset);
    ATL_ASSERT(k > 0, contact.slot, p, k);
    contact.mass[p] = 1 / k;
    contact.separation[p] = contact.start_separation[p] = manifold.separation[i];
  }
}

void load_friction(const SolverSettings& settings, const ContactResponse& response, DirectContact& contact) {
  ContactLaw& law = contact.law;
  const double along = 0.5 * (response.along(contact.axes[1]) + response.along(contact.axes[2]));
  const double twist = response.turning(contact.axes[0]);
  ATL_ASSERT(along > 0, contact.slot, along);
  law.friction_stiffness = 1 / (tuning::friction_compliance * along);
  law.torsional_stiffness = twist > 0 ? 1 / (tuning::friction_compliance * twist) : 0;
  law.pyramid = settings.pyramid;
}

void load_surfaces(const SurfaceContact& surface, const ContactResponse& response, DirectContact& contact) {
  ContactLaw& law = contact.law;
  const Vector3 slip = get3(surface.slip), spin = get3(surface.spin);
  law.surfaces = {0,
                  spin.dot(contact.axes[1]),
                  spin.dot(contact.axes[2]),
                  slip.dot(contact.axes[1]),
                  slip.dot(contact.axes[2]),
                  spin.dot(contact.axes[0])};
  contact.rolling = surface.rolling_friction;
  contact.torsional = surface.torsional_friction;
  if (is_uneven(surface)) {
    const double part = get3(surface.grip).norm();
    contact.friction *= part;
    contact.radius *= surface.twist / part;
  }
  const double rolls = 0.5 * (response.turning(contact.axes[1]) + response.turning(contact.axes[2]));
  if (contact.rolling > 0 && rolls > 0) law.rolling_stiffness = 1 / (tuning::friction_compliance * rolls);
}

// The pieces that the last step's impulses were on. `share`: what is solved for at once, of the substep that impulses
// are kept as those of.
void warm_start(const SolveInput& input, double share, DirectContact& contact) {
  const collision::ContactManifold& manifold = input.manifolds[contact.slot];
  ContactAnswer& answer = contact.answer;
  answer = {};
  int point = 0;
  for (int i = 0; i < collision::max_points; ++i) {
    if (manifold.separation[i] >= collision::no_point) continue;
    answer.normal[point] = share * collision::kept_impulse(manifold.normal_impulse[i]);
    if (manifold.normal_impulse[i] > 0) answer.pieces.points |= static_cast<std::uint8_t>(1 << point);
    ++point;
  }
  const double load = answer.load();
  contact.bound_friction(load);
  const Vector3 friction = share * get3(manifold.friction_impulse);
  answer.friction = {friction.dot(contact.axes[1]), friction.dot(contact.axes[2])};
  answer.torsional = share * manifold.torsional_impulse;
  const auto is_bound = [](double impulse, double bound) { return std::abs(impulse) >= at_bound * bound; };
  if (contact.law.pyramid) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const double bound = (axis == 0 ? 1 : contact.law.friction_ratio) * contact.law.friction_bound;
      const bool slides = is_bound(answer.friction[axis], bound);
      answer.pieces.slides |= static_cast<std::uint8_t>(slides ? 1 << axis : 0);
    }
  } else {
    const double size = Eigen::Vector2d(answer.friction[0], answer.friction[1] / contact.law.friction_ratio).norm();
    answer.pieces.slides = is_bound(size, contact.law.friction_bound) ? 3 : 0;
  }
  answer.pieces.spins = is_bound(answer.torsional, contact.law.torsional_bound);
  if (contact.law.rolling_stiffness > 0) {
    ATL_ASSERT(input.surface_contacts != nullptr, contact.slot);
    const Vector3 rolling = share * get3(input.surface_contacts[contact.slot].rolling_impulse);
    answer.rolling = {rolling.dot(contact.axes[1]), rolling.dot(contact.axes[2])};
    answer.pieces.rolls = is_bound(rolling.norm(), contact.law.rolling_bound);
  }
}

// Contacts that carried nothing in the last step. A body that nothing carried has just been put or has just landed
// where it is: all points that it touches with may come to push. Beside others such a contact is idle, as between the
// boxes of a row, and pushes only where its bodies close.
void guess_idle_contacts(double dt, IslandProblem& problem) {
  if (problem.contacts.empty()) return;
  std::vector<bool> carried(problem.bodies.size());
  for (const DirectContact& contact : problem.contacts) {
    if (!(contact.answer.load() > 0)) continue;
    for (const std::uint32_t body : {contact.first, contact.second}) {
      if (body != no_body) carried[body] = true;
    }
  }
  const auto is_new = [&](std::uint32_t body) { return body != no_body && !carried[body]; };
  for (DirectContact& contact : problem.contacts) {
    if (contact.answer.load() > 0) continue;
    const bool begins = is_new(contact.first) || is_new(contact.second);
    const Six motion = contact.motion_at(problem.velocity);
    for (int i = 0; i < contact.law.points; ++i) {
      const double parts = contact.law.speed(i, motion) + std::max(contact.separation[i], 0.0) / dt;
      const bool pushes = begins ? contact.separation[i] <= 0 : parts < -tuning::resting_speed;
      if (pushes) contact.answer.pieces.points |= static_cast<std::uint8_t>(1 << i);
    }
  }
}

void load_contact(const SolveInput& input, const TouchingPair& pair, const IslandProblem& problem, bool half_way,
                  DirectContact& contact) {
  const std::vector<DirectBody>& bodies = problem.bodies;
  const BodyTable& table = input.bodies;
  const collision::ContactManifold& manifold = input.manifolds[pair.slot];
  contact.friction = manifold.friction;
  contact.rolling = contact.torsional = 0;
  contact.law = {};  // whatever was solved before must not show
  if (input.surface_contacts != nullptr) contact.law.friction_ratio = input.surface_contacts[pair.slot].ratio;
  load_frame(input, bodies, half_way, contact);
  const ContactResponse response{bodies, contact, table.inverse_mass[pair.first] + table.inverse_mass[pair.second]};
  load_points(manifold, response, contact);
  ATL_ASSERT(contact.law.points >= 1, pair.slot, pair.first, pair.second);
  contact.lands = lands(contact, problem.velocity, input.dt);
  // A landing foresees nothing: its bodies move by their last velocities, along rows of half the way.
  if (half_way && !contact.lands) go_ahead(contact);
  load_friction(input.settings, response, contact);
  if (input.surface_contacts == nullptr) return;
  SurfaceContact& surface = input.surface_contacts[pair.slot];
  const double ahead = half_way ? input.dt : 0.5 * input.dt;
  update_surface_contact(pair, table, manifold, ahead, input.added_slip(pair.slot), surface);
  load_surfaces(surface, response, contact);
}

bool bounces(const SolveInput& input, const DirectContact& contact, const std::vector<double>& velocity) {
  if (input.manifolds[contact.slot].restitution == 0) return false;
  Six motion = contact.motion_at(velocity);
  motion[0] = contact.approach;
  for (int i = 0; i < contact.law.points; ++i) {
    if (contact.law.speed(i, motion) < -input.settings.restitution_threshold) return true;
  }
  return false;
}

}  // namespace

bool load_contacts(const SolveInput& input, const IslandMembers& members, IslandProblem& problem) {
  // Impulses are kept as those of a substep.
  const bool at_once = members.joints.empty();
  const double share = at_once ? input.settings.substeps / input.settings.refinement : 1;
  problem.contacts.resize(members.contacts.size());
  for (std::size_t c = 0; c < members.contacts.size(); ++c) {
    const TouchingPair& pair = members.contacts[c];
    DirectContact& contact = problem.contacts[c];
    contact.slot = pair.slot;
    contact.first_body = pair.first;
    contact.second_body = pair.second;
    contact.first = members.local(input, pair.first);
    contact.second = members.local(input, pair.second);
    load_contact(input, pair, problem, at_once, contact);
    warm_start(input, share, contact);
    if (bounces(input, contact, problem.velocity)) return false;
  }
  guess_idle_contacts(at_once ? input.dt : input.substep(), problem);
  forget_rows(problem);
  return true;
}

void turn_contacts(const SolveInput& input, const IslandMembers& members, IslandProblem& problem) {
  for (std::size_t c = 0; c < members.contacts.size(); ++c) {
    DirectContact& contact = problem.contacts[c];
    load_contact(input, members.contacts[c], problem, true, contact);
    contact.answer = contact.lasting;
    contact.bound_friction(contact.answer.load());
  }
  forget_rows(problem);
}

void place_contacts(const IslandPoses& poses, std::vector<DirectContact>& contacts) {
  const BodyTable& table = poses.table;
  for (DirectContact& contact : contacts) {
    const auto& [normal, tangent, other] = contact.axes;
    const BodyPose pose_first = poses.of(contact.first, contact.first_body);
    const BodyPose pose_second = poses.of(contact.second, contact.second_body);
    const auto turn_of = [&](std::uint32_t body, const BodyPose& now) -> Quaternion {
      if (table.mobility[body] == Mobility::Fixed) return Quaternion::Identity();
      return now.orientation * table.orientation(body).conjugate();
    };
    const Quaternion turn_first = turn_of(contact.first_body, pose_first);
    const Quaternion turn_second = turn_of(contact.second_body, pose_second);
    const double apart = normal.dot((pose_second.position - table.position(contact.second_body)) -
                                    (pose_first.position - table.position(contact.first_body)));
    for (int i = 0; i < contact.law.points; ++i) {
      const Vector3 off = contact.law.x[i] * tangent + contact.law.y[i] * other;
      const double turned = gained_along(contact.on_second, off, turn_second, normal) -
                            gained_along(contact.on_first, off, turn_first, normal);
      contact.separation[i] = contact.start_separation[i] + apart + turned;
    }
  }
}

}  // namespace atl::solver
