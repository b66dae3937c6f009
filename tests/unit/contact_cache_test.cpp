// The cache of contacts against a plain list of them.

#include <collision/contacts/contact_cache.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <set>
#include <vector>

#include "support/random.h"

namespace atl::collision {
namespace {

using test::Random;

constexpr std::uint32_t bodies = 12;
constexpr std::uint32_t surface = bodies - 1;  // its pairs have four contacts

// One shape a body, of the same number.
struct Model {
  ContactCache cache;
  std::map<std::pair<std::uint32_t, std::uint32_t>, bool> pairs;  // whether it has points
  std::set<std::uint32_t> active;

  bool is_active(Pair pair) const { return active.contains(pair.first) || active.contains(pair.second); }

  void add_some(Random& random) {
    std::set<std::pair<std::uint32_t, std::uint32_t>> chosen;
    for (int i = 0; i < 5; ++i) {
      const std::uint32_t a = random.below(bodies);
      const std::uint32_t b = random.below(bodies);
      if (a != b && !pairs.contains(std::minmax(a, b))) chosen.insert(std::minmax(a, b));
    }
    std::vector<Pair> fresh;
    for (const auto& [a, b] : chosen) fresh.push_back({a, b});
    cache.add(fresh, [](Pair pair) {
      return ContactCache::Start{pair.first, pair.second, 0, 0, 1, false, pair.second == surface ? 4 : 1};
    });
    for (const auto& pair : chosen) {
      pairs[pair] = random.chance(0.5);
      cache.for_each_contact_of(pair.first, [&](std::uint32_t slot) {
        const Contact& contact = cache.contacts[slot];
        if (contact.pair == Pair{pair.first, pair.second}) cache.contacts[slot].count = pairs[pair] ? 2 : 0;
      });
    }
  }

  void change_active(Random& random) {
    std::vector<std::uint32_t> started;
    std::vector<std::uint32_t> stopped;
    for (std::uint32_t body = 0; body < bodies; ++body) {
      if (!random.chance(0.3)) continue;
      (active.contains(body) ? stopped : started).push_back(body);
    }
    const std::span<const std::uint32_t> order = cache.order().slots();
    const std::vector<std::uint32_t> before(order.begin(), order.end());
    for (const std::uint32_t body : started) active.insert(body);
    for (const std::uint32_t body : stopped) active.erase(body);
    const auto woken = cache.set_active(started, stopped);
    std::vector<std::uint32_t> expected;
    for (const std::uint32_t slot : cache.order().slots()) {
      if (std::find(before.begin(), before.end(), slot) == before.end()) expected.push_back(slot);
    }
    EXPECT_EQ(std::vector<std::uint32_t>(woken.begin(), woken.end()), expected);
  }

  void remove_some(Random& random) {
    std::set<std::uint64_t> gone;
    for (const auto& [pair, points] : pairs) {
      const Pair key{pair.first, pair.second};
      if (is_active(key) && random.chance(0.1)) gone.insert(key.key());
    }
    cache.remove_if([&](std::uint32_t slot) { return gone.contains(cache.contacts[slot].pair.key()); });
    std::erase_if(pairs, [&](const auto& entry) {
      return gone.contains(Pair{entry.first.first, entry.first.second}.key());
    });
  }

  void remove_body(std::uint32_t body) {
    cache.remove_contacts_of(body);
    std::erase_if(pairs, [&](const auto& entry) { return entry.first.first == body || entry.first.second == body; });
  }

  // Pair and part of each contact, in order.
  using Entries = std::vector<std::pair<std::uint64_t, int>>;
  Entries entries(std::span<const std::uint32_t> slots) const {
    Entries list;
    for (const std::uint32_t slot : slots)
      list.emplace_back(cache.contacts[slot].pair.key(), cache.contacts[slot].part);
    return list;
  }

  void check() const {
    Entries all;
    Entries in_order;
    std::vector<std::size_t> of_body(bodies, 0);
    for (const auto& [pair, points] : pairs) {
      const Pair key{pair.first, pair.second};
      const int parts = pair.second == surface ? 4 : 1;
      for (int part = 0; part < parts; ++part) {
        all.emplace_back(key.key(), part);
        if (is_active(key)) in_order.emplace_back(key.key(), part);
        ++of_body[pair.first];
        ++of_body[pair.second];
      }
      EXPECT_TRUE(cache.pairs.contains(key));
      if (is_active(key)) {
        EXPECT_EQ(cache.touches(key), points);
      }
    }
    EXPECT_EQ(entries(cache.order().slots()), in_order);
    EXPECT_EQ(entries(cache.all_in_order()), all);
    EXPECT_EQ(cache.size(), all.size());
    EXPECT_EQ(cache.pairs.size(), pairs.size());
    for (std::uint32_t body = 0; body < bodies; ++body) {
      std::set<std::uint32_t> seen;
      cache.for_each_contact_of(body, [&](std::uint32_t slot) {
        EXPECT_TRUE(seen.insert(slot).second);
        EXPECT_TRUE(cache.contacts[slot].body_first == body || cache.contacts[slot].body_second == body);
      });
      EXPECT_EQ(seen.size(), of_body[body]);
    }
  }
};

TEST(ContactCache, HoldsActiveContactsInOrderAndRemembersTheOthers) {
  Random random(5);
  for (int world = 0; world < 20; ++world) {
    Model model;
    for (int step = 0; step < 60; ++step) {
      model.change_active(random);
      model.add_some(random);
      if (random.chance(0.5)) model.remove_some(random);
      if (random.chance(0.2)) model.remove_body(random.below(bodies));
      if (random.chance(0.6)) model.check();  // what came and went in between adds up
      if (testing::Test::HasFailure()) return;
    }
  }
}

}  // namespace
}  // namespace atl::collision
