#include "mutate_json.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <iterator>
#include <nlohmann/json.hpp>
#include <random>
#include <vector>

namespace atl::fuzz {
namespace {

using Json = nlohmann::ordered_json;

constexpr int deepest = 80;  // beyond what a scene file may be

// False if they are nested deeper.
bool list_values(Json& value, std::vector<Json*>& all, int depth = 0) {
  all.push_back(&value);
  if (!value.is_structured()) return true;
  if (depth == deepest) return false;
  return std::all_of(value.begin(), value.end(), [&](Json& part) { return list_values(part, all, depth + 1); });
}

// At the edges of what is allowed, and of another kind.
Json odd_value(std::minstd_rand& random) {
  static const Json values = Json::parse(R"([
    null, true, false, 0, -1, 1, 2, 3, 0.5, -0.5, 1e-7, 1e-320, 1e40, 1e300, 1e17, 4294967296, "", "x", "box", "12",
    "unlimited", "ground", "a~b/c\n", [], {}, [0, 0, 0], [1, 2, 3], [0, 0, 0, 0], [1, 0], [1, 1, 5],
    [1e300, 1e300, 1e300], [5, 5], {"type": "sphere", "radius": 0.2}])");
  return values[random() % values.size()];
}

void change_members(Json& object, const std::vector<Json*>& all, std::minstd_rand& random) {
  auto member = object.begin();
  std::advance(member, random() % object.size());
  const std::string key = member.key();
  switch (random() % 4) {
    case 0:
      object.erase(key);
      return;
    case 1: {  // a slip of the pen
      Json moved = std::move(*member);
      object.erase(key);
      object[key + "s"] = std::move(moved);
      return;
    }
    default: {  // what another object has
      const Json& other = *all[random() % all.size()];
      if (!other.is_object() || other.empty()) {
        object[key] = other;
        return;
      }
      auto its = other.begin();
      std::advance(its, random() % other.size());
      const std::string other_key = its.key();
      const Json copy = *its;
      object[other_key] = copy;
    }
  }
}

void change_elements(Json& array, const std::vector<Json*>& all, std::minstd_rand& random) {
  const auto at = static_cast<std::ptrdiff_t>(random() % array.size());
  switch (random() % 3) {
    case 0:
      array.erase(array.begin() + at);
      return;
    case 1: {
      const Json copy = array[static_cast<std::size_t>(at)];
      array.push_back(copy);
      return;
    }
    default: {
      const Json copy = *all[random() % all.size()];
      array.push_back(copy);
    }
  }
}

void change(Json& value, const std::vector<Json*>& all, std::minstd_rand& random) {
  if (random() % 2 != 0 && !value.empty()) {
    if (value.is_object()) return change_members(value, all, random);
    if (value.is_array()) return change_elements(value, all, random);
  }
  if (value.is_number() && random() % 2 != 0) {
    // No factor that makes a count of a few millions, which are made in earnest.
    constexpr std::array factors = {-1.0, 1e-3, 1e12};
    value = value.get<double>() * factors[random() % factors.size()];
  } else if (random() % 3 == 0) {
    const Json copy = *all[random() % all.size()];
    value = copy;
  } else {
    value = odd_value(random);
  }
}

}  // namespace

std::string mutate_json(std::string_view text, unsigned int seed) {
  std::minstd_rand random(seed);
  if (random() % 8 == 0) return "";
  Json root = Json::parse(text, nullptr, false);
  if (root.is_discarded()) return "";
  std::vector<Json*> all;
  if (!list_values(root, all)) return "";
  change(*all[random() % all.size()], all, random);
  return root.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace atl::fuzz
