#include "lattice.h"
#include "max_parts.h"
#include "memory_need.h"
#include "random.h"
#include "schema.h"
#include "words.h"

namespace atl::scene {
namespace {

constexpr int max_along_axis = static_cast<int>(max_bodies);

std::array<int, 3> read_count(const Reader& in) {
  constexpr const char* what = "an array of three integers, [x, y, layers]";
  if (in.size(what) != 3) in.expected(what);
  std::array<int, 3> count{};
  for (std::size_t i = 0; i < 3; ++i) count[i] = in.element(i).integer(1, max_along_axis);
  return count;
}

std::array<int, 2> read_taper(const Reader& in, const std::array<int, 3>& count) {
  constexpr const char* what = "an array of two integers, [x, y]";
  if (in.size(what) != 2) in.expected(what);
  std::array<int, 2> taper{};
  for (std::size_t i = 0; i < 2; ++i) {
    taper[i] = in.element(i).integer(0, max_along_axis);
    const double top = count[i] - double(taper[i]) * (count[2] - 1);
    if (top < 1) in.element(i).fail(number_text(taper[i]), "a taper that leaves bodies in every layer");
  }
  return taper;
}

Lattice read_lattice(const Reader& in) {
  Lattice lattice;
  lattice.count = read_count(in.at("count", "[x, y, layers], how many bodies along each axis"));
  get(in, "spacing", lattice.spacing);
  return lattice;
}

Lattice read_copies(const Reader& in) {
  in.only_keys({"count", "spacing"});
  return read_lattice(in);
}

}  // namespace

std::vector<SceneBody> read_generator(const Reader& in, const Library& library, std::size_t room, std::uint64_t seed,
                                      std::uint64_t stream) {
  in.only_keys({"body", "count", "spacing", "taper", "stagger", "jitter", "random_orientation", "copies"});
  const SceneBody body = read_body(in.at("body", "a body to repeat"), library);
  Lattice lattice = read_lattice(in);
  if (const auto taper = in.find("taper")) lattice.taper = read_taper(*taper, lattice.count);
  if (const auto stagger = in.find("stagger")) {
    lattice.stagger = stagger->numbers<2>("an array of two numbers, [x, y]", between(-1, 1));
  }
  Vector3 jitter = Vector3::Zero();
  get(in, "jitter", jitter, at_least(0));
  bool random_orientation = false;
  get(in, "random_orientation", random_orientation);
  if (random_orientation && in.at("body", "").has("orientation")) {
    in.fail_at("random_orientation", "it for a body with an orientation", "one of them");
  }
  Lattice copies;
  if (const auto found = in.find("copies")) copies = read_copies(*found);

  const double size = lattice.size() * copies.size();
  if (size > static_cast<double>(room)) {
    const std::string memory = memory_words({.bodies = size});
    in.fail_at("count", number_text(size) + " bodies" + (memory.empty() ? "" : ", which need " + memory),
               "at most " + std::to_string(room) + " more: a scene has at most " + std::to_string(max_bodies));
  }
  Random random(seed, stream);
  std::vector<SceneBody> bodies;
  bodies.reserve(static_cast<std::size_t>(size));
  const std::vector<Vector3> points = lattice.points();
  for (const Vector3& copy : copies.points()) {
    for (const Vector3& point : points) {
      SceneBody& placed = bodies.emplace_back(body);
      if (!body.name.empty()) placed.name = body.name + "_" + std::to_string(bodies.size() - 1);
      placed.def.position += copy + point + random.in_box(jitter);
      if (!placed.def.position.allFinite()) {
        in.fail("positions too large for a double", "a smaller position, spacing or jitter");
      }
      if (random_orientation) placed.def.orientation = random.rotation();
    }
  }
  return bodies;
}

}  // namespace atl::scene
