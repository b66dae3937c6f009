#pragma once

#include <jobs/arrays.h>
#include <solver/direct/direct_rows.h>
#include <solver/direct/solve_input.h>

#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

namespace atl::solver {

/// Couples each two different bodies of some pairs, which may have no_body.
template <typename Pairs>
void couple_all(const Pairs& pairs, std::vector<std::pair<std::uint32_t, std::uint32_t>>& coupled) {
  std::vector<std::uint32_t> bodies;
  for (const auto& pair : pairs) {
    for (const std::uint32_t body : {pair.first, pair.second}) {
      if (body != no_body) bodies.push_back(body);
    }
  }
  std::sort(bodies.begin(), bodies.end());
  bodies.erase(std::unique(bodies.begin(), bodies.end()), bodies.end());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    for (std::size_t k = 0; k < i; ++k) coupled.emplace_back(bodies[k], bodies[i]);
  }
}

/// The members of an island: its dynamic bodies, whose places in this list are their numbers in the island's problem,
/// and the pairs of bodies that touch or are joined.
struct IslandMembers {
  std::size_t island = 0;
  std::uint32_t first_rank = 0;  ///< of its bodies among those of all islands
  std::vector<std::uint32_t> bodies;
  std::vector<TouchingPair> contacts;
  std::vector<JointLink> joints;
  std::vector<std::uint8_t> rows;                             ///< of each
  std::vector<std::pair<std::uint32_t, std::uint32_t>> ends;  ///< likewise: the numbers of its bodies

  /// The numbers of the bodies of each term of tendons, one tendon after another.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> term_ends;

  /// The number of a body of the world in the problem, or no_body if it isn't dynamic.
  std::uint32_t local(const SolveInput& input, std::uint32_t body) const {
    return input.bodies.mobility[body] == Mobility::Dynamic ? input.islands.rank(body) - first_rank : no_body;
  }

  /// Takes in the island of a group. Returns whether it has the bodies, contacts and joints of the one before, in the
  /// same order; slots of contacts may be others.
  bool take_in(const SolveInput& input, const IslandGroup& group);

  /// Numbers of bodies that touch or are joined.
  std::vector<std::pair<std::uint32_t, std::uint32_t>> couplings(const SolveInput& input) const;

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(bodies, contacts, joints, rows, ends, term_ends); }
};

}  // namespace atl::solver
