// Containment: a body whose state is no longer finite, or absurd, is taken out of the world as if it had been removed,
// so that everything else goes on as it would without it.

#include "world/containment.h"

#include <atoll/error.h>
#include <features/with_joints.h>
#include <jobs/assert.h>
#include <solver/integrate/motion_locks.h>
#include <solver/integrate/state_bounds.h>

#include <algorithm>
#include <optional>
#include <sstream>

#include "world/bodies.h"
#include "world/colliders.h"
#include "world/joints.h"

namespace atl {
namespace {

std::optional<Quarantine> fault_in(const solver::BodyTable& bodies, std::uint32_t body) {
  if (solver::is_sound(bodies, body)) return {};
  const bool finite = bodies.position(body).allFinite() && bodies.orientation(body).coeffs().allFinite() &&
                      bodies.velocity(body).allFinite() && bodies.angular_velocity(body).allFinite();
  if (!finite) return Quarantine::NotFinite;
  if (bodies.position(body).squaredNorm() > solver::farthest * solver::farthest) return Quarantine::TooFar;
  return bodies.velocity(body).norm() > solver::top_speed ? Quarantine::TooFast : Quarantine::TooFastSpin;
}

bool is_within(const Vector3& velocity, double bound) { return velocity.squaredNorm() <= bound * bound; }

// The fault in the motion that forces alone would give a dynamic body within dt.
std::optional<Quarantine> fault_in_push(const solver::BodyTable& bodies, std::uint32_t body, const Vector3& gravity,
                                        double dt) {
  const Vector3 force = bodies.force(body);
  const Vector3 torque = bodies.torque(body);
  if (!force.allFinite() || !torque.allFinite()) return Quarantine::NotFinite;
  const Vector3 acceleration = solver::linear_acceleration(bodies, body, gravity);
  if (!is_within(bodies.velocity(body) + dt * acceleration, solver::top_speed)) return Quarantine::TooMuchForce;
  if (torque.isZero(0)) return {};
  const Vector3 turn = solver::angular_response(bodies, body, torque);
  if (!is_within(bodies.angular_velocity(body) + dt * turn, solver::top_spin)) return Quarantine::TooMuchTorque;
  return {};
}

// A belt that runs at such a speed would tear away whatever touched it.
std::optional<Quarantine> fault_in_surface(const solver::BodyTable& bodies, std::uint32_t body) {
  if (bodies.surfaces.empty()) return {};
  const solver::SurfaceMotion& motion = bodies.surfaces[body].motion;
  if (is_within(motion.velocity, solver::top_speed) && is_within(motion.angular_velocity, solver::top_spin)) return {};
  return Quarantine::TooFastSurface;
}

void put_back(Stores& world, std::uint32_t body, const solver::BodyPose& pose) {
  world.bodies.position(body) = pose.position;
  world.bodies.set_orientation(body, pose.orientation);
}

}  // namespace

void suspect_new(Stores& world, std::uint32_t body) {
  const bool rests = world.records.type[body] == BodyType::Static;
  if (rests && !fault_in(world.bodies, body) && !fault_in_surface(world.bodies, body)) {
    world.quarantine.suspect_checked(body);
  } else {
    world.quarantine.suspect(body);
  }
}

std::vector<QuarantineFault> quarantine_suspects(Stores& world) {
  std::vector<QuarantineFault> failed;
  for (const std::uint32_t body : world.quarantine.suspects()) {
    if (!world.records.alive[body] || world.quarantine.contains(body)) continue;
    std::optional<Quarantine> fault = fault_in(world.bodies, body);
    if (!fault) fault = fault_in_surface(world.bodies, body);
    if (!fault && world.records.dynamic[body]) fault = fault_in_push(world.bodies, body, world.gravity, world.clock.dt);
    if (fault) failed.emplace_back(body, *fault);
  }
  std::sort(failed.begin(), failed.end());
  for (const auto& [body, reason] : failed) {
    const solver::BodyPose* before = world.quarantine.pose_before(body);
    const bool strayed = !solver::is_in_place(world.bodies.position(body), world.bodies.orientation(body));
    if (strayed && before) put_back(world, body, *before);
    put_in_quarantine(world, body, reason);
  }
  world.quarantine.clear_suspects();
  return failed;
}

void before_move(Stores& world, std::uint32_t body, const Vector3& position) {
  world.quarantine.suspect(body);
  const solver::BodyPose now{world.bodies.position(body), world.bodies.orientation(body)};
  if (!solver::is_in_place(position, now.orientation) && solver::is_in_place(now.position, now.orientation)) {
    world.quarantine.remember_pose(body, now);
  }
}

void restrain_broken(Stores& world, solver::FastBodies& moved, std::vector<QuarantineFault>& broken) {
  broken.clear();
  moved.for_each([&](solver::MovedBodies& of_worker) {
    std::erase_if(of_worker.fast, [&](const solver::MovedBody& fast) {
      const std::optional<Quarantine> fault = fault_in(world.bodies, fast.body);
      if (!fault) return false;
      broken.emplace_back(fast.body, *fault);
      put_back(world, fast.body, fast.start);
      world.bodies.velocity(fast.body).setZero();
      world.bodies.angular_velocity(fast.body).setZero();
      world.aabbs.mark_dirty(fast.body);
      return true;
    });
  });
  std::sort(broken.begin(), broken.end());
  ATL_ASSERT(std::adjacent_find(broken.begin(), broken.end()) == broken.end(), broken.size());
}

namespace {

// Takes the body out of all that a step goes through. It can come back.
void leave(Stores& world, std::uint32_t body) {
  ATL_ASSERT(world.records.alive[body] && !world.quarantine.contains(body), body);
  if constexpr (with_joints) suspend_joints_of(world, body);
  take_out(world, body);
  // How far it got before it broke depends on what else was done in the step.
  world.bodies.turned[body] = 0;
  world.aabbs.bounds.aabb_margin[body] = 0;
  world.bodies.clear_push(body);
  world.sleeping.rest_time[body] = 0;
  world.aabbs.swept_margins()[body] = 0;
}

// Puts the body back as it is now: it may have been given another mass or shape while it was out.
void come_back(Stores& world, std::uint32_t body) {
  ATL_ASSERT(world.records.alive[body] && world.quarantine.contains(body), body);
  ATL_ASSERT(!world.sleeping.is_asleep(body), body);
  const BodyConstants& constants = *world.records.constants[body];
  world.quarantine.remove(body);
  world.bodies.mobility[body] = mobility_of(constants.type);
  world.bodies.gyroscopic[body] = constants.gyroscopic;
  world.records.dynamic[body] = constants.type == BodyType::Dynamic;
  world.sleeping.awake[body] = world.records.dynamic[body];
  world.sleeping.rest_time[body] = 0;
  world.contents.count(world.bodies, world.records, body, +1);
  mark_arrival_or_departure(world, body);
  add_proxies(world, body);
  if constexpr (with_joints) resume_joints_of(world, body);
  world.quarantine.suspect(body);
}

}  // namespace

void put_in_quarantine(Stores& world, std::uint32_t body, Quarantine reason) {
  leave(world, body);
  world.quarantine.add({{body, world.records.generation[body]}, reason, quarantine_reason(reason), world.clock.steps});
}

void release_body(Stores& world, std::uint32_t body) {
  const BodyId id = id_of(world, body);
  std::ostringstream message;
  message << "World::release: the body (index " << id.index << ", generation " << id.generation << ") ";
  if (!world.quarantine.is_quarantined(body)) {
    message << "is not in quarantine; expected one that World::quarantined() lists";
    throw Error(message.str());
  }
  std::optional<Quarantine> fault = fault_in(world.bodies, body);
  if (!fault) fault = fault_in_surface(world.bodies, body);
  if (fault) {
    message << "can't come back: " << quarantine_reason(*fault) << " (position "
            << world.bodies.position(body).transpose() << " m, velocity " << world.bodies.velocity(body).transpose()
            << " m/s, angular velocity " << world.bodies.angular_velocity(body).transpose()
            << " rad/s); expected a state within these bounds, see World::set_pose "
            << "and set_velocity";
    throw Error(message.str());
  }
  come_back(world, body);
}

void set_enabled(Stores& world, std::uint32_t body, bool enabled) {
  if (world.quarantine.is_quarantined(body)) {
    throw Error("World::set_enabled: the body is in quarantine; expected one that is not, see World::release");
  }
  if (enabled != world.quarantine.is_disabled(body)) return;
  if (enabled) {
    come_back(world, body);
    return;
  }
  const Vector3 velocity = world.bodies.velocity(body);
  const Vector3 angular_velocity = world.bodies.angular_velocity(body);
  leave(world, body);
  world.quarantine.disable(body);
  world.bodies.velocity(body) = velocity;
  world.bodies.angular_velocity(body) = angular_velocity;
}

}  // namespace atl
