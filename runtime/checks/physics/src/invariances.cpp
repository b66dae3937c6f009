// Invariances: results must not depend on a moving frame or on the scale.

#include <algorithm>

#include "cases.h"

namespace atl::physics {
namespace {

// Speed of the fastest body of a pile against its open box, which moves at `speed`, after 8 s, m/s; 1e3 if one is lost.
double pile_in_frame(const Resolution& at, double speed) {
  World world = make_world(at);
  const Vector3 frame(speed, 0, 0);
  const auto wall = [&](const Vector3& place, const Vector3& half) {
    world.add_body({.type = BodyType::Kinematic, .shape = Box{half}, .position = place, .velocity = frame});
  };
  wall({0, 0, -0.5}, {3, 3, 0.5});
  for (const double side : {-1.0, 1.0}) {
    wall({3.5 * side, 0, 2}, {0.5, 4, 3});
    wall({0, 3.5 * side, 2}, {4, 0.5, 3});
  }
  std::vector<BodyId> bodies;
  for (int i = 0; i < 60; ++i) {
    bodies.push_back(world.add_body(
        {.shape = Box{{0.3, 0.3, 0.3}},
         .position = {-1.5 + 1.0 * (i % 4) + 0.02 * (i % 7), -1.5 + 1.0 * (i / 4 % 4), 0.5 + 0.8 * (i / 16)},
         .velocity = frame}));
  }
  run(world, at, 8);
  double max = 0;
  for (const BodyId id : bodies) {
    if (world.is_quarantined(id)) return 1e3;
    const Vector3 place = world.pose(id).position - 8 * frame;
    if (place.head<2>().norm() > 5 || place.z() < -1) return 1e3;
    max = std::max(max, (world.velocity(id) - frame).norm());
  }
  return max;
}

// The same, after 4 s, for a stack that is dropped by 1 cm onto a plate that moves at `speed`.
double stack_on_flatbed(const Resolution& at, double speed) {
  World world = make_world(at);
  const Vector3 frame(speed, 0, 0);
  world.add_body({.type = BodyType::Kinematic, .shape = Box{{3, 1, 0.1}}, .position = {0, 0, -0.1}, .velocity = frame});
  std::vector<BodyId> bodies;
  for (int i = 0; i < 4; ++i) {
    bodies.push_back(world.add_body({.shape = Box{}, .position = {0, 0, 0.51 + 1.01 * i}, .velocity = frame}));
  }
  run(world, at, 4);
  double max = 0;
  for (const BodyId id : bodies) {
    const Vector3 place = world.pose(id).position - 4 * frame;
    if (place.head<2>().norm() > 0.1 || place.z() < 0.4) return 1e3;
    max = std::max(max, (world.velocity(id) - frame).norm());
  }
  return max;
}

// The most overlap of a pile of boxes in parts of their size; time and gravity as for 1 m if `scaled`.
double overlap_by_scale(const Resolution& at, double size, bool scaled) {
  const double gravity = scaled ? g * size : g;
  World world = make_world(at, gravity);
  add_ground(world);
  std::vector<BodyId> bodies;
  for (int i = 0; i < 5; ++i) {
    bodies.push_back(
        world.add_body({.shape = Box{Vector3::Constant(0.5 * size)}, .position = {0, 0, size * (0.5 + 1.2 * i)}}));
  }
  double max = 0;
  run(world, at, scaled ? 6 : 6 * std::sqrt(size), [&](double) {
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      const double below = i == 0 ? -0.5 * size : world.pose(bodies[i - 1]).position.z();
      max = std::max(max, size - (world.pose(bodies[i]).position.z() - below));
    }
  });
  return max / size;
}

}  // namespace

void add_invariances(std::vector<PhysicsCase>& cases) {
  for (const double speed : {0.0, 100.0, 1000.0}) {
    const char* const growth = speed > 0 ? "noise of single precision, 6e-8 of the speed" : "";
    cases.push_back({.name = "pile-at-" + std::to_string(static_cast<int>(speed)),
                     .what = "60 boxes in a box that moves at " + std::to_string(static_cast<int>(speed)) +
                             " m/s: the fastest of them against it after 8 s",
                     .unit = "m/s",
                     .source = "Galilean invariance",
                     .limit = 0.01,
                     .measure = [=](const Resolution& at) { return pile_in_frame(at, speed); },
                     .known_growth = growth});
    cases.push_back({.name = "flatbed-at-" + std::to_string(static_cast<int>(speed)),
                     .what = "a stack of four boxes on a plate that moves at " +
                             std::to_string(static_cast<int>(speed)) + " m/s: the fastest against it after 4 s",
                     .unit = "m/s",
                     .source = "Galilean invariance",
                     .limit = 0.01,
                     .measure = [=](const Resolution& at) { return stack_on_flatbed(at, speed); },
                     .known_growth = growth});
  }
  const auto scales = [&](const char* name, const char* what, double size, bool scaled, double dt = 1.0 / 60) {
    cases.push_back(
        {.name = name,
         .what = std::string("five boxes of ") + what + " that fall 0.2 of it on each other: overlap by size",
         .unit = "",
         .source = "scale",
         .limit = 0.02,
         .dt = dt,
         .measure = [=](const Resolution& at) { return overlap_by_scale(at, size, scaled); }});
  };
  scales("scale-1m", "1 m", 1, true);
  scales("scale-1km", "1 km, gravity scaled,", 1000, true);
  scales("scale-1cm-scaled", "1 cm, gravity scaled,", 0.01, true);
  scales("scale-1cm", "1 cm under usual gravity", 0.01, false, 1.0 / 240);
}

}  // namespace atl::physics
