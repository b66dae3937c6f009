// Grains: how densely they lie, how they flow out, what walls carry, and what slopes and chains of forces they make.

#include <algorithm>
#include <numeric>
#include <span>

#include "cases.h"

namespace atl::physics {
namespace {

constexpr double d = 1;                // m, of grains on average
const double beat = std::sqrt(d / g);  // s: they fall by half of themselves

// Balls of a tenth more or less than d, so that they don't line up, which fall loosely into a shaft.
class Grains {
 public:
  Grains(World& world, double friction) : world_(world), friction_(friction) {}

  // From the ground up, between walls so far apart (m) along x and y.
  void fill(int count, double length, double width) {
    const double pitch = 1.15 * d;
    const int along = static_cast<int>(length / pitch), across = static_cast<int>(width / pitch);
    const Vector3 first(-0.5 * pitch * (along - 1), -0.5 * pitch * (across - 1), 0.7 * d);
    for (int i = 0; i < count; ++i) {
      add(first + pitch * Vector3(i % along, i / along % across, i / (along * across)));
    }
  }
  std::span<const BodyId> ids() const { return ids_; }
  double mass() const {
    double sum = 0;
    for (const BodyId id : ids_) sum += world_.mass(id);
    return sum;
  }
  Vector3 place(std::size_t grain) const { return world_.pose(ids_[grain]).position; }
  double radius(std::size_t grain) const { return radii_[grain]; }
  double top(std::size_t grain) const { return place(grain).z() + radii_[grain]; }

 private:
  void add(const Vector3& place) {
    const double radius = d * (0.45 + 0.1 * uniform(random_));
    const double vx = uniform(random_) - 0.5, vy = uniform(random_) - 0.5;  // d / s
    ids_.push_back(world_.add_body(
        {.shape = Sphere{radius}, .position = place, .velocity = {vx, vy, 0}, .material = {.friction = friction_}}));
    radii_.push_back(radius);
  }

  World& world_;
  double friction_;
  std::mt19937 random_{1};
  std::vector<BodyId> ids_;
  std::vector<double> radii_;
};

void add_shaft(World& world, double width, double friction) {
  for (const Vector3& normal : {Vector3(1, 0, 0), Vector3(-1, 0, 0), Vector3(0, 1, 0), Vector3(0, -1, 0)}) {
    world.add_body(
        {.type = BodyType::Static, .shape = HalfSpace{normal, -0.5 * width}, .material = {.friction = friction}});
  }
}

// Grains that have come to lie in a shaft on the ground.
struct Bed {
  static constexpr double width = 10 * d;

  World world;
  Grains grains;

  Bed(const Resolution& at, double friction, int count) : world(make_world(at)), grains(world, friction) {
    add_ground(world, {.friction = friction});
    add_shaft(world, width, friction);
    grains.fill(count, width, width);
    run(world, at, 50 * beat);
  }
};

// The part of space that they fill, two grains away from what bounds them, by a grid of points.
double packing(const Resolution& at, double friction) {
  const Bed bed(at, friction, 1500);
  std::vector<double> tops;
  for (std::size_t i = 0; i < bed.grains.ids().size(); ++i) tops.push_back(bed.grains.top(i));
  std::nth_element(tops.begin(), tops.begin() + 1400, tops.end());
  const double half = 0.5 * Bed::width - 2 * d, low = 2 * d, high = tops[1400] - 3 * d, step = 0.1 * d;
  const auto cells = [&](double length) { return static_cast<int>(length / step); };
  const int nx = cells(2 * half), nz = cells(high - low);
  std::vector<bool> filled(static_cast<std::size_t>(nx * nx * nz), false);
  for (std::size_t i = 0; i < bed.grains.ids().size(); ++i) {
    const Vector3 centre = (bed.grains.place(i) - Vector3(-half, -half, low)) / step - Vector3::Constant(0.5);
    const double r = bed.grains.radius(i) / step;
    const auto range = [&](double at_centre, int end) {
      return std::pair(std::max(0, static_cast<int>(std::ceil(at_centre - r))),
                       std::min(end - 1, static_cast<int>(std::floor(at_centre + r))));
    };
    const auto [x0, x1] = range(centre.x(), nx);
    const auto [y0, y1] = range(centre.y(), nx);
    const auto [z0, z1] = range(centre.z(), nz);
    for (int z = z0; z <= z1; ++z) {
      for (int y = y0; y <= y1; ++y) {
        for (int x = x0; x <= x1; ++x) {
          if ((Vector3(x, y, z) - centre).squaredNorm() > r * r) continue;
          filled[static_cast<std::size_t>((z * nx + y) * nx + x)] = true;
        }
      }
    }
  }
  return static_cast<double>(std::count(filled.begin(), filled.end(), true)) / static_cast<double>(filled.size());
}

// The decay of how often a force is so many times the mean, of those above it.
double tail_of_bed(const Resolution& at, int count) {
  const Bed bed(at, 0.5, count);
  // Forces grow with depth: each by the mean of its layer.
  constexpr int lowest = 2, highest = 8;
  std::vector<double> forces[highest];
  for (const ContactForce& contact : bed.world.contact_forces()) {
    const int layer = static_cast<int>(contact.position.z() / d);
    if (layer < lowest || layer >= highest || contact.normal_force <= 0) continue;
    forces[layer].push_back(contact.normal_force);
  }
  // From one and a half times the mean on, where the law has got to its tail.
  constexpr double from = 1.5;
  double above = 0, excess = 0;
  for (const std::vector<double>& of_layer : forces) {
    const double mean = std::accumulate(of_layer.begin(), of_layer.end(), 0.0) / static_cast<double>(of_layer.size());
    for (const double force : of_layer) {
      if (force <= from * mean) continue;
      above += 1;
      excess += force / mean - from;
    }
  }
  return above / excess;
}

// One bed's is known to a fifteenth.
double force_tail(const Resolution& at) {
  double sum = 0;
  for (const int count : {1400, 1500, 1600}) sum += tail_of_bed(at, count);
  return sum / 3;
}

// 1/s: how many grains flow out of a hole of `hole` (m) in the flat floor of a shaft.
double outflow(const Resolution& at, double hole) {
  constexpr double width = 18 * d, thickness = 0.2 * d;
  constexpr int sides = 24, count = 3000;
  World world = make_world(at);
  const Material material{.friction = 0.5};
  add_shaft(world, width, material.friction);
  for (int i = 0; i < sides; ++i) {
    const double from = 2 * pi * i / sides, to = 2 * pi * (i + 1) / sides;
    std::vector<Vector3> points;
    for (const double angle : {from, to}) {
      const Vector3 out(std::cos(angle), std::sin(angle), 0);
      for (const double radius : {0.5 * hole / std::cos(pi / sides), 0.75 * width}) {
        for (const double z : {-thickness, 0.0}) points.push_back(radius * out + Vector3(0, 0, z));
      }
    }
    world.add_body({.type = BodyType::Static, .shape = ConvexHull(points), .material = material});
  }
  const BodyId plug = world.add_body(
      {.type = BodyType::Static, .shape = Box{{0.5 * hole, 0.5 * hole, thickness}}, .position = {0, 0, -thickness}});
  Grains grains(world, material.friction);
  grains.fill(count, width, width);
  run(world, at, 12 * beat);
  world.remove_body(plug);
  run(world, at, 8 * beat);
  const auto gone = [&] {
    int sum = 0;
    for (std::size_t i = 0; i < count; ++i) sum += grains.place(i).z() < -thickness;
    return sum;
  };
  const int before = gone();
  double time = 0;
  int after = before;
  while (after < before + 700 && time < 80 * beat) {
    world.step(at.dt);
    time += at.dt;
    after = gone();
  }
  return (after - before) / time;
}

// The line y = slope (x - zero).
struct Line {
  double slope, zero;
};

Line line_through(std::span<const double> x, std::span<const double> y) {
  double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
  for (std::size_t i = 0; i < x.size(); ++i) n += 1, sx += x[i], sy += y[i], sxx += x[i] * x[i], sxy += x[i] * y[i];
  const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
  return {slope, sx / n - sy / (n * slope)};
}

// The hole, in grains, at which nothing flows any more by Beverloo's law: flow goes with (hole - zero)^2.5.
double beverloo(const Resolution& at) {
  std::vector<double> holes, flows;
  for (const double hole : {5.0, 6.5, 8.0}) {
    holes.push_back(hole);
    flows.push_back(std::pow(outflow(at, hole * d), 0.4));
  }
  return line_through(holes, flows).zero;
}

// N: what grains in a narrow shaft press on its floor with, which goes down slowly so that walls carry what they can.
struct Silo {
  double weight, load;
};

Silo silo(const Resolution& at, int count) {
  constexpr double width = 8 * d;
  World world = make_world(at);
  const Material material{.friction = 0.5};
  add_shaft(world, width, material.friction);
  const BodyId floor = world.add_body(
      {.type = BodyType::Kinematic, .shape = Box{{width, width, d}}, .position = {0, 0, -d}, .material = material});
  Grains grains(world, material.friction);
  grains.fill(count, width, width);
  run(world, at, 40 * beat);
  world.set_velocity(floor, {0, 0, -0.01 * d / beat}, Vector3::Zero());
  double sum = 0;
  int steps = 0;
  run(world, at, 40 * beat, [&](double time) {
    if (time < 20 * beat) return;
    for (const ContactForce& contact : world.contact_forces()) {
      if (contact.a == floor || contact.b == floor) sum += contact.normal_force;
    }
    ++steps;
  });
  return {g * grains.mass(), sum / steps};
}

// How well the load on the floor follows weight by Janssen's law, of which one number is fitted: the worst of four
// fills, by the most that the floor can carry.
double janssen(const Resolution& at) {
  std::vector<Silo> fills;
  for (const int count : {200, 400, 800, 1600}) fills.push_back(silo(at, count));
  const auto worst = [&](double max) {
    double off = 0;
    for (const Silo& fill : fills) {
      off = std::max(off, std::abs(fill.load / max - (1 - std::exp(-fill.weight / max))));
    }
    return off;
  };
  double best = 1;
  for (double max = 0.5 * fills.back().load; max < 2 * fills.back().load; max *= 1.005) {
    best = std::min(best, worst(max));
  }
  return best;
}

// rad: against the horizontal, the slope that grains come to lie at in a long box that is tilted by more.
double repose(const Resolution& at, double friction) {
  constexpr double length = 24 * d, width = 6 * d, tilt = 0.6;
  constexpr int count = 1400;
  World world = make_world(at);
  const Material material{.friction = friction};
  add_ground(world, material);
  for (const double side : {1.0, -1.0}) {
    world.add_body({.type = BodyType::Static, .shape = HalfSpace{{side, 0, 0}, -0.5 * length}, .material = material});
    world.add_body(
        {.type = BodyType::Static, .shape = HalfSpace{{0, side, 0}, -0.5 * width}, .material = {.friction = 0}});
  }
  Grains grains(world, friction);
  grains.fill(count, length, width);
  run(world, at, 30 * beat);
  const double seconds = 40 * beat;
  run(world, at, seconds, [&](double time) {
    const double angle = tilt * std::min(time / seconds, 1.0);
    world.set_gravity(g * Vector3(std::sin(angle), 0, -std::cos(angle)));
  });
  run(world, at, seconds);
  // Columns of d x d: how high the highest grain of each is, away from the ends.
  constexpr int columns = 18, rows = 6;
  double tops[columns][rows] = {};
  for (std::size_t i = 0; i < count; ++i) {
    const Vector3 place = grains.place(i) / d;
    const int column = static_cast<int>(std::floor(place.x() + 0.5 * columns));
    const int row = std::clamp(static_cast<int>(place.y() + 0.5 * rows), 0, rows - 1);
    if (column < 0 || column >= columns) continue;
    tops[column][row] = std::max(tops[column][row], grains.top(i));
  }
  std::vector<double> along, heights;
  for (int column = 0; column < columns; ++column) {
    double sum = 0;
    for (const double top : tops[column]) sum += top;
    along.push_back(d * column);
    heights.push_back(sum / rows);
  }
  return tilt - std::atan(line_through(along, heights).slope);
}

}  // namespace

void add_granular(std::vector<PhysicsCase>& cases) {
  const auto packs = [&](const char* name, double friction, double right, double limit, const char* source) {
    cases.push_back({.name = name,
                     .what = "1500 balls poured into a shaft, friction " + std::to_string(friction).substr(0, 3) +
                             ": the part of space that they fill",
                     .unit = "",
                     .right = right,
                     .source = source,
                     .limit = limit,
                     .measure = [=](const Resolution& at) { return packing(at, friction); },
                     .statistical = true});
  };
  packs("packing-smooth", 0, 0.64, 0.02, "random close packing, 0.63 to 0.65; Scott and Kilgour, J. Phys. D 2, 1969");
  packs("packing-rough", 1, 0.58, 0.03, "random loose packing, 0.55 to 0.61; Onoda and Liniger, PRL 64, 1990");
  cases.push_back(
      {.name = "force-tail",
       .what = "the same, friction 0.5: the rate by which contact forces well above the mean, in means, get rare",
       .unit = "",
       .right = 1.12,
       .source = "the same bed by discrete elements whose springs give by a thousandth, perf/reference/grain_bed.cpp",
       .limit = 0.15,
       .measure = force_tail,
       .statistical = true});
  cases.push_back({.name = "beverloo",
                   .what = "balls that flow out of holes of 5, 6.5 and 8 of them, friction 0.5: where a line through "
                           "flow^0.4 has none left",
                   .unit = "",
                   .right = 1.4,
                   .source = "Beverloo et al., Chem. Eng. Sci. 15, 1961; 1 by Mankoc et al., Granular Matter 9, 2007",
                   .limit = 0.4,
                   .measure = [](const Resolution& at) { return beverloo(at); },
                   .statistical = true});
  cases.push_back({.name = "janssen",
                   .what =
                       "balls in a shaft of eight of them, friction 0.5: how far the load on the floor, by the most "
                       "that it bears, is off",
                   .unit = "",
                   .source = "Janssen, Z. VDI 39, 1895: 1 - exp(-weight / most), most fitted",
                   .limit = 0.05,
                   .measure = janssen,
                   .statistical = true});
  cases.push_back({.name = "repose",
                   .what = "balls in a box that is tilted, friction 0.5: the slope that they come to lie at",
                   .unit = "rad",
                   .right = 0.408,
                   .source = "dry spheres, 23.4 degrees; Albert et al., Phys. Rev. E 56, 1997",
                   .limit = 0.06,
                   .measure = [](const Resolution& at) { return repose(at, 0.5); },
                   .statistical = true});
}

}  // namespace atl::physics
