#pragma once
/// Random assemblies of joined bodies, and the energy that they may have.

#include <atoll/atoll.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "support/bodies.h"
#include "support/random.h"

namespace atl::test {

/// Which assemblies to make.
struct AssemblyKind {
  bool motors = true;
  bool springs = true;
  bool ranges = true;
  bool apart = true;      ///< some start with joints that are apart by some cm and rad
  bool redundant = true;  ///< some joints twice and threefold, and more joints than make a tree
  bool pinned = true;     ///< some hang on what is static
  bool locks = false;     ///< motions of most bodies are locked
};

/// An assembly, and what can have made it move.
struct Assembly {
  WorldDef world;
  std::vector<BodyDef> bodies;
  std::vector<JointDef> joints;  ///< with `first` and `second` by place in `bodies`, as the index of an id
  std::string features;          ///< of what, for people
  double length = 0;             ///< m: no two points of it are farther apart
  double gap = 0;                ///< m or rad, by which joints start apart at most
};

/// J: energies that `world` has, of which joints' are not counted.
inline double mechanical_energy(const World& world, const std::vector<BodyId>& ids) {
  double energy = 0;
  for (const BodyId id : ids) {
    if (world.type(id) != BodyType::Dynamic) continue;
    const Matrix3 turn = world.pose(id).orientation.toRotationMatrix();
    const Vector3 spin = turn.transpose() * world.angular_velocity(id);
    const MassProperties mass = body_mass(world.definition(id));
    energy += 0.5 * mass.mass * world.velocity(id).squaredNorm() + 0.5 * spin.dot(mass.inertia * spin) -
              mass.mass * world.gravity().dot(world.centre_of_mass(id));
  }
  return energy;
}

namespace assembly {

inline double radius_of(const BodyDef& def) {
  if (const auto* ball = std::get_if<Sphere>(&def.shape)) return ball->radius;
  if (const auto* capsule = std::get_if<Capsule>(&def.shape)) return capsule->radius + capsule->half_height;
  return std::get<Box>(def.shape).half_extents.norm();
}

inline BodyDef random_body(Random& random) {
  BodyDef def;
  const double size = random.real(0.05, 0.3);
  switch (random.below(3)) {
    case 0:
      def.shape = Sphere{size};
      break;
    case 1:
      def.shape = Capsule{.radius = size * random.real(0.2, 1), .half_height = size};
      break;
    default:
      def.shape = Box{{size, size * random.real(0.1, 1), size * random.real(0.1, 1)}};
  }
  def.orientation = random.rotation(std::numbers::pi);
  return def;
}

inline JointAxis random_axis(Random& random, const AssemblyKind& kind, bool turns, std::ostringstream& words) {
  JointAxis axis;
  if (kind.ranges && random.chance(0.3)) {
    const double max = turns ? 1.5 : 0.3;
    axis.range = {-random.real(0, max), random.real(0, max)};
    if (random.chance(0.2)) axis.range.restitution = random.real(0, 1);
    words << " range";
  }
  if (kind.springs && random.chance(0.3)) {
    axis.spring = JointSpring{};
    axis.spring->rest = random.chance(0.5) ? 0 : random.real(-0.3, 0.3);
    if (random.chance(0.5)) {
      axis.spring->hertz = random.magnitude(0.5, 200);
      axis.spring->damping_ratio = random.chance(0.3) ? 0 : random.real(0, 2);
      words << " spring " << axis.spring->hertz << " Hz";
    } else {
      axis.spring->stiffness = random.magnitude(1, 1e6);
      axis.spring->damping = random.chance(0.3) ? 0 : random.magnitude(0.1, 1e3);
      words << " spring " << *axis.spring->stiffness << " N/m";
    }
  }
  if (kind.motors && random.chance(0.3)) {
    axis.motor = JointMotor{};
    axis.motor->speed = random.chance(0.3) ? 0 : random.real(-3, 3) * (turns ? 1 : 0.3);
    axis.motor->max_force = random.chance(0.2) ? unlimited : random.magnitude(0.1, 1e3);
    if (random.chance(0.3)) {
      axis.motor->servo = JointServo{.target = random.real(-0.3, 0.3),
                                     .stiffness = random.magnitude(1, 1e5),
                                     .damping = random.magnitude(0.1, 1e3)};
      words << " servo";
    }
    words << " motor " << axis.motor->speed << " by " << *axis.motor->max_force;
  }
  if (random.chance(0.1)) axis.armature = random.magnitude(0.01, 1);
  return axis;
}

inline JointKind random_kind(Random& random, const AssemblyKind& kind, std::ostringstream& words) {
  const auto axis = [&](bool turns) { return random_axis(random, kind, turns, words); };
  switch (random.below(9)) {
    case 0:
      words << " ball";
      return BallJoint{.friction = kind.motors && random.chance(0.3) ? random.magnitude(0.01, 10) : 0};
    case 1:
      words << " hinge";
      return HingeJoint{axis(true)};
    case 2:
      words << " slider";
      return SliderJoint{axis(false)};
    case 3:
      words << " fixed";
      return FixedJoint{};
    case 4: {
      words << " distance";
      DistanceJoint joint;  // its range is set to where it is
      if (kind.springs && random.chance(0.3)) joint.distance.spring = JointSpring{.hertz = random.magnitude(1, 100)};
      return joint;
    }
    case 5: {
      words << " universal";
      UniversalJoint joint;
      joint.first = axis(true);
      joint.second = axis(true);
      return joint;
    }
    case 6: {
      words << " cone";
      ConeTwistJoint joint;
      if (kind.ranges && random.chance(0.5)) joint.swing_limit = random.real(0.2, 2);
      joint.twist = axis(true);
      if (kind.motors && random.chance(0.3)) joint.swing_friction = random.magnitude(0.01, 10);
      return joint;
    }
    case 7: {
      words << " six";
      SixDofJoint joint;
      for (int i = 0; i < 3; ++i) {
        if (random.chance(0.7))
          joint.offset[i].range = {0, 0};
        else
          joint.offset[i] = axis(false);
        if (random.chance(0.5))
          joint.turn[i].range = {0, 0};
        else
          joint.turn[i] = axis(true);
      }
      return joint;
    }
    default: {
      words << " wheel";
      WheelJoint joint;
      joint.suspension = axis(false);
      if (!joint.suspension.motor && !joint.suspension.spring) joint.suspension.spring = JointSpring{.hertz = 2};
      if (random.chance(0.5)) joint.steering = axis(true);
      joint.spin = axis(true);
      return joint;
    }
  }
}

// All in one plane, along and about any axes, in place, or without turning.
inline void lock_motions(Random& random, std::vector<BodyDef>& bodies) {
  const std::uint32_t how = random.below(3);
  for (BodyDef& def : bodies) {
    if (!random.chance(0.6)) continue;
    if (how == 0) {
      def.locks = MotionLocks::plane(Axis::Y);
    } else if (how == 1) {
      for (bool& lock : def.locks.linear) lock = random.chance(0.3);
      for (bool& lock : def.locks.angular) lock = random.chance(0.3);
    } else {
      (random.chance(0.5) ? def.locks.linear : def.locks.angular) = {true, true, true};
    }
  }
}

inline Pose seen_from(const BodyDef& body, const Vector3& point, const Quaternion& turn) {
  return {body.orientation.conjugate() * (point - body.position), body.orientation.conjugate() * turn};
}

}  // namespace assembly

/// The one of a seed. `kind` says what may be in it.
inline Assembly random_assembly(std::uint32_t seed, const AssemblyKind& kind = {}) {
  using namespace assembly;
  Random random(seed);
  Assembly made;
  std::ostringstream words;

  Settings& settings = made.world.settings;
  settings.joint_solver = random.chance(0.4)   ? JointSolver::Iterative
                          : random.chance(0.5) ? JointSolver::Direct
                                               : JointSolver::Auto;
  settings.contact_solver = random.chance(0.4)   ? ContactSolver::Auto
                            : random.chance(0.5) ? ContactSolver::Direct
                                                 : ContactSolver::Iterative;
  settings.substeps = std::vector{1, 2, 4, 4, 4, 8}[random.below(6)];
  settings.stabilisation = random.chance(0.7)   ? Stabilisation::Soft
                           : random.chance(0.5) ? Stabilisation::Baumgarte
                                                : Stabilisation::SplitImpulse;
  if (random.chance(0.2)) settings.iterations = static_cast<int>(1 + random.below(4));
  if (random.chance(0.1)) settings.warm_starting = false;
  words << "joints "
        << (settings.joint_solver == JointSolver::Iterative ? "swept"
            : settings.joint_solver == JointSolver::Direct  ? "direct"
                                                            : "auto")
        << ", contacts "
        << (settings.contact_solver == ContactSolver::Auto     ? "auto"
            : settings.contact_solver == ContactSolver::Direct ? "direct"
                                                               : "swept")
        << ", substeps " << settings.substeps << ", stabilisation "
        << (settings.stabilisation == Stabilisation::Soft        ? "soft"
            : settings.stabilisation == Stabilisation::Baumgarte ? "baumgarte"
                                                                 : "split")
        << (settings.warm_starting ? "" : ", cold") << ", iterations " << settings.iterations;
  if (random.chance(0.4)) made.world.gravity.setZero();
  words << (made.world.gravity.isZero() ? ", no gravity" : ", gravity");

  // Each body beside one before it: a chain or a tree.
  const std::size_t count = 2 + random.below(11);
  const bool chain = random.chance(0.5);
  const double mass_ratio = random.chance(0.5) ? 1 : random.magnitude(1, 1000);
  const double gap = kind.apart && random.chance(0.4) ? random.magnitude(0.001, 0.1) : 0;
  const double speed = random.chance(0.5) ? 0 : random.magnitude(0.1, 10);
  const double spin = random.chance(0.5) ? 0 : random.magnitude(0.1, 10);
  const std::size_t copies = kind.redundant && random.chance(0.3) ? 2 + random.below(2) : 1;
  words << ", bodies " << count << (chain ? " chain" : " tree") << ", masses " << mass_ratio << ", gap " << gap
        << ", speed " << speed << ", spin " << spin << ", copies " << copies;
  made.gap = gap;
  std::vector<std::size_t> parents(count, 0);
  for (std::size_t i = 0; i < count; ++i) {
    BodyDef def = random_body(random);
    def.mass = random.magnitude(1, mass_ratio + 1e-9);
    def.velocity = speed * random.real(0, 1) * random.direction();
    def.angular_velocity = spin * random.real(0, 1) * random.direction();
    def.filter.group = -1;
    if (i > 0) {
      parents[i] = chain ? i - 1 : random.below(i);
      const BodyDef& parent = made.bodies[parents[i]];
      def.position = parent.position + (radius_of(parent) + radius_of(def)) * random.direction();
    }
    made.length += 2 * radius_of(def) + gap;
    made.bodies.push_back(def);
  }

  const auto join = [&](std::size_t first, std::size_t second, const Vector3& point, const Quaternion& turn) {
    JointDef joint;
    joint.kind = random_kind(random, kind, words);
    joint.first.index = static_cast<std::uint32_t>(first);
    joint.second.index = static_cast<std::uint32_t>(second);
    const double off = random.chance(0.5) ? gap : 0;
    const Vector3 aside = off * random.real(0, 1) * random.direction();
    const Quaternion askew = random.rotation(off);
    joint.frame_first = seen_from(made.bodies[first], point, turn);
    if (auto* rod = std::get_if<DistanceJoint>(&joint.kind)) {
      joint.frame_first = seen_from(made.bodies[first], made.bodies[first].position, turn);
      const double length = (made.bodies[second].position - made.bodies[first].position).norm();
      if (!rod->distance.spring) {
        const bool rope = random.chance(0.3);
        rod->distance.range = {rope ? 0 : length + off, length + off};
      } else {
        rod->distance.range = {};
        rod->distance.range.lower = 0;
        rod->distance.spring->rest = length;
      }
      joint.frame_second = seen_from(made.bodies[second], made.bodies[second].position, turn);
    } else {
      joint.frame_second = seen_from(made.bodies[second], point + aside, turn * askew);
    }
    const std::size_t times = random.chance(0.7) ? copies : 1;
    for (std::size_t i = 0; i < times; ++i) made.joints.push_back(joint);
  };
  for (std::size_t i = 1; i < count; ++i) {
    const Vector3 to_parent = made.bodies[parents[i]].position - made.bodies[i].position;
    const Vector3 point = made.bodies[i].position + to_parent.normalized() * radius_of(made.bodies[i]);
    join(parents[i], i, point, random.rotation(std::numbers::pi));
  }
  // More than a tree: rings, and two joints between the same two.
  if (kind.redundant && random.chance(0.3)) {
    const std::size_t more = 1 + random.below(3);
    words << ", loops " << more;
    for (std::size_t i = 0; i < more; ++i) {
      const std::size_t first = random.below(count), second = random.below(count);
      if (first == second) continue;
      const Vector3 middle = 0.5 * (made.bodies[first].position + made.bodies[second].position);
      join(first, second, middle, random.rotation(std::numbers::pi));
    }
  }
  if (kind.pinned && random.chance(0.5)) {
    const std::size_t pins = 1 + (random.chance(0.3) ? 1 : 0);
    words << ", pins " << pins;
    for (std::size_t i = 0; i < pins; ++i) {
      const std::size_t held = i == 0 ? 0 : random.below(count);
      const BodyDef body = made.bodies[held];
      made.bodies.push_back({.type = BodyType::Static,
                             .shape = Sphere{0.01},
                             .position = body.position + radius_of(body) * random.direction()});
      made.bodies.back().filter.group = -1;
      join(made.bodies.size() - 1, held, made.bodies.back().position, random.rotation(std::numbers::pi));
    }
  }
  if (kind.locks) lock_motions(random, made.bodies);
  made.features = words.str();
  return made;
}

/// The world of an assembly, and its bodies in order.
inline std::vector<BodyId> add_to(World& world, const Assembly& assembly) {
  std::vector<BodyId> ids;
  for (const BodyDef& def : assembly.bodies) ids.push_back(world.add_body(def));
  for (JointDef joint : assembly.joints) {
    joint.first = ids[joint.first.index];
    joint.second = ids[joint.second.index];
    world.add_joint(joint);
  }
  return ids;
}

/// J: what an assembly may gain in a time (s) beyond what it starts with, by kinds of what gives it.
struct EnergyAllowance {
  double springs = 0;  ///< what springs and servos hold, once joints have closed
  double motors = 0;   ///< the work of motors: those of limited force push no further than their speed
  double heights = 0;  ///< of its weight, over its length: what errors of motion are measured by
  double closing = 0;  ///< of bodies that move at the speed at which joints are closed
  double start = 0;    ///< the kinetic energy that it has

  double all() const { return springs + motors + heights + closing + start; }
};

/// The energy that an assembly may gain, from its first state.
inline EnergyAllowance energy_allowance(const World& world, const Assembly& made, const std::vector<BodyId>& ids,
                                        double time) {
  EnergyAllowance allowed;
  double mass = 0;
  for (const BodyId id : ids) {
    if (world.type(id) != BodyType::Dynamic) continue;
    mass += world.mass(id);
    allowed.start += world.mass(id) * world.gravity().dot(world.centre_of_mass(id));
  }
  allowed.start += mechanical_energy(world, ids);
  allowed.heights = mass * world.gravity().norm() * made.length;

  double drive = 0;  // m/s that unlimited motors add up to at most
  const auto add = [&](const JointAxis& axis, bool turns, double position, double rate, double own) {
    if (axis.range.lower == axis.range.upper) return;
    allowed.start += 0.5 * axis.armature * rate * rate;
    const double reach = made.gap;
    if (axis.spring) {
      const double off = std::abs(position - axis.spring->rest) + reach;
      const double omega = 2 * std::numbers::pi * axis.spring->hertz;
      const double stiffness =
          axis.spring->is_linear() ? axis.spring->stiffness.value_or(0) : (own + axis.armature) * omega * omega;
      allowed.springs += 0.5 * stiffness * off * off;
    }
    if (!axis.motor) return;
    const double speed = std::abs(axis.motor->speed);
    if (axis.motor->servo) {
      const JointServo& servo = *axis.motor->servo;
      const double off = std::abs(position - servo.target) + reach;
      const double held = 0.5 * servo.stiffness * off * off;
      allowed.springs += held;
      allowed.motors += 0.25 * servo.damping * speed * speed * time;
    } else if (speed == 0) {
      return;
    } else if (*axis.motor->max_force < unlimited) {
      allowed.motors += *axis.motor->max_force * speed * time;
    } else {
      drive += speed * (turns ? made.length : 1);
    }
  };
  for (const JointId id : world.joints()) {
    const JointDef& joint = world.joint(id);
    const JointState state = world.joint_state(id);
    double own = 1e300, own_turn = 1e300;
    for (const BodyId body : {joint.first, joint.second}) {
      if (world.type(body) != BodyType::Dynamic) continue;
      own = std::min(own, world.mass(body));
      own_turn = std::min(own_turn, body_mass(world.definition(body)).inertia.trace());
    }
    const auto axis = [&](const JointAxis& of, bool turns, std::size_t at) {
      add(of, turns, state.position[at], state.speed[at], turns ? own_turn : own);
    };
    std::visit(
        [&](const auto& kind) {
          using Kind = std::decay_t<decltype(kind)>;
          if constexpr (std::is_same_v<Kind, HingeJoint>) axis(kind.angle, true, 0);
          if constexpr (std::is_same_v<Kind, SliderJoint>) axis(kind.offset, false, 0);
          if constexpr (std::is_same_v<Kind, DistanceJoint>) axis(kind.distance, false, 0);
          if constexpr (std::is_same_v<Kind, UniversalJoint>) {
            axis(kind.first, true, 0);
            axis(kind.second, true, 1);
          }
          if constexpr (std::is_same_v<Kind, ConeTwistJoint>) axis(kind.twist, true, 1);
          if constexpr (std::is_same_v<Kind, SixDofJoint>) {
            for (std::size_t i = 0; i < 3; ++i) {
              axis(kind.offset[i], false, i);
              axis(kind.turn[i], true, 3 + i);
            }
          }
          if constexpr (std::is_same_v<Kind, WheelJoint>) {
            axis(kind.suspension, false, 0);
            axis(kind.steering, true, 1);
            axis(kind.spin, true, 2);
          }
        },
        joint.kind);
  }
  allowed.motors += 0.5 * mass * drive * drive;
  if (made.gap > 0) allowed.closing = 0.5 * mass * std::pow(std::min(made.gap / dt, 3.0), 2);
  return allowed;
}

}  // namespace atl::test
