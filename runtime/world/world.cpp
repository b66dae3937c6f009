// The public face of World: checks arguments and hands on.

#include <atoll/snapshot.h>
#include <atoll/step_length.h>
#include <atoll/world.h>
#include <features/with_joints.h>
#include <features/with_recording.h>
#include <features/with_snapshots.h>
#include <jobs/stopwatch.h>
#include <solver/integrate/motion_locks.h>
#include <solver/integrate/trigonometry.h>

#include <atomic>
#include <cmath>
#include <limits>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "state/body_hashes.h"
#include "state/recorder.h"
#include "state/restore.h"
#include "step/forced_step.h"
#include "step/results.h"
#include "step/sensors.h"
#include "world/bodies.h"
#include "world/body_definition.h"
#include "world/colliders.h"
#include "world/containment.h"
#include "world/joints.h"
#include "world/left_out.h"
#include "world/make_joint.h"
#include "world/materials.h"
#include "world/put_to_sleep.h"
#include "world/redefine.h"
#include "world/refuse.h"
#include "world/settings_check.h"
#include "world/world_impl.h"

namespace atl {
namespace {

int checked_threads(const char* what, int threads) {
  if (threads >= 1 && threads <= 1024) return threads;
  std::ostringstream message;
  message << what << " is " << threads << "; expected 1 to 1024";
  throw Error(message.str());
}

const Settings& checked(const Settings& settings) {
  check(settings);
  return settings;
}

void check_step(const char* call, double dt) {
  if (dt >= shortest_step && dt <= longest_step) return;
  std::ostringstream message;
  message << call << ": dt is " << dt << "; expected a number from 1e-12 to 1 (s)";
  throw Error(message.str());
}

// Worlds are numbered as they are made. The number goes into no result: it tells whose a snapshot is.
std::uint64_t next_serial() {
  static std::atomic<std::uint64_t> last = 0;
  return ++last;
}

// Makes a change of a world, and has the call recorded if there is a recording.
template <typename Call>
void change(auto& impl, const auto& make, const auto&... arguments) {
  impl.step_guard.change([&] {
    make();
    if constexpr (with_recording) {
      if (impl.recorder) impl.recorder->note(Call(arguments...));
    }
  });
}

// The same of joints, which a build may be without.
template <typename Call>
void change_joints(auto& impl, const auto& make, const auto&... arguments) {
  const auto make_if_built = [&] {
    if constexpr (with_joints) make(impl.stores);
  };
  change<Call>(impl, make_if_built, arguments...);
}

}  // namespace

World::Impl::Impl(const WorldDef& def)
    : arena(checked_threads("WorldDef.threads", def.threads), def.dynamic_threads), serial(next_serial()) {
  stores.gravity = def.gravity;
  stores.settings = checked(def.settings);
  use_kernels(def.settings.simd);
  check_finite("WorldDef.gravity", def.gravity);
}

void World::Impl::use_kernels(Simd simd) {
  kernels = &kernels_for(simd);
  narrowphase_kernels = collision::find_narrowphase_kernels(kernels->name);
}

StepReport World::Impl::step(double dt) {
  begin_step();
  return advance(dt, stores.settings.substeps, true);
}

void World::Impl::begin_step() {
  ++stores.clock.steps;
  stores.results.joint_events.clear();
  pipeline.begin_step();
}

StepReport World::Impl::advance(double dt, int substeps, bool ends_step) {
  const jobs::Clock::time_point start = jobs::Clock::now();
  StepReport report;
  StepClock& clock = stores.clock;
  clock.dt = dt;
  stores.results.contact_forces_valid = false;
  stores.results.captured = stores.settings.keep_contact_problem;
  rules.note = nullptr;
  if constexpr (with_recording) {
    if (recorder) {
      rules.note = [this](std::uint32_t question, const ContactAnswers& answers) {
        recorder->record_answers(question, answers);
      };
    }
  }
  ContactRules* const asked = rules.filters() || rules.modifies() ? &rules : nullptr;
  step_guard.change([&] {
    pipeline.run(stores, {substeps, ends_step, arena, *kernels, *narrowphase_kernels, asked, report});
  });
  clock.last_substep = dt / substeps;
  clock.last_dt = dt;
  clock.time += dt;
  report_features(stores, pipeline, rules, recorder != nullptr, report);
  report.ms = jobs::ms_since(start);
  return report;
}

void World::Impl::check_idle(const char* call, bool makes_anew) const {
  step_guard.check_thread(call, "World::");
  if (!makes_anew) step_guard.check_whole(call, "World::");
  const char* who = asking != nullptr ? asking : rules.asking();
  if (who == nullptr) return;
  throw Error(std::string("World::") + call + ": found a step under way; expected no call of it from " + who +
              ", which may only look");
}

std::uint32_t World::Impl::index_to_change(BodyId id, const char* call) const {
  check_idle(call);
  return index_of(stores, id, call);
}

std::uint32_t World::Impl::index_to_change(JointId id, const char* call) const {
  check_idle(call);
  return index_of(stores, id, call);
}

BodyId World::Impl::add_body(const CheckedBody& start) {
  return step_guard.change([&] {
    viewed.make_room(stores.bodies, stores.bodies.size() + 1);
    const BodyId id = atl::add_body(stores, start);
    query_gate.note(stores.broadphase);
    if constexpr (with_recording) {
      if (recorder) recorder->record_body(start, fingerprint(start.constants));
    }
    return id;
  });
}

void World::Impl::redefine(std::uint32_t body, const BodyConstants& constants) {
  step_guard.change([&] {
    atl::redefine(stores, body, constants);
    query_gate.note(stores.broadphase);
    if constexpr (with_recording) {
      if (recorder) recorder->record_shape(id_of(stores, body), constants, fingerprint(constants));
    }
  });
}

void World::Impl::observe(const World& world, const StepReport& report, double dt) {
  struct Telling {
    const char*& asking;
    explicit Telling(const char*& who) : asking(who) { asking = "a step observer"; }
    ~Telling() { asking = nullptr; }
  } const telling(asking);
  for (std::size_t i = 0; i < observers.size();) {
    if (observers[i](world, report, dt)) {
      ++i;
    } else {
      observers.erase(observers.begin() + static_cast<std::ptrdiff_t>(i));
    }
  }
}

World::Impl::~Impl() {
  if constexpr (with_recording) end_recording();
}

namespace {

// Checks and records a step, which is done by `step()`.
template <typename Step>
StepReport take_step(const World& world, auto& impl, double dt, bool forced, const Step& step) {
  check_step("World::step", dt);
  impl.check_idle("step");
  const StepGuard::Step under_way(impl.step_guard, "World::step");
  if constexpr (with_recording) {
    if (impl.recorder) impl.recorder->record_step(dt, forced, impl.stores.settings.run_everything, impl.rules);
  }
  impl.rules.begin_step(world);
  begin_accelerations(impl.stores);
  begin_sensing(impl.stores);
  const StepReport report = step();
  end_accelerations(impl.stores, dt);
  if constexpr (with_recording) {
    if (impl.recorder) impl.record_result();
  }
  if (!impl.observers.empty()) impl.observe(world, report, dt);
  impl.rules.rethrow();
  return report;
}

}  // namespace

World::World(const WorldDef& def) : impl_(std::make_unique<Impl>(def)) {}
World::~World() = default;

World::World(World&& other) {
  if (other.impl_ != nullptr) other.impl_->check_not_in_batch();
  impl_ = std::move(other.impl_);
}

World& World::operator=(World&& other) {
  for (const World* world : {this, &other}) {
    if (world->impl_ != nullptr) world->impl_->check_not_in_batch();
  }
  impl_ = std::move(other.impl_);
  return *this;
}

void World::stay_in_batch() { impl_->in_batch = true; }

BodyId World::add_body(const BodyDef& def) {
  impl_->check_idle("add_body");
  return impl_->add_body(check(def));
}

void World::remove_body(BodyId id) {
  const std::uint32_t body = impl_->index_to_change(id, "remove_body");
  change<calls::RemoveBody>(
      *impl_, [&] { atl::remove_body(impl_->stores, body); }, id);
}

bool World::contains(BodyId id) const { return atl::contains(impl_->stores, id); }

std::size_t World::body_count() const { return impl_->stores.records.count; }

std::vector<BodyId> World::bodies() const {
  const BodyRecords& records = impl_->stores.records;
  std::vector<BodyId> ids;
  ids.reserve(records.count);
  for (std::uint32_t body = 0; body < records.alive.size(); ++body) {
    if (records.alive[body]) ids.push_back({body, records.generation[body]});
  }
  return ids;
}

std::optional<BodyId> World::find_body(std::string_view name) const {
  for (const auto& [body, its] : impl_->stores.records.names) {
    if (its == name) return id_of(impl_->stores, body);
  }
  return std::nullopt;
}

Pose World::pose(BodyId id) const { return pose_of(impl_->stores, index_of(impl_->stores, id, "pose")); }

BodyState World::state(BodyId id) const {
  const std::uint32_t body = index_of(impl_->stores, id, "state");
  return {pose_of(impl_->stores, body), impl_->stores.bodies.velocity(body),
          impl_->stores.bodies.angular_velocity(body)};
}

Vector3 World::centre_of_mass(BodyId id) const {
  return impl_->stores.bodies.position(index_of(impl_->stores, id, "centre_of_mass"));
}

Vector3 World::velocity(BodyId id) const {
  return impl_->stores.bodies.velocity(index_of(impl_->stores, id, "velocity"));
}

Vector3 World::angular_velocity(BodyId id) const {
  return impl_->stores.bodies.angular_velocity(index_of(impl_->stores, id, "angular_velocity"));
}

double World::mass(BodyId id) const {
  const double inverse = impl_->stores.bodies.inverse_mass[index_of(impl_->stores, id, "mass")];
  return inverse > 0 ? 1 / inverse : std::numeric_limits<double>::infinity();
}

BodyType World::type(BodyId id) const { return impl_->stores.records.type[index_of(impl_->stores, id, "type")]; }

bool World::is_asleep(BodyId id) const {
  return impl_->stores.sleeping.is_asleep(index_of(impl_->stores, id, "is_asleep"));
}

BoundingBox World::bounds(BodyId id) const { return bounds_of(impl_->stores, index_of(impl_->stores, id, "bounds")); }

BodyDef World::definition(BodyId id) const {
  return definition_of(impl_->stores, index_of(impl_->stores, id, "definition"));
}

void World::set_pose(BodyId id, const Pose& pose) {
  const std::uint32_t body = impl_->index_to_change(id, "set_pose");
  check_finite("World::set_pose: pose.position", pose.position);
  const Quaternion orientation = checked_orientation("World::set_pose: pose.orientation", pose.orientation);
  change<calls::SetPose>(
      *impl_, [&] { atl::set_pose(impl_->stores, body, pose.position, orientation); }, id, pose);
}

void World::set_velocity(BodyId id, const Vector3& linear, const Vector3& angular) {
  check_finite("World::set_velocity: linear", linear);
  check_finite("World::set_velocity: angular", angular);
  const std::uint32_t index = impl_->index_to_change(id, "set_velocity");
  if (impl_->stores.records.type[index] == BodyType::Static && !(linear.isZero(0) && angular.isZero(0))) {
    throw Error("World::set_velocity: the body is static; expected a dynamic or kinematic one");
  }
  const auto set = [&] {
    const std::uint32_t body = awaken(impl_->stores, index);
    solver::BodyTable& bodies = impl_->stores.bodies;
    bodies.velocity(body) = solver::without(solver::linear_locks(bodies.locks[body]), linear);
    bodies.angular_velocity(body) = solver::without(solver::angular_locks(bodies.locks[body]), angular);
  };
  change<calls::SetVelocity>(*impl_, set, id, linear, angular);
}

void World::move_to(BodyId id, const Pose& pose, double dt) {
  check_step("World::move_to", dt);
  check_finite("World::move_to: pose.position", pose.position);
  const Quaternion orientation = checked_orientation("World::move_to: pose.orientation", pose.orientation);
  const std::uint32_t body = index_of(impl_->stores, id, "move_to");
  if (impl_->stores.records.type[body] != BodyType::Kinematic) {
    throw Error("World::move_to: the body is not kinematic; expected one that is, as forces move others");
  }
  const Vector3 position = pose.position + orientation * impl_->stores.records.centre[body];
  const Quaternion turn = orientation * impl_->stores.bodies.orientation(body).conjugate();
  const double half_sine = turn.vec().norm();
  const double angle = 2 * solver::arctangent(half_sine, std::abs(turn.w()));
  Vector3 spin = Vector3::Zero();
  if (half_sine > 0) spin = (turn.w() < 0 ? -1 : 1) * angle / (dt * half_sine) * turn.vec();
  set_velocity(id, (position - impl_->stores.bodies.position(body)) / dt, spin);
}

void World::set_surface_velocity(BodyId id, const Vector3& velocity, const Vector3& angular) {
  check_finite("World::set_surface_velocity: velocity", velocity);
  check_finite("World::set_surface_velocity: angular", angular);
  check_built_for_surface("World::set_surface_velocity: velocity", velocity);
  check_built_for_surface("World::set_surface_velocity: angular", angular);
  const std::uint32_t body = impl_->index_to_change(id, "set_surface_velocity");
  const auto set = [&] { atl::set_surface_velocity(impl_->stores, body, {velocity, angular}); };
  change<calls::SetSurfaceVelocity>(*impl_, set, id, velocity, angular);
}

void World::apply_force(BodyId id, const Vector3& force, const Vector3& torque) {
  check_finite("World::apply_force: force", force);
  check_finite("World::apply_force: torque", torque);
  const std::uint32_t body = impl_->index_to_change(id, "apply_force");
  const auto push = [&] { atl::apply_force(impl_->stores, awaken(impl_->stores, body), force, torque); };
  change<calls::ApplyForce>(*impl_, push, id, force, torque);
}

void World::apply_impulse(BodyId id, const Vector3& impulse, const Vector3& point) {
  check_finite("World::apply_impulse: impulse", impulse);
  check_finite("World::apply_impulse: point", point);
  const std::uint32_t body = impl_->index_to_change(id, "apply_impulse");
  const Vector3 moment = (point - impl_->stores.bodies.position(body)).cross(impulse);
  check_impulse(impl_->stores, body, impulse, moment);
  const auto push = [&] { atl::apply_impulse(impl_->stores, awaken(impl_->stores, body), impulse, moment); };
  change<calls::ApplyImpulse>(*impl_, push, id, impulse, point);
}

void World::wake(BodyId id) {
  const std::uint32_t body = impl_->index_to_change(id, "wake");
  change<calls::Wake>(
      *impl_, [&] { awaken(impl_->stores, body); }, id);
}

void World::sleep(BodyId id) {
  const std::uint32_t body = impl_->index_to_change(id, "sleep");
  if (impl_->stores.sleeping.stays_awake(body)) {
    throw Error("World::sleep: BodyDef::may_sleep is false; expected a body that may sleep");
  }
  if (impl_->stores.records.type[body] != BodyType::Dynamic) {
    throw Error("World::sleep: the body is static or kinematic; expected a dynamic one");
  }
  if (!impl_->stores.settings.sleeping) {
    throw Error("World::sleep: Settings::sleeping is false; expected it to be set, as nothing sleeps without it");
  }
  change<calls::Sleep>(
      *impl_, [&] { put_to_sleep(impl_->stores, body); }, id);
}

std::span<const Quarantined> World::quarantined() const { return impl_->stores.quarantine.bodies(); }

bool World::is_quarantined(BodyId id) const {
  return impl_->stores.quarantine.is_quarantined(index_of(impl_->stores, id, "is_quarantined"));
}

void World::release(BodyId id) {
  const std::uint32_t body = impl_->index_to_change(id, "release");
  change<calls::Release>(
      *impl_, [&] { release_body(impl_->stores, body); }, id);
  impl_->query_gate.note(impl_->stores.broadphase);
}

void World::set_filter(BodyId id, const CollisionFilter& filter) {
  const std::uint32_t body = impl_->index_to_change(id, "set_filter");
  change<calls::SetFilter>(
      *impl_, [&] { atl::set_filter(impl_->stores, body, filter); }, id, filter);
}

namespace {

// Has a copy of a body's constants changed by set(constants), and the call recorded.
template <typename Call>
void change_body(auto& impl, std::uint32_t body, const auto& set, const auto&... arguments) {
  BodyConstants constants = *impl.stores.records.constants[body];
  set(constants);
  check_built_for(constants);
  change<Call>(
      impl, [&] { change_constants(impl.stores, body, constants); }, arguments...);
}

void check_columns(const char* call, std::size_t ids, Eigen::Index first, Eigen::Index second) {
  if (static_cast<Eigen::Index>(ids) == first && first == second) return;
  std::ostringstream message;
  message << call << ": found " << ids << " ids and arrays of " << first << " and " << second
          << " columns; expected as many columns as ids";
  throw Error(message.str());
}

void check_all_finite(const char* what, const Eigen::Ref<const Eigen::MatrixXd>& columns) {
  for (Eigen::Index i = 0; i < columns.cols(); ++i) {
    if (columns.col(i).allFinite()) continue;
    std::ostringstream message;
    message << what << ": column " << i << " is (" << columns.col(i).transpose() << "); expected finite numbers";
    throw Error(message.str());
  }
}

}  // namespace

void World::set_material(BodyId id, const Material& material) {
  const std::uint32_t body = impl_->index_to_change(id, "set_material");
  check("World::set_material: material", material);
  const auto set = [&](BodyConstants& constants) { constants.material = material; };
  change_body<calls::SetMaterial>(*impl_, body, set, id, material);
}

void World::set_mass(BodyId id, double mass) {
  const std::uint32_t body = impl_->index_to_change(id, "set_mass");
  check_positive("World::set_mass: mass", mass, loads);
  if (impl_->stores.records.type[body] != BodyType::Dynamic) {
    throw Error("World::set_mass: the body is static or kinematic; expected a dynamic one");
  }
  const auto set = [mass](BodyConstants& constants) { give_mass("World::set_mass: mass", mass, constants); };
  change_body<calls::SetMass>(*impl_, body, set, id, mass);
}

void World::set_gravity_scale(BodyId id, double scale) {
  const std::uint32_t body = impl_->index_to_change(id, "set_gravity_scale");
  check_number("World::set_gravity_scale: scale", scale);
  const auto set = [scale](BodyConstants& constants) { constants.gravity_scale = scale; };
  change_body<calls::SetGravityScale>(*impl_, body, set, id, scale);
}

void World::set_damping(BodyId id, double linear, double angular) {
  const std::uint32_t body = impl_->index_to_change(id, "set_damping");
  check_not_negative("World::set_damping: linear", linear);
  check_not_negative("World::set_damping: angular", angular);
  const auto set = [&](BodyConstants& constants) {
    constants.linear_damping = linear;
    constants.angular_damping = angular;
  };
  change_body<calls::SetDamping>(*impl_, body, set, id, linear, angular);
}

void World::set_shape(BodyId id, const Shape& shape) {
  const std::uint32_t body = impl_->index_to_change(id, "set_shape");
  BodyConstants constants = *impl_->stores.records.constants[body];
  give_shape("World::set_shape: shape", shape, constants);
  check_built_for(constants);
  impl_->redefine(body, constants);
}

void World::set_heights(BodyId id, std::uint32_t column, std::uint32_t row, std::uint32_t columns,
                        std::span<const double> heights) {
  const std::uint32_t body = impl_->index_to_change(id, "set_heights");
  const auto set = [&] { change_heights(impl_->stores, body, {column, row, columns}, heights); };
  change<calls::SetHeights>(*impl_, set, id, column, row, columns, heights);
  impl_->query_gate.note(impl_->stores.broadphase);
}

void World::set_definition(BodyId id, const BodyDef& def) {
  const std::uint32_t body = impl_->index_to_change(id, "set_definition");
  BodyDef asked = def;
  asked.awake = true;  // it says how a body is added
  const BodyDef before = definition(id);
  const bool keeps_motion = def.velocity == before.velocity && def.angular_velocity == before.angular_velocity;
  if (keeps_motion && asked.type == BodyType::Static) asked.velocity = asked.angular_velocity = Vector3::Zero();
  const BodyConstants constants = redefined(impl_->stores, body, asked);
  if (fingerprint(constants) != fingerprint(*impl_->stores.records.constants[body])) impl_->redefine(body, constants);
  if (asked.position != before.position || asked.orientation.coeffs() != before.orientation.coeffs()) {
    set_pose(id, {asked.position, asked.orientation});
  }
  if (!keeps_motion) set_velocity(id, asked.velocity, asked.angular_velocity);
  if (asked.surface_velocity != before.surface_velocity ||
      asked.surface_angular_velocity != before.surface_angular_velocity) {
    set_surface_velocity(id, asked.surface_velocity, asked.surface_angular_velocity);
  }
  if (asked.filter != before.filter) set_filter(id, asked.filter);
  if (asked.name != before.name) set_name(id, asked.name);
  if (asked.user_data != before.user_data) set_user_data(id, asked.user_data);
}

void World::set_enabled(BodyId id, bool enabled) {
  const std::uint32_t body = impl_->index_to_change(id, "set_enabled");
  change<calls::SetEnabled>(
      *impl_, [&] { atl::set_enabled(impl_->stores, body, enabled); }, id, enabled);
  impl_->query_gate.note(impl_->stores.broadphase);
}

bool World::is_enabled(BodyId id) const {
  return !impl_->stores.quarantine.is_disabled(index_of(impl_->stores, id, "is_enabled"));
}

Material World::material(BodyId id) const {
  return impl_->stores.records.material[index_of(impl_->stores, id, "material")];
}

std::uint64_t World::user_data(BodyId id) const {
  return impl_->stores.records.user_data[index_of(impl_->stores, id, "user_data")];
}

void World::set_user_data(BodyId id, std::uint64_t data) {
  const std::uint32_t body = impl_->index_to_change(id, "set_user_data");
  change<calls::SetUserData>(
      *impl_, [&] { impl_->stores.records.user_data[body] = data; }, id, data);
}

std::string_view World::name(BodyId id) const {
  const auto& names = impl_->stores.records.names;
  const auto found = names.find(index_of(impl_->stores, id, "name"));
  return found == names.end() ? std::string_view() : found->second;
}

void World::set_name(BodyId id, std::string_view name) {
  const std::uint32_t body = impl_->index_to_change(id, "set_name");
  check_name("World::set_name: name", name);
  change<calls::SetName>(
      *impl_, [&] { give_name(impl_->stores, body, name); }, id, name);
}

void World::set_poses(std::span<const BodyId> ids, const Eigen::Ref<const Eigen::Matrix3Xd>& positions,
                      const Eigen::Ref<const Eigen::Matrix4Xd>& orientations) {
  check_columns("World::set_poses", ids.size(), positions.cols(), orientations.cols());
  check_all_finite("World::set_poses: positions", positions);
  const auto orientation = [&](std::size_t i) {
    return Quaternion(Eigen::Vector4d(orientations.col(static_cast<Eigen::Index>(i))));
  };
  for (std::size_t i = 0; i < ids.size(); ++i) {
    index_of(impl_->stores, ids[i], "set_poses");
    checked_orientation("World::set_poses: orientations", orientation(i));
  }
  for (std::size_t i = 0; i < ids.size(); ++i) {
    set_pose(ids[i], {positions.col(static_cast<Eigen::Index>(i)), orientation(i)});
  }
}

void World::set_velocities(std::span<const BodyId> ids, const Eigen::Ref<const Eigen::Matrix3Xd>& linear,
                           const Eigen::Ref<const Eigen::Matrix3Xd>& angular) {
  check_columns("World::set_velocities", ids.size(), linear.cols(), angular.cols());
  check_all_finite("World::set_velocities: linear", linear);
  check_all_finite("World::set_velocities: angular", angular);
  for (const BodyId id : ids) {
    if (impl_->stores.records.type[index_of(impl_->stores, id, "set_velocities")] == BodyType::Static) {
      throw Error("World::set_velocities: a body is static; expected dynamic or kinematic ones");
    }
  }
  for (std::size_t i = 0; i < ids.size(); ++i) {
    set_velocity(ids[i], linear.col(static_cast<Eigen::Index>(i)), angular.col(static_cast<Eigen::Index>(i)));
  }
}

void World::apply_forces(std::span<const BodyId> ids, const Eigen::Ref<const Eigen::Matrix3Xd>& forces,
                         const Eigen::Ref<const Eigen::Matrix3Xd>& torques) {
  check_columns("World::apply_forces", ids.size(), forces.cols(), torques.cols());
  check_all_finite("World::apply_forces: forces", forces);
  check_all_finite("World::apply_forces: torques", torques);
  for (const BodyId id : ids) index_of(impl_->stores, id, "apply_forces");
  for (std::size_t i = 0; i < ids.size(); ++i) {
    apply_force(ids[i], forces.col(static_cast<Eigen::Index>(i)), torques.col(static_cast<Eigen::Index>(i)));
  }
}

void World::set_collision_enabled(BodyId a, BodyId b, bool enabled) {
  const std::uint32_t first = impl_->index_to_change(a, "set_collision_enabled");
  const std::uint32_t second = impl_->index_to_change(b, "set_collision_enabled");
  if (first == second) throw Error("World::set_collision_enabled: both bodies are the same; expected two bodies");
  const auto set = [&] { atl::set_collision_enabled(impl_->stores, first, second, enabled); };
  change<calls::SetCollisionEnabled>(*impl_, set, a, b, enabled);
}

void World::set_material_pair(const MaterialPair& pair) {
  impl_->check_idle("set_material_pair");
  check(pair);
  change<calls::SetMaterialPair>(
      *impl_, [&] { atl::set_material_pair(impl_->stores, pair); }, pair);
}

std::span<const MaterialPair> World::material_pairs() const { return impl_->stores.material_pairs; }

void World::set_contact_filter(ContactFilter filter) {
  impl_->check_idle("set_contact_filter");
  impl_->rules.filter = std::move(filter);
}

void World::set_contact_modifier(ContactModifier modifier) {
  impl_->check_idle("set_contact_modifier");
  impl_->rules.modifier = std::move(modifier);
}

void World::refilter(BodyId id) {
  const std::uint32_t body = impl_->index_to_change(id, "refilter");
  change<calls::Refilter>(
      *impl_, [&] { atl::refilter(impl_->stores, body); }, id);
}

JointId World::add_joint(const JointDef& def) {
  impl_->check_idle("add_joint");
  if constexpr (with_joints) {
    const JointDef kept = def;  // that may be another joint's, which moves
    JointId id;
    change<calls::AddJoint>(
        *impl_, [&] { id = atl::add_joint(impl_->stores, kept); }, kept);
    return id;
  }
  throw_left_out("World::add_joint is called", "joints", "JOINTS");
}

void World::remove_joint(JointId id) {
  const std::uint32_t joint = impl_->index_to_change(id, "remove_joint");
  const auto remove = [&](auto& stores) { atl::remove_joint(stores, joint); };
  change_joints<calls::RemoveJoint>(*impl_, remove, id);
}

bool World::contains(JointId id) const { return atl::contains(impl_->stores, id); }
std::size_t World::joint_count() const { return impl_->stores.joints.count; }

std::vector<JointId> World::joints() const {
  const JointTable& joints = impl_->stores.joints;
  std::vector<JointId> ids;
  ids.reserve(joints.count);
  for (std::uint32_t joint = 0; joint < joints.size(); ++joint) {
    if (joints.alive[joint]) ids.push_back({joint, joints.generation[joint]});
  }
  return ids;
}

std::optional<JointId> World::find_joint(std::string_view name) const {
  const JointTable& joints = impl_->stores.joints;
  for (std::uint32_t joint = 0; joint < joints.size() && !name.empty(); ++joint) {
    if (joints.alive[joint] && joints.def[joint]->name == name) return JointId{joint, joints.generation[joint]};
  }
  return std::nullopt;
}

const JointDef& World::joint(JointId id) const {
  return *impl_->stores.joints.def[index_of(impl_->stores, id, "joint")];
}
JointState World::joint_state(JointId id) const {
  const std::uint32_t joint = index_of(impl_->stores, id, "joint_state");
  if constexpr (with_joints) return atl::joint_state(impl_->stores, joint);
  return {};
}

std::uint64_t World::user_data(JointId id) const {
  return impl_->stores.joints.def[index_of(impl_->stores, id, "user_data")]->user_data;
}

void World::set_user_data(JointId id, std::uint64_t data) {
  JointDef def = *impl_->stores.joints.def[impl_->index_to_change(id, "set_user_data")];
  def.user_data = data;
  set_joint(id, def);
}

std::string_view World::name(JointId id) const {
  return impl_->stores.joints.def[index_of(impl_->stores, id, "name")]->name;
}

void World::set_name(JointId id, std::string_view name) {
  JointDef def = *impl_->stores.joints.def[impl_->index_to_change(id, "set_name")];
  check_name("World::set_name: name", name);
  def.name = name;
  set_joint(id, def);
}

void World::set_joint(JointId id, const JointDef& def) {
  const std::uint32_t joint = impl_->index_to_change(id, "set_joint");
  const JointDef kept = def;  // that may be the joint's own, which goes
  const auto set = [&](auto& stores) { atl::set_joint(stores, joint, kept); };
  change_joints<calls::SetJointDefinition>(*impl_, set, id, kept);
}

void World::set_joint(JointId id, const JointKind& kind) {
  const std::uint32_t joint = impl_->index_to_change(id, "set_joint");
  JointDef def = *impl_->stores.joints.def[joint];
  check("World::set_joint: kind", kind);
  def.kind = kind;
  const auto set = [&](auto& stores) { atl::set_joint(stores, joint, def); };
  change_joints<calls::SetJoint>(*impl_, set, id, def.kind);
}

namespace {

const JointAxis& checked_axis(const char* call, const JointDef& joint, std::size_t coordinate) {
  if (const JointAxis* axis = named_axis(joint.kind, coordinate)) return *axis;
  throw Error(std::string(call) + ": a " + name_of(joint.kind) + " has no axis along coordinate " +
              std::to_string(coordinate) + "; expected one that its definition names");
}

// The motor along a coordinate.
JointMotor checked_motor(const char* call, const JointDef& joint, std::size_t coordinate, bool as_servo) {
  const std::optional<JointMotor>& motor = checked_axis(call, joint, coordinate).motor;
  if (motor && (motor->servo || !as_servo)) return *motor;
  throw Error(std::string(call) + ": the joint has no " + (as_servo ? "servo" : "motor") +
              " along that coordinate; expected one, see World::set_joint_axis");
}

template <typename Call>
void drive(auto& impl, JointId id, double value, std::size_t coordinate, const JointMotor& motor, const char* call) {
  const std::uint32_t joint = impl.index_to_change(id, call);
  const auto set = [&](auto& stores) { atl::drive(stores, joint, coordinate, motor); };
  change_joints<Call>(impl, set, id, value, coordinate);
}

}  // namespace

const JointAxis& World::joint_axis(JointId id, std::size_t coordinate) const {
  return checked_axis("World::joint_axis", joint(id), coordinate);
}

void World::set_joint_axis(JointId id, const JointAxis& axis, std::size_t coordinate) {
  JointKind kind = joint(id).kind;
  checked_axis("World::set_joint_axis", joint(id), coordinate);
  *named_axis(kind, coordinate) = axis;
  set_joint(id, kind);
}

void World::set_motor_speed(JointId id, double speed, std::size_t coordinate) {
  constexpr const char* call = "World::set_motor_speed";
  check_finite("World::set_motor_speed: speed", speed);
  JointMotor motor = checked_motor(call, joint(id), coordinate, false);
  motor.speed = speed;
  drive<calls::SetMotorSpeed>(*impl_, id, speed, coordinate, motor, "set_motor_speed");
}

void World::set_servo_target(JointId id, double target, std::size_t coordinate) {
  constexpr const char* call = "World::set_servo_target";
  check_number("World::set_servo_target: target", target);
  JointMotor motor = checked_motor(call, joint(id), coordinate, true);
  motor.servo->target = target;
  drive<calls::SetServoTarget>(*impl_, id, target, coordinate, motor, "set_servo_target");
}

void World::set_joint_enabled(JointId id, bool enabled) {
  const std::uint32_t joint = impl_->index_to_change(id, "set_joint_enabled");
  const auto set = [&](auto& stores) { atl::set_joint_enabled(stores, joint, enabled); };
  change_joints<calls::SetJointEnabled>(*impl_, set, id, enabled);
}

void World::count_turns_from(JointId id, double angle, std::size_t coordinate) {
  const std::uint32_t joint = impl_->index_to_change(id, "count_turns_from");
  check_number("World::count_turns_from: angle", angle);
  const auto set = [&](auto& stores) { atl::count_turns_from(stores, joint, angle, coordinate); };
  change_joints<calls::CountTurnsFrom>(*impl_, set, id, angle, coordinate);
}

void World::share_definitions(const World& alike) {
  if constexpr (with_joints) share_joint_definitions(impl_->stores, alike.impl_->stores);
}

void World::prefetch_places() const { jobs::prefetch_lines(impl_.get(), jobs::lines_of(sizeof(Impl))); }

void World::prefetch() const {
  jobs::prefetch(*impl_);
  atl::prefetch(impl_->stores, impl_->pipeline);
}

std::vector<MemoryUse> World::memory() const { return memory_of(impl_->stores, impl_->pipeline); }
std::span<const SolverChoice> World::solver_choices() const { return impl_->stores.results.solver_choices; }
std::span<const MissedTarget> World::missed_targets() const { return impl_->stores.results.missed_targets; }

std::span<const JointEvent> World::joint_events() const { return impl_->stores.results.joint_events; }

void World::set_gravity(const Vector3& gravity) {
  impl_->check_idle("set_gravity");
  check_finite("World::set_gravity: gravity", gravity);
  const auto set = [&] {
    if (gravity != impl_->stores.gravity) wake_all(impl_->stores);
    impl_->stores.gravity = gravity;
  };
  change<calls::SetGravity>(*impl_, set, gravity);
}

void World::set_settings(const Settings& settings) {
  impl_->check_idle("set_settings");
  check(settings);
  const auto set = [&] {
    if (!settings.sleeping) wake_all(impl_->stores);
    impl_->stores.changes.joints |=
        settings.joint_solver != impl_->stores.settings.joint_solver && impl_->stores.joints.size() > 0;
    impl_->stores.settings = settings;
    impl_->use_kernels(settings.simd);
  };
  change<calls::SetSettings>(*impl_, set, settings);
}

double World::time() const { return impl_->stores.clock.time; }
const Settings& World::settings() const { return impl_->stores.settings; }
const Vector3& World::gravity() const { return impl_->stores.gravity; }
int World::threads() const { return impl_->arena.threads(); }
void World::set_threads(int threads) {
  impl_->check_idle("set_threads");
  if (impl_->in_batch)
    throw Error("World::set_threads: a world of a Batch; expected one by itself, see Batch::threads");
  impl_->arena.set_threads(checked_threads("World::set_threads: threads", threads));
}
Simd World::simd() const { return simd_of(*impl_->kernels); }

StepReport World::step(double dt) {
  return take_step(*this, *impl_, dt, false, [&] { return impl_->step(dt); });
}

StepReport World::step(double dt, const ForceLaw& law) {
  if (!law) throw Error("World::step: the force law is empty; expected one that can be called");
  return take_step(*this, *impl_, dt, true, [&] { return ForcedStep(*this, law, dt).run(); });
}

void World::add_step_observer(StepObserver observer) {
  impl_->check_idle("add_step_observer");
  if (!observer) throw Error("World::add_step_observer: the observer is empty; expected one that can be called");
  impl_->observers.push_back(std::move(observer));
}

std::span<const ContactForce> World::contact_forces() const {
  impl_->step_guard.check("World::contact_forces");
  return atl::contact_forces(impl_->stores, impl_->pipeline.contacts(), *impl_->narrowphase_kernels, impl_->arena);
}
std::vector<ContactForce> World::contact_forces(BodyId id) const {
  index_of(impl_->stores, id, "contact_forces");
  std::vector<ContactForce> found;
  for (const ContactForce& force :
       atl::contact_forces(impl_->stores, impl_->pipeline.contacts(), *impl_->narrowphase_kernels, impl_->arena)) {
    if (force.a == id || force.b == id) found.push_back(force);
  }
  return found;
}
std::span<const PairForce> World::pair_forces() const {
  impl_->step_guard.check("World::pair_forces");
  return atl::pair_forces(impl_->stores, impl_->pipeline.contacts(), *impl_->narrowphase_kernels, impl_->arena);
}
Wrench World::contact_wrench(BodyId id) const {
  impl_->step_guard.check("World::contact_wrench");
  return atl::contact_wrench(impl_->stores, index_of(impl_->stores, id, "contact_wrench"), impl_->pipeline.contacts(),
                             *impl_->narrowphase_kernels, impl_->arena);
}
Eigen::Matrix<double, 6, Eigen::Dynamic> World::contact_wrenches() const {
  impl_->step_guard.check("World::contact_wrenches");
  return atl::contact_wrenches(impl_->stores, impl_->pipeline.contacts(), *impl_->narrowphase_kernels, impl_->arena);
}
Eigen::Map<const Eigen::Matrix3Xd> World::accelerations() const {
  return atl::accelerations(impl_->stores, false, "accelerations");
}
Eigen::Map<const Eigen::Matrix3Xd> World::angular_accelerations() const {
  return atl::accelerations(impl_->stores, true, "angular_accelerations");
}
Vector3 World::proper_acceleration(BodyId id, const Vector3& point) const {
  return atl::proper_acceleration(impl_->stores, index_of(impl_->stores, id, "proper_acceleration"), point);
}
ContactProblem World::contact_problem() const {
  if (!impl_->stores.results.captured) return {};
  return atl::contact_problem(impl_->stores, impl_->pipeline.contacts().touching(), impl_->pipeline.solve().capture(),
                              impl_->stores.clock.last_substep);
}
std::span<const ContactEvent> World::contact_events() const {
  if (!impl_->stores.settings.contact_events) {
    throw Error("World::contact_events: Settings::contact_events is false; expected it to be set before the step");
  }
  return impl_->stores.results.contact_events.events;
}

std::span<const SleepEvent> World::sleep_events() const { return impl_->stores.results.sleep_events; }

std::span<const SensorEvent> World::sensor_events() const { return impl_->stores.results.sensor_events.events; }

std::vector<BodyId> World::bodies_in(BodyId sensor) const {
  if (!impl_->stores.records.sensor[index_of(impl_->stores, sensor, "bodies_in")]) {
    throw Error("World::bodies_in: the body is not a sensor; expected one, see BodyDef::sensor");
  }
  std::vector<BodyId> bodies;
  for (const auto& [of, body] : impl_->stores.results.sensor_events.within) {
    if (of == sensor) bodies.push_back(body);
  }
  return bodies;
}

Eigen::Matrix3Xd World::origins() const {
  const Stores& stores = impl_->stores;
  Eigen::Matrix3Xd result = positions();
  for (std::uint32_t body = 0; body < stores.bodies.size(); ++body) {
    if (stores.records.alive[body]) result.col(body) = pose_of(stores, body).position;
  }
  return result;
}

void World::keep_views() { impl_->viewed.keeps = true; }

Eigen::Map<const Eigen::Matrix3Xd> World::positions() const {
  return {impl_->stores.bodies.positions.data(), 3, static_cast<Eigen::Index>(impl_->stores.bodies.size())};
}
Eigen::Map<const Eigen::Matrix4Xd> World::orientations() const {
  return {impl_->stores.bodies.orientations.data(), 4, static_cast<Eigen::Index>(impl_->stores.bodies.size())};
}
Eigen::Map<const Eigen::Matrix3Xd> World::velocities() const {
  return {impl_->stores.bodies.velocities.data(), 3, static_cast<Eigen::Index>(impl_->stores.bodies.size())};
}
Eigen::Map<const Eigen::Matrix3Xd> World::angular_velocities() const {
  return {impl_->stores.bodies.angular_velocities.data(), 3, static_cast<Eigen::Index>(impl_->stores.bodies.size())};
}

void World::save(Snapshot& snapshot) const {
  impl_->check_idle("save");
  if constexpr (!with_snapshots) throw_left_out("World::save is called", "snapshots", "SNAPSHOTS");
  if (!snapshot.owns_bytes()) snapshot.bytes_ = std::make_shared<std::vector<std::byte>>();
  snapshot.world_definition_ = impl_->world_definition();
  snapshot.size_ = 0;  // should memory run out: what it held is overwritten
  snapshot.size_ = impl_->save_state(*snapshot.bytes_);
  snapshot.origin_ = impl_->serial;
}

void World::restore(const Snapshot& snapshot) {
  impl_->check_idle("restore", true);
  if constexpr (!with_snapshots) throw_left_out("World::restore is called", "snapshots", "SNAPSHOTS");
  if (snapshot.empty()) throw Error("World::restore: the snapshot is empty; expected one that holds a state");
  impl_->step_guard.change([&] {
    impl_->restore(snapshot.world_definition_, snapshot.origin_, snapshot.state());
    if constexpr (with_recording) {
      if (impl_->recorder) impl_->record_state();
    }
  });
}

void World::record(const std::string& path, const RecordingOptions& options) {
  impl_->check_idle("record");
  if constexpr (!with_recording) throw_left_out("World::record is called", "recordings", "RECORDING");
  impl_->record(path, options);
}

bool World::is_recording() const { return impl_->recorder != nullptr; }

void World::stop_recording() {
  impl_->check_idle("stop_recording");
  if (!impl_->recorder) throw Error("World::stop_recording: no recording is under way; expected one");
  if constexpr (with_recording) impl_->stop_recording("World::stop_recording");
}

std::uint64_t World::state_hash() const {
  impl_->step_guard.check("World::state_hash");
  return impl_->state_hash();
}
std::vector<BodyHash> World::body_hashes() const {
  impl_->step_guard.check("World::body_hashes");
  return atl::body_hashes(impl_->stores);
}
BodyHash World::body_hash(BodyId id) const {
  return atl::body_hash(impl_->stores, index_of(impl_->stores, id, "body_hash"));
}

JointDef joint_at(const World& world, JointKind kind, BodyId first, BodyId second, const Vector3& point,
                  const Vector3& axis) {
  check_finite("joint_at: point", point);
  check_finite("joint_at: axis", axis);
  const double length = axis.norm();
  if (!(length > 0)) throw Error("joint_at: axis is zero; expected the direction of the joint's x axis");
  // Frames that lie as the world's do where the axis is its x axis.
  Matrix3 frame;
  frame.col(0) = axis / length;
  const Vector3 across = std::abs(frame(2, 0)) < 0.9 ? Vector3::UnitZ() : Vector3::UnitY();
  frame.col(1) = across.cross(frame.col(0)).normalized();
  frame.col(2) = frame.col(0).cross(frame.col(1));
  const Quaternion orientation(frame);
  const auto in_frame_of = [&](BodyId id) {
    const Pose pose = world.pose(id);
    const Quaternion back = pose.orientation.conjugate();
    return Pose{back * (point - pose.position), back * orientation};
  };
  return {.kind = kind,
          .first = first,
          .second = second,
          .frame_first = in_frame_of(first),
          .frame_second = in_frame_of(second)};
}

}  // namespace atl
