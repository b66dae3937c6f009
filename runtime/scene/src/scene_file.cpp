#include <atoll/scene.h>

#include <filesystem>
#include <unordered_set>

#include "file_size.h"
#include "max_parts.h"
#include "schema.h"
#include "words.h"

namespace atl {
namespace scene {
namespace {

constexpr double newest_version = 1;
constexpr int max_steps = 1'000'000'000;

void read_format(const Reader& in) {
  const Reader format = in.at("format", quote("atoll-scene"));
  if (!format.is<std::string>() || format.string() != "atoll-scene") format.expected(quote("atoll-scene"));
  const Reader version = in.at("version", number_text(newest_version));
  if (!version.is_number(newest_version)) version.expected(number_text(newest_version));
}

Library read_library(const Reader& in) {
  Library library;
  if (const auto materials = in.find("materials")) {
    for (const JsonValue::Member& member : materials->members()) {
      library.materials[member.key] = read_material(materials->member(member));
    }
  }
  if (const auto shapes = in.find("shapes")) {
    for (const JsonValue::Member& member : shapes->members()) {
      library.shapes[member.key] = read_shape(shapes->member(member));
    }
  }
  return library;
}

// Before anything is made of the document.
void check_memory(const JsonDocument& document) {
  const SceneSize size = size_of_file(document.root);
  const std::string words = memory_words(size);
  // A scene with more bodies than allowed is refused later, by the reader, which knows the place in the file.
  if (words.empty() || size.bodies > static_cast<double>(max_bodies)) return;
  throw SceneError(document.origin + ": its " + number_text(size.bodies) + " bodies need " + words);
}

// Adds bodies to a scene and sees to it that no two have one name.
class BodyList {
 public:
  explicit BodyList(std::vector<SceneBody>& bodies) : bodies_(bodies) {}

  std::size_t room() const { return max_bodies - bodies_.size(); }

  void add(SceneBody body, const Reader& in) {
    if (!body.name.empty() && !names_.insert(body.name).second) {
      in.fail_at("name", "a second body named " + quote(body.name), "a name that no other body has");
    }
    bodies_.push_back(std::move(body));
  }

 private:
  std::vector<SceneBody>& bodies_;
  std::unordered_set<std::string> names_;
};

void read_bodies(const Reader& in, const Library& library, BodyList& list) {
  const std::size_t count = in.size("an array of bodies");
  if (count > max_bodies) {
    in.fail(std::to_string(count) + " bodies", "at most " + std::to_string(max_bodies));
  }
  for (std::size_t i = 0; i < count; ++i) list.add(read_body(in.element(i), library), in.element(i));
}

void read_generators(const Reader& in, const Library& library, std::uint64_t seed, BodyList& list) {
  const std::size_t count = in.size("an array of generators");
  for (std::size_t i = 0; i < count; ++i) {
    const Reader generator = in.element(i);
    for (SceneBody& body : read_generator(generator, library, list.room(), seed, i)) {
      list.add(std::move(body), generator.at("body", ""));
    }
  }
}

void read_joints(const Reader& in, Scene& scene) {
  const std::size_t count = in.size("an array of joints");
  if (count > max_joints) in.fail(std::to_string(count) + " joints", "at most " + std::to_string(max_joints));
  Places bodies("body"), joints("joint");
  for (const SceneBody& body : scene.bodies) bodies.add(body.name);
  std::unordered_set<std::string> names;
  for (std::size_t i = 0; i < count; ++i) {
    SceneJoint joint = read_joint(in.element(i), scene, bodies, joints);
    if (!joint.name.empty() && !names.insert(joint.name).second) {
      in.element(i).fail_at("name", "a second joint named " + quote(joint.name), "a name that no other joint has");
    }
    joints.add(joint.name);
    scene.joints.push_back(std::move(joint));
  }
}

}  // namespace
}  // namespace scene

Scene parse_scene(std::string_view json, const std::string& origin, std::uint64_t seed, MeshFiles files) {
  using namespace scene;
  JsonDocument document = parse_json(json, origin);
  document.mesh_files = files;
  const Reader in(document);
  // The format first: of another kind of file, no other message would make sense.
  read_format(in);
  in.only_keys({"format", "version", "name", "description", "gravity", "dt", "steps", "starts_at_rest", "settings",
                "materials", "material_pairs", "shapes", "bodies", "generators", "joints"});
  check_memory(document);

  Scene scene;
  scene.name = printable(std::filesystem::path(origin).stem().string());
  read_name(in, scene.name);
  if (const auto description = in.find("description")) description->string();
  get(in, "gravity", scene.gravity);
  get(in, "dt", scene.dt, between(shortest_step, longest_step));
  get(in, "steps", scene.steps, 1, max_steps);
  get(in, "starts_at_rest", scene.starts_at_rest);
  if (const auto settings = in.find("settings")) scene.settings = read_settings(*settings);

  const Library library = read_library(in);
  if (const auto pairs = in.find("material_pairs")) {
    for (std::size_t i = 0; i < pairs->size("an array of pairs of materials"); ++i) {
      scene.material_pairs.push_back(read_material_pair(pairs->element(i)));
    }
  }
  BodyList list(scene.bodies);
  if (const auto bodies = in.find("bodies")) read_bodies(*bodies, library, list);
  if (const auto generators = in.find("generators")) read_generators(*generators, library, seed, list);
  if (scene.bodies.empty()) in.fail_at("bodies", "no bodies", "at least one, here or from a generator");
  if (const auto joints = in.find("joints")) read_joints(*joints, scene);
  return scene;
}

}  // namespace atl
