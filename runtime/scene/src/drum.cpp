#include "builtin.h"
#include "loose_solids.h"

namespace atl::scene {
namespace drum {

constexpr double radius = 8;       // m, inside
constexpr double half_length = 8;  // m, along y
constexpr int staves = 24;
constexpr double thickness = 0.5;  // m

// The corners of a regular polygon whose sides touch the unit circle; by turns of one corner, so that no sine is
// rounded otherwise elsewhere.
std::vector<Vector3> corners() {
  const Quaternion turn = Quaternion(Eigen::AngleAxisd(2 * 3.14159265358979323846 / staves, Vector3::UnitY()));
  const double out = 1 / std::sqrt(0.5 * (1 + (turn * Vector3::UnitX()).x()));
  std::vector<Vector3> all = {out * Vector3::UnitX()};
  while (all.size() < staves) all.push_back(turn * all.back());
  return all;
}

Compound hoop() {
  Compound compound;
  const std::vector<Vector3> all = corners();
  for (std::size_t i = 0; i < all.size(); ++i) {
    std::vector<Vector3> points;
    for (const Vector3& corner : {all[i], all[(i + 1) % all.size()]}) {
      for (const double at : {radius, radius + thickness}) {
        for (const double y : {-half_length, half_length}) points.push_back(at * corner + Vector3(0, y, 0));
      }
    }
    compound.children.push_back({.shape = ConvexHull(points)});
  }
  return compound;
}

}  // namespace drum

Scene build_drum(const ParameterValues& values, std::uint64_t seed) {
  using namespace drum;
  Scene scene = scene_on_ground(600, false);
  const double height = 10;  // m, of the axle
  SceneBody hoop = loose_solid("drum", drum::hoop(), {0, 0, height}, Quaternion::Identity());
  hoop.def.type = BodyType::Kinematic;
  hoop.def.angular_velocity = {0, values["spin"], 0};
  scene.bodies.push_back(hoop);
  scene.bodies.push_back(solid_beyond("end_south", {0, 1, 0}, -half_length));
  scene.bodies.push_back(solid_beyond("end_north", {0, -1, 0}, -half_length));
  Random random(seed);
  // Each layer gets the boxes that lie within the drum at its height.
  constexpr double pitch = 0.9;  // m, more than a box across: there is room for 3200
  int number = 0;
  for (double z = -0.8 * radius; number < values.integer("boxes"); z += pitch) {
    const double half_chord = std::sqrt(radius * radius - z * z) - pitch;
    const int across = static_cast<int>(2 * half_chord / pitch), along = static_cast<int>(2 * half_length / pitch);
    for (int i = 0; i < across * along && number < values.integer("boxes"); ++i) {
      const Vector3 place(pitch * (i % across - 0.5 * (across - 1)), pitch * (i / across - 0.5 * (along - 1)),
                          height + z);
      Vector3 half;
      for (double& extent : half) extent = random.uniform(0.15, 0.25);
      scene.bodies.push_back(loose_solid("box_" + std::to_string(number++), Box{half}, place, random.rotation()));
    }
  }
  return scene;
}

}  // namespace atl::scene
