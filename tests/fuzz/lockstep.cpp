#include "lockstep.h"

#include <atoll/error.h>

#include <cstdint>

#include "finding.h"

namespace atl::fuzz {
namespace {

std::string error_of(const Lockstep::Call& make, World& world, std::size_t number) {
  try {
    make(world, number);
    return {};
  } catch (const Error& error) {
    require(error.what()[0] != '\0', "an error says nothing");
    return error.what();
  }
}

}  // namespace

Lockstep::Lockstep(std::span<const Variant> variants) {
  for (const Variant& variant : variants) {
    worlds_.push_back(
        World({.threads = variant.threads, .dynamic_threads = false, .settings = {.simd = variant.simd}}));
  }
}

std::string Lockstep::call(const char* name, const Call& make) {
  const std::uint64_t before = first().state_hash();
  const std::string error = step(make);
  require(error.empty() || first().state_hash() == before,
          std::string(name) + " threw and changed the world: " + error);
  require_same_state(name);
  return error;
}

std::string Lockstep::step(const Call& make) {
  const std::string error = error_of(make, first(), 0);
  for (std::size_t i = 1; i < worlds_.size(); ++i) {
    const std::string other = error_of(make, worlds_[i], i);
    require(other == error, "worlds throw different errors: \"" + error + "\" and \"" + other + "\"");
  }
  require_same_state("a call");
  return error;
}

void Lockstep::require_same_state(const char* name) {
  const std::uint64_t hash = first().state_hash();
  for (std::size_t i = 1; i < worlds_.size(); ++i) {
    require(worlds_[i].state_hash() == hash,
            std::string(name) + " comes to another state in world " + std::to_string(i));
  }
}

}  // namespace atl::fuzz
