// Pairs found apart are left alone for as long as motion can't have brought them together, and no longer.

#include <collision/contacts/update_contacts.h>
#include <collision/narrowphase/collide.h>
#include <collision/narrowphase/distance.h>
#include <collision/narrowphase/surface_contacts.h>
#include <collision/shapes/triangle_mesh.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <span>
#include <vector>

#include "grid_mesh.h"
#include "support/random.h"

namespace atl::collision {
namespace {

using test::Random;

const NarrowphaseKernels& any_kernels() {
  for (const char* name : {"avx512", "avx2", "sse4", "neon", "portable"}) {
    if (const NarrowphaseKernels* found = find_narrowphase_kernels(name)) return *found;
  }
  ADD_FAILURE() << "no kernels";
  std::abort();
}

// Two bodies of one shape each, whose fat boxes always overlap.
struct TwoBodies {
  TwoBodies(const Shape& first, const Shape& second, const Pose& local) {
    const std::array<const Shape*, 2> shapes = {&first, &second};
    for (std::uint32_t body = 0; body < 2; ++body) {
      colliders.add(body, 0, *shapes[body], local);
      broadphase.add_box(body, everywhere, false);
    }
    const Pair pair{0, 1};
    const auto size = static_cast<float>(std::min(first.inner_radius, second.inner_radius));
    const bool on_surface = is_surface(second.kind);
    if (on_surface) dynamic[1] = mobility[1] = 0;
    cache.set_active(both, {});
    cache.add(std::span(&pair, 1), [&](Pair) {
      const bool has_local_offset = colliders.has_local_offset[0] != 0;
      return ContactCache::Start{0, 1, 0.5f, 0, size, has_local_offset, on_surface ? max_surface_manifolds : 1};
    });
    update();
  }

  void put(std::size_t body, const Vector3& position, const Quaternion& orientation) {
    const Quaternion before(orientations.data() + 4 * body);
    turned[body] += 2 * (before.conjugate() * orientation).vec().norm();
    for (std::size_t i = 0; i < 3; ++i) positions[3 * body + i] = position[static_cast<Eigen::Index>(i)];
    for (std::size_t i = 0; i < 4; ++i) {
      orientations[4 * body + i] = orientation.coeffs()[static_cast<Eigen::Index>(i)];
    }
  }

  PoseView poses() const { return {positions.data(), orientations.data()}; }

  void update() {
    update_contacts(cache, broadphase, {colliders, poses(), dynamic, mobility, turned, reaches, any_kernels()}, arena,
                    result);
    broadphase.forget_moves();
  }

  bool found_touching() const {
    return std::any_of(cache.contacts.begin(), cache.contacts.end(), [](const Contact& c) { return c.count > 0; });
  }

  // True if the narrowphase finds points at this share of the margin.
  bool touching(double share) const {
    const bool swap = colliders.shape[1].kind < colliders.shape[0].kind;
    const std::uint32_t lower = swap ? 1 : 0;
    const Pose second = relative(colliders.pose(lower, poses()), colliders.pose(1 - lower, poses()));
    const double margin = speculative_margin(static_cast<double>(cache.contacts[0].size), 0);
    if (is_surface(colliders.shape[1].kind)) {
      SurfaceManifolds found;
      collide_surface(colliders.shape[0], colliders.shape[1],
                      relative(colliders.pose(1, poses()), colliders.pose(0, poses())), share * margin, found);
      return found.count > 0;
    }
    Manifold manifold;
    collide(colliders.shape[lower], colliders.shape[1 - lower], second, share * margin, manifold);
    return manifold.count > 0;
  }

  static inline const Aabb everywhere = Aabb::around(Vector3::Constant(-100), Vector3::Constant(100));
  ColliderTable colliders;
  std::array<double, 6> positions = {0, 0, 0, 10, 0, 0};
  std::array<double, 8> orientations = {0, 0, 0, 1, 0, 0, 0, 1};
  static constexpr std::array<std::uint32_t, 2> both = {0, 1};
  std::array<std::uint8_t, 2> dynamic = {1, 1};
  std::array<std::uint8_t, 2> mobility = {2, 2};
  std::array<double, 2> turned = {0, 0};
  std::array<StepReach, 2> reaches = {};
  Broadphase broadphase;
  ContactCache cache;
  jobs::Arena arena{1};
  ContactUpdate result;
};

const Pose centred{Vector3::Zero(), Quaternion::Identity()};

TEST(Apart, NoneThatComesWithinTheMarginIsMissed) {
  Random random(7);
  const std::vector<Shape> shapes = {Shape::box({0.2, 0.5, 1.5}), Shape::capsule(0.2, 1), Shape::cylinder(0.6, 0.3)};
  int touching = 0;
  std::int64_t recycled = 0;
  for (int run = 0; run < 60; ++run) {
    const Pose local = random.chance(0.5) ? centred : Pose{random.vector(0.7), random.rotation()};
    TwoBodies bodies(shapes[random.below(3)], shapes[random.below(3)], local);
    std::array<Vector3, 2> at = {random.vector(1.5), random.vector(1.5)};
    std::array<Quaternion, 2> turned = {random.rotation(), random.rotation()};
    const double pace = random.magnitude(1e-3, 0.3);
    for (int step = 0; step < 100; ++step) {
      for (std::size_t body = 0; body < 2; ++body) {
        at[body] = 0.98 * (at[body] + random.vector(pace));
        turned[body] = (random.rotation(pace) * turned[body]).normalized();
        bodies.put(body, at[body], turned[body]);
      }
      bodies.update();
      recycled += bodies.found_touching() ? 0 : bodies.result.counts.recycled;
      if (!bodies.touching(0.5)) continue;
      ++touching;
      ASSERT_TRUE(bodies.found_touching()) << "run " << run << ", step " << step;
    }
  }
  // Both happen.
  EXPECT_GT(touching, 100);
  EXPECT_GT(recycled, 100);
}

// Hills and dales of triangles of 0.5 m, of which there are 200.
TriangleMesh hills(Random& random) {
  return test::grid(10, 2.5, [&](double, double) { return 0.3 * random.vector(1).x(); });
}

TEST(Apart, NoneThatComesToASurfaceIsMissed) {
  Random random(8);
  const std::vector<Shape> shapes = {Shape::box({0.2, 0.3, 0.5}), Shape::capsule(0.2, 0.3), Shape::sphere(0.3)};
  const TriangleMesh mesh = hills(random);
  const Shape surface = Shape::triangle_mesh(mesh);
  int touching = 0;
  std::int64_t recycled = 0, recomputed = 0;
  for (int run = 0; run < 120; ++run) {
    const Pose local = random.chance(0.5) ? centred : Pose{random.vector(0.7), random.rotation()};
    TwoBodies bodies(shapes[random.below(3)], surface, local);
    const Pose body{random.vector(20), random.rotation()};
    bodies.put(1, body.position, body.orientation);
    const Pose stands = placed(body, local);
    Vector3 at = random.vector(1.5) + Vector3(0, 0, 1.5);
    Quaternion turn = random.rotation();
    const double pace = random.magnitude(1e-3, 0.1);
    for (int step = 0; step < 100; ++step) {
      at = at + random.vector(pace) - 0.02 * (at - Vector3(0, 0, 0.5));
      turn = (random.rotation(pace) * turn).normalized();
      bodies.put(0, stands.position + stands.orientation * at, turn);
      bodies.update();
      recomputed += bodies.result.counts.recomputed;
      recycled += bodies.found_touching() ? 0 : bodies.result.counts.recycled;
      if (!bodies.touching(0.5)) continue;
      ++touching;
      ASSERT_TRUE(bodies.found_touching()) << "run " << run << ", step " << step;
    }
  }
  EXPECT_GT(touching, 100);
  EXPECT_GT(recycled, recomputed / 4);
}

// By hand, as set_pose() does: the solid stays where it is.
TEST(Apart, ASurfaceThatIsTurnedIsLookedAtAnew) {
  Random random(9);
  const TriangleMesh mesh = hills(random);
  TwoBodies bodies(Shape::box({0.2, 0.3, 0.5}), Shape::triangle_mesh(mesh), centred);
  const Vector3 above(0, 0, 2.2);
  bodies.put(0, above, Quaternion::Identity());
  bodies.put(1, Vector3::Zero(), Quaternion::Identity());
  bodies.update();
  bodies.update();
  ASSERT_FALSE(bodies.found_touching());
  ASSERT_EQ(bodies.result.counts.recomputed, 0);
  // About x by a right angle, and a half more: its rim comes up to the box.
  bodies.put(1, Vector3::Zero(), Quaternion(std::sqrt(0.5), -std::sqrt(0.5), 0, 0));
  bodies.turned[1] += put_elsewhere;
  bodies.update();
  EXPECT_EQ(bodies.result.counts.recomputed, 1);
}

// A child of a compound is tested by the way that it moves itself. Turning in place brings it no nearer, so a child
// that stays where it is needs no test, however far from the body's centre it is.
TEST(Apart, AChildThatTurnsWhereItIsCostsNothing) {
  Random random(11);
  const TriangleMesh mesh = hills(random);
  TwoBodies bodies(Shape::box({0.2, 0.3, 0.5}), Shape::triangle_mesh(mesh), {{3, 0, 0}, Quaternion::Identity()});
  const Vector3 place(3, 0, 2);
  bodies.put(1, Vector3::Zero(), Quaternion::Identity());
  bodies.put(0, place - Vector3(3, 0, 0), Quaternion::Identity());
  for (int step = 0; step < 5; ++step) bodies.update();
  ASSERT_EQ(bodies.result.counts.recomputed, 0);
  for (int step = 1; step < 60; ++step) {
    const Quaternion turn(Eigen::AngleAxisd(0.1 * step, Vector3::UnitZ()));
    bodies.put(0, place - turn * Vector3(3, 0, 0), turn);
    bodies.update();
    ASSERT_EQ(bodies.result.counts.recomputed, 0) << step;
  }
}

// Together through space, as boxes that fall side by side: nothing is asked anew.
TEST(Apart, MovingTogetherCostsNothing) {
  TwoBodies bodies(Shape::box(Vector3::Constant(0.5)), Shape::box(Vector3::Constant(0.5)), centred);
  for (int step = 0; step < 20; ++step) {
    const Vector3 fallen(0, 0, -0.3 * step);
    bodies.put(0, fallen, Quaternion::Identity());
    bodies.put(1, fallen + 1.2 * Vector3::UnitX(), Quaternion::Identity());
    bodies.update();
    EXPECT_EQ(bodies.result.counts.recycled, 1) << "step " << step;
    EXPECT_EQ(bodies.result.counts.recomputed, 0);
  }
}

}  // namespace
}  // namespace atl::collision
