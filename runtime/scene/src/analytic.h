#pragma once

#include "builtin.h"

namespace atl::scene {

// Scenes whose motion is known in closed form, each with its measure: analytic/*.cpp.
Scene build_free_flight(const ParameterValues& values, std::uint64_t seed);
Scene build_spinning_top(const ParameterValues& values, std::uint64_t seed);
Scene build_heavy_top(const ParameterValues& values, std::uint64_t seed);
Scene build_sliding_blocks(const ParameterValues& values, std::uint64_t seed);
Scene build_incline(const ParameterValues& values, std::uint64_t seed);
Scene build_tipping_block(const ParameterValues& values, std::uint64_t seed);
Scene build_rolling_sphere(const ParameterValues& values, std::uint64_t seed);
Scene build_rolling_resistance(const ParameterValues& values, std::uint64_t seed);
Scene build_torsion(const ParameterValues& values, std::uint64_t seed);
Scene build_incline_sphere(const ParameterValues& values, std::uint64_t seed);
Scene build_pushed_box(const ParameterValues& values, std::uint64_t seed);
Scene build_bouncing_ball(const ParameterValues& values, std::uint64_t seed);
Scene build_elastic_ball(const ParameterValues& values, std::uint64_t seed);
Scene build_elastic_pair(const ParameterValues& values, std::uint64_t seed);
Scene build_stack_forces(const ParameterValues& values, std::uint64_t seed);
Scene build_rocking_block(const ParameterValues& values, std::uint64_t seed);
Scene build_cradle(const ParameterValues& values, std::uint64_t seed);

// And with joints.
Scene build_pendulum(const ParameterValues& values, std::uint64_t seed);
Scene build_double_pendulum(const ParameterValues& values, std::uint64_t seed);
Scene build_slider_crank(const ParameterValues& values, std::uint64_t seed);
Scene build_spring_damper(const ParameterValues& values, std::uint64_t seed);
Scene build_hanging_chain(const ParameterValues& values, std::uint64_t seed);
Scene build_catenary(const ParameterValues& values, std::uint64_t seed);

}  // namespace atl::scene
