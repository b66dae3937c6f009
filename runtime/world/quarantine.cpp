// Containment: a body whose state is no longer finite, or absurd, is taken out of the world as if it had been removed,
// so that everything else goes on as it would without it.

#include "world/quarantine.h"

#include <atoll/error.h>
#include <jobs/with_joints.h>
#include <solver/constraints/motion_locks.h>
#include <solver/integrate/state_bounds.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <sstream>

#include "world/world_impl.h"

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

// What forces would make of a dynamic body within dt that nothing holds back.
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
  if (bodies.surfaces.empty() || is_within(bodies.surfaces[body].velocity, solver::top_speed)) return {};
  return Quarantine::TooFastSurface;
}

}  // namespace

const char* quarantine_reason(Quarantine reason) {
  switch (reason) {
    case Quarantine::NotFinite:
      return "its state is not finite";
    case Quarantine::TooFar:
      return "it is farther than 1e12 m from the origin";
    case Quarantine::TooFast:
      return "its speed is above 1e6 m/s";
    case Quarantine::TooFastSpin:
      return "its angular speed is above 1e6 rad/s";
    case Quarantine::TooFastSurface:
      return "the speed of its surface is above 1e6 m/s";
    case Quarantine::TooMuchForce:
      return "forces would take its speed above 1e6 m/s in one step";
    case Quarantine::TooMuchTorque:
      return "torques would take its angular speed above 1e6 rad/s in one step";
  }
  return "";
}

std::size_t QuarantineList::find(std::uint32_t body) const {
  const auto place = std::lower_bound(bodies_.begin(), bodies_.end(), body,
                                      [](const Quarantined& entry, std::uint32_t b) { return entry.id.index < b; });
  return place != bodies_.end() && place->id.index == body ? static_cast<std::size_t>(place - bodies_.begin())
                                                           : bodies_.size();
}

void QuarantineList::add(const Quarantined& body, const Kept& kept) {
  const auto place = std::lower_bound(bodies_.begin(), bodies_.end(), body.id,
                                      [](const Quarantined& entry, BodyId id) { return entry.id < id; });
  kept_.insert(kept_.begin() + (place - bodies_.begin()), kept);
  bodies_.insert(place, body);
}

void QuarantineList::remove(std::uint32_t body) {
  const auto place = static_cast<std::ptrdiff_t>(find(body));
  kept_.erase(kept_.begin() + place);
  bodies_.erase(bodies_.begin() + place);
}

void QuarantineList::clear() {
  bodies_.clear();
  kept_.clear();
  clear_suspects();
}

void QuarantineList::suspect(std::uint32_t body) {
  if (suspected_[body] == to_check) return;
  suspected_[body] = to_check;
  suspects_.push_back(body);
}

void QuarantineList::suspect_checked(std::uint32_t body) {
  if (suspected_[body] == to_check) return;
  suspected_[body] = checked;
  any_checked_ = true;
}

const solver::BodyPose* QuarantineList::pose_before(std::uint32_t body) const {
  const auto found = poses_before_.find(body);
  return found == poses_before_.end() ? nullptr : &found->second;
}

void QuarantineList::clear_suspects() {
  if (any_checked_) {
    std::fill(suspected_.begin(), suspected_.end(), std::uint8_t{0});
    any_checked_ = false;
  } else {
    for (const std::uint32_t body : suspects_) suspected_[body] = 0;
  }
  suspects_.clear();
  poses_before_.clear();
}

// What is static stays as it is checked here, unless a caller touches it.
void World::Impl::suspect_new(std::uint32_t body) {
  const bool rests = records.type[body] == BodyType::Static;
  if (rests && !fault_in(bodies, body) && !fault_in_surface(bodies, body)) {
    quarantine.suspect_checked(body);
  } else {
    quarantine.suspect(body);
  }
}

// At the start of a step, of the bodies that callers touched: those that fail meet nothing.
void World::Impl::quarantine_suspects() {
  std::vector<std::pair<std::uint32_t, Quarantine>> failed;
  for (const std::uint32_t body : quarantine.suspects()) {
    if (!records.alive[body] || quarantine.contains(body)) continue;
    std::optional<Quarantine> fault = fault_in(bodies, body);
    if (!fault) fault = fault_in_surface(bodies, body);
    if (!fault && records.dynamic[body]) fault = fault_in_push(bodies, body, gravity, dt_);
    if (fault) failed.emplace_back(body, *fault);
  }
  std::sort(failed.begin(), failed.end());
  for (const auto& [body, reason] : failed) {
    const solver::BodyPose* before = quarantine.pose_before(body);
    const bool strayed = !solver::is_in_place(bodies.position(body), bodies.orientation(body));
    if (strayed && before) put_back(body, *before);
    put_in_quarantine(body, reason);
  }
  quarantine.clear_suspects();
}

// Before a caller moves a body: should it be moved where nothing can be, it is to be found where it was.
void World::Impl::before_move(std::uint32_t body, const Vector3& position) {
  quarantine.suspect(body);
  const solver::BodyPose now{bodies.position(body), bodies.orientation(body)};
  if (!solver::is_in_place(position, now.orientation) && solver::is_in_place(now.position, now.orientation)) {
    quarantine.remember_pose(body, now);
  }
}

void World::Impl::put_back(std::uint32_t body, const solver::BodyPose& pose) {
  bodies.position(body) = pose.position;
  bodies.set_orientation(body, pose.orientation);
}

// After the solve: what came out of it unsound is where the step found it, and still, for the rest of the step.
void World::Impl::restrain_broken() {
  broken_.clear();
  fast_.for_each([this](solver::MovedBodies& of_worker) {
    std::erase_if(of_worker.fast, [this](const solver::MovedBody& fast) {
      const std::optional<Quarantine> fault = fault_in(bodies, fast.body);
      if (!fault) return false;
      broken_.emplace_back(fast.body, *fault);
      put_back(fast.body, fast.start);
      bodies.velocity(fast.body).setZero();
      bodies.angular_velocity(fast.body).setZero();
      aabbs.mark_dirty(fast.body);
      return true;
    });
  });
  std::sort(broken_.begin(), broken_.end());
}

// At the end of the step, when nothing asks for the step's islands any more.
void World::Impl::quarantine_broken() {
  if (broken_.empty()) return;
  captured_ = false;
  for (const auto& [body, reason] : broken_) put_in_quarantine(body, reason);
}

void World::Impl::put_in_quarantine(std::uint32_t body, Quarantine reason) {
  QuarantineList::Kept kept{bodies.mobility[body], bodies.gyroscopic[body], broadphase.filter(colliders.first[body])};
  if constexpr (with_joints) suspend_joints_of(body);
  take_out(body);
  // Odometers that have lost count would spread to whatever meets the body next.
  if (!std::isfinite(bodies.turned[body])) bodies.turned[body] = 0;
  aabbs.bounds.aabb_margin[body] = 0;
  bodies.force(body).setZero();
  bodies.torque(body).setZero();
  sleeping.rest_time[body] = 0;
  aabbs.swept_margins()[body] = 0;
  quarantine.add({{body, records.generation[body]}, reason, quarantine_reason(reason), steps_}, kept);
  ++report_.quarantined;
  const auto index = static_cast<std::int64_t>(body);
  if (report_.first_non_finite_body < 0 || index < report_.first_non_finite_body) {
    report_.first_non_finite_body = index;
  }
}

void World::Impl::release_body(BodyId id) {
  const std::uint32_t body = index_of(id, "release");
  std::ostringstream message;
  message << "World::release: the body (index " << id.index << ", generation " << id.generation << ") ";
  if (!quarantine.contains(body)) {
    message << "is not in quarantine; expected one that World::quarantined() lists";
    throw Error(message.str());
  }
  std::optional<Quarantine> fault = fault_in(bodies, body);
  if (!fault) fault = fault_in_surface(bodies, body);
  if (fault) {
    message << "can't come back: " << quarantine_reason(*fault) << " (position " << bodies.position(body).transpose()
            << " m, velocity " << bodies.velocity(body).transpose() << " m/s, angular velocity "
            << bodies.angular_velocity(body).transpose()
            << " rad/s); expected a state within these bounds, see World::set_pose "
            << "and set_velocity";
    throw Error(message.str());
  }
  const QuarantineList::Kept kept = quarantine.kept(body);
  quarantine.remove(body);
  bodies.mobility[body] = kept.mobility;
  bodies.gyroscopic[body] = kept.gyroscopic;
  records.dynamic[body] = kept.mobility == solver::Mobility::Dynamic;
  sleeping.awake[body] = records.dynamic[body];
  sleeping.rest_time[body] = 0;
  if (records.dynamic[body]) selection_.arrive(body);
  contents.count(bodies, records, body, +1);
  note_arrival_or_departure(body);
  add_proxies(body, kept.filter);
  if constexpr (with_joints) resume_joints_of(body);
  quarantine.suspect(body);
}

}  // namespace atl
