// At which slope, friction or overhang what stands gives way, found by bisection; and that it doesn't matter which way
// a world is turned.

#include <algorithm>

#include "cases.h"

namespace atl::physics {
namespace {

// Bisects for the value at which a structure gives way: it holds below that value and fails above.
template <typename Holds>
double threshold(double low, double high, const Holds& holds) {
  constexpr int rounds = 12;
  for (int i = 0; i < rounds; ++i) {
    const double middle = 0.5 * (low + high);
    (holds(middle) ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

// Gravity that leans, over level ground, is a slope of that tangent.
World sloped_world(const Resolution& at, double tangent) {
  World world = make_world(at);
  world.set_gravity(g * Vector3(tangent, 0, -1).normalized());
  return world;
}

// The tangent at which a box begins to slide.
double sliding_slope(const Resolution& at, double friction) {
  return threshold(0, 1, [&](double tangent) {
    World world = sloped_world(at, tangent);
    const Material material{.friction = friction};
    add_ground(world, material);
    const BodyId box = world.add_body({.shape = Box{{0.5, 0.5, 0.1}}, .position = {0, 0, 0.1}, .material = material});
    run(world, at, 2);
    return world.velocity(box).norm() < 1e-3 * g;
  });
}

// The tangent at which a column of cubes that is let go on a slope falls over.
double toppling_slope(const Resolution& at, int cubes) {
  return threshold(0.5 / cubes, 1.5 / cubes, [&](double tangent) {
    World world = sloped_world(at, tangent);
    const Material material{.friction = 1};
    add_ground(world, material);
    BodyId top;
    for (int i = 0; i < cubes; ++i) {
      top = world.add_body({.shape = Box{{0.5, 0.5, 0.5}}, .position = {0, 0, i + 0.5}, .material = material});
    }
    run(world, at, 8);
    return world.pose(top).position.z() > cubes - 1;
  });
}

// How far the top one of a stack of blocks of 1 m reaches out by the harmonic series, as a part of that, when it falls.
double overhang(const Resolution& at, int blocks) {
  return threshold(0.9, 1.1, [&](double part) {
    World world = make_world(at);
    add_ground(world, {.friction = 0.6});
    const double height = 0.2;
    world.add_body({.type = BodyType::Static, .shape = Box{{0.5, 0.5, 0.5 * height}}, .position = {0, 0, 5}});
    double x = 0;
    BodyId top;
    for (int i = 0; i < blocks; ++i) {
      x += part * 0.5 / (blocks - i);
      top = world.add_body({.shape = Box{{0.5, 0.5, 0.5 * height}}, .position = {x, 0, 5 + height * (i + 1)}});
    }
    run(world, at, 8);
    return world.pose(top).position.z() > 5 + height * (blocks - 0.5);
  });
}

// m, by which bodies that slide, roll and tumble down a slope part from the same in a world that is turned.
double turned_world(const Resolution& at) {
  const Quaternion turn = turn_about({1, 2, 3}, 1.2);
  std::vector<Vector3> ends[2];
  for (const bool turned : {false, true}) {
    const Quaternion frame = turned ? turn : Quaternion(1, 0, 0, 0);
    World world = make_world(at);
    world.set_gravity(frame * (g * Vector3(0.3, 0, -1).normalized()));
    const Material material{.friction = 0.4};
    world.add_body({.type = BodyType::Static,
                    .shape = HalfSpace{.normal = frame * Vector3::UnitZ(), .offset = 0},
                    .material = material});
    const Shape shapes[] = {Box{{0.2, 0.1, 0.1}}, Sphere{0.1}, Cylinder{.radius = 0.2, .half_height = 0.1}};
    std::vector<BodyId> ids;
    for (int i = 0; i < 3; ++i) {
      ids.push_back(world.add_body({.shape = shapes[i],
                                    .position = frame * Vector3(0, i, i == 2 ? 0.2 : 0.1),
                                    .orientation = frame * turn_about(Vector3::UnitX(), i == 2 ? pi / 2 : 0),
                                    .velocity = frame * Vector3(3, 0.5 * i, 0),
                                    .material = material}));
    }
    run(world, at, 2);
    for (const BodyId id : ids) ends[turned].push_back(frame.conjugate() * world.pose(id).position);
  }
  double max = 0;
  for (std::size_t i = 0; i < 3; ++i) max = std::max(max, (ends[0][i] - ends[1][i]).norm());
  return max;
}

}  // namespace

void add_statics(std::vector<PhysicsCase>& cases) {
  for (const double friction : {0.1, 0.5}) {
    cases.push_back({.name = "friction-angle-" + std::to_string(static_cast<int>(10 * friction)),
                     .what = "a box on a slope, friction " + std::to_string(friction).substr(0, 3) +
                             ": the tangent at which it slides",
                     .unit = "",
                     .right = friction,
                     .source = "Coulomb, by bisection",
                     .scale = friction,
                     .measure = [=](const Resolution& at) { return sliding_slope(at, friction); }});
  }
  cases.push_back(
      {.name = "toppling-3",
       .what = "a column of three cubes, let go on a slope: the tangent at which it topples",
       .unit = "",
       .right = 1.0 / 3,
       .source = "its weight over its edge, by bisection",
       .scale = 1.0 / 3,
       .measure = [](const Resolution& at) { return toppling_slope(at, 3); },
       .known_failure =
           "a load that comes at once takes the sweeps some substeps to carry; solved at once it is right"});
  cases.push_back({.name = "overhang-5",
                   .what = "five blocks that lean out by the harmonic series: the part of it at which they fall",
                   .unit = "",
                   .right = 1,
                   .source = "sum of 1 / 2 n, by bisection",
                   .measure = [](const Resolution& at) { return overhang(at, 5); },
                   .known_growth = "a load that comes at once takes the sweeps some substeps to carry, and these are "
                                   "swept in finer steps alone"});
  cases.push_back({.name = "turned-world",
                   .what = "a box, a ball and a cylinder that run down a slope, and the same turned: how far they part",
                   .unit = "m",
                   .source = "invariance under turning",
                   .limit = 1e-3,
                   .measure = turned_world});
}

}  // namespace atl::physics
