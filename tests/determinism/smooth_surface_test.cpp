// Balls on smooth surfaces: the same bits whatever the threads, vectors, restores and ways of solving.

#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "support/variants.h"

namespace atl::test::smooth_surface_test {
namespace {

// Balls, boxes and a hung ball in a bowl, which stands or moves.
Scene bowl(const std::string& type) {
  std::ostringstream text;
  text << R"({"format": "atoll-scene", "version": 1, "dt": 0.01, "steps": 60, "bodies": [)"
       << R"({"name": "bowl", "type": ")" << type << R"(", "position": [-2, -2, 0],)"
       << (type == "kinematic" ? R"("velocity": [50, 0, 0],)" : "")
       << R"("shape": {"type": "height_field", "smooth": true,)"
       << R"("spacing": [0.5, 0.5], "heights": [)";
  for (int j = 0; j <= 8; ++j) {
    text << (j > 0 ? ", [" : "[");
    for (int i = 0; i <= 8; ++i) text << (i > 0 ? ", " : "") << 0.05 * ((i - 4) * (i - 4) + (j - 4) * (j - 4));
    text << "]";
  }
  text << "]}}";
  for (int i = 0; i < 8; ++i) {
    text << R"(, {"name": "ball)" << i << R"(", "position": [)" << 0.4 * (i % 3) - 0.3 << ", " << 0.4 * (i / 3) - 0.4
         << R"(, 0.9], "velocity": [)" << (type == "kinematic" ? 50 : 0) + i % 2
         << R"(, 1, 0], "shape": {"type": "sphere", "radius": 0.15}, "material": {"friction": )" << 0.2 * (i % 3)
         << R"(, "restitution": )" << 0.3 * (i % 2) << "}}";
  }
  text << R"(], "joints": [{"kind": "distance", "first": "ball0", "second": "ball1", "at": [-0.3, -0.4, 0.9],)"
       << R"("at_second": [0.1, -0.4, 0.9]}]})";
  return parse_scene(text.str(), "bowl.json");
}

class SmoothSurfaceBits : public testing::TestWithParam<ContactSolver> {};

TEST_P(SmoothSurfaceBits, AreTheSame) {
  using divergence::Restore;
  for (const char* type : {"static", "kinematic"}) {
    Scene scene = bowl(type);
    scene.settings.contact_solver = GetParam();
    const divergence::Variant first;
    const auto trail = divergence::follow(scene, first);
    for (const Simd simd : divergence::supported_simds()) {
      expect_same(trail, scene, first, {.threads = 2, .simd = simd, .restore = Restore::FreshWorld});
    }
    expect_same(trail, scene, first, {.threads = 1, .restore = Restore::SameWorld});
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, SmoothSurfaceBits,
                         testing::Values(ContactSolver::Auto, ContactSolver::Direct, ContactSolver::Iterative),
                         [](const auto& test) { return std::to_string(test.index); });

}  // namespace
}  // namespace atl::test::smooth_surface_test
