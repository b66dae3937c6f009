// Ellipsoids and tapered capsules: the same bits whatever the threads, vectors and restores.

#include <gtest/gtest.h>

#include <sstream>
#include <string>

#include "support/variants.h"

namespace atl::test::smooth_solids_test {
namespace {

// Both kinds fall on each other and on boxes, between a plane and a field of heights.
Scene heap() {
  std::ostringstream text;
  text << R"({"format": "atoll-scene", "version": 1, "dt": 0.01, "steps": 80, "bodies": [)"
       << R"({"type": "static", "shape": {"type": "half_space", "offset": -0.2}},)"
       << R"({"type": "static", "position": [-1, -1, 0], "shape": {"type": "height_field", "spacing": [1, 1],)"
       << R"("heights": [[0.4, 0.1, 0.4], [0.1, 0, 0.1], [0.4, 0.1, 0.4]]}})";
  for (int i = 0; i < 24; ++i) {
    text << R"(, {"position": [)" << 0.4 * (i % 3) - 0.4 << ", " << 0.4 * (i / 3 % 2) - 0.2 << ", "
         << 0.6 + 0.35 * (i / 6) << R"(], "orientation": [0.1, )" << 0.2 * (i % 4) << R"(, 0.3, 1], "shape": )";
    if (i % 3 == 0) text << R"({"type": "ellipsoid", "half_axes": [0.2, 0.15, 0.1]}})";
    if (i % 3 == 1) text << R"({"type": "tapered_capsule", "radii": [0.15, 0.1], "half_height": 0.1}})";
    if (i % 3 == 2) text << R"({"type": "box", "half_extents": [0.15, 0.1, 0.1]}})";
  }
  text << "]}";
  return parse_scene(text.str(), "heap.json");
}

class SmoothSolidsBits : public testing::TestWithParam<ContactSolver> {};

TEST_P(SmoothSolidsBits, AreTheSame) {
  using divergence::Restore;
  Scene scene = heap();
  scene.settings.contact_solver = GetParam();
  const divergence::Variant first;
  const auto trail = divergence::follow(scene, first);
  for (const Simd simd : divergence::supported_simds()) {
    expect_same(trail, scene, first, {.threads = 2, .simd = simd, .restore = Restore::FreshWorld});
  }
  expect_same(trail, scene, first, {.threads = 1, .restore = Restore::SameWorld});
}

INSTANTIATE_TEST_SUITE_P(Solvers, SmoothSolidsBits, testing::Values(ContactSolver::Iterative, ContactSolver::Direct));

}  // namespace
}  // namespace atl::test::smooth_solids_test
