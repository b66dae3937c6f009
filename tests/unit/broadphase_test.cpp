// New pairs against brute force, under random motion, additions and removals.

#include <collision/broadphase.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

#include "random.h"

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

  bool paired(std::uint32_t a, std::uint32_t b) const {
    const Proxy& x = proxies[a];
    const Proxy& y = proxies[b];
    if (x.kind == Kind::Free || y.kind == Kind::Free) return false;
    if (x.kind != Kind::Moving && y.kind != Kind::Moving) return false;
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
};

class Motion {
 public:
  Motion(std::uint32_t seed, std::uint32_t shapes, int threads) : random_(seed), arena_(threads) {
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
      }
    }
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

  void add(std::uint32_t shape) {
    Model::Proxy& proxy = model_.proxies[shape];
    const double what = random_.real(0, 1);
    proxy = {};
    proxy.moved = true;
    proxy.kind = what < 0.02 ? Kind::HalfSpace : what < 0.3 ? Kind::Fixed : Kind::Moving;
    if (proxy.kind == Kind::HalfSpace) {
      proxy.plane = {random_.direction(), random_.real(-8, -4)};
      broadphase_.add_half_space(shape, proxy.plane);
    } else {
      proxy.box = random_box();
      broadphase_.add_box(shape, proxy.box, proxy.kind == Kind::Fixed);
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
  jobs::Arena arena_;
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
    Motion motion(seed, 250, 2);
    for (int step = 0; step < 25; ++step) {
      motion.step();
      ASSERT_EQ(motion.found(), motion.expected()) << "seed " << seed << ", step " << step;
      total += motion.found().size();
    }
  }
  EXPECT_GT(total, 5000u);
}

TEST(Broadphase, PairsDoNotDependOnThreads) {
  Motion one(9, 600, 1);
  Motion four(9, 600, 4);
  for (int step = 0; step < 10; ++step) {
    one.step();
    four.step();
    ASSERT_EQ(one.found(), four.found());
  }
}

TEST(Broadphase, OnlyMovesAreAskedForPartners) {
  jobs::Arena arena(1);
  Broadphase broadphase;
  const Aabb box{{0, 0, 0}, {1, 1, 1}};
  broadphase.add_box(0, box, false);
  broadphase.add_box(1, box, false);
  EXPECT_TRUE(broadphase.has_moved(0));
  EXPECT_EQ(broadphase.find_new_pairs({}, arena).size(), 1u);
  broadphase.forget_moves();
  EXPECT_FALSE(broadphase.has_moved(0));
  EXPECT_TRUE(broadphase.find_new_pairs({}, arena).empty());
  broadphase.move_box(1, box);
  EXPECT_EQ(broadphase.find_new_pairs({}, arena).size(), 1u);
}

}  // namespace
}  // namespace atl::collision
