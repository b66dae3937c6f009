#include <atoll/error_meter.h>

#include <algorithm>
#include <cmath>

#include "joint_axes.h"

namespace atl {
namespace {

bool is_dynamic(const SceneBody& body) { return body.def.type == BodyType::Dynamic; }

std::vector<BodyState> starting_states(const Scene& scene) {
  std::vector<BodyState> states;
  for (const SceneBody& body : scene.bodies) {
    const BodyDef& def = body.def;
    states.push_back({{def.position, def.orientation.normalized()}, def.velocity, def.angular_velocity});
  }
  return states;
}

std::vector<PlacedShape> shapes_at(const Scene& scene, std::span<const BodyState> states) {
  std::vector<PlacedShape> shapes;
  for (std::size_t i = 0; i < states.size(); ++i) {
    shapes.push_back({scene.bodies[i].def.type, scene.bodies[i].def.shape, states[i].pose});
  }
  return shapes;
}

// Without gravity no direction is down; the scenes' own up is as good as any.
Vector3 up(const Scene& scene) {
  const double g = scene.gravity.norm();
  return g > 0 ? Vector3(-scene.gravity / g) : Vector3(0, 0, 1);
}

// Nothing from outside changes the momentum of what it holds.
bool is_closed_system(const Scene& scene) {
  return scene.gravity.isZero(0) && std::all_of(scene.bodies.begin(), scene.bodies.end(), [](const SceneBody& body) {
           return is_dynamic(body) && body.force.isZero(0);
         });
}

// Bodies that all share one filter's group of those that pass each other touch nothing.
bool nothing_touches(const Scene& scene) {
  if (scene.bodies.empty()) return true;
  const int group = scene.bodies.front().def.filter.group;
  return group < 0 && std::all_of(scene.bodies.begin(), scene.bodies.end(),
                                  [=](const SceneBody& body) { return body.def.filter.group == group; });
}

// Springs keep energy, and motors bring it, that the motion of bodies does not tell.
bool joints_have_energy(const Scene& scene) {
  for (const SceneJoint& joint : scene.joints) {
    for (const JointAxis& axis : scene::axes_of(joint.def.kind)) {
      if (axis.spring || (axis.motor && axis.motor->speed != 0)) return true;
    }
  }
  return false;
}

}  // namespace

ErrorMeter::ErrorMeter(const Scene& scene, Follow follow)
    : scene_(scene), follow_(follow), last_(starting_states(scene)), joints_(placed_joints(scene)) {
  if (scene.closed_form && follow == Follow::Run) closed_form_ = scene.closed_form->measure();
  for (const SceneBody& body : scene.bodies) {
    if (is_dynamic(body)) mass_.push_back(body_mass(body.def));
  }
  start_ = motion();
}

bool ErrorMeter::needs_loads() const { return closed_form_ && scene_.closed_form->needs_loads; }

void ErrorMeter::observe(double time, std::span<const BodyState> states, std::span<const ContactLoad> loads) {
  last_.assign(states.begin(), states.end());
  if (closed_form_) closed_form_->observe(time, states, loads);
  if (follow_ == Follow::Run && !joints_.empty()) {
    const JointDriftReport drift = measure_joint_drift(joints_, states);
    gaps_.mean_sum += drift.mean;
    gaps_.max = std::max(gaps_.max, drift.max);
    ++gaps_.steps;
  }
}

MotionReport ErrorMeter::motion() const {
  std::vector<MovingBody> moving;
  for (std::size_t i = 0; i < last_.size(); ++i) {
    const SceneBody& body = scene_.bodies[i];
    if (is_dynamic(body)) moving.push_back({mass_[moving.size()], last_[i], body.def.gravity_scale});
  }
  return measure_motion(moving, scene_.gravity);
}

void ErrorMeter::add_joint_errors(std::vector<ErrorMeasure>& errors) const {
  if (joints_.empty()) return;
  if (gaps_.steps > 0) {
    errors.push_back({"joint_gap_run_mean", gaps_.mean_sum / gaps_.steps, "m"});
    errors.push_back({"joint_gap_run_max", gaps_.max, "m"});
  }
  const JointDriftReport drift = measure_joint_drift(joints_, last_);
  errors.push_back({"joint_drift_max", drift.max, "m"});
  errors.push_back({"joint_drift_rms", drift.rms, "m"});
  if (drift.angles > 0) errors.push_back({"joint_angle_max", drift.angle_max, "rad"});
  if (drift.ranges > 0) errors.push_back({"joint_excess_max", drift.excess_max, "m"});
  if (drift.angle_ranges > 0) errors.push_back({"joint_angle_excess_max", drift.angle_excess_max, "rad"});
}

std::vector<ErrorMeasure> ErrorMeter::errors() const {
  std::vector<ErrorMeasure> errors;
  if (closed_form_) errors = closed_form_->errors();
  add_joint_errors(errors);

  const std::vector<PlacedShape> shapes = shapes_at(scene_, last_);
  if (!nothing_touches(scene_)) {
    const PenetrationReport penetration = measure_penetration(shapes, may_touch(scene_));
    errors.push_back({"penetration_max", penetration.max, "m"});
    errors.push_back({"penetration_p99", penetration.p99, "m"});
    errors.push_back({"penetration_mean", penetration.mean, "m"});
    errors.push_back({"penetration_max_relative", penetration.max_relative, ""});
  }

  if (scene_.starts_at_rest) {
    const RestReport rest = measure_rest(placed_shapes(scene_), shapes, up(scene_));
    errors.push_back({"sink_max", rest.sink_max, "m"});
    errors.push_back({"sink_mean", rest.sink_mean, "m"});
    errors.push_back({"drift_max", rest.drift_max, "m"});
    errors.push_back({"tilt_max", rest.tilt_max, "rad"});
  }

  const MotionReport end = motion();
  const double energy = start_.kinetic + start_.potential;
  if (energy != 0 && !joints_have_energy(scene_)) {
    errors.push_back({"energy_drift", std::abs((end.kinetic + end.potential - energy) / energy), ""});
  }
  const double momentum = start_.momentum.norm();
  if (is_closed_system(scene_) && momentum > 0) {
    errors.push_back({"momentum_drift", (end.momentum - start_.momentum).norm() / momentum, ""});
  }
  return errors;
}

bool ErrorMeter::fell() const {
  if (!scene_.starts_at_rest) return false;
  constexpr double max_tilt = 0.3;  // rad
  const std::vector<PlacedShape> ideal = placed_shapes(scene_);
  const std::vector<PlacedShape> actual = shapes_at(scene_, last_);
  std::size_t dynamic = 0;
  for (std::size_t i = 0; i < actual.size(); ++i) {
    if (!is_dynamic(scene_.bodies[i])) continue;
    const double size = std::cbrt(mass_[dynamic++].volume);
    const RestReport rest = measure_rest(std::span(ideal).subspan(i, 1), std::span(actual).subspan(i, 1), up(scene_));
    if (rest.tilt_max > max_tilt || rest.drift_max > size) return true;
  }
  return false;
}

}  // namespace atl
