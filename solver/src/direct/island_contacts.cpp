#include <jobs/assert.h>
#include <solver/constraints/contact_arm.h>
#include <solver/direct/island_matrix.h>
#include <solver/integrate/free_flight.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "direct/island_solves.h"
#include "integrate/rows3.h"

namespace atl::solver {
namespace {

// Part of a bound from which on an impulse counts as at the bound: 1 less the rounding of single precision.
constexpr double at_bound = 1 - 1e-6;

// Where a manifold carries (m, from its middle), and the mean distance (m) of that from its points, both by what these
// carried last or, where that is nothing, of the deepest.
struct CentreOfLoad {
  Vector3 place = Vector3::Zero();
  double radius = 0;
};

// An edge on which a disc rolls is not in the middle of what else comes near, and doesn't hold it from turning on it.
CentreOfLoad centre_of_load(const collision::ContactManifold& manifold) {
  const collision::Tangents tangents = collision::tangents(manifold.normal);
  std::array<double, collision::max_points> weights;
  std::array<Vector3, collision::max_points> places;
  double deepest = collision::no_point, sum = 0;
  for (std::size_t i = 0; i < collision::max_points; ++i) {
    deepest = std::min<double>(deepest, manifold.separation[i]);
    weights[i] = manifold.separation[i] < collision::no_point ? collision::kept_impulse(manifold.normal_impulse[i]) : 0;
    places[i] = manifold.x[i] * get3(tangents.first) + manifold.y[i] * get3(tangents.second);
    sum += weights[i];
  }
  if (!(sum > 0)) {
    for (std::size_t i = 0; i < collision::max_points; ++i) {
      weights[i] = std::max(tuning::min_overlap - (manifold.separation[i] - deepest), 0.0);
    }
    sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  }
  CentreOfLoad centre;
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (weights[i] > 0) centre.place += weights[i] / sum * places[i];
  }
  for (std::size_t i = 0; i < weights.size(); ++i) {
    if (weights[i] > 0) centre.radius += weights[i] / sum * (places[i] - centre.place).norm();
  }
  return centre;
}

// A body's side of a contact: its arm as the step begins, half way through it, and at its end.
struct Side {
  std::uint32_t body;
  double sign;  // of its velocity in that of the contact
  Vector3 start, half, end;
  Vector3 velocity, spin, last_spin;

  Vector3 speed() const { return velocity + spin.cross(start); }
  // m/s: of the place where it is touched, which a round surface rolls along under itself.
  Vector3 passes(double dt) const { return velocity + (end - start) / dt; }
};

// Tells surfaces of revolution that touch with their side or the edge of it, and don't lie on a flat end.
bool stands_on_rim(const ContactArm& on, const Vector3& normal) {
  const double along = on.axis.dot(normal);
  return !on.axis.isZero(0) && 1 - along * along > tuning::min_lean;
}

bool is_rolled_on(const ContactArm& on, const Vector3& normal) {
  return !on.rim.isZero(0) && (on.axis.isZero(0) || stands_on_rim(on, normal));
}

// The place of a contact with something round is where that has rolled to, on the other body as well.
void follow_round(const Vector3& normal, double dt, const Side& round, Side& other) {
  const Vector3 over = round.passes(dt) - other.speed();
  const Vector3 along = over - normal.dot(over) * normal;
  other.half += 0.5 * dt * along;
  other.end += dt * along;
}

// The contact's frame, and its arms. Velocities are to be kept by rows as they are at the end of the step, and impulses
// act half way through it: then bodies that go on turning as they do neither lose energy nor gain any (the midpoint
// rule of Hairer, Lubich and Wanner, "Geometric Numerical Integration", 2006, section II.1, for velocities that change
// by impulses). Rows are those of half the way, and what they still come to be off is given.
void load_frame(const SolveInput& input, const std::vector<DirectBody>& bodies, bool half_way, DirectContact& contact) {
  const BodyTable& table = input.bodies;
  const collision::ContactManifold& manifold = input.manifolds[contact.slot];
  const collision::Pair colliders = input.contacts[contact.slot].pair;
  const collision::Tangents tangents = collision::tangents(manifold.normal);
  const Vector3 normal = get3(manifold.normal).normalized();
  const bool uneven = contact.law.friction_ratio != 1;
  const Vector3 nearly = uneven ? get3(input.surface_contacts[contact.slot].grip) : get3(tangents.first);
  const Vector3 tangent = (nearly - normal.dot(nearly) * normal).normalized();
  contact.axes = {normal, tangent, normal.cross(tangent)};
  ATL_ASSERT(!(std::abs(contact.axes[2].squaredNorm() - 1) > 1e-9), contact.slot, contact.axes[2].norm());
  contact.given = {};
  contact.line_turn = 0;
  const auto load_side = [&](std::uint32_t body, std::uint32_t local, std::uint32_t collider, const Vector3& anchor,
                             double sign, ContactArm& on) -> Side {
    on = contact_arm(table, body, *input.colliders, collider, anchor + contact.middle, -sign * normal);
    const Vector3 none = Vector3::Zero(), start = on.pivot + on.rim;
    Side side{body, sign, start, start, start, none, none, none};
    if (table.mobility[body] == Mobility::Fixed) return side;
    side.velocity = table.velocity(body);
    side.spin = table.angular_velocity(body);
    if (!half_way) return side;
    side.last_spin = local == no_body ? side.spin : Vector3(2 * bodies[local].spin - side.spin);
    const Vector3 turn = local == no_body ? half_turn(table, body, input.dt) : bodies[local].half_turn;
    side.half = turned_arm(on, turn, normal);
    side.end = turned_arm(on, 2 * turn, normal);
    if (!on.axis.isZero(0)) contact.line_turn = line_turn(on, turn, normal);
    return side;
  };
  const auto load_sides = [&]() -> std::array<Side, 2> {
    return {load_side(contact.first_body, contact.first, colliders.first, get3(manifold.anchor_first), -1,
                      contact.on_first),
            load_side(contact.second_body, contact.second, colliders.second, get3(manifold.anchor_second), 1,
                      contact.on_second)};
  };
  contact.middle = Vector3::Zero();
  contact.radius = manifold.friction_radius;
  std::array<Side, 2> sides = load_sides();
  if (stands_on_rim(contact.on_first, normal) || stands_on_rim(contact.on_second, normal)) {
    const CentreOfLoad load = centre_of_load(manifold);
    contact.middle = load.place;
    contact.radius = load.radius;
    sides = load_sides();
  }
  auto& [first, second] = sides;
  const bool round_first = is_rolled_on(contact.on_first, normal);
  const bool round_second = is_rolled_on(contact.on_second, normal);
  if (half_way && round_first && !round_second) follow_round(normal, input.dt, first, second);
  if (half_way && round_second && !round_first) follow_round(normal, input.dt, second, first);
  contact.arm_first = first.half;
  contact.arm_second = second.half;
  contact.approach = normal.dot(second.speed() - first.speed());
  contact.ahead = contact.last_spin = Vector3::Zero();
  for (const Side& side : sides) {
    if (table.mobility[side.body] == Mobility::Kinematic) {
      contact.add_motion(side.sign, side.half, side.velocity, side.spin, contact.given);
    }
    contact.ahead += side.sign * side.last_spin.cross(side.end - side.half);
    contact.last_spin += side.sign * side.last_spin;
  }
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

// Tells contacts along a line.
bool is_line(const collision::ContactManifold& manifold) {
  return manifold.separation[1] < collision::no_point && manifold.separation[2] >= collision::no_point;
}

// Gives a contact what its arms and, of what touches along a line, the turn of that make of its motion until the end of
// the step.
void go_ahead(bool line, DirectContact& contact) {
  contact.give(contact.ahead);
  if (!line) return;
  contact.given[1] += contact.line_turn * contact.axes[2].dot(contact.last_spin);
  contact.given[2] -= contact.line_turn * contact.axes[1].dot(contact.last_spin);
}

void load_points(const collision::ContactManifold& manifold, const ContactResponse& response, DirectContact& contact) {
  ContactLaw& law = contact.law;
  // A load on one end of a line that lags behind the axis above it would drive the rolling.
  const double tangent = is_line(manifold) ? contact.line_turn : 0;
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

// True if a point comes to lie in the other body, from where it is on, at the speed at which it closes: the body is
// stopped on its way, by however much.
bool lands(const DirectContact& contact, bool line, const std::vector<double>& velocity, double dt) {
  Six motion = contact.motion_at(velocity);
  motion[0] = contact.approach;
  if (line) {
    const double about = motion[1];
    motion[1] -= contact.line_turn * motion[2];
    motion[2] += contact.line_turn * about;
  }
  for (int i = 0; i < contact.law.points; ++i) {
    const double gap = std::max(contact.start_separation[i], 0.0);
    if (-contact.law.speed(i, motion) * dt - gap > 2 * tuning::min_overlap) return true;
  }
  return false;
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
  contact.lands = lands(contact, is_line(manifold), problem.velocity, input.dt);
  // What lands moves by the velocities that it has then, along rows of half the way.
  if (half_way && !contact.lands) go_ahead(is_line(manifold), contact);
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
