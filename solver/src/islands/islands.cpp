#include <jobs/assert.h>
#include <jobs/scratch.h>
#include <solver/islands/islands.h>
#include <solver/tuning.h>

#include <algorithm>
#include <numeric>

namespace atl::solver {
namespace {

// Contacts and joints, which count alike: of about 250 bytes each with their share of bodies, these stay well within
// the 1 MB of second-level cache that current server cores have; throughput was flat from 100 to 3500 contacts a group.
constexpr std::size_t group_contacts = 512;

// An island of this many contacts takes one worker about a millisecond: the rest should help.
constexpr std::size_t large_contacts = 2048;

// Islands and free bodies together have every awake candidate once, in order, and what acts between two bodies stands
// in the island of both.
void check_islands(const Islands& islands, std::span<const std::uint32_t> candidates,
                   std::span<const std::uint8_t> awake) {
  std::size_t covered = islands.free_bodies().size();
  for (const std::uint32_t body : islands.free_bodies()) {
    ATL_ASSERT(islands.island_of(body) == Islands::none, body, islands.island_of(body));
  }
  for (std::uint32_t island = 0; island < islands.count(); ++island) {
    const std::span<const std::uint32_t> bodies = islands.bodies(island, island + 1);
    ATL_ASSERT(!bodies.empty(), island);
    covered += bodies.size();
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      ATL_ASSERT(i == 0 || bodies[i - 1] < bodies[i], bodies[i], island);
      ATL_ASSERT(islands.island_of(bodies[i]) == island, bodies[i], islands.island_of(bodies[i]), island);
      ATL_ASSERT(islands.rank(bodies[i]) == islands.first_rank(island) + i, bodies[i], islands.rank(bodies[i]), island);
    }
    const auto check_ends = [&](const auto& pair) {
      for (const std::uint32_t body : {pair.first, pair.second}) {
        ATL_ASSERT(!awake[body] || islands.island_of(body) == island, body, islands.island_of(body), island);
      }
    };
    for (const TouchingPair& pair : islands.contacts(island, island + 1)) check_ends(pair);
    for (const JointLink& link : islands.joints(island, island + 1)) check_ends(link);
  }
  std::size_t candidates_awake = 0;
  for (const std::uint32_t body : candidates) candidates_awake += awake[body];
  ATL_ASSERT(covered == candidates_awake, covered, candidates_awake);
}

}  // namespace

std::uint32_t Islands::Memory::find(std::uint32_t body) {
  while (parent[body] != body) {
    parent[body] = parent[parent[body]];
    body = parent[body];
  }
  return body;
}

void Islands::build(std::span<const std::uint32_t> candidates, std::span<const std::uint8_t> awake,
                    std::span<const TouchingPair> pairs, std::span<const JointLink> links,
                    std::span<const JointLink> ties) {
  Memory& memory = jobs::of_this_thread<Memory>();
  for (const std::uint32_t body : bodies_) island_of_[body] = none;
  // If nothing moves, nothing asks for islands by body, and arrays over all bodies are not needed.
  if (!candidates.empty() || !pairs.empty() || !links.empty()) {
    if (memory.parent.size() < awake.size()) memory.parent.resize(awake.size());
    rank_.resize(awake.size());
    island_of_.resize(awake.size(), none);
  }
  memory.join(candidates, awake, pairs, links, ties);
  number(candidates, awake, memory);

  // Counting sorts of bodies and pairs by island.
  std::partial_sum(body_start_.begin(), body_start_.end(), body_start_.begin());
  bodies_.resize(body_start_.back());
  memory.cursor.assign(body_start_.begin(), body_start_.end());
  for (const std::uint32_t body : candidates) {
    if (island_of_[body] == none) continue;
    rank_[body] = memory.cursor[island_of_[body]]++;
    bodies_[rank_[body]] = body;
  }
  sort_by_island(pairs, memory, contacts_, contact_start_);
  sort_by_island(links, memory, joints_, joint_start_);
  if constexpr (jobs::with_asserts) check_islands(*this, candidates, awake);
}

// Sorts the pairs in which at least one body is awake by island; within an island the given order stays.
template <typename Pair>
void Islands::sort_by_island(std::span<const Pair> pairs, Memory& memory, jobs::CompactArray<Pair>& sorted,
                             jobs::CompactArray<std::uint32_t>& start) const {
  std::vector<std::uint32_t>& island_of_pair = memory.island_of_pair;
  start.assign(body_start_.size(), 0);
  island_of_pair.resize(pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const std::uint32_t island = island_of_[pairs[i].first];
    island_of_pair[i] = island != none ? island : island_of_[pairs[i].second];
    if (island_of_pair[i] != none) ++start[island_of_pair[i] + 1];
  }
  std::partial_sum(start.begin(), start.end(), start.begin());
  sorted.resize(start.back());
  memory.cursor.assign(start.begin(), start.end());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    if (island_of_pair[i] != none) sorted[memory.cursor[island_of_pair[i]]++] = pairs[i];
  }
}

// Finds the components.
void Islands::Memory::join(std::span<const std::uint32_t> candidates, std::span<const std::uint8_t> awake,
                           std::span<const TouchingPair> pairs, std::span<const JointLink> links,
                           std::span<const JointLink> ties) {
  for (const std::uint32_t body : candidates) parent[body] = none;
  const auto touch = [this](std::uint32_t body) {
    if (parent[body] == none) parent[body] = body;
  };
  const auto join_all = [&](const auto& all) {
    for (const auto& pair : all) {
      if (awake[pair.first]) touch(pair.first);
      if (awake[pair.second]) touch(pair.second);
      if (!awake[pair.first] || !awake[pair.second]) continue;
      const std::uint32_t a = find(pair.first);
      const std::uint32_t b = find(pair.second);
      parent[std::max(a, b)] = std::min(a, b);
    }
  };
  join_all(pairs);
  join_all(links);
  join_all(ties);
}

// Numbers islands as their lowest body comes up, and counts their bodies.
void Islands::number(std::span<const std::uint32_t> candidates, std::span<const std::uint8_t> awake, Memory& memory) {
  free_bodies_.clear();
  body_start_.assign(1, 0);
  for (const std::uint32_t body : candidates) {
    if (!awake[body]) continue;
    if (memory.parent[body] == none) {
      free_bodies_.push_back(body);
      continue;
    }
    const std::uint32_t root = memory.find(body);
    if (root == body) {
      island_of_[body] = static_cast<std::uint32_t>(body_start_.size()) - 1;
      body_start_.push_back(0);
    } else {
      island_of_[body] = island_of_[root];
    }
    ++body_start_[island_of_[body] + 1];
  }
}

std::span<const std::uint32_t> Islands::bodies(std::size_t begin, std::size_t end) const {
  ATL_ASSERT(begin <= end && end <= count(), begin, end, count());
  return std::span(bodies_).subspan(body_start_[begin], body_start_[end] - body_start_[begin]);
}

std::span<const TouchingPair> Islands::contacts(std::size_t begin, std::size_t end) const {
  ATL_ASSERT(begin <= end && end <= count(), begin, end, count());
  return std::span(contacts_).subspan(contact_start_[begin], contact_start_[end] - contact_start_[begin]);
}

std::span<const JointLink> Islands::joints(std::size_t begin, std::size_t end) const {
  ATL_ASSERT(begin <= end && end <= count(), begin, end, count());
  return std::span(joints_).subspan(joint_start_[begin], joint_start_[end] - joint_start_[begin]);
}

Build build_of(const Islands& islands, std::size_t island) {
  if (islands.joint_count(island) > 0) return Build::Joined;
  const auto bodies = static_cast<double>(islands.body_count(island));
  const auto contacts = static_cast<double>(islands.contact_count(island));
  const bool columns = bodies <= tuning::max_bodies && contacts <= tuning::contacts_of_columns * bodies;
  return columns ? Build::Columns : Build::Any;
}

void pack_groups(const Islands& islands, bool one_each, std::span<const std::uint32_t> group_keys,
                 std::vector<IslandGroup>& groups) {
  groups.clear();
  std::size_t begin = 0;
  std::size_t contacts = 0;
  const auto close = [&](std::size_t end) {
    if (begin < end) groups.push_back({begin, end, false});
    begin = end;
    contacts = 0;
  };
  for (std::size_t island = 0; island < islands.count(); ++island) {
    const std::size_t here = islands.contact_count(island) + islands.joint_count(island);
    if (here >= large_contacts || (!group_keys.empty() && group_keys[island] == Islands::none)) {
      close(island);
      groups.push_back({island, island + 1, here >= large_contacts});
      begin = island + 1;
    } else {
      const bool parts = !group_keys.empty() && begin < island && group_keys[island] != group_keys[begin];
      if (one_each || parts || contacts + here > group_contacts) close(island);
      contacts += here;
    }
  }
  close(islands.count());
}

}  // namespace atl::solver
