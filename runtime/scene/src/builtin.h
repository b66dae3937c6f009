#pragma once

#include <atoll/scene.h>

#include <cstdint>
#include <string_view>
#include <vector>

namespace atl::scene {

/// Values of a built-in scene's parameters, checked against their ranges.
class ParameterValues {
 public:
  explicit ParameterValues(const BuiltinScene& scene);

  double operator[](std::string_view name) const { return values_[index(name)]; }
  int integer(std::string_view name) const { return static_cast<int>((*this)[name]); }
  void set(std::string_view name, double value) { values_[index(name)] = value; }

  /// "wall:base=100": what gives this scene again.
  std::string address() const;

 private:
  std::size_t index(std::string_view name) const;

  const BuiltinScene* scene_;
  std::vector<double> values_;
};

/// All of a scene but its name, which the caller sets.
using SceneBuilder = Scene (*)(const ParameterValues& values, std::uint64_t seed);

Scene build_pyramid3d(const ParameterValues& values, std::uint64_t seed);
Scene build_wall(const ParameterValues& values, std::uint64_t seed);
Scene build_islands(const ParameterValues& values, std::uint64_t seed);
Scene build_pile(const ParameterValues& values, std::uint64_t seed);
Scene build_marbles(const ParameterValues& values, std::uint64_t seed);
Scene build_hopper(const ParameterValues& values, std::uint64_t seed);
Scene build_conveyor(const ParameterValues& values, std::uint64_t seed);
Scene build_rocks(const ParameterValues& values, std::uint64_t seed);
Scene build_mixed(const ParameterValues& values, std::uint64_t seed);
Scene build_drum(const ParameterValues& values, std::uint64_t seed);
Scene build_terrain(const ParameterValues& values, std::uint64_t seed);
Scene build_stack(const ParameterValues& values, std::uint64_t seed);
Scene build_chain(const ParameterValues& values, std::uint64_t seed);
Scene build_joint_grid(const ParameterValues& values, std::uint64_t seed);
Scene build_ragdolls(const ParameterValues& values, std::uint64_t seed);
Scene build_bridge(const ParameterValues& values, std::uint64_t seed);
Scene build_vehicle(const ParameterValues& values, std::uint64_t seed);

/// The scene that "name" or "name:param=value,param=value" describes. Throws SceneError.
Scene load_builtin(std::string_view text, std::uint64_t seed);

}  // namespace atl::scene
