// Chains in equilibrium: straight down under a weight, and between two supports.

#include "../analytic.h"
#include "comparison.h"
#include "rod.h"

namespace atl::scene {
namespace resting_chains {

constexpr double duration = 3;  // s

// Everything stays where it starts.
ClosedForm stays(const Scene& scene, std::string metric, std::string source, double scale) {
  std::vector<Vector3> places;
  for (const SceneBody& body : scene.bodies) places.push_back(body.def.position);
  return known_motion(std::move(metric), std::move(source), {{"sag_error"}},
                      [places, scale](double, std::span<const BodyState> states, LargestErrors& errors) {
                        for (std::size_t i = 0; i < places.size(); ++i) {
                          const Vector3 moved = states[i].pose.position - places[i];
                          errors.raise("analytic_error", moved.norm() / scale);
                          errors.raise("sag_error", std::abs(moved.z()) / scale);
                        }
                      });
}

// Distance of the ends, in lengths of a link, of links in equilibrium under a horizontal pull in weights of a link. By
// moments about its middle a link points as the mean of the tensions at its ends, whose vertical parts add up from
// the lowest point.
double span_of(int links, double pull) {
  double span = 0;
  for (int i = 0; i < links; ++i) {
    const double vertical = i - (links - 1) / 2.0;
    span += pull / std::sqrt(pull * pull + vertical * vertical);
  }
  return span;
}

// The pull that makes it so: the span grows with the pull, so halving its interval finds it.
double pull_for(int links, double span) {
  double low = 0, high = 1;
  while (span_of(links, high) < span) high *= 2;
  for (int i = 0; i < 100; ++i) {
    const double middle = (low + high) / 2;
    (span_of(links, middle) < span ? low : high) = middle;
  }
  return high;
}

}  // namespace resting_chains

Scene build_hanging_chain(const ParameterValues& values, std::uint64_t) {
  using namespace resting_chains;
  const int links = values.integer("links");
  constexpr double ball_radius = 0.5;  // m
  const double length = links * chain_link_length;
  Scene scene;
  scene.steps = steps_for(duration);
  scene.starts_at_rest = true;
  scene.bodies.push_back(untouched(fixed_ball("anchor", {0, 0, 0}, chain_link_radius)));
  for (int i = 0; i < links; ++i) {
    scene.bodies.push_back(chain_link(i, {0, 0, -(i + 0.5) * chain_link_length}, -Vector3::UnitZ()));
    join_last_two(scene, BallJoint{}, {0, 0, -i * chain_link_length});
  }
  SceneBody ball;
  ball.name = "ball";
  ball.def = {.shape = Sphere{ball_radius}, .position = {0, 0, -length - ball_radius}, .mass = values["ratio"]};
  scene.bodies.push_back(untouched(ball));
  join_last_two(scene, BallJoint{}, {0, 0, -length});
  scene.closed_form = stays(scene, "largest distance of a body from its place, relative to the chain's length",
                            "balance of forces: rigid links do not stretch", length);
  return scene;
}

Scene build_catenary(const ParameterValues& values, std::uint64_t) {
  using namespace resting_chains;
  const int links = values.integer("links");
  const double pull = pull_for(links, links / values["slack"]);
  Scene scene;
  scene.steps = steps_for(duration);
  scene.starts_at_rest = true;
  scene.bodies.push_back(untouched(fixed_ball("west", {0, 0, 0}, chain_link_radius)));
  Vector3 end = Vector3::Zero();
  double lowest = 0;
  for (int i = 0; i < links; ++i) {
    const Vector3 along = Vector3(pull, 0, i - (links - 1) / 2.0).normalized();
    scene.bodies.push_back(chain_link(i, end + chain_link_length / 2 * along, along));
    join_last_two(scene, BallJoint{}, end);
    end += chain_link_length * along;
    lowest = std::min(lowest, end.z());
  }
  scene.bodies.push_back(untouched(fixed_ball("east", end, chain_link_radius)));
  join_last_two(scene, BallJoint{}, end);
  scene.closed_form = stays(scene, "largest distance of a link from its place, relative to the sag at the start",
                            "equilibrium of rigid links: each points as the mean of the tensions at its ends", -lowest);
  return scene;
}

}  // namespace atl::scene
