#include <cmath>

#include "cases.h"
#include "criteria.h"
#include "parts.h"

namespace atl::stability {

namespace {

// The banks are 6.5 m high and 19.5 m apart, and the planks 20 m long: they can sag to 4.3 m.
Criterion boxes_through() {
  return {"boxes_through", "", 0, [](const History& run) {
            double through = 0;
            for (std::size_t i = 0; i < run.scene.bodies.size(); ++i) {
              const Vector3& place = run.states.back()[i].pose.position;
              const bool between = std::abs(place.x()) < 9 && std::abs(place.y()) < 1;
              if (run.scene.bodies[i].name.starts_with("box") && between && place.z() < 4) ++through;
            }
            return through;
          }};
}

}  // namespace

// Chains start level, as high as they are long, so energies are relative to the weight times the length.
void add_joints(CaseList& cases) {
  for (const double ratio : {10.0, 1e2, 1e3, 1e4, 1e5, 1e6}) {
    const std::string times = in_name(ratio);
    cases.push_back({.name = "chain-" + times,
                     .what = "chain of 100 links, level, with a ball " + times + " times as heavy as a link at its end",
                     .build = [times] { return load_scene("chain:links=100,ratio=" + times); },
                     .steps = 300,
                     .criteria = {joint_gap(1e-3), energy_gain(1e-2)}});
  }
  cases.push_back({.name = "rope-1000",
                   .what = "rope of 1000 links that swings down from level",
                   .build = [] { return load_scene("chain:links=1000,ratio=1"); },
                   .steps = 180,
                   .criteria = {peak_joint_gap(1e-3), energy_change(1e-2)}});
  cases.push_back({.name = "rope-1000-hanging",
                   .what = "rope of 1000 links that hangs with 1000 times a link's weight at its end",
                   .build = [] { return load_scene("hanging-chain:links=1000,ratio=1000"); },
                   .steps = 120,
                   .criteria = {peak_joint_gap(1e-3), drift(1e-3), sink(1e-3)}});
  for (const int ratio : {100, 1000}) {
    const std::string times = std::to_string(ratio);
    cases.push_back(
        {.name = "bridge-" + times,
         .what = "bridge of 40 planks onto which five boxes fall, each " + times + " times as heavy",
         .build = [times] { return load_scene("bridge:planks=40,ratio=" + times); },
         .steps = 300,
         .criteria = {joint_gap(1e-3), penetration(1e-2), peak_speed(20), energy_gain(1e-2), boxes_through()}});
  }
  cases.push_back(
      {.name = "net-32",
       .what = "net of 32 x 32 balls that hangs by the middle of its upper edge",
       .build = [] { return load_scene("joint-grid:n=32"); },
       .steps = 200,
       .criteria = {known_to_fail(peak_joint_gap(1e-2), "joints that make nets are solved one after another"),
                    energy_gain(1e-2)}});
}

}  // namespace atl::stability
