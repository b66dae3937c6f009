#include <atoll/scene.h>

#include "words.h"

namespace atl {

std::vector<BodyId> build_scene(const Scene& scene, World& world) {
  std::vector<BodyId> ids;
  ids.reserve(scene.bodies.size());
  for (const SceneBody& body : scene.bodies) {
    try {
      ids.push_back(world.add_body(body.def));
    } catch (const Error& error) {
      const std::string name = body.name.empty() ? "" : " " + scene::quote(body.name);
      throw SceneError(scene.name + ": body " + std::to_string(ids.size()) + name + ": " + error.what());
    }
  }
  return ids;
}

std::vector<PlacedShape> placed_shapes(const Scene& scene) {
  std::vector<PlacedShape> shapes;
  shapes.reserve(scene.bodies.size());
  for (const SceneBody& body : scene.bodies) {
    const BodyDef& def = body.def;
    shapes.push_back({def.type, def.shape, {def.position, def.orientation.normalized()}});
  }
  return shapes;
}

std::vector<PlacedShape> placed_shapes(const Scene& scene, const World& world, const std::vector<BodyId>& ids) {
  std::vector<PlacedShape> shapes;
  shapes.reserve(scene.bodies.size());
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const BodyDef& def = scene.bodies[i].def;
    shapes.push_back({def.type, def.shape, world.pose(ids.at(i))});
  }
  return shapes;
}

}  // namespace atl
