// Islands against plain breadth-first components, and the colouring of their contacts.

#include <gtest/gtest.h>
#include <solver/islands/islands.h>
#include <solver/sweep/colouring.h>

#include <algorithm>
#include <map>
#include <set>

#include "support/random.h"

namespace atl::solver {
namespace {

using test::Random;

struct Graph {
  std::vector<std::uint32_t> candidates;  // dynamic and kinematic bodies
  BodyTable bodies;
  std::vector<std::uint8_t> awake;
  std::vector<TouchingPair> pairs;
};

Graph random_graph(Random& random, std::uint32_t count, double pairs_per_body) {
  Graph graph;
  graph.bodies.resize(count);
  for (std::uint32_t body = 0; body < count; ++body) {
    graph.bodies.mobility[body] = random.chance(0.1)   ? Mobility::Fixed
                                  : random.chance(0.1) ? Mobility::Kinematic
                                                       : Mobility::Dynamic;
    graph.awake.push_back(graph.bodies.mobility[body] == Mobility::Dynamic);
    if (graph.bodies.mobility[body] != Mobility::Fixed) graph.candidates.push_back(body);
  }
  std::set<std::pair<std::uint32_t, std::uint32_t>> chosen;
  for (int i = 0; i < pairs_per_body * count; ++i) {
    const std::uint32_t a = random.below(count);
    const std::uint32_t b = random.below(count);
    if (a != b && (graph.awake[a] || graph.awake[b])) chosen.insert(std::minmax(a, b));
  }
  for (const auto& [a, b] : chosen) {
    graph.pairs.push_back({a, b, static_cast<std::uint32_t>(graph.pairs.size())});
  }
  return graph;
}

// The lowest body that each awake body is connected to.
std::map<std::uint32_t, std::uint32_t> components(const Graph& graph) {
  std::map<std::uint32_t, std::uint32_t> label;
  for (std::uint32_t body = 0; body < graph.awake.size(); ++body) {
    if (graph.awake[body]) label[body] = body;
  }
  for (bool changed = true; changed;) {
    changed = false;
    for (const TouchingPair& pair : graph.pairs) {
      if (!graph.awake[pair.first] || !graph.awake[pair.second]) continue;
      const std::uint32_t lowest = std::min(label[pair.first], label[pair.second]);
      changed |= label[pair.first] != lowest || label[pair.second] != lowest;
      label[pair.first] = label[pair.second] = lowest;
    }
  }
  return label;
}

TEST(Islands, AreTheConnectedComponentsInOrderOfTheirLowestBody) {
  Random random(1);
  for (int i = 0; i < 200; ++i) {
    const Graph graph = random_graph(random, 1 + random.below(60), random.real(0, 1.2));
    Islands islands;
    islands.build(graph.candidates, graph.awake, graph.pairs);
    const auto label = components(graph);

    std::set<std::uint32_t> touched;
    for (const TouchingPair& pair : graph.pairs) {
      for (const std::uint32_t body : {pair.first, pair.second}) {
        if (graph.awake[body]) touched.insert(body);
      }
    }
    std::set<std::uint32_t> seen;
    std::size_t contacts = 0;
    std::uint32_t last_lowest = 0;
    for (std::size_t island = 0; island < islands.count(); ++island) {
      const auto bodies = islands.bodies(island, island + 1);
      ASSERT_FALSE(bodies.empty());
      EXPECT_TRUE(std::is_sorted(bodies.begin(), bodies.end()));
      const std::uint32_t lowest = label.at(bodies.front());
      EXPECT_EQ(lowest, bodies.front());
      if (island > 0) {
        EXPECT_GT(lowest, last_lowest);
      }
      last_lowest = lowest;
      for (const std::uint32_t body : bodies) {
        EXPECT_EQ(label.at(body), lowest);
        EXPECT_TRUE(seen.insert(body).second);
      }
      std::uint32_t last_slot = 0;
      for (const TouchingPair& pair : islands.contacts(island, island + 1)) {
        const std::uint32_t dynamic = graph.awake[pair.first] ? pair.first : pair.second;
        EXPECT_EQ(label.at(dynamic), lowest);
        EXPECT_GE(pair.slot, last_slot);
        last_slot = pair.slot;
        ++contacts;
      }
    }
    EXPECT_EQ(seen, touched);
    EXPECT_EQ(contacts, graph.pairs.size());
    for (const std::uint32_t body : islands.free_bodies()) EXPECT_TRUE(graph.awake[body] && !touched.contains(body));
    EXPECT_EQ(islands.free_bodies().size() + touched.size(), label.size());
  }
}

TEST(Islands, GroupsHoldAllOfThemOnceAndInOrder) {
  Random random(2);
  const Graph graph = random_graph(random, 30000, 0.45);
  Islands islands;
  islands.build(graph.candidates, graph.awake, graph.pairs);
  std::vector<IslandGroup> groups;
  pack_groups(islands, false, {}, groups);
  std::size_t next = 0;
  for (const IslandGroup& group : groups) {
    EXPECT_EQ(group.begin, next);
    EXPECT_LT(group.begin, group.end);
    if (group.large) {
      EXPECT_EQ(group.end - group.begin, 1u);
    }
    next = group.end;
  }
  EXPECT_EQ(next, islands.count());
  EXPECT_GT(groups.size(), 1u);
}

std::vector<LocalContact> random_contacts(Random& random, std::uint32_t first_dynamic, std::uint32_t count, int pairs) {
  std::vector<LocalContact> contacts;
  for (int i = 0; i < pairs; ++i) {
    const std::uint32_t a = random.below(count);
    const std::uint32_t b = random.below(count);
    if (a != b && std::max(a, b) >= first_dynamic) {
      contacts.push_back({a, b, static_cast<std::uint32_t>(contacts.size())});
    }
  }
  return contacts;
}

TEST(Colouring, NoTwoContactsOfAColourShareADynamicBodyAndEachIsPlacedOnce) {
  Random random(3);
  for (int i = 0; i < 50; ++i) {
    const std::uint32_t first_dynamic = 1 + random.below(4);
    const std::uint32_t count = first_dynamic + 2 + random.below(60);
    const auto contacts = random_contacts(random, first_dynamic, count, 300);
    Colouring colouring;
    std::vector<ContactBlock> blocks;
    colouring.build(contacts, first_dynamic, count, blocks);

    std::set<std::int32_t> slots;
    for (const Colour& colour : colouring.colours()) {
      std::set<std::int32_t> bodies;
      for (std::size_t b = colour.begin_block; b < colour.end_block; ++b) {
        if (colour.serial) bodies.clear();
        for (std::size_t lane = 0; lane < block_lanes; ++lane) {
          if (blocks[b].slot[lane] < 0) {
            EXPECT_EQ((blocks[b].write_first | blocks[b].write_second) >> lane & 1, 0);
            continue;
          }
          EXPECT_TRUE(slots.insert(blocks[b].slot[lane]).second);
          const LocalContact& contact = contacts[static_cast<std::size_t>(blocks[b].slot[lane])];
          EXPECT_EQ(contact.first, static_cast<std::uint32_t>(blocks[b].first[lane]));
          EXPECT_EQ(contact.second, static_cast<std::uint32_t>(blocks[b].second[lane]));
          EXPECT_EQ(blocks[b].write_first >> lane & 1, contact.first >= first_dynamic);
          EXPECT_EQ(blocks[b].write_second >> lane & 1, contact.second >= first_dynamic);
          for (const std::uint32_t body : {contact.first, contact.second}) {
            if (body >= first_dynamic) {
              EXPECT_TRUE(bodies.insert(static_cast<std::int32_t>(body)).second);
            }
          }
        }
      }
    }
    EXPECT_EQ(slots.size(), contacts.size());
  }
}

TEST(Colouring, BodyWithMoreContactsThanColoursGetsTheRestOneByOne) {
  std::vector<LocalContact> contacts;
  for (std::uint32_t i = 0; i < 200; ++i) contacts.push_back({1, 2 + i, i});
  Colouring colouring;
  std::vector<ContactBlock> blocks;
  colouring.build(contacts, 1, 202, blocks);
  ASSERT_EQ(colouring.colours().size(), 65u);
  const Colour& last = colouring.colours().back();
  EXPECT_TRUE(last.serial);
  EXPECT_EQ(last.end_block - last.begin_block, 200u - 64u);
}

// Other islands of the group must not change the colour of a contact: lanes may be shared, order may not.
TEST(Colouring, OfAnIslandIsItsOwn) {
  Random random(4);
  const auto alone = random_contacts(random, 1, 30, 100);
  auto company = random_contacts(random, 1, 30, 100);
  for (LocalContact& contact : company) {
    if (contact.first >= 1) contact.first += 29;
    if (contact.second >= 1) contact.second += 29;
    contact.slot += static_cast<std::uint32_t>(alone.size());
  }
  auto together = company;
  together.insert(together.end(), alone.begin(), alone.end());
  const auto colour_by_slot = [](const std::vector<LocalContact>& contacts) {
    Colouring colouring;
    std::vector<ContactBlock> blocks;
    colouring.build(contacts, 1, 60, blocks);
    std::map<std::int32_t, std::size_t> colour_of;
    for (std::size_t colour = 0; colour < colouring.colours().size(); ++colour) {
      for (std::size_t b = colouring.colours()[colour].begin_block; b < colouring.colours()[colour].end_block; ++b) {
        for (const std::int32_t slot : blocks[b].slot) colour_of[slot] = colour;
      }
    }
    colour_of.erase(-1);
    return colour_of;
  };
  const auto own = colour_by_slot(alone);
  const auto shared = colour_by_slot(together);
  for (const auto& [slot, colour] : own) EXPECT_EQ(shared.at(slot), colour);
}

}  // namespace
}  // namespace atl::solver
