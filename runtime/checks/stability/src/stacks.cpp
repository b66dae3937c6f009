#include "cases.h"
#include "criteria.h"
#include "parts.h"

namespace atl::stability {
namespace {

constexpr int boxes = 10;

void add_towers(CaseList& cases) {
  for (const int height : {10, 30, 50, 100}) {
    const std::string count = std::to_string(height);
    cases.push_back({.name = "stack-" + count,
                     .what = "tower of " + count + " boxes",
                     .build = [count] { return load_scene("stack:height=" + count); },
                     .steps = 600,
                     .criteria = stands()});
  }
}

void add_heavy_tops(CaseList& cases) {
  for (const double ratio : {10.0, 1e2, 1e3, 1e4, 1e5, 1e6}) {
    const std::string times = in_name(ratio);
    cases.push_back({.name = "heavy-top-" + times,
                     .what = "box " + times + " times as heavy on nine",
                     .build = [times] { return load_scene("stack:height=10,ratio=" + times); },
                     .steps = 600,
                     .criteria = stands()});
  }
}

// `step` is the ninth root of the ratio.
void add_ladder(CaseList& cases, double ratio, double step) {
  cases.push_back({.name = "mass-ladder-" + in_name(ratio),
                   .what = "ten boxes, each heavier than the one below, the top one " + in_name(ratio) + " times",
                   .build =
                       [step] {
                         Scene scene = tower(boxes);
                         double factor = 1;
                         for (std::size_t i = 1; i < scene.bodies.size(); ++i) {
                           scene.bodies[i].def.density *= factor;
                           factor *= step;
                         }
                         return scene;
                       },
                   .steps = 600,
                   .criteria = stands()});
}

Scene heavy_on_four() {
  constexpr double small = 0.1, large = 2;  // m, edges: a face has 400 times the area
  constexpr double out = (large - small) / 2;
  Scene scene;
  scene.starts_at_rest = true;
  scene.bodies.push_back(ground());
  for (const double x : {-out, out}) {
    for (const double y : {-out, out}) add_tower(scene, 1, small, {x, y, 0});
  }
  add_tower(scene, 1, large, {0, 0, small});
  return scene;
}

}  // namespace

void add_stacks(CaseList& cases) {
  add_towers(cases);
  add_heavy_tops(cases);
  add_ladder(cases, 1e3, 2.154434690031884);
  add_ladder(cases, 1e4, 2.782559402207124);
  cases.push_back({.name = "heavy-on-four-small",
                   .what = "box on four with a 400th of its face's area and an 8000th of its mass",
                   .build = heavy_on_four,
                   .steps = 600,
                   .criteria = stands()});
  cases.push_back({.name = "wide-pyramid",
                   .what = "pyramid of 2109 boxes, 18 x 18 in the lowest layer",
                   .build = [] { return load_scene("pyramid3d:layers=18"); },
                   .steps = 240,
                   .criteria = {penetration(2e-3), drift(1e-2)}});
  cases.push_back({.name = "wide-wall",
                   .what = "wall of 5050 boxes, 100 in the lowest row",
                   .build = [] { return load_scene("wall:base=100"); },
                   .steps = 240,
                   .criteria = {sink(0.1), drift(0.05)}});
}

}  // namespace atl::stability
