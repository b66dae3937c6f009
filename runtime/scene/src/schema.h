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
Quaternion read_orientation(const Reader& in);
Shape read_shape(const Reader& in);
SceneBody read_body(const Reader& in, const Library& library);

/// Bodies of one entry of "generators". `room` is how many more a scene may have; `stream` numbers the
/// generator, so that editing one does not change the random content of another.
std::vector<SceneBody> read_generator(const Reader& in, const Library& library, std::size_t room, std::uint64_t seed,
                                      std::uint64_t stream);

}  // namespace atl::scene
