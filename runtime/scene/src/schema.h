#pragma once
/// The parts of a scene file, one function each. README.md has the schema in words.

#include <atoll/scene.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "reader.h"

namespace atl::scene {

/// Materials and shapes that bodies refer to by name.
struct Library {
  std::map<std::string, Material, std::less<>> materials;
  std::map<std::string, Shape, std::less<>> shapes;
};

Settings read_settings(const Reader& in);
Material read_material(const Reader& in);
MaterialPair read_material_pair(const Reader& in);
CollisionFilter read_filter(const Reader& in);
Quaternion read_orientation(const Reader& in);
Shape read_shape(const Reader& in);
SceneBody read_body(const Reader& in, const Library& library);

/// Bodies of one entry of "generators". `room` is how many more a scene may have; `stream` numbers the
/// generator, so that editing one does not change the random content of another.
std::vector<SceneBody> read_generator(const Reader& in, const Library& library, std::size_t room, std::uint64_t seed,
                                      std::uint64_t stream);

/// The places of the bodies, or joints, of a scene among them, by their names.
class Places {
 public:
  /// `what`: "body" or "joint".
  explicit Places(const char* what) : what_(what) {}

  void add(const std::string& name);
  /// A part's name or its place.
  std::size_t read(const Reader& in) const;

 private:
  const char* what_;
  std::map<std::string, std::size_t, std::less<>> names_;
  std::size_t count_ = 0;
};

/// A joint between bodies of the scene, which has them all; or a tendon over joints, which are those that it has.
SceneJoint read_joint(const Reader& in, const Scene& scene, const Places& bodies, const Places& joints);

}  // namespace atl::scene
