#include <algorithm>
#include <cmath>

#include "cases.h"
#include "criteria.h"
#include "parts.h"

namespace atl::stability {
namespace {

using scene::sine_cosine;

// Three storeys of leaning pairs with flat cards across, which bear on the upper edges of two pairs each, 2 cm inside
// their own. A foot needs friction of at most the tangent of the lean, 0.36.
Scene card_house(double friction) {
  constexpr double lean = 20 * degree, length = 1, thickness = 0.02, width = 0.7;  // m
  const auto [sine, cosine] = sine_cosine(lean);
  const double storey = length * cosine + thickness * sine;
  const double pitch = 2 * (length * sine + thickness * cosine) + 0.01;  // of pairs, whose feet do not touch
  const Material material = {.friction = friction};

  Scene scene;
  scene.starts_at_rest = true;
  scene.bodies.push_back(plane(material));
  const auto add_card = [&](const Vector3& half_extents, const Vector3& position, double turn) {
    scene.bodies.push_back(
        solid(numbered("card", static_cast<int>(scene.bodies.size())), Box{half_extents}, position, material));
    scene.bodies.back().def.orientation = turned(turn, Vector3::UnitY());
  };
  constexpr int storeys = 3;
  for (int level = 0; level < storeys; ++level) {
    const double floor = level * (storey + thickness);
    const int pairs = storeys - level;
    const auto apex = [=](int pair) { return (pair - 0.5 * (pairs - 1)) * pitch; };
    for (int pair = 0; pair < pairs; ++pair) {
      const double out = (length * sine + thickness * cosine) / 2;
      for (const double side : {-1.0, 1.0}) {
        add_card({thickness / 2, width / 2, length / 2}, {apex(pair) + side * out, 0, floor + storey / 2},
                 -side * lean);
      }
    }
    for (int gap = 0; gap + 1 < pairs; ++gap) {
      add_card({(pitch - 2e-3) / 2, width / 2, thickness / 2},
               {(apex(gap) + apex(gap + 1)) / 2, 0, floor + storey + thickness / 2}, 0);
    }
  }
  return scene;
}

/// A joint between two stones: where it crosses the arch's line, and the direction across that.
struct Cut {
  Vector3 place;
  Vector3 outwards;
};

// Hulls between cuts.
void add_voussoirs(Scene& scene, const std::vector<Cut>& cuts, double thickness, double width,
                   const Material& material) {
  for (std::size_t i = 0; i + 1 < cuts.size(); ++i) {
    const Vector3 centre = (cuts[i].place + cuts[i + 1].place) / 2;
    std::vector<Vector3> corners;
    for (const Cut& cut : {cuts[i], cuts[i + 1]}) {
      for (const double out : {-thickness / 2, thickness / 2}) {
        for (const double y : {-width / 2, width / 2}) {
          corners.push_back(cut.place - centre + out * cut.outwards + Vector3(0, y, 0));
        }
      }
    }
    scene.bodies.push_back(solid(numbered("voussoir", static_cast<int>(i)), ConvexHull(corners), centre, material));
  }
}

// A ring stands if it is thicker than 0.107 of its radius (Heyman, "The masonry arch", 1982); this is twice that.
Scene semicircular_arch() {
  constexpr int stones = 17;
  constexpr double radius = 5, thickness = 1;  // m
  const Material material = {.friction = 0.7};
  Scene scene;
  scene.starts_at_rest = true;
  scene.bodies.push_back(plane(material));
  std::vector<Cut> cuts;
  for (int i = 0; i <= stones; ++i) {
    const auto [sine, cosine] = sine_cosine(std::numbers::pi * (stones - i) / stones);
    const Vector3 outwards(cosine, 0, sine);
    cuts.push_back({radius * outwards, outwards});
  }
  add_voussoirs(scene, cuts, thickness, 1, material);
  return scene;
}

// The curve of a hanging chain, upside down: thrust runs along the middle. Its slope is s / a at the arc length s from
// the crown, so that no hyperbolic function is needed but for x, which is the integral of the direction.
Scene catenary_arch() {
  constexpr int stones = 17;
  constexpr double a = 3.095, half_length = 7.477, thickness = 0.4;  // m: a span of 10 m and a rise of 5 m
  const Material material = {.friction = 0.7};
  const auto along = [](double s) -> Vector3 { return Vector3(1, 0, -s / a) / std::sqrt(1 + s * s / (a * a)); };
  const auto x_at = [&](double s) {
    constexpr int intervals = 200;  // of Simpson's rule
    double sum = 0;
    for (int i = 0; i < intervals; ++i) {
      const double from = s * i / intervals, to = s * (i + 1) / intervals;
      sum += (along(from).x() + 4 * along((from + to) / 2).x() + along(to).x()) / 6;
    }
    return s / intervals * sum;
  };
  const double rise = std::sqrt(a * a + half_length * half_length) - a;
  std::vector<Cut> cuts;
  for (int i = 0; i <= stones; ++i) {
    const double s = half_length * (2.0 * i / stones - 1);
    const Vector3 tangent = along(s);
    cuts.push_back({{x_at(s), 0, rise + a - std::sqrt(a * a + s * s)}, Vector3(-tangent.z(), 0, tangent.x())});
  }
  Scene scene;
  scene.starts_at_rest = true;
  // Abutments at right angles to the thrust.
  for (const double side : {-1.0, 1.0}) {
    scene.bodies.push_back(plane(material, -side * along(side * half_length)));
    scene.bodies.back().name = side < 0 ? "abutment_west" : "abutment_east";
    scene.bodies.back().def.position = side < 0 ? cuts.front().place : cuts.back().place;
  }
  add_voussoirs(scene, cuts, thickness, 1, material);
  return scene;
}

constexpr int dominoes = 20;  // in each of two rows
constexpr int domino_rows = 2;

Scene domino_rows_falling() {
  const Vector3 half(0.05, 0.25, 0.5);  // m
  constexpr double pitch = 0.5;         // m
  constexpr double push = 1;            // rad/s, 2.6 times what tips it over its edge
  Scene scene;
  scene.bodies.push_back(ground());
  for (int row = 0; row < domino_rows; ++row) {
    for (int i = 0; i < dominoes; ++i) {
      SceneBody domino = solid(numbered("domino", row * dominoes + i), Box{half}, {i * pitch, row * 0.7, half.z()},
                               scene::builtin_material);
      if (i == 0) {
        domino.def.angular_velocity = {0, push, 0};
        domino.def.velocity = push * Vector3(half.z(), 0, half.x());
      }
      scene.bodies.push_back(domino);
    }
  }
  return scene;
}

// Counts the stones left standing: only the last of a row can fall flat; each other leans on the next by a radian or
// more.
Criterion left_standing() {
  return {"left_standing", "", 0, [](const History& run) {
            constexpr double fallen = 0.9;  // rad
            return static_cast<double>(
                std::count_if(run.states.back().begin() + 1, run.states.back().end(), [](const BodyState& state) {
                  return state.pose.orientation.angularDistance(Quaternion::Identity()) < fallen;
                }));
          }};
}

// Two planks a layer, across those of the layer below.
Scene plank_tower() {
  constexpr int layers = 50;
  const Vector3 half(0.6, 0.12, 0.04);  // m
  const double out = half.x() - half.y();
  Scene scene;
  scene.starts_at_rest = true;
  scene.bodies.push_back(ground());
  for (int layer = 0; layer < layers; ++layer) {
    const double z = (2 * layer + 1) * half.z();
    const bool along_x = layer % 2 == 0;
    for (const double side : {-out, out}) {
      scene.bodies.push_back(solid(numbered("plank", static_cast<int>(scene.bodies.size())),
                                   Box{along_x ? half : Vector3(half.y(), half.x(), half.z())},
                                   along_x ? Vector3(0, side, z) : Vector3(side, 0, z), scene::builtin_material));
    }
  }
  return scene;
}

}  // namespace

void add_masonry(CaseList& cases) {
  for (const double friction : {0.6, 0.7, 0.8}) {
    cases.push_back({.name = "card-house-" + in_name(friction),
                     .what = "card house of three storeys, cards 2 cm thick, friction " + in_name(friction),
                     .build = [friction] { return card_house(friction); },
                     .steps = 300,
                     .criteria = {penetration(1e-3), drift(2e-2), tilt(0.05)}});
  }
  cases.push_back({.name = "arch-semicircle",
                   .what = "semicircular arch of 17 stones, a fifth of its radius thick, friction 0.7",
                   .build = semicircular_arch,
                   .steps = 600,
                   .criteria = {penetration(1e-3), drift(1e-2), sink(2e-2)}});
  cases.push_back({.name = "arch-catenary",
                   .what = "arch of 17 stones along the line of thrust, 0.4 m thick over 10 m, friction 0.7",
                   .build = catenary_arch,
                   .steps = 600,
                   .criteria = {penetration(1e-3), drift(1e-2), sink(2e-2)}});
  cases.push_back({.name = "plank-tower",
                   .what = "tower of 100 planks, 50 layers crosswise",
                   .build = plank_tower,
                   .steps = 300,
                   .criteria = stands_softly()});
  // A falling domino's centre comes to 2.7 m/s, and rises by 2.5 mm as it tips.
  cases.push_back({.name = "dominoes",
                   .what = "two rows of 20 dominoes that knock each other over",
                   .build = domino_rows_falling,
                   .steps = 600,
                   .criteria = {left_standing(), peak_speed(4), rise(2e-2), energy_gain(1e-2)}});
}

}  // namespace atl::stability
