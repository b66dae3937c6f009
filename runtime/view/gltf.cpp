#include "view/gltf.h"

#include <atoll/error.h>
#include <atoll/world.h>
#include <tiny_gltf.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <ostream>
#include <utility>

#include "view/colour.h"

namespace atl::view {
namespace {

constexpr std::size_t hue_count = 12;  // of what moves

}  // namespace

GltfFilm::GltfFilm(GltfOptions options) : options_(std::move(options)), clock_(options_.first_step, options_.stride) {}

void GltfFilm::add(const World& world, const StepReport&, double dt) {
  if (clock_.tick(dt)) add_frame(world);
}

void GltfFilm::add_frame(const World& world) {
  const std::size_t frame = times_.size();
  times_.push_back(static_cast<float>(clock_.time()));
  std::map<BodyId, std::size_t> places;
  for (const BodyId id : world.bodies()) {
    const auto known = places_.find(id);
    const std::size_t place = known != places_.end() ? known->second : bodies_.size();
    places.emplace(id, place);
    if (known == places_.end()) {
      const std::string name(world.name(id));
      bodies_.push_back({.name = name.empty() ? "body " + std::to_string(id.index) : name,
                         .surface = surfaces_.number_of(world, id),
                         .moves = world.type(id) != BodyType::Static,
                         .first_frame = frame,
                         .positions = {},
                         .turns = {}});
    }
    Body& body = bodies_[place];
    const Pose pose = world.pose(id);
    const Eigen::Vector3f at = pose.position.cast<float>();
    // A body that was lost far away may be beyond a float's range; it keeps its last place.
    const bool is_known = at.allFinite() || body.positions.empty();
    Eigen::Vector4f turn = pose.orientation.coeffs().cast<float>().normalized();
    if (!body.turns.empty() && turn.dot(Eigen::Map<const Eigen::Vector4f>(body.turns.back().data())) < 0) turn = -turn;
    body.positions.push_back(!is_known         ? body.positions.back()
                             : !at.allFinite() ? std::array<float, 3>{}
                                               : std::array{at.x(), at.y(), at.z()});
    body.turns.push_back({turn.x(), turn.y(), turn.z(), turn.w()});
  }
  places_ = std::move(places);
}

// The parts of a glTF file, with their data in one buffer.
class GltfFilm::Writer {
 public:
  explicit Writer(const GltfFilm& film) : film_(film) {
    model_.asset.version = "2.0";
    model_.asset.generator = "Atoll";
    model_.buffers.emplace_back();
    tinygltf::Node root;
    root.name = film.options_.name.empty() ? "run" : film.options_.name;
    root.rotation = {-std::sqrt(0.5), 0, 0, std::sqrt(0.5)};  // z to y
    model_.nodes.push_back(root);
    if (film.times_.size() > 1) {
      times_ = add_numbers(film.times_.data(), film.times_.size(), 1, Bounds::Told);
      animation_.name = root.name;
    }
    for (std::size_t place = 0; place < film.bodies_.size(); ++place) add_body(place);
    if (!animation_.channels.empty()) model_.animations.push_back(std::move(animation_));
    tinygltf::Scene scene;
    scene.nodes = {0};
    model_.scenes.push_back(scene);
    model_.defaultScene = 0;
    if (model_.buffers[0].data.empty()) model_.buffers.clear();
  }

  bool write(std::ostream& out, bool binary) {
    return tinygltf::TinyGLTF().WriteGltfSceneToStream(&model_, out, !binary, binary);
  }

 private:
  enum class Bounds { Told, Left };

  // The material of a moving body, by its place in the list of bodies, or that of static bodies.
  int material(const Body& body, std::size_t place) {
    const std::size_t hue = body.moves ? place % hue_count : hue_count;
    const auto known = materials_.find(hue);
    if (known != materials_.end()) return known->second;
    const Colour colour = linear(body.moves ? body_colour(hue) : static_colour);
    tinygltf::Material made;
    made.name = body.moves ? "moving " + std::to_string(hue) : "static";
    made.pbrMetallicRoughness.baseColorFactor = {colour.r, colour.g, colour.b, 1};
    made.pbrMetallicRoughness.metallicFactor = 0;
    made.pbrMetallicRoughness.roughnessFactor = 0.8;
    model_.materials.push_back(made);
    return materials_[hue] = static_cast<int>(model_.materials.size()) - 1;
  }

  int add_view(const void* data, std::size_t size, int target) {
    std::vector<unsigned char>& bytes = model_.buffers[0].data;
    bytes.resize((bytes.size() + 3) / 4 * 4);
    tinygltf::BufferView view;
    view.buffer = 0;
    view.byteOffset = bytes.size();
    view.byteLength = size;
    view.target = target;
    const auto* first = static_cast<const unsigned char*>(data);
    bytes.insert(bytes.end(), first, first + size);
    model_.bufferViews.push_back(view);
    return static_cast<int>(model_.bufferViews.size()) - 1;
  }

  // Adds `count` vectors of 1, 3 or 4 floats.
  int add_numbers(const float* data, std::size_t count, std::size_t width, Bounds bounds, int target = 0) {
    tinygltf::Accessor accessor;
    accessor.bufferView = add_view(data, count * width * sizeof(float), target);
    accessor.componentType = TINYGLTF_COMPONENT_TYPE_FLOAT;
    accessor.type = width == 1 ? TINYGLTF_TYPE_SCALAR : width == 3 ? TINYGLTF_TYPE_VEC3 : TINYGLTF_TYPE_VEC4;
    accessor.count = count;
    for (std::size_t k = 0; k < width && bounds == Bounds::Told; ++k) {
      float min = data[k], max = data[k];
      for (std::size_t i = 1; i < count; ++i) {
        min = std::min(min, data[i * width + k]);
        max = std::max(max, data[i * width + k]);
      }
      accessor.minValues.push_back(min);
      accessor.maxValues.push_back(max);
    }
    model_.accessors.push_back(accessor);
    return static_cast<int>(model_.accessors.size()) - 1;
  }

  // Places and indices of a surface's triangles.
  const std::pair<int, int>& surface(std::uint32_t number) {
    const auto known = geometry_.find(number);
    if (known != geometry_.end()) return known->second;
    const Triangles& triangles = film_.surfaces_[number];
    std::vector<std::array<float, 3>> vertices;
    for (const Vector3& vertex : triangles.vertices) {
      const Eigen::Vector3f at = vertex.cast<float>();
      vertices.push_back({at.x(), at.y(), at.z()});
    }
    const int places =
        add_numbers(vertices.front().data(), vertices.size(), 3, Bounds::Told, TINYGLTF_TARGET_ARRAY_BUFFER);
    tinygltf::Accessor indices;
    indices.bufferView = add_view(triangles.triangles.data(), triangles.triangles.size() * 3 * sizeof(std::uint32_t),
                                  TINYGLTF_TARGET_ELEMENT_ARRAY_BUFFER);
    indices.componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
    indices.type = TINYGLTF_TYPE_SCALAR;
    indices.count = 3 * triangles.triangles.size();
    model_.accessors.push_back(indices);
    return geometry_[number] = {places, static_cast<int>(model_.accessors.size()) - 1};
  }

  int mesh(std::uint32_t number, int material_index) {
    const auto known = meshes_.find({number, material_index});
    if (known != meshes_.end()) return known->second;
    const auto [places, indices] = surface(number);
    tinygltf::Primitive primitive;
    primitive.attributes["POSITION"] = places;
    primitive.indices = indices;
    primitive.material = material_index;
    primitive.mode = TINYGLTF_MODE_TRIANGLES;
    tinygltf::Mesh mesh;
    mesh.primitives.push_back(primitive);
    model_.meshes.push_back(mesh);
    return meshes_[{number, material_index}] = static_cast<int>(model_.meshes.size()) - 1;
  }

  void add_body(std::size_t place) {
    const Body& body = film_.bodies_[place];
    tinygltf::Node node;
    node.name = body.name;
    node.mesh = mesh(body.surface, material(body, place));
    const std::array<float, 3>& at = body.positions.front();
    const std::array<float, 4>& turn = body.turns.front();
    node.translation = {at[0], at[1], at[2]};
    node.rotation = {turn[0], turn[1], turn[2], turn[3]};
    const int number = static_cast<int>(model_.nodes.size());
    model_.nodes[0].children.push_back(number);
    model_.nodes.push_back(node);
    if (film_.times_.size() == 1) return;
    const auto varies = [](const auto& values) {
      return std::any_of(values.begin(), values.end(), [&](const auto& value) { return value != values.front(); });
    };
    if (varies(body.positions)) add_channel(number, "translation", by_frame(body, body.positions), 3, "LINEAR");
    if (varies(body.turns)) add_channel(number, "rotation", by_frame(body, body.turns), 4, "LINEAR");
    const bool always = body.first_frame == 0 && body.positions.size() == film_.times_.size();
    if (always) return;
    std::vector<std::array<float, 3>> scales(film_.times_.size(), {0, 0, 0});
    for (std::size_t i = 0; i < body.positions.size(); ++i) scales[body.first_frame + i] = {1, 1, 1};
    add_channel(number, "scale", scales, 3, "STEP");
  }

  // Before it came and after it went it stands still.
  template <typename Value>
  std::vector<Value> by_frame(const Body& body, const std::vector<Value>& values) const {
    std::vector<Value> all(body.first_frame, values.front());
    all.insert(all.end(), values.begin(), values.end());
    all.resize(film_.times_.size(), values.back());
    return all;
  }

  template <typename Value>
  void add_channel(int node, const char* path, const std::vector<Value>& values, std::size_t width,
                   const char* interpolation) {
    tinygltf::AnimationSampler sampler;
    sampler.input = times_;
    sampler.output = add_numbers(values.front().data(), values.size(), width, Bounds::Left);
    sampler.interpolation = interpolation;
    tinygltf::AnimationChannel channel;
    channel.sampler = static_cast<int>(animation_.samplers.size());
    channel.target_node = node;
    channel.target_path = path;
    animation_.samplers.push_back(sampler);
    animation_.channels.push_back(channel);
  }

  const GltfFilm& film_;
  tinygltf::Model model_;
  tinygltf::Animation animation_;
  int times_ = -1;                                         // accessor
  std::map<std::size_t, int> materials_;                   // by hue
  std::map<std::uint32_t, std::pair<int, int>> geometry_;  // accessors of places and indices
  std::map<std::pair<std::uint32_t, int>, int> meshes_;    // by surface and material
};

void GltfFilm::write(std::ostream& out, bool binary) const {
  if (!Writer(*this).write(out, binary)) throw Error("the scene could not be written as glTF");
}

}  // namespace atl::view
