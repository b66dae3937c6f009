#include <algorithm>
#include <cmath>

#include "cases.h"
#include "criteria.h"
#include "parts.h"
#include "scene/src/lattice.h"

namespace atl::stability {
namespace {

// Contacts push at 3 m/s at most.
constexpr double exit_speed = 3.5;  // m/s

Criterion parting_speed() {
  return {"exit_speed", "m/s", exit_speed, [](const History& run) {
            double speed = 0;
            for (const auto& states : run.states) {
              for (const BodyState& a : states) {
                for (const BodyState& b : states) speed = std::max(speed, (a.velocity - b.velocity).norm());
              }
            }
            return speed;
          }};
}

Criterion kinetic_energy(double limit) {
  return {"kinetic_energy", "J", limit, [](const History& run) {
            double max = 0;
            for (const auto& states : run.states) {
              std::vector<MovingBody> moving;
              for (std::size_t i = 0; i < states.size(); ++i) {
                moving.push_back({.mass = body_mass(run.scene.bodies[i].def), .state = states[i]});
              }
              max = std::max(max, measure_motion(moving, Vector3::Zero()).kinetic);
            }
            return max;
          }};
}

constexpr double unit_mass = 1000;  // kg

// Two solids of 1 m in free space, one shifted by less than that.
void add_pair(CaseList& cases, const std::string& kind, const Shape& shape, int percent) {
  const std::string share = std::to_string(percent);
  const double apart = 1 - percent / 100.0;
  cases.push_back(
      {.name = "overlap-" + kind + "-" + share,
       .what = "two that start " + share + "% inside each other, without gravity: " + kind,
       .build =
           [shape, apart] {
             Scene scene;
             scene.gravity.setZero();
             for (const double x : {0.0, apart}) {
               scene.bodies.push_back(
                   solid(x == 0 ? "first" : "second", shape, {x, 0.1 * x, 0}, scene::builtin_material));
               scene.bodies.back().def.mass = unit_mass;
             }
             return scene;
           },
       .steps = 240,
       .criteria = {parting_speed(), kinetic_energy(0.25 * unit_mass * exit_speed * exit_speed), penetration(1e-3)}});
}

Scene cluster() {
  Scene scene;
  scene.gravity.setZero();
  const scene::Lattice lattice = {.count = {2, 2, 2}, .spacing = {0.1, 0.1, 0.1}};
  for (const Vector3& point : lattice.points()) {
    scene.bodies.push_back(
        solid(numbered("box", static_cast<int>(scene.bodies.size())), Box{corner(1)}, point, scene::builtin_material));
  }
  return scene;
}

Scene box_in_ground() {
  Scene scene;
  scene.bodies.push_back(ground());
  add_tower(scene, 1, 1, {0, 0, -0.9});
  return scene;
}

// The plates come as near as half a diameter.
Scene squeezed_spheres() {
  constexpr double speed = 0.1;  // m/s
  Scene scene;
  const Vector3 half(3, 3, 0.5);
  scene.bodies.push_back(kinematic_box("lower", half, {0, 0, -1}, {0, 0, speed}));
  scene.bodies.push_back(kinematic_box("upper", half, {0, 0, 1}, {0, 0, -speed}));
  const scene::Lattice lattice = {.count = {3, 3, 1}, .spacing = {1.2, 1.2, 1}};
  for (const Vector3& point : lattice.points()) {
    scene.bodies.push_back(
        solid(numbered("ball", static_cast<int>(scene.bodies.size())), Sphere{0.5}, point, scene::builtin_material));
  }
  return scene;
}

// Counts the centres of balls between the plates that got into a plate, or through it.
Criterion beyond_plates() {
  return {"balls_beyond_plates", "", 0, [](const History& run) {
            const std::vector<BodyState>& end = run.states.back();
            const double lower = end[0].pose.position.z() + 0.5, upper = end[1].pose.position.z() - 0.5;
            return static_cast<double>(std::count_if(end.begin() + 2, end.end(), [=](const BodyState& state) {
              const Vector3& p = state.pose.position;
              const bool between = std::max(std::abs(p.x()), std::abs(p.y())) < 3;
              return between && (p.z() < lower || p.z() > upper);
            }));
          }};
}

constexpr double wall_face = 2;         // m
constexpr std::size_t crushed_box = 3;  // place in the scene

// The piston ends 20 cm from the wall.
Scene piston() {
  Scene scene;
  scene.bodies.push_back(ground());
  scene.bodies.push_back(fixed_box("wall", {0.5, 2, 2}, {wall_face + 0.5, 0, 2}));
  scene.bodies.push_back(kinematic_box("piston", {0.5, 0.5, 0.5}, {0, 0, 0.5}, {0.5, 0, 0}));
  add_tower(scene, 1, 1, {wall_face - 0.6, 0, 0});
  add_tower(scene, 5, 1, {-5, 5, 0});
  return scene;
}

Criterion bystanders_drift() {
  return {"bystanders_drift", "m", 1e-2, [](const History& run) {
            double drift = 0;
            for (std::size_t i = crushed_box + 1; i < run.scene.bodies.size(); ++i) {
              drift =
                  std::max(drift, (run.states.back()[i].pose.position - run.states.front()[i].pose.position).norm());
            }
            return drift;
          }};
}

// Two walls that meet at the origin, each at an angle from the vertical.
Scene trough(double angle, const Material& material) {
  const auto [sine, cosine] = scene::sine_cosine(angle);
  Scene scene;
  scene.starts_at_rest = true;
  for (const double side : {-1.0, 1.0}) {
    scene.bodies.push_back(plane(material, {-side * cosine, 0, sine}));
    scene.bodies.back().name = side < 0 ? "west" : "east";
  }
  return scene;
}

// Upright, on its two lower edges, where the trough is 1 m wide.
Scene wedged_box(double density_above) {
  constexpr double angle = 15 * degree;
  Scene scene = trough(angle, scene::builtin_material);
  const auto [sine, cosine] = scene::sine_cosine(angle);
  add_tower(scene, density_above > 0 ? 2 : 1, 1, {0, 0, 0.5 * cosine / sine});
  if (density_above > 0) scene.bodies.back().def.density *= density_above;
  return scene;
}

// Corner down, its faces on the walls.
Scene box_in_trough() {
  const Material smooth = {.friction = 0};
  Scene scene = trough(45 * degree, smooth);
  scene.bodies.push_back(solid("box", Box{corner(1)}, {0, 0, std::sqrt(0.5)}, smooth));
  scene.bodies.back().def.orientation = turned(45 * degree, Vector3::UnitY());
  return scene;
}

void add_wedges(CaseList& cases) {
  const std::vector<Criterion> held = {penetration(1e-3), drift(5e-3), sink(5e-3), end_speed(1e-2)};
  cases.push_back({.name = "wedge",
                   .what = "box on its lower edges between walls 15 degrees from the vertical",
                   .build = [] { return wedged_box(0); },
                   .criteria = held});
  cases.push_back({.name = "wedge-loaded",
                   .what = "the same under one 100 times as heavy",
                   .build = [] { return wedged_box(100); },
                   .criteria = held});
  cases.push_back({.name = "wedge-smooth",
                   .what = "box corner down in a right-angled trough without friction",
                   .build = box_in_trough,
                   .criteria = held});
}

}  // namespace

void add_overlaps(CaseList& cases) {
  for (const int percent : {25, 90}) {
    add_pair(cases, "boxes", Box{corner(1)}, percent);
    add_pair(cases, "spheres", Sphere{0.5}, percent);
  }
  cases.push_back({.name = "overlap-cluster",
                   .what = "eight boxes that start 90% inside each other, without gravity",
                   .build = cluster,
                   .steps = 240,
                   .criteria = {peak_speed(exit_speed), kinetic_energy(8 * 0.5 * unit_mass * exit_speed * exit_speed),
                                penetration(1e-3)}});
  cases.push_back({.name = "overlap-ground",
                   .what = "box that starts 90% in the ground",
                   .build = box_in_ground,
                   .criteria = {peak_speed(exit_speed), penetration(1e-3), end_speed(1e-2)}});
  cases.push_back({.name = "squeezed-spheres",
                   .what = "nine balls between kinematic plates that come as near as half a diameter",
                   .build = squeezed_spheres,
                   .steps = 150,
                   .criteria = {peak_speed(5), beyond_plates()}});
  // Pushed from two sides, at 3 m/s each.
  cases.push_back({.name = "piston",
                   .what = "kinematic piston that crushes a box against a wall, beside a stack",
                   .build = piston,
                   .steps = 156,
                   .criteria = {peak_speed(6),
                                peak_of("beyond_wall", "m", 0, crushed_box,
                                        [](const BodyState& state) { return state.pose.position.x() - wall_face; }),
                                bystanders_drift()}});
  add_wedges(cases);
}

}  // namespace atl::stability
