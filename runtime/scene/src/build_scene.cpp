#include <atoll/scene.h>
#include <atoll/world.h>

#include <algorithm>
#include <map>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "words.h"

namespace atl {

namespace {

// Runs it, and says which part of the scene it was about if that fails.
template <class Add>
auto add_part(const Scene& scene, const char* kind, std::size_t place, const std::string& name, const Add& add) {
  try {
    return add();
  } catch (const Error& error) {
    throw SceneError(scene.name + ": " + kind + " " + std::to_string(place) +
                     (name.empty() ? "" : " " + scene::quote(name)) + ": " + error.what());
  }
}

// Under the name that the scene knows it by.
BodyId add(const SceneBody& body, World& world) {
  if (body.name.empty()) return world.add_body(body.def);
  BodyDef named = body.def;
  named.name = body.name;
  return world.add_body(named);
}

bool filters_agree(const CollisionFilter& a, const CollisionFilter& b) {
  if (a.group != 0 && a.group == b.group) return a.group > 0;
  return (a.mask & b.category) != 0 && (b.mask & a.category) != 0;
}

// Gives the terms of a tendon the ids of their joints.
void name_joints(const SceneJoint& joint, const std::vector<JointId>& ids, TendonJoint& tendon) {
  if (joint.terms.size() != tendon.terms.size()) {
    throw Error("SceneJoint.terms: there are " + std::to_string(joint.terms.size()) +
                "; expected one for each of the " + std::to_string(tendon.terms.size()) + " terms of the tendon");
  }
  for (std::size_t i = 0; i < joint.terms.size(); ++i) {
    if (joint.terms[i] >= ids.size()) {
      throw Error("SceneJoint.terms[" + std::to_string(i) + "] is " + std::to_string(joint.terms[i]) +
                  "; expected the place of a joint ahead of the tendon, which are " + std::to_string(ids.size()));
    }
    tendon.terms[i].joint = ids[joint.terms[i]];
  }
}

void add_tendon(const World& world, JointId id, const std::map<JointId, std::size_t>& places, Scene& scene) {
  JointDef def = world.joint(id);
  auto& tendon = std::get<TendonJoint>(def.kind);
  std::vector<std::size_t> terms;
  for (TendonTerm& term : tendon.terms) {
    const auto place = places.find(std::exchange(term.joint, {}));
    if (place == places.end()) return;
    terms.push_back(place->second);
  }
  const SceneJoint& of = scene.joints[terms.front()];
  std::string name = std::exchange(def.name, {});
  scene.joints.push_back({std::move(name), std::move(def), of.first, of.second, std::move(terms)});
}

}  // namespace

std::vector<BodyId> build_scene(const Scene& scene, World& world) {
  std::vector<JointId> joints;
  return build_scene(scene, world, joints);
}

std::vector<BodyId> build_scene(const Scene& scene, World& world, std::vector<JointId>& joints) {
  for (const MaterialPair& pair : scene.material_pairs) world.set_material_pair(pair);
  std::vector<BodyId> ids;
  ids.reserve(scene.bodies.size());
  for (const SceneBody& body : scene.bodies) {
    ids.push_back(add_part(scene, "body", ids.size(), body.name, [&] { return add(body, world); }));
  }
  joints.clear();
  joints.reserve(scene.joints.size());
  for (const SceneJoint& joint : scene.joints) {
    joints.push_back(add_part(scene, "joint", joints.size(), joint.name, [&] {
      JointDef def = joint.def;
      if (def.name.empty()) def.name = joint.name;
      def.first = ids.at(joint.first);
      def.second = ids.at(joint.second);
      if (auto* tendon = std::get_if<TendonJoint>(&def.kind)) name_joints(joint, joints, *tendon);
      return world.add_joint(def);
    }));
  }
  return ids;
}

Scene scene_of(const World& world) {
  Scene scene{.gravity = world.gravity(), .settings = world.settings()};
  scene.material_pairs.assign(world.material_pairs().begin(), world.material_pairs().end());
  std::map<BodyId, std::size_t> places;
  for (const BodyId id : world.bodies()) {
    places[id] = scene.bodies.size();
    BodyDef def = world.definition(id);
    std::string name = std::exchange(def.name, {});
    scene.bodies.push_back({.name = std::move(name), .def = std::move(def)});
  }
  std::map<JointId, std::size_t> joint_places;
  std::vector<JointId> tendons;
  for (const JointId id : world.joints()) {
    if (!world.joint_state(id).enabled) continue;
    JointDef def = world.joint(id);
    if (std::holds_alternative<TendonJoint>(def.kind)) {
      tendons.push_back(id);
      continue;
    }
    joint_places[id] = scene.joints.size();
    const std::size_t first = places.at(def.first), second = places.at(def.second);
    std::string name = std::exchange(def.name, {});
    scene.joints.push_back({.name = std::move(name), .def = std::move(def), .first = first, .second = second});
  }
  for (const JointId id : tendons) add_tendon(world, id, joint_places, scene);
  return scene;
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
  for (const PairForce& pair : world.pair_forces()) {
    loads.push_back({.a = places.at(pair.a), .b = places.at(pair.b), .force = pair.force});
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

std::vector<PlacedJoint> placed_joints(const Scene& scene) {
  std::vector<PlacedJoint> joints;
  joints.reserve(scene.joints.size());
  const auto moves = [&](std::size_t body) { return scene.bodies[body].def.type == BodyType::Dynamic; };
  for (const SceneJoint& joint : scene.joints) {
    if (!moves(joint.first) && !moves(joint.second)) continue;
    joints.push_back({joint.def.kind, joint.first, joint.second, joint.def.frame_first, joint.def.frame_second});
  }
  return joints;
}

MayTouch may_touch(const Scene& scene) {
  using Pair = std::pair<std::size_t, std::size_t>;
  std::vector<CollisionFilter> filters;
  for (const SceneBody& body : scene.bodies) filters.push_back(body.def.filter);
  std::vector<Pair> joined;
  for (const SceneJoint& joint : scene.joints) {
    if (!joint.def.collide) joined.emplace_back(std::minmax(joint.first, joint.second));
  }
  std::sort(joined.begin(), joined.end());
  return [filters = std::move(filters), joined = std::move(joined)](std::size_t a, std::size_t b) {
    return filters_agree(filters.at(a), filters.at(b)) &&
           !std::binary_search(joined.begin(), joined.end(), Pair(std::minmax(a, b)));
  };
}

}  // namespace atl
