#include <algorithm>
#include <cmath>

#include "cases.h"
#include "criteria.h"
#include "parts.h"
#include "simulate.h"

namespace atl::stability {
namespace {

constexpr int tower_height = 5;  // boxes

// In a substep a body falls by g h^2; below that nothing is known of a contact, whose load is up to five bodies'.
void add_steps(CaseList& cases) {
  for (const int rate : {1000, 240, 120, 30, 20, 10}) {
    const double dt = 1.0 / rate;
    const double fall = standard_gravity * dt * dt / 16;  // m, in one of four substeps
    cases.push_back({.name = "step-1-" + std::to_string(rate),
                     .what = "stack of five for 5 s in steps of 1/" + std::to_string(rate) + " s",
                     .build =
                         [dt] {
                           Scene scene = tower(tower_height);
                           scene.dt = dt;
                           return scene;
                         },
                     .steps = 5 * rate,
                     .criteria = {penetration(std::max(1e-3, tower_height * fall)), drift(1e-2), tilt(1e-2)}});
  }
}

void add_gravity(CaseList& cases) {
  cases.push_back({.name = "gravity-100",
                   .what = "stack of five under 100 times gravity",
                   .build =
                       [] {
                         Scene scene = tower(tower_height);
                         scene.gravity *= 100;
                         return scene;
                       },
                   .criteria = {penetration(2e-2), drift(1e-2), tilt(1e-2)}});
}

void add_sizes(CaseList& cases) {
  const struct {
    const char* name;
    double edge;   ///< m
    double share;  ///< of it, that overlap may have: the fall in a substep, 0.17 mm, does not scale
  } sizes[] = {{"1mm", 1e-3, 1e-2}, {"1cm", 1e-2, 1e-2}, {"10cm", 0.1, 1e-2},
               {"10m", 10, 1e-3},   {"100m", 100, 1e-3}, {"1km", 1000, 1e-3}};
  for (const auto& size : sizes) {
    const double edge = size.edge;
    cases.push_back({.name = std::string("size-") + size.name,
                     .what = std::string("stack of five boxes of ") + size.name,
                     .build = [edge] { return tower(tower_height, edge); },
                     .criteria = {relative_penetration(size.share), relative_drift(2e-2), tilt(2e-2)}});
  }
  cases.push_back({.name = "sizes-beside",
                   .what = "stacks of five boxes of 1 mm and of 1 km in one scene",
                   .build =
                       [] {
                         Scene scene = tower(tower_height, 1000);
                         add_tower(scene, tower_height, 1e-3, {600, 0, 0});
                         return scene;
                       },
                   .criteria = {relative_penetration(1e-2), relative_drift(2e-2), tilt(2e-2)}});
  cases.push_back({.name = "sizes-upon",
                   .what = "stack of five boxes of 1 mm on a box of 1 km",
                   .build =
                       [] {
                         Scene scene = tower(1, 1000);
                         add_tower(scene, tower_height, 1e-3, {300, 200, 1000});
                         return scene;
                       },
                   .criteria = {relative_penetration(1e-2), relative_drift(2e-2), tilt(2e-2)}});
}

Scene far_tower(const Vector3& base) {
  Scene scene;
  scene.starts_at_rest = true;
  scene.bodies.push_back(ground());
  scene.bodies.back().def.position = base;
  add_tower(scene, tower_height, 1, base);
  return scene;
}

// From where the same stack comes to that starts at the origin.
Criterion difference(const Vector3& base) {
  return {"difference", "m", 1e-3, [base](const History& run) {
            const Scene near = far_tower(Vector3::Zero());
            const Simulated twin = simulate(near, static_cast<int>(run.states.size()) - 1);
            double max = 0;
            for (std::size_t i = 0; i < near.bodies.size(); ++i) {
              const Vector3 place = run.states.back()[i].pose.position - base;
              max = std::max(max, (place - twin.history.states.back()[i].pose.position).norm());
            }
            return max;
          }};
}

}  // namespace

void add_scales(CaseList& cases) {
  add_steps(cases);
  add_gravity(cases);
  add_sizes(cases);
  const Vector3 base(1e7, -1e7, 1e7);
  cases.push_back({.name = "far-away",
                   .what = "stack of five 1e7 m from the origin along each axis",
                   .build = [base] { return far_tower(base); },
                   .criteria = {difference(base), penetration(1e-3), drift(1e-2)}});
}

}  // namespace atl::stability
