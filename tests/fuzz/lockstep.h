#pragma once
/// Worlds to which the same is done, on other numbers of threads and other instruction sets: all have to come to the
/// same.

#include <atoll/atoll.h>

#include <cstddef>
#include <functional>
#include <span>
#include <string>
#include <vector>

namespace atl::fuzz {

struct Variant {
  int threads = 1;
  Simd simd = Simd::Auto;
};

class Lockstep {
 public:
  explicit Lockstep(std::span<const Variant> variants);

  std::span<World> worlds() { return worlds_; }
  World& first() { return worlds_.front(); }

  using Call = std::function<void(World& world, std::size_t number)>;
  /// Makes a call in each world. All have to throw the same Error or none, which is returned, empty for none; to change
  /// nothing where they throw; and to come to the same state. Throws Finding if not.
  std::string call(const char* name, const Call& make);
  /// The same of a call that may change the world and throw: a step, through which what functions throw goes.
  std::string step(const Call& make);

 private:
  void require_same_state(const char* name);

  std::vector<World> worlds_;
};

}  // namespace atl::fuzz
