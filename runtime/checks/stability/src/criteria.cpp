#include "criteria.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace atl::stability {
namespace {

using States = std::vector<BodyState>;

bool is_dynamic(const SceneBody& body) { return body.def.type == BodyType::Dynamic; }

std::vector<PlacedShape> shapes_at(const Scene& scene, const States& states) {
  std::vector<PlacedShape> shapes;
  for (std::size_t i = 0; i < states.size(); ++i) {
    shapes.push_back({scene.bodies[i].def.type, scene.bodies[i].def.shape, states[i].pose});
  }
  return shapes;
}

PenetrationReport penetration_at_end(const History& run) {
  return measure_penetration(shapes_at(run.scene, run.states.back()), may_touch(run.scene));
}

RestReport rest_at_end(const History& run) {
  return measure_rest(shapes_at(run.scene, run.states.front()), shapes_at(run.scene, run.states.back()),
                      -run.scene.gravity.normalized());
}

double fastest(const Scene& scene, const States& states) {
  double speed = 0;
  for (std::size_t i = 0; i < states.size(); ++i) {
    if (is_dynamic(scene.bodies[i])) speed = std::max(speed, states[i].velocity.norm());
  }
  return speed;
}

/// Energy and momentum at the start and after each step.
std::vector<MotionReport> motions(const History& run) {
  std::vector<MovingBody> moving;
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < run.scene.bodies.size(); ++i) {
    const SceneBody& body = run.scene.bodies[i];
    if (!is_dynamic(body)) continue;
    moving.push_back({.mass = body_mass(body.def), .gravity_scale = body.def.gravity_scale});
    places.push_back(i);
  }
  std::vector<MotionReport> reports;
  for (const States& states : run.states) {
    for (std::size_t i = 0; i < moving.size(); ++i) moving[i].state = states[places[i]];
    reports.push_back(measure_motion(moving, run.scene.gravity));
  }
  return reports;
}

double energy(const MotionReport& motion) { return motion.kinetic + motion.potential; }

/// The largest of `part` of the change of energy, relative to the start.
double max_energy(const History& run, double (*part)(double)) {
  const std::vector<MotionReport> reports = motions(run);
  const double start = energy(reports.front());
  double max = 0;
  for (const MotionReport& report : reports) max = std::max(max, part(energy(report) - start));
  return max / std::abs(start);
}

template <class OfStates>
double largest(const History& run, const OfStates& of_states) {
  double value = 0;
  for (std::size_t step = 1; step < run.states.size(); ++step) value = std::max(value, of_states(run.states[step]));
  return value;
}

}  // namespace

Criterion penetration(double limit) {
  return {"penetration", "m", limit, [](const History& run) { return penetration_at_end(run).max; }};
}

Criterion relative_penetration(double limit) {
  return {"relative_penetration", "", limit, [](const History& run) { return penetration_at_end(run).max_relative; }};
}

Criterion drift(double limit) {
  return {"drift", "m", limit, [](const History& run) { return rest_at_end(run).drift_max; }};
}

Criterion relative_drift(double limit) {
  return {"relative_drift", "", limit, [](const History& run) {
            double drift = 0;
            for (std::size_t i = 0; i < run.scene.bodies.size(); ++i) {
              const BodyDef& def = run.scene.bodies[i].def;
              if (def.type != BodyType::Dynamic) continue;
              const Vector3 moved = run.states.back()[i].pose.position - run.states.front()[i].pose.position;
              drift = std::max(drift, moved.norm() / std::cbrt(body_mass(def).volume));
            }
            return drift;
          }};
}

Criterion sink(double limit) {
  return {"sink", "m", limit, [](const History& run) { return rest_at_end(run).sink_max; }};
}

Criterion tilt(double limit) {
  return {"tilt", "rad", limit, [](const History& run) { return rest_at_end(run).tilt_max; }};
}

Criterion joint_gap(double limit) {
  return {"joint_gap", "m", limit,
          [](const History& run) { return measure_joint_drift(placed_joints(run.scene), run.states.back()).max; }};
}

Criterion peak_joint_gap(double limit) {
  return {"peak_joint_gap", "m", limit, [](const History& run) {
            const std::vector<PlacedJoint> joints = placed_joints(run.scene);
            return largest(run, [&](const States& states) { return measure_joint_drift(joints, states).max; });
          }};
}

Criterion end_speed(double limit) {
  return {"end_speed", "m/s", limit, [](const History& run) { return fastest(run.scene, run.states.back()); }};
}

Criterion peak_speed(double limit) {
  return {"peak_speed", "m/s", limit, [](const History& run) {
            return largest(run, [&](const States& states) { return fastest(run.scene, states); });
          }};
}

Criterion travel_error(double limit) {
  return {"travel_error", "m", limit, [](const History& run) {
            double error = 0;
            for (std::size_t i = 0; i < run.scene.bodies.size(); ++i) {
              if (!is_dynamic(run.scene.bodies[i])) continue;
              Vector3 place = run.states.front()[i].pose.position;
              for (std::size_t step = 1; step < run.states.size(); ++step) {
                place += run.scene.dt / 2 * (run.states[step - 1][i].velocity + run.states[step][i].velocity);
              }
              error = std::max(error, (place - run.states.back()[i].pose.position).norm());
            }
            return error;
          }};
}

Criterion rise(double limit) {
  return {"rise", "m", limit, [](const History& run) {
            const Vector3 up = -run.scene.gravity.normalized();
            return largest(run, [&](const States& states) {
              double height = 0;
              for (std::size_t i = 0; i < states.size(); ++i) {
                height = std::max(height, up.dot(states[i].pose.position - run.states.front()[i].pose.position));
              }
              return height;
            });
          }};
}

Criterion energy_gain(double limit) {
  return {"energy_gain", "", limit,
          [](const History& run) { return max_energy(run, [](double change) { return change; }); }};
}

Criterion energy_change(double limit) {
  return {"energy_change", "", limit,
          [](const History& run) { return max_energy(run, [](double change) { return std::abs(change); }); }};
}

Criterion angular_momentum_change(double limit) {
  return {"angular_momentum_change", "", limit, [](const History& run) {
            const std::vector<MotionReport> reports = motions(run);
            const Vector3 start = reports.front().angular_momentum;
            double change = 0;
            for (const MotionReport& report : reports) {
              change = std::max(change, (report.angular_momentum - start).norm());
            }
            return change / start.norm();
          }};
}

Criterion peak_of(std::string name, std::string unit, double limit, std::size_t body, BodyMeasure measure) {
  return {std::move(name), std::move(unit), limit, [body, measure = std::move(measure)](const History& run) {
            return largest(run, [&](const States& states) { return measure(states.at(body)); });
          }};
}

Criterion known_to_fail(Criterion criterion, std::string reason) {
  criterion.known_failure = std::move(reason);
  return criterion;
}

std::vector<Criterion> stands() { return {penetration(1e-3), drift(1e-2)}; }

std::vector<Criterion> stands_softly() { return {known_to_fail(penetration(1e-3), softness), drift(1e-2)}; }

}  // namespace atl::stability
