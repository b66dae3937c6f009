#include <atoll/error_meter.h>

#include <algorithm>
#include <cmath>

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

}  // namespace

ErrorMeter::ErrorMeter(const Scene& scene, Follow follow) : scene_(scene), last_(starting_states(scene)) {
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
}

MotionReport ErrorMeter::motion() const {
  std::vector<MovingBody> moving;
  for (std::size_t i = 0; i < last_.size(); ++i) {
    const SceneBody& body = scene_.bodies[i];
    if (is_dynamic(body)) moving.push_back({mass_[moving.size()], last_[i], body.def.gravity_scale});
  }
  return measure_motion(moving, scene_.gravity);
}

std::vector<ErrorMeasure> ErrorMeter::errors() const {
  std::vector<ErrorMeasure> errors;
  if (closed_form_) errors = closed_form_->errors();

  const std::vector<PlacedShape> shapes = shapes_at(scene_, last_);
  const PenetrationReport penetration = measure_penetration(shapes);
  errors.push_back({"penetration_max", penetration.max, "m"});
  errors.push_back({"penetration_p99", penetration.p99, "m"});
  errors.push_back({"penetration_mean", penetration.mean, "m"});
  errors.push_back({"penetration_max_relative", penetration.max_relative, ""});

  if (scene_.starts_at_rest) {
    const RestReport rest = measure_rest(placed_shapes(scene_), shapes, up(scene_));
    errors.push_back({"sink_max", rest.sink_max, "m"});
    errors.push_back({"sink_mean", rest.sink_mean, "m"});
    errors.push_back({"drift_max", rest.drift_max, "m"});
    errors.push_back({"tilt_max", rest.tilt_max, "rad"});
  }

  const MotionReport end = motion();
  const double energy = start_.kinetic + start_.potential;
  if (energy != 0) {
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
  constexpr double most_tilt = 0.3;  // rad
  const std::vector<PlacedShape> ideal = placed_shapes(scene_);
  const std::vector<PlacedShape> actual = shapes_at(scene_, last_);
  std::size_t dynamic = 0;
  for (std::size_t i = 0; i < actual.size(); ++i) {
    if (!is_dynamic(scene_.bodies[i])) continue;
    const double size = std::cbrt(mass_[dynamic++].volume);
    const RestReport rest = measure_rest(std::span(ideal).subspan(i, 1), std::span(actual).subspan(i, 1), up(scene_));
    if (rest.tilt_max > most_tilt || rest.drift_max > size) return true;
  }
  return false;
}

}  // namespace atl
