// Bodies that slide and roll on curved surfaces.

#include <algorithm>

#include "cases.h"

namespace atl::physics {
namespace {

constexpr double radius = 1, ball_radius = 0.1;  // m

TriangleMesh bowl_mesh(std::uint32_t rings, std::uint32_t sectors, double smooth_angle = 0.5) {
  std::vector<Vector3> vertices = {Vector3::Zero()};
  std::vector<TriangleMesh::Indices> triangles;
  for (std::uint32_t i = 1; i <= rings; ++i) {
    for (std::uint32_t j = 0; j < sectors; ++j) {
      const double out = pi / 2 * i / rings, around = 2 * pi * j / sectors;
      vertices.emplace_back(
          radius * Vector3(std::sin(out) * std::cos(around), std::sin(out) * std::sin(around), 1 - std::cos(out)));
    }
  }
  const auto at = [=](std::uint32_t i, std::uint32_t j) { return i == 0 ? 0 : 1 + (i - 1) * sectors + j % sectors; };
  for (std::uint32_t i = 0; i < rings; ++i) {
    for (std::uint32_t j = 0; j < sectors; ++j) {
      triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      if (i > 0) triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  return {vertices, triangles, smooth_angle};
}

struct Field {
  HeightField shape;
  Vector3 position;  // m
};

Field bowl_field(double cell) {
  const auto samples = static_cast<std::uint32_t>(1.8 * radius / cell) + 1;
  const double middle = 0.5 * (samples - 1) * cell;
  std::vector<double> heights;
  for (std::uint32_t j = 0; j < samples; ++j) {
    for (std::uint32_t i = 0; i < samples; ++i) {
      const double x = i * cell - middle, y = j * cell - middle;
      heights.push_back(radius - std::sqrt(std::max(radius * radius - x * x - y * y, 0.0)));
    }
  }
  return {HeightField(samples, samples, cell, cell, heights, true), {-middle, -middle, 0}};
}

struct Energy {
  double left, max;  // over that at the start
};

// Runs a ball for a while, from 0.5 rad up the bowl and so far (m) off it, let go or pushed around it.
Energy energy_in_bowl(const Resolution& at, const Shape& bowl, const Vector3& position, double friction, double around,
                      double seconds, double off = 0) {
  World world = make_world(at);
  const Material material{.friction = friction};
  world.add_body({.type = BodyType::Static, .shape = bowl, .position = position, .material = material});
  const double out = 0.5, yaw = 0.3;
  const Vector3 towards(std::sin(out) * std::cos(yaw), std::sin(out) * std::sin(yaw), -std::cos(out));
  const BodyId ball = world.add_body({.shape = Sphere{ball_radius},
                                      .position = Vector3(0, 0, radius) + (radius - ball_radius - off) * towards,
                                      .velocity = around * Vector3(-std::sin(yaw), std::cos(yaw), 0),
                                      .material = material});
  const double mass = world.mass(ball);
  const Matrix3 inertia = 0.4 * mass * ball_radius * ball_radius * Matrix3::Identity();
  const auto energy = [&] {
    return kinetic_energy(world, ball, inertia) + mass * g * (world.pose(ball).position.z() - ball_radius);
  };
  const double start = energy();
  double max = start;
  run(world, at, seconds, [&](double) { max = std::max(max, energy()); });
  return {energy() / start, max / start};
}

double energy_left(const Resolution& at, const Shape& bowl, const Vector3& position, double friction, double around,
                   double seconds) {
  return energy_in_bowl(at, bowl, position, friction, around, seconds).left;
}

}  // namespace

void add_bowls(std::vector<PhysicsCase>& cases) {
  const auto add = [&](const char* name, const char* what, auto measure) {
    cases.push_back({.name = name, .what = what, .unit = "", .right = 1, .source = "conservation", .measure = measure});
  };
  add("bowl-mesh", "a frictionless ball in a bowl of 80 x 320 triangles that count as smooth: energy left after 15 s",
      [](const Resolution& at) { return energy_left(at, bowl_mesh(80, 320), Vector3::Zero(), 0, 0, 15); });
  add("bowl-coarse-mesh", "the same of 10 x 40 triangles",
      [](const Resolution& at) { return energy_left(at, bowl_mesh(10, 40), Vector3::Zero(), 0, 0, 15); });
  add("bowl-field", "the same on a smooth height field with cells of 20 mm", [](const Resolution& at) {
    const Field field = bowl_field(0.02);
    return energy_left(at, field.shape, field.position, 0, 0, 15);
  });
  add("bowl-around", "a frictionless ball that circles in the bowl of 80 x 320: energy left after 15 s",
      [](const Resolution& at) { return energy_left(at, bowl_mesh(80, 320), Vector3::Zero(), 0, 2.05, 15); });
  for (const std::uint32_t rings : {10u, 20u, 80u}) {
    const std::string size = std::to_string(rings) + " x " + std::to_string(4 * rings);
    cases.push_back({.name = "bowl-plain-" + std::to_string(rings),
                     .what = "a frictionless ball in a bowl of " + size + " plain triangles: most energy in 15 s",
                     .unit = "",
                     .right = 1,
                     .source = "edges take energy and never give any",
                     .measure = [=](const Resolution& at) {
                       // Facets are within the sphere by up to this, along and across.
                       const double sag = 2 * radius * (1 - std::cos(pi / 4 / rings));
                       return energy_in_bowl(at, bowl_mesh(rings, 4 * rings, 0), Vector3::Zero(), 0, 0, 15, sag).max;
                     }});
  }
  add("bowl-rolling", "a ball that rolls in the bowl of 80 x 320, friction 0.8: energy left after 15 s",
      [](const Resolution& at) { return energy_left(at, bowl_mesh(80, 320), Vector3::Zero(), 0.8, 0, 15); });
  add("bowl-field-rolling", "the same on the height field", [](const Resolution& at) {
    const Field field = bowl_field(0.02);
    return energy_left(at, field.shape, field.position, 0.8, 0, 15);
  });
}

}  // namespace atl::physics
