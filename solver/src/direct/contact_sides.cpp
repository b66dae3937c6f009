#include "direct/contact_sides.h"

#include <solver/constraints/contact_arm.h>
#include <solver/tuning.h>

#include <algorithm>
#include <array>
#include <numeric>

#include "integrate/rows3.h"

namespace atl::solver {
namespace {

// The centre of a manifold's load (m, from its middle), and its mean distance (m) from the points. Points weigh by
// their last impulses, or if these are zero by their depth.
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

// Tells contacts along a line.
bool is_line(const collision::ContactManifold& manifold) {
  return manifold.separation[1] < collision::no_point && manifold.separation[2] >= collision::no_point;
}

Side side_of(const SolveInput& input, const std::vector<DirectBody>& bodies, bool half_way, bool second,
             DirectContact& contact) {
  const BodyTable& table = input.bodies;
  const collision::ContactManifold& manifold = input.manifolds[contact.slot];
  const collision::Pair colliders = input.contacts[contact.slot].pair;
  const Vector3& normal = contact.axes[0];
  const std::uint32_t body = second ? contact.second_body : contact.first_body;
  const std::uint32_t local = second ? contact.second : contact.first;
  const double sign = second ? 1 : -1;
  const Vector3 anchor = get3(second ? manifold.anchor_second : manifold.anchor_first) + contact.middle;
  ContactArm& on = second ? contact.on_second : contact.on_first;
  on = contact_arm(table, body, *input.colliders, second ? colliders.second : colliders.first, anchor, -sign * normal);
  const Vector3 none = Vector3::Zero(), start = on.pivot + on.rim;
  Side side{sign, start, start, start, none, none, none};
  if (table.mobility[body] == Mobility::Fixed) return side;
  side.velocity = table.velocity(body);
  side.spin = table.angular_velocity(body);
  if (!half_way) return side;
  side.last_spin = local == no_body ? side.spin : Vector3(2 * bodies[local].spin - side.spin);
  const Vector3 turn = local == no_body ? half_turn(table, body, input.dt) : bodies[local].half_turn;
  side.half = turned_arm(on, turn, normal);
  side.end = turned_arm(on, 2 * turn, normal);
  if (!on.axis.isZero(0) && is_line(manifold)) contact.line_turn = line_turn(on, turn, normal);
  return side;
}

}  // namespace

void place_sides(const SolveInput& input, const std::vector<DirectBody>& bodies, bool half_way,
                 DirectContact& contact) {
  const collision::ContactManifold& manifold = input.manifolds[contact.slot];
  const Vector3& normal = contact.axes[0];
  const auto sides_of = [&]() -> std::array<Side, 2> {
    return {side_of(input, bodies, half_way, false, contact), side_of(input, bodies, half_way, true, contact)};
  };
  contact.line_turn = 0;
  contact.middle = Vector3::Zero();
  contact.radius = manifold.friction_radius;
  std::array<Side, 2> sides = sides_of();
  if (stands_on_rim(contact.on_first, normal) || stands_on_rim(contact.on_second, normal)) {
    const CentreOfLoad load = centre_of_load(manifold);
    contact.middle = load.place;
    contact.radius = load.radius;
    sides = sides_of();
  }
  auto& [first, second] = sides;
  const bool round_first = is_rolled_on(contact.on_first, normal);
  const bool round_second = is_rolled_on(contact.on_second, normal);
  if (half_way && round_first && !round_second) follow_round(normal, input.dt, first, second);
  if (half_way && round_second && !round_first) follow_round(normal, input.dt, second, first);
  contact.arm_first = first.half;
  contact.arm_second = second.half;
  contact.approach = normal.dot(second.speed() - first.speed());
  contact.given = {};
  contact.ahead = contact.last_spin = Vector3::Zero();
  for (const Side& side : sides) {
    const std::uint32_t body = side.sign < 0 ? contact.first_body : contact.second_body;
    if (input.bodies.mobility[body] == Mobility::Kinematic) {
      contact.add_motion(side.sign, side.half, side.velocity, side.spin, contact.given);
    }
    contact.ahead += side.sign * side.last_spin.cross(side.end - side.half);
    contact.last_spin += side.sign * side.last_spin;
  }
}

bool lands(const DirectContact& contact, const std::vector<double>& velocity, double dt) {
  Six motion = contact.motion_at(velocity);
  motion[0] = contact.approach;
  const double about = motion[1];
  motion[1] -= contact.line_turn * motion[2];
  motion[2] += contact.line_turn * about;
  for (int i = 0; i < contact.law.points; ++i) {
    const double gap = std::max(contact.start_separation[i], 0.0);
    if (-contact.law.speed(i, motion) * dt - gap > 2 * tuning::min_overlap) return true;
  }
  return false;
}

void go_ahead(DirectContact& contact) {
  contact.give(contact.ahead);
  contact.given[1] += contact.line_turn * contact.axes[2].dot(contact.last_spin);
  contact.given[2] -= contact.line_turn * contact.axes[1].dot(contact.last_spin);
}

}  // namespace atl::solver
