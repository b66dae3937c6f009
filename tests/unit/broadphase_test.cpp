// New pairs against brute force, under random motion, additions and removals.

#include <collision/broadphase/broadphase.h>
#include <collision/broadphase/fat_box.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <set>
#include <vector>

#include "support/random.h"

namespace atl::collision {
namespace {

using test::Random;

enum class Kind { Free, Moving, Fixed, HalfSpace };

// The same shapes as a Broadphase has, and the pairs by definition.
struct Model {
  struct Proxy {
    Kind kind = Kind::Free;
    Aabb box = Aabb::empty();
    Plane plane = {Vector3::UnitZ(), 0};
    Filter filter;
    bool moved = false;
  };

  static bool below(const Plane& plane, const Aabb& box) {
    for (int corner = 0; corner < 8; ++corner) {
      const Vector3 p(corner & 1 ? box.lower[0] : box.upper[0], corner & 2 ? box.lower[1] : box.upper[1],
                      corner & 4 ? box.lower[2] : box.upper[2]);
      if (plane.normal.dot(p) <= plane.offset) return true;
    }
    return false;
  }

  bool meets(const Filter& x, const Filter& y) const {
    if (x.owner == y.owner || ignored.count(Pair::of(x.owner, y.owner)) != 0) return false;
    if (x.group == y.group && x.group > 0) return true;
    if (x.group == y.group && x.group < 0) return false;
    return (x.category & y.mask) != 0 && (y.category & x.mask) != 0;
  }

  bool paired(std::uint32_t a, std::uint32_t b) const {
    const Proxy& x = proxies[a];
    const Proxy& y = proxies[b];
    if (x.kind == Kind::Free || y.kind == Kind::Free) return false;
    if (x.kind != Kind::Moving && y.kind != Kind::Moving) return false;
    if (!meets(x.filter, y.filter)) return false;
    if (x.kind == Kind::HalfSpace) return below(x.plane, y.box);
    if (y.kind == Kind::HalfSpace) return below(y.plane, x.box);
    return x.box.overlaps(y.box);
  }

  std::vector<Pair> new_pairs(const std::set<Pair>& known) const {
    std::vector<Pair> pairs;
    for (std::uint32_t a = 0; a < proxies.size(); ++a) {
      for (std::uint32_t b = a + 1; b < proxies.size(); ++b) {
        const bool moved = proxies[a].moved || proxies[b].moved;
        if (moved && paired(a, b) && known.count({a, b}) == 0) pairs.push_back({a, b});
      }
    }
    return pairs;
  }

  std::vector<Proxy> proxies;
  std::set<Pair> ignored;  // owners
};

class Motion {
 public:
  Motion(std::uint32_t seed, std::uint32_t shapes) : random_(seed) {
    model_.proxies.resize(shapes);
    for (std::uint32_t shape = 0; shape < shapes; ++shape) add(shape);
  }

  // Moves, removes and adds some shapes, then finds pairs; the known ones that parted are forgotten.
  void step() {
    for (std::uint32_t shape = 0; shape < model_.proxies.size(); ++shape) {
      if (model_.proxies[shape].kind == Kind::Free) {
        if (random_.chance(0.3)) add(shape);
      } else if (random_.chance(0.03)) {
        remove(shape);
      } else if (random_.chance(0.3)) {
        move(shape);
      } else if (random_.chance(0.03)) {
        model_.proxies[shape].filter = random_filter(shape);
        model_.proxies[shape].moved = true;
        broadphase_.set_filter(shape, model_.proxies[shape].filter);
      }
    }
    for (int i = 0; i < 4; ++i) change_ignored();
    const auto known = known_;
    for (const Pair pair : known) {
      EXPECT_EQ(broadphase_.overlap(pair.first, pair.second), model_.paired(pair.first, pair.second));
      if (!model_.paired(pair.first, pair.second)) forget(pair);
    }
    expected_ = model_.new_pairs(known_);
    const std::span<const Pair> pairs = broadphase_.find_new_pairs(set_, arena_);
    found_.assign(pairs.begin(), pairs.end());
    for (const Pair pair : found_) {
      known_.insert(pair);
      set_.insert(pair);
    }
    broadphase_.forget_moves();
    for (Model::Proxy& proxy : model_.proxies) proxy.moved = false;
  }

  const std::vector<Pair>& found() const { return found_; }
  const std::vector<Pair>& expected() const { return expected_; }

 private:
  Aabb random_box() {
    const Vector3 centre = random_.vector(8);
    const Vector3 half(random_.real(0, 1), random_.real(0, 1), random_.real(0, 1));
    return Aabb::around(centre - half, centre + half);
  }

  // Often none; else such that a good part of all pairs may meet.
  Filter random_filter(std::uint32_t shape) {
    Filter filter{.owner = shape};
    if (random_.chance(0.5)) return filter;
    filter.category = 1u << random_.below(3);
    filter.mask = random_.below(8);
    filter.group = static_cast<std::int32_t>(random_.below(5)) - 2;
    filter.owner = shape - shape % 3;
    return filter;
  }

  void change_ignored() {
    const auto count = static_cast<std::uint32_t>(model_.proxies.size());
    const bool lift = !model_.ignored.empty() && random_.chance(0.4);
    const Pair owners = lift ? *model_.ignored.begin() : Pair::of(random_.below(count), random_.below(count));
    if (owners.first == owners.second) return;
    if (lift) {
      model_.ignored.erase(owners);
      broadphase_.enable_pair(owners.second, owners.first);
    } else {
      model_.ignored.insert(owners);
      broadphase_.disable_pair(owners.second, owners.first);
    }
    for (Model::Proxy& proxy : model_.proxies) {
      if (proxy.filter.owner == owners.first || proxy.filter.owner == owners.second) proxy.moved = true;
    }
  }

  void add(std::uint32_t shape) {
    Model::Proxy& proxy = model_.proxies[shape];
    const double what = random_.real(0, 1);
    proxy = {};
    proxy.moved = true;
    proxy.filter = random_filter(shape);
    proxy.kind = what < 0.02 ? Kind::HalfSpace : what < 0.3 ? Kind::Fixed : Kind::Moving;
    if (proxy.kind == Kind::HalfSpace) {
      proxy.plane = {random_.direction(), random_.real(-8, -4)};
      broadphase_.add_half_space(shape, proxy.plane, proxy.filter);
    } else {
      proxy.box = random_box();
      broadphase_.add_box(shape, proxy.box, proxy.kind == Kind::Fixed, proxy.filter);
    }
  }

  void move(std::uint32_t shape) {
    Model::Proxy& proxy = model_.proxies[shape];
    proxy.moved = true;
    if (proxy.kind == Kind::HalfSpace) {
      proxy.plane.normal = random_.direction();
      broadphase_.move_half_space(shape, proxy.plane);
    } else {
      proxy.box = random_box();
      broadphase_.move_box(shape, proxy.box);
    }
  }

  void remove(std::uint32_t shape) {
    broadphase_.remove(shape);
    model_.proxies[shape] = {};
    const auto known = known_;
    for (const Pair pair : known) {
      if (pair.first == shape || pair.second == shape) forget(pair);
    }
  }

  void forget(Pair pair) {
    known_.erase(pair);
    set_.erase(pair);
  }

  Random random_;
  jobs::Arena arena_{2};
  Broadphase broadphase_;
  Model model_;
  std::set<Pair> known_;
  PairSet set_;
  std::vector<Pair> found_, expected_;
};

// Equal vectors: the right pairs, in order, once each, and none of two that can't move.
TEST(Broadphase, FindsThePairsOfBruteForce) {
  std::size_t total = 0;
  for (std::uint32_t seed = 0; seed < 5; ++seed) {
    Motion motion(seed, 250);
    for (int step = 0; step < 25; ++step) {
      motion.step();
      ASSERT_EQ(motion.found(), motion.expected()) << "seed " << seed << ", step " << step;
      total += motion.found().size();
    }
  }
  EXPECT_GT(total, 5000u);
}

// If most of what moved is fixed, the search starts from the moving shapes.
TEST(Broadphase, FindsThePairsOfFewMovingShapesAmongManyFixed) {
  Random random(5);
  jobs::Arena arena(2);
  Broadphase broadphase;
  std::vector<Aabb> boxes;
  constexpr std::uint32_t moving = 20, max = 1000;
  const auto box = [&] {
    const Vector3 lower = random.vector(10);
    return Aabb::around(lower, lower + Vector3::Ones());
  };
  broadphase.add_half_space(max, {Vector3::UnitZ(), -8});
  for (int round = 0; round < 30; ++round) {
    std::set<std::uint32_t> moved;
    for (std::uint32_t shape = 0; shape < boxes.size(); ++shape) {
      if (!random.chance(round % 3 == 0 ? 0.2 : 0.01)) continue;
      broadphase.move_box(shape, boxes[shape] = box());
      moved.insert(shape);
    }
    for (int i = 0; i < (round % 4 == 0 ? 100 : 2) && boxes.size() < max; ++i) {
      const auto shape = static_cast<std::uint32_t>(boxes.size());
      boxes.push_back(box());
      broadphase.add_box(shape, boxes[shape], shape % (max / moving) != 7);
      moved.insert(shape);
    }
    std::vector<Pair> expected;
    for (std::uint32_t a = 0; a < boxes.size(); ++a) {
      for (std::uint32_t b = a + 1; b < boxes.size(); ++b) {
        const bool moves = a % (max / moving) == 7 || b % (max / moving) == 7;
        const bool asked = moved.count(a) + moved.count(b) > 0;
        if (moves && asked && boxes[a].overlaps(boxes[b])) expected.push_back({a, b});
      }
      const bool below = boxes[a].lower[2] <= -8;
      if (a % (max / moving) == 7 && below && (moved.count(a) > 0 || round == 0)) expected.push_back({a, max});
    }
    std::sort(expected.begin(), expected.end());
    const std::span<const Pair> found = broadphase.find_new_pairs({}, arena);
    ASSERT_EQ(std::vector<Pair>(found.begin(), found.end()), expected);
    broadphase.forget_moves();
  }
}

constexpr Aabb unit_box{{0, 0, 0}, {1, 1, 1}};

// Takes minutes if removing one shape takes a search of all that moved.
TEST(Broadphase, RemovesManyShapesAndTheirMoves) {
  jobs::Arena arena(1);
  Broadphase broadphase;
  constexpr std::uint32_t count = 100'000;
  for (std::uint32_t shape = 0; shape < count; ++shape) {
    const auto x = static_cast<float>(shape);
    broadphase.add_box(shape, {{x, 0, 0}, {x + 1.5f, 1, 1}}, false, {.owner = count / 2 + shape % 2});
  }
  for (std::uint32_t shape = 0; shape < count; ++shape) broadphase.remove(shape);
  EXPECT_TRUE(broadphase.find_new_pairs({}, arena).empty());
  // A number is free again, whether or not its moves are forgotten.
  broadphase.add_box(7, unit_box, false);
  broadphase.add_box(8, unit_box, false);
  EXPECT_EQ(broadphase.find_new_pairs({}, arena).size(), 1u);
  broadphase.forget_moves();
  EXPECT_FALSE(broadphase.has_moved(7));
}

TEST(Broadphase, BoxesWithNanMeetNobodyAndInfiniteOnesEverybody) {
  constexpr float nan = std::numeric_limits<float>::quiet_NaN();
  constexpr float infinity = std::numeric_limits<float>::infinity();
  jobs::Arena arena(1);
  Broadphase broadphase;
  broadphase.add_half_space(0, {Vector3::UnitZ(), 5});
  broadphase.add_box(1, {{nan, 0, 0}, {1, 1, 1}}, false);
  broadphase.add_box(2, {{-infinity, -infinity, -infinity}, {infinity, infinity, infinity}}, false);
  broadphase.add_box(3, {{0, 0, nan}, {1, 1, 1}}, false);
  broadphase.add_box(4, unit_box, false);
  broadphase.add_box(5, {{50, 0, 0}, {51, 1, 1}}, false);
  const std::vector<Pair> expected = {{0, 2}, {0, 4}, {0, 5}, {2, 4}, {2, 5}};
  for (int round = 0; round < 3; ++round) {  // as inserted, refitted and rebuilt
    const std::span<const Pair> pairs = broadphase.find_new_pairs({}, arena);
    EXPECT_EQ(std::vector<Pair>(pairs.begin(), pairs.end()), expected);
    for (std::uint32_t shape = 1; shape <= 5; ++shape) broadphase.move_box(shape, broadphase.proxies().fat_box(shape));
  }
  broadphase.move_box(1, unit_box);
  EXPECT_TRUE(broadphase.overlap(1, 4));
}

// A fat box holds the shape for as many steps as predicted, on its way and with its margin on all sides.
TEST(FatBox, ContainsTheShapeAsLongAsPredicted) {
  Random random(12);
  for (int i = 0; i < 500; ++i) {
    const Vector3 lower = random.vector(100);
    const Vector3 upper = lower + Vector3(random.real(0.5, 2), random.real(0.5, 2), 1);
    const Vector3 displacement = random.real(0, 0.1) * random.direction();
    const double aabb_margin = random.real(0, 0.2);
    const Aabb fat = fattened({lower, upper}, aabb_margin, displacement);
    for (int step = 0; step <= static_cast<int>(predicted_steps); ++step) {
      const Vector3 at = step * displacement * (1 - 1e-12);
      const Vector3 margin = Vector3::Constant(aabb_margin * (1 - 1e-12));
      EXPECT_TRUE(fat.contains(Aabb::around(lower + at - 0.999 * margin, upper + at + 0.999 * margin)));
    }
    const Vector3 volume_of_sweep = upper - lower + predicted_steps * displacement.cwiseAbs();
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const double swept = volume_of_sweep[static_cast<Eigen::Index>(axis)];
      EXPECT_NEAR(fat.upper[axis] - fat.lower[axis], swept + 2 * aabb_margin, 1e-4);
    }
  }
  // One that crosses a thousand times its size in a step gets a box of twice its size.
  const Aabb fast = fattened({Vector3::Zero(), Vector3::Ones()}, 0, Vector3(1000, 0, 0));
  EXPECT_EQ(fast, (Aabb{{0, 0, 0}, {2, 1, 1}}));
}

}  // namespace
}  // namespace atl::collision
