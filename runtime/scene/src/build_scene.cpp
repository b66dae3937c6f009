#include <atoll/scene.h>

#include <map>

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

void apply_forces(const Scene& scene, World& world, const std::vector<BodyId>& ids) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (!scene.bodies[i].force.isZero(0)) world.apply_force(ids.at(i), scene.bodies[i].force);
  }
}

std::vector<BodyState> body_states(const World& world, const std::vector<BodyId>& ids) {
  std::vector<BodyState> states;
  states.reserve(ids.size());
  for (const BodyId id : ids) states.push_back(world.state(id));
  return states;
}

std::vector<ContactLoad> contact_loads(const World& world, const std::vector<BodyId>& ids) {
  std::map<BodyId, std::size_t> places;
  for (std::size_t i = 0; i < ids.size(); ++i) places[ids[i]] = i;
  std::vector<ContactLoad> loads;
  for (const ContactForce& contact : world.contact_forces()) {
    const std::size_t a = places.at(contact.a), b = places.at(contact.b);
    if (loads.empty() || loads.back().a != a || loads.back().b != b) loads.push_back({.a = a, .b = b});
    loads.back().force += contact.normal_force * contact.normal + contact.friction;
  }
  return loads;
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
