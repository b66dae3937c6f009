#pragma once
/// The parts of a scene file, one function each. README.md has the schema in words.

#include <atoll/scene.h>

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "reader.h"

namespace atl::scene {

/// What bodies refer to by name.
struct Library {
  std::map<std::string, Material, std::less<>> materials;
  std::map<std::string, Shape, std::less<>> shapes;
};

Settings read_settings(const Reader& in);
Material read_material(const Reader& in);
CollisionFilter read_filter(const Reader& in);
Quaternion read_orientation(const Reader& in);
Shape read_shape(const Reader& in);
SceneBody read_body(const Reader& in, const Library& library);

/// Bodies of one entry of "generators". `room` is how many more a scene may have; `stream` numbers the
/// generator, so that editing one does not change the random content of another.
std::vector<SceneBody> read_generator(const Reader& in, const Library& library, std::size_t room, std::uint64_t seed,
                                      std::uint64_t stream);

/// Where the bodies of a scene are among them, by their names.
class BodyPlaces {
 public:
  explicit BodyPlaces(const std::vector<SceneBody>& bodies);

  /// A body's name or its place.
  std::size_t read(const Reader& in) const;

 private:
  std::map<std::string, std::size_t, std::less<>> names_;
  std::size_t count_;
};

/// A joint between bodies of the scene, which has them all.
SceneJoint read_joint(const Reader& in, const Scene& scene, const BodyPlaces& places);

}  // namespace atl::scene
