#include <cmath>

#include "cases.h"
#include "criteria.h"
#include "parts.h"
#include "scene/src/lattice.h"
#include "scene/src/random.h"

namespace atl::stability {
namespace {

// Boxes turned at random that fall onto each other, from 3.4 m at most.
Scene heap(double friction) {
  const Material material = {.friction = friction};
  Scene scene;
  scene.bodies.push_back(plane(material));
  scene::Random random(1);
  const scene::Lattice lattice = {.count = {3, 3, 3}, .spacing = {1, 1, 1.1}};
  for (const Vector3& point : lattice.points()) {
    SceneBody box = solid(numbered("box", static_cast<int>(scene.bodies.size())), Box{{0.35, 0.25, 0.25}},
                          point + Vector3(0, 0, 1.2), material);
    box.def.orientation = random.rotation();
    scene.bodies.push_back(box);
  }
  return scene;
}

constexpr double steep = 80 * degree;

// A block on a steep slope, too flat to tip over.
Scene slope(double friction) {
  const Material material = {.friction = friction};
  const Vector3 half(0.5, 0.5, 0.05);
  const Quaternion turn = turned(steep, Vector3::UnitY());
  const Vector3 normal = turn * Vector3::UnitZ();
  Scene scene;
  scene.bodies.push_back(plane(material, normal));
  scene.bodies.push_back(solid("block", Box{half}, half.z() * normal, material));
  scene.bodies.back().def.orientation = turn;
  return scene;
}

constexpr double slide_time = 2;  // s
constexpr int slide_steps = 120;

// Error of the block's way down the slope, against Coulomb friction, relative to the height of a free fall.
Criterion slide_error(double friction) {
  const auto [sine, cosine] = scene::sine_cosine(steep);
  const double fall = 0.5 * standard_gravity * slide_time * slide_time;
  const double expected = friction * cosine < sine ? fall * (sine - friction * cosine) : 0;
  return {"slide_error", "", 1e-3, [=](const History& run) {
            const double way = (run.states.back()[1].pose.position - run.states.front()[1].pose.position).norm();
            return std::abs(way - expected) / fall;
          }};
}

// A slender rod, tilted so that friction at the tip, which leads, presses it into the ground. With a coefficient above
// 4/3 no finite force keeps the tip from going in (Painleve's paradox: Genot and Brogliato, "New results on Painleve
// paradoxes", 1999).
Scene painleve_rod(double friction) {
  constexpr double radius = 0.01, half_height = 0.5;  // m
  constexpr double lean = 27 * degree;                // from the vertical
  const Material material = {.friction = friction};
  Scene scene;
  scene.bodies.push_back(plane(material));
  const Quaternion turn = turned(lean, Vector3::UnitY());
  SceneBody body = solid("rod", Capsule{.radius = radius, .half_height = half_height},
                         Vector3(0, 0, radius) + half_height * (turn * Vector3::UnitZ()), material);
  body.def.orientation = turn;
  body.def.velocity = {-5, 0, 0};
  scene.bodies.push_back(body);
  return scene;
}

}  // namespace

void add_friction(CaseList& cases) {
  for (const double friction : {0.0, 1e-6, 10.0, 1e6}) {
    const std::string number = in_name(friction);
    cases.push_back({.name = "friction-stack-" + number,
                     .what = "stack of five with friction " + number,
                     .build = [friction] { return tower(5, 1, {.friction = friction}); },
                     .criteria = {penetration(1e-3), drift(1e-2)}});
    cases.push_back({.name = "friction-slope-" + number,
                     .what = "block on a slope of 80 degrees with friction " + number + ": slides or holds",
                     .build = [friction] { return slope(friction); },
                     .steps = slide_steps,
                     .criteria = {slide_error(friction), penetration(1e-3)}});
    // A fall from 3.7 m ends at 8.5 m/s.
    cases.push_back({.name = "friction-heap-" + number,
                     .what = "27 boxes that fall into a heap with friction " + number,
                     .build = [friction] { return heap(friction); },
                     .criteria = {energy_gain(1e-2), peak_speed(9), penetration(5e-3)}});
  }
  for (const double friction : {1.2, 3.0}) {
    cases.push_back({.name = "painleve-" + in_name(friction),
                     .what = "slender rod pushed along on its tip at 5 m/s with friction " + in_name(friction),
                     .build = [friction] { return painleve_rod(friction); },
                     .criteria = {energy_gain(1e-2), peak_speed(6), penetration(5e-3)}});
  }
}

}  // namespace atl::stability
