// What an island's contacts are to the direct solver, and its matrix.

#include <solver/constraints/contact_inertia.h>
#include <solver/direct/direct_contacts.h>

#include <algorithm>
#include <cmath>

#include "integrate/matrix3.h"
#include "integrate/rows3.h"

namespace atl::solver {
namespace {

// Of an effective mass's inverse, that contacts give: an overlap of 5 compliance g dt^2 by own weights carried. Doubles
// hold a top box a million times as heavy as the nine below it at 1e-9; at 1e-6 it sinks by 25 mm, here by 2. Friction
// gives more, or Newton's method finds no way over its edges: what is held back by friction alone creeps by 1e-6 g dt.
constexpr double compliance = 1e-8;
constexpr double friction_compliance = 1e-6;

// Columns have one block of the factor a body, walls 5 to 10.
constexpr std::size_t factor_blocks_per_body = 12;

// rad: a body whose moments of inertia differ may not turn by more within a step.
constexpr double most_tumble = 0.3;

// Of the bound: at it, but for rounding to single precision.
constexpr double at_bound = 1 - 1e-6;

}  // namespace

bool DirectContacts::analyse(const SolveInput& input, const IslandGroup& group) {
  const std::span<const std::uint32_t> bodies = input.islands.bodies(group.begin, group.end);
  const std::span<const TouchingPair> pairs = input.islands.contacts(group.begin, group.end);
  island_ = group.begin;
  first_rank_ = input.islands.first_rank(group.begin);
  const auto same_bodies = [](const TouchingPair& a, const TouchingPair& b) {
    return a.first == b.first && a.second == b.second;
  };
  const bool same = std::equal(bodies.begin(), bodies.end(), members_.begin(), members_.end()) &&
                    std::equal(pairs.begin(), pairs.end(), pairs_.begin(), pairs_.end(), same_bodies);
  pairs_.assign(pairs.begin(), pairs.end());  // slots may be others
  if (same) return fits_;
  members_.assign(bodies.begin(), bodies.end());
  if (bodies.size() > most_bodies) return fits_ = false;
  std::vector<std::pair<std::uint32_t, std::uint32_t>> couplings;
  for (const TouchingPair& pair : pairs) {
    const std::uint32_t first = local(input, pair.first);
    const std::uint32_t second = local(input, pair.second);
    if (first != none && second != none) couplings.emplace_back(first, second);
  }
  const std::vector<std::uint8_t> sizes(bodies.size(), 6);
  return fits_ = system_.analyse(sizes, couplings, factor_blocks_per_body * bodies.size());
}

std::uint32_t DirectContacts::local(const SolveInput& input, std::uint32_t body) const {
  return input.bodies.mobility[body] == Mobility::Dynamic ? input.islands.rank(body) - first_rank_ : none;
}

bool DirectContacts::load_bodies(const SolveInput& input) {
  const BodyTable& table = input.bodies;
  const std::size_t count = members_.size();
  bodies_.resize(count);
  for (auto* numbers : {&velocity_, &free_, &gradient_, &direction_, &product_}) numbers->resize(6 * count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint32_t body = members_[i];
    const Matrix3 rotation = table.orientation(body).toRotationMatrix();
    const Vector3 spin = table.angular_velocity(body);
    if (table.gyroscopic[body] && !(input.dt * spin.norm() <= most_tumble)) return false;
    Body& of = bodies_[i];
    of.body = body;
    of.mass = 1 / table.inverse_mass[body];
    if (is_seen_heavier(input, body)) {
      of.inertia = inertia_in_contact(table, body);
      of.inverse_inertia = inverse_inertia_in_contact(table, body);
    } else {
      of.inertia = rotation * table.inertia[body] * rotation.transpose();
      of.inverse_inertia = rotation * table.inverse_inertia[body] * rotation.transpose();
    }
    of.radius = std::sqrt(of.inertia.trace() / (3 * of.mass));
    of.acceleration = input.gravity * table.gravity_scale[body] + table.inverse_mass[body] * table.force(body);
    const Vector3 turning = of.inverse_inertia * (table.torque(body) - spin.cross(of.inertia * spin));
    Eigen::Map<Vector3> velocity(&free_[6 * i]);
    Eigen::Map<Vector3> angular(&free_[6 * i + 3]);
    // As sweeps would in their substeps.
    const double h = input.dt / input.settings.substeps;
    velocity = table.velocity(body);
    angular = spin;
    for (int k = 0; k < input.settings.substeps; ++k) {
      velocity = (velocity + h * of.acceleration) / (1 + h * table.linear_damping[body]);
      angular = (angular + h * turning) / (1 + h * table.angular_damping[body]);
    }
  }
  load_velocities(input);
  return true;
}

// Those of the start of the step.
void DirectContacts::load_velocities(const SolveInput& input) {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    Eigen::Map<Vector3> velocity(&velocity_[6 * i]);
    Eigen::Map<Vector3> angular(&velocity_[6 * i + 3]);
    velocity = input.bodies.velocity(bodies_[i].body);
    angular = input.bodies.angular_velocity(bodies_[i].body);
  }
}

// Returns false if one bounces: that wants the impact's speed.
bool DirectContacts::load_contacts(const SolveInput& input) {
  contacts_.resize(pairs_.size());
  for (std::size_t c = 0; c < pairs_.size(); ++c) {
    Contact& contact = contacts_[c];
    load_contact(input, pairs_[c], contact);
    if (input.manifolds[contact.slot].restitution == 0) continue;
    const Six motion = motion_now(contact);
    for (int i = 0; i < contact.law.points; ++i) {
      if (contact.law.speed(i, motion) < -input.settings.restitution_threshold) return false;
    }
  }
  return true;
}

void DirectContacts::load_contact(const SolveInput& input, const TouchingPair& pair, Contact& contact) const {
  const BodyTable& table = input.bodies;
  const collision::ContactManifold& manifold = input.manifolds[pair.slot];
  contact.slot = pair.slot;
  contact.first = local(input, pair.first);
  contact.second = local(input, pair.second);
  contact.friction = manifold.friction;
  contact.lever = manifold.lever;
  contact.rolling = contact.torsional = 0;
  place(input, pair, contact);

  const double inverse_mass = table.inverse_mass[pair.first] + table.inverse_mass[pair.second];
  const auto response = [&](const Vector3& first, const Vector3& second) {
    double sum = 0;
    if (contact.first != none) sum += first.dot(bodies_[contact.first].inverse_inertia * first);
    if (contact.second != none) sum += second.dot(bodies_[contact.second].inverse_inertia * second);
    return sum;
  };
  ContactLaw& law = contact.law;
  law.points = 0;
  for (int i = 0; i < collision::max_points; ++i) {
    if (manifold.separation[i] >= collision::no_point) continue;
    const int p = law.points++;
    const double x = law.x[p] = manifold.x[i];
    const double y = law.y[p] = manifold.y[i];
    // (arm + x t1 + y t2) x n, of which t1 x n = -t2 and t2 x n = t1
    const Vector3 offset = y * contact.axes[1] - x * contact.axes[2];
    const double k = inverse_mass + response(contact.arm_first.cross(contact.axes[0]) + offset,
                                             contact.arm_second.cross(contact.axes[0]) + offset);
    contact.mass[p] = 1 / k;
    contact.separation[p] = manifold.separation[i];
  }
  const auto along_tangent = [&](const Vector3& axis) {
    return inverse_mass + response(contact.arm_first.cross(axis), contact.arm_second.cross(axis));
  };
  const double along = 0.5 * (along_tangent(contact.axes[1]) + along_tangent(contact.axes[2]));
  const double twist = response(contact.axes[0], contact.axes[0]);
  law.friction_stiffness = 1 / (friction_compliance * along);
  law.twist_stiffness = twist > 0 ? 1 / (friction_compliance * twist) : 0;
  law.pyramid = input.settings.pyramid;
  law.slip = {0, 0};
  law.rolling_stiffness = 0;
  if (input.surface_contacts != nullptr) {
    SurfaceContact& surface = input.surface_contacts[pair.slot];
    note_surfaces_of(pair, table, manifold, surface);
    const Vector3 slip = get3(surface.slip);
    law.slip = {slip.dot(contact.axes[1]), slip.dot(contact.axes[2])};
    contact.rolling = surface.rolling_friction;
    contact.torsional = surface.torsional_friction;
    const double rolls =
        0.5 * (response(contact.axes[1], contact.axes[1]) + response(contact.axes[2], contact.axes[2]));
    if (contact.rolling > 0 && rolls > 0) law.rolling_stiffness = 1 / (friction_compliance * rolls);
  }
  warm_start(input, contact);
}

// Contacts stop what closes them, and no more.
void DirectContacts::stop_contacts(const SolveInput& input) {
  for (Contact& contact : contacts_) {
    for (int i = 0; i < contact.law.points; ++i) {
      contact.law.stiffness[i] = contact.mass[i] / compliance;
      contact.law.bias[i] = std::max(contact.separation[i], 0.0) / input.dt;
    }
  }
}

// They part their overlap: as the springs that they are said to be, or as fast as sweeps would.
void DirectContacts::push_contacts_apart(const SolveInput& input) {
  const SolverSettings& settings = input.settings;
  const bool soft = settings.contact_hertz > 0;
  struct Push {
    double rate;  // 1/s, of the overlap
    double held;  // of the mass
  };
  const auto push_from = [&](bool fixed) -> Push {
    if (!soft) return {SubstepConstants::parting_rate(settings, input.dt, fixed), 1 / compliance};
    const double hertz = fixed ? 2 * settings.contact_hertz : settings.contact_hertz;
    const Softness spring = Softness::of(hertz, settings.contact_damping_ratio, input.dt);
    return {spring.bias_rate, static_cast<double>(spring.mass_scale) / spring.impulse_scale};
  };
  const Push from_fixed = push_from(true);
  const Push from_dynamic = push_from(false);
  for (Contact& contact : contacts_) {
    const Push& push = contact.fixed() ? from_fixed : from_dynamic;
    for (int i = 0; i < contact.law.points; ++i) {
      const double separation = contact.separation[i];
      const bool apart = separation > 0;
      contact.law.stiffness[i] = contact.mass[i] * (apart ? 1 / compliance : push.held);
      contact.law.bias[i] =
          apart ? separation / input.dt : std::max(push.rate * separation, -settings.contact_push_speed);
    }
    if (soft) contact.factored.points = 0xff;
  }
}

void DirectContacts::place(const SolveInput& input, const TouchingPair& pair, Contact& contact) const {
  const BodyTable& table = input.bodies;
  const collision::ContactManifold& manifold = input.manifolds[pair.slot];
  const collision::Tangents tangents = collision::tangents(manifold.normal);
  const Vector3 normal = get3(manifold.normal).normalized();
  const Vector3 nearly(tangents.first[0], tangents.first[1], tangents.first[2]);
  const Vector3 tangent = (nearly - normal.dot(nearly) * normal).normalized();
  contact.axes = {normal, tangent, normal.cross(tangent)};
  contact.given = {};
  const auto place_side = [&](std::uint32_t body, const float(&anchor)[3], Vector3& arm, double sign) {
    // A ball is touched on the line through its centre.
    arm = table.ball[body] ? Vector3(normal.dot(get3(anchor)) * normal) : get3(anchor);
    if (table.mobility[body] != Mobility::Kinematic) return;
    contact.add_motion(sign, arm, table.velocity(body), table.angular_velocity(body), contact.given);
  };
  place_side(pair.first, manifold.anchor_first, contact.arm_first, -1);
  place_side(pair.second, manifold.anchor_second, contact.arm_second, 1);
}

// The pieces that the last step's impulses were on.
void DirectContacts::warm_start(const SolveInput& input, Contact& contact) {
  const collision::ContactManifold& manifold = input.manifolds[contact.slot];
  const double substeps = input.settings.substeps;
  ContactAnswer& answer = contact.answer;
  answer = {};
  int point = 0;
  for (int i = 0; i < collision::max_points; ++i) {
    if (manifold.separation[i] >= collision::no_point) continue;
    answer.normal[point] = substeps * manifold.normal_impulse[i];
    if (manifold.normal_impulse[i] > 0) answer.pieces.points |= static_cast<std::uint8_t>(1 << point);
    ++point;
  }
  const double load = answer.load();
  contact.bound_friction(load);
  const Vector3 friction = substeps * get3(manifold.friction_impulse);
  answer.friction = {friction.dot(contact.axes[1]), friction.dot(contact.axes[2])};
  answer.twist = substeps * manifold.twist_impulse;
  const auto is_bound = [](double impulse, double bound) { return std::abs(impulse) >= at_bound * bound; };
  if (contact.law.pyramid) {
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const bool slides = is_bound(answer.friction[axis], contact.law.friction_bound);
      answer.pieces.slides |= static_cast<std::uint8_t>(slides ? 1 << axis : 0);
    }
  } else {
    answer.pieces.slides = is_bound(friction.norm(), contact.law.friction_bound) ? 3 : 0;
  }
  answer.pieces.spins = is_bound(answer.twist, contact.law.twist_bound);
  if (contact.law.rolling_stiffness > 0) {
    const Vector3 rolling = substeps * get3(input.surface_contacts[contact.slot].rolling_impulse);
    answer.rolling = {rolling.dot(contact.axes[1]), rolling.dot(contact.axes[2])};
    answer.pieces.rolls = is_bound(rolling.norm(), contact.law.rolling_bound);
  }
  if (load > 0) return;
  // It has just begun.
  for (int i = 0; i < contact.law.points; ++i) {
    if (contact.separation[i] <= 0) answer.pieces.points |= static_cast<std::uint8_t>(1 << i);
  }
}

void DirectContacts::Contact::add_motion(double sign, const Vector3& arm, const Vector3& v, const Vector3& w,
                                         Six& to) const {
  const Vector3 at_centre = v + w.cross(arm);
  for (int axis = 0; axis < 3; ++axis) {
    to[along(axis)] += sign * axes[axis].dot(at_centre);
    to[about(axis)] += sign * axes[axis].dot(w);
  }
}

void DirectContacts::Contact::bound_friction(double load) {
  bound_load = load;
  law.friction_bound = friction * load;
  law.twist_bound = lever * law.friction_bound + torsional * load;
  law.rolling_bound = rolling * load;
}

Six DirectContacts::Contact::motion_after(double t) const {
  Six after = motion;
  for (int k = 0; k < 6; ++k) after[k] += t * change[k];
  return after;
}

// What velocities make of the motion.
Six DirectContacts::motion_of(const Contact& contact, const std::vector<double>& velocities) const {
  Six motion = {};
  const auto add = [&](std::uint32_t body, const Vector3& arm, double sign) {
    if (body == none) return;
    contact.add_motion(sign, arm, Eigen::Map<const Vector3>(&velocities[6 * body]),
                       Eigen::Map<const Vector3>(&velocities[6 * body + 3]), motion);
  };
  add(contact.first, contact.arm_first, -1);
  add(contact.second, contact.arm_second, 1);
  return motion;
}

Six DirectContacts::motion_now(const Contact& contact) const {
  Six motion = motion_of(contact, velocity_);
  for (int k = 0; k < 6; ++k) motion[k] += contact.given[k];
  return motion;
}

void DirectContacts::add_impulse(const Contact& contact, const Six& impulse, double sign,
                                 std::vector<double>& to) const {
  const Vector3 force = impulse[0] * contact.axes[0] + impulse[3] * contact.axes[1] + impulse[4] * contact.axes[2];
  const Vector3 couple = impulse[1] * contact.axes[1] + impulse[2] * contact.axes[2] + impulse[5] * contact.axes[0];
  const auto add = [&](std::uint32_t body, const Vector3& arm, double side) {
    if (body == none) return;
    const Vector3 torque = couple + arm.cross(force);
    for (int k = 0; k < 3; ++k) {
      to[6 * body + k] += side * force[k];
      to[6 * body + 3 + k] += side * torque[k];
    }
  };
  add(contact.first, contact.arm_first, -sign);
  add(contact.second, contact.arm_second, sign);
}

void DirectContacts::mass_times(const std::vector<double>& velocities, std::vector<double>& product) const {
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const Vector3 linear = bodies_[i].mass * Eigen::Map<const Vector3>(&velocities[6 * i]);
    const Vector3 angular = bodies_[i].inertia * Eigen::Map<const Vector3>(&velocities[6 * i + 3]);
    for (int k = 0; k < 3; ++k) {
      product[6 * i + k] = linear[k];
      product[6 * i + 3 + k] = angular[k];
    }
  }
}

bool DirectContacts::is_factored() const {
  // Where something slides its stiffness is another at each motion.
  return std::all_of(contacts_.begin(), contacts_.end(), [](const Contact& contact) {
    const ContactPieces& pieces = contact.answer.pieces;
    const bool turns = (pieces.slides != 0 && !contact.law.pyramid) || pieces.rolls;
    return contact.factored == pieces && !turns;
  });
}

bool DirectContacts::factor() {
  add_masses();
  for (Contact& contact : contacts_) {
    add_stiffness(contact, contact.law.derivative(contact.motion, contact.answer.pieces));
    contact.factored = contact.answer.pieces;
  }
  return system_.factor();
}

void DirectContacts::add_masses() {
  system_.clear();
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    const auto node = static_cast<std::uint32_t>(i);
    double* block = system_.values(system_.block_index(node, node));
    for (int k = 0; k < 3; ++k) {
      block[7 * k] = bodies_[i].mass;
      for (int r = 0; r < 3; ++r) block[(3 + r) + 6 * (3 + k)] = bodies_[i].inertia(r, k);
    }
  }
}

// J^T K J, with K the derivative of the contact's impulses by its motion and J that of its motion by the velocities. K
// is put into the world's frame at the contact's centre, [P Q; Q^T S] of forces and couples by speeds and spins, and
// moved to the bodies' centres by their arms.
void DirectContacts::add_stiffness(const Contact& contact, const std::array<Six, 6>& k) {
  const auto& [n, t1, t2] = contact.axes;
  const Vector3 leans = k[0][1] * t1 + k[0][2] * t2;
  Matrix3 p, q, s;
  for (int c = 0; c < 3; ++c) {
    const double p_n = k[0][0] * n[c], p_1 = k[3][3] * t1[c] + k[3][4] * t2[c], p_2 = k[3][4] * t1[c] + k[4][4] * t2[c];
    const double s_n = k[5][5] * n[c], s_1 = k[1][1] * t1[c] + k[1][2] * t2[c], s_2 = k[1][2] * t1[c] + k[2][2] * t2[c];
    for (int r = 0; r < 3; ++r) {
      p(r, c) = p_n * n[r] + p_1 * t1[r] + p_2 * t2[r];
      q(r, c) = leans[c] * n[r];
      s(r, c) = s_n * n[r] + s_1 * t1[r] + s_2 * t2[r];
    }
  }
  struct Side {
    Vector3 arm;
    Matrix3 forces;   // by spins
    Matrix3 crossed;  // [arm] q
  };
  const auto side_of = [&](const Vector3& arm) { return Side{arm, q + crossed(arm, p).transpose(), crossed(arm, q)}; };
  const auto add = [&](std::uint32_t row, const Side& of_row, std::uint32_t column, const Side& of_column,
                       double sign) {
    double* block = system_.values(system_.block_index(row, column));
    const Matrix3 turns = crossed(of_row.arm, of_column.forces);
    for (int c = 0; c < 3; ++c) {
      for (int r = 0; r < 3; ++r) {
        block[r + 6 * c] += sign * p(r, c);
        block[3 + r + 6 * c] += sign * of_row.forces(c, r);
        block[r + 6 * (3 + c)] += sign * of_column.forces(r, c);
        block[3 + r + 6 * (3 + c)] += sign * (turns(r, c) + of_column.crossed(c, r) + s(r, c));
      }
    }
  };
  const Side first = side_of(contact.arm_first);
  const Side second = side_of(contact.arm_second);
  if (contact.first != none) add(contact.first, first, contact.first, first, 1);
  if (contact.second != none) add(contact.second, second, contact.second, second, 1);
  if (contact.first == none || contact.second == none) return;
  // A block has the rows of what is eliminated later.
  if (system_.is_earlier(contact.first, contact.second)) {
    add(contact.second, second, contact.first, first, -1);
  } else {
    add(contact.first, first, contact.second, second, -1);
  }
}

}  // namespace atl::solver
