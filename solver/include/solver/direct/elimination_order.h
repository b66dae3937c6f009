#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <utility>
#include <vector>

namespace atl::solver {

/// The order in which the nodes of a graph are eliminated, and the others that each is coupled with at that time: the
/// pattern of a sparse factor's columns.
struct EliminationOrder {
  std::vector<std::uint32_t> order;  ///< nodes as they are eliminated
  std::vector<std::uint32_t> rank;   ///< by node: the inverse
  std::vector<std::size_t> start;    ///< by rank, in `later`, and the end
  std::vector<std::uint32_t> later;  ///< ranks of a node's neighbours when it is eliminated, rising
};

inline constexpr std::size_t any_fill = std::numeric_limits<std::size_t>::max();

/// Eliminates the node with the least neighbours left, first come first served among equals (Tinney and Walker, "Direct
/// solutions of sparse network equations", 1967): so a chain from both ends in turn, a tree from its leaves inwards.
/// `couplings`: pairs of different nodes, in any order and any number of times; the result depends on neither. Empty
/// if there were more than `max` neighbours in all, which is found out as soon as that is certain.
EliminationOrder min_degree_order(std::size_t nodes, std::span<const std::pair<std::uint32_t, std::uint32_t>> couplings,
                                  std::size_t max = any_fill);

}  // namespace atl::solver
