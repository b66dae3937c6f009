// Changes that differ from world to world of a batch, given as arrays.

#include <atoll/batch.h>
#include <atoll/error.h>

#include <string>

#include "columns.h"

namespace atl {
namespace {

void check_count(const char* call, const char* what, std::size_t found, std::size_t expected) {
  if (found == expected) return;
  throw Error(std::string(call) + ": found " + std::to_string(found) + " numbers of " + what + "; expected " +
              std::to_string(expected) + " of them");
}

// Calls change(world, its number among `places`) for each.
template <typename Change>
void for_each(Batch& batch, std::span<const std::size_t> places, const Change& change) {
  const std::vector<std::size_t> numbers = numbers_of(batch, places);
  batch.for_each([&](World& world, std::size_t place) { change(world, numbers[place]); }, places);
}

// Gives a body of each world a number, by set(world, body, number).
template <typename Set>
void set_numbers(const char* call, const char* what, Batch& batch, std::size_t body, std::span<const double> numbers,
                 std::span<const std::size_t> places, const Set& set) {
  if (body >= batch.bodies().size()) {
    throw Error(std::string(call) + ": found body " + std::to_string(body) + "; expected one below " +
                std::to_string(batch.bodies().size()));
  }
  check_count(call, what, numbers.size(), places.empty() ? batch.size() : places.size());
  for_each(batch, places, [&](World& world, std::size_t i) { set(world, batch.bodies()[body], numbers[i]); });
}

}  // namespace

void set_gravities(Batch& batch, std::span<const double> gravities, std::span<const std::size_t> places) {
  check_count("set_gravities", "gravities", gravities.size(), 3 * (places.empty() ? batch.size() : places.size()));
  for_each(batch, places, [&](World& world, std::size_t i) { world.set_gravity(Vector3(gravities.data() + 3 * i)); });
}

void set_masses(Batch& batch, std::size_t body, std::span<const double> masses, std::span<const std::size_t> places) {
  set_numbers("set_masses", "masses", batch, body, masses, places,
              [](World& world, BodyId id, double mass) { world.set_mass(id, mass); });
}

void set_frictions(Batch& batch, std::size_t body, std::span<const double> frictions,
                   std::span<const std::size_t> places) {
  set_numbers("set_frictions", "frictions", batch, body, frictions, places,
              [](World& world, BodyId id, double friction) {
                Material material = world.material(id);
                material.friction = friction;
                world.set_material(id, material);
              });
}

}  // namespace atl
