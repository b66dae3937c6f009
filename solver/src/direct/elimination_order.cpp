#include <jobs/assert.h>
#include <solver/direct/elimination_order.h>

#include <algorithm>

namespace atl::solver {
namespace {

constexpr std::uint32_t none = ~std::uint32_t{0};

// Nodes by degree, each degree in order of arrival.
class Queue {
 public:
  explicit Queue(std::size_t nodes)
      : head_(nodes, none), tail_(nodes, none), next_(nodes, none), previous_(nodes, none) {}

  void push(std::uint32_t node, std::size_t degree) {
    ATL_ASSERT(node < next_.size(), node, next_.size());
    ATL_ASSERT(degree < head_.size(), node, degree, head_.size());
    const std::uint32_t last = tail_[degree];
    previous_[node] = last;
    next_[node] = none;
    (last == none ? head_[degree] : next_[last]) = node;
    tail_[degree] = node;
    min_ = std::min(min_, degree);
  }

  void remove(std::uint32_t node, std::size_t degree) {
    ATL_ASSERT(node < next_.size(), node, next_.size());
    ATL_ASSERT(degree < head_.size() && head_[degree] != none, node, degree);
    const std::uint32_t before = previous_[node];
    const std::uint32_t after = next_[node];
    (before == none ? head_[degree] : next_[before]) = after;
    (after == none ? tail_[degree] : previous_[after]) = before;
  }

  // There is one.
  std::uint32_t front() {
    while (head_[min_] == none) ++min_;
    ATL_ASSERT(min_ < head_.size(), min_, head_.size());
    return head_[min_];
  }

 private:
  std::vector<std::uint32_t> head_, tail_;      // by degree
  std::vector<std::uint32_t> next_, previous_;  // by node
  std::size_t min_ = 0;                         // no node has a lower degree
};

// Neighbours of each node that is left, rising.
class Graph {
 public:
  Graph(std::size_t nodes, std::span<const std::pair<std::uint32_t, std::uint32_t>> couplings) : lists_(nodes) {
    for (const auto& [a, b] : couplings) {
      ++lists_[a].room;
      ++lists_[b].room;
    }
    std::size_t total = 0;
    for (List& list : lists_) {
      list.begin = total;
      total += list.room;
    }
    pool_.reserve(2 * total);
    pool_.resize(total);
    for (const auto& [a, b] : couplings) {
      pool_[lists_[a].begin + lists_[a].count++] = b;
      pool_[lists_[b].begin + lists_[b].count++] = a;
    }
    for (List& list : lists_) {
      const auto begin = pool_.begin() + static_cast<std::ptrdiff_t>(list.begin);
      const auto end = begin + static_cast<std::ptrdiff_t>(list.count);
      std::sort(begin, end);
      list.count = static_cast<std::size_t>(std::unique(begin, end) - begin);
      ends_ += list.count;
    }
  }

  std::size_t degree(std::uint32_t node) const { return lists_[node].count; }
  std::span<const std::uint32_t> neighbours(std::uint32_t node) const {
    return {pool_.data() + lists_[node].begin, lists_[node].count};
  }
  // Between the nodes that are left.
  std::size_t couplings() const { return ends_ / 2; }

  // Takes out a neighbour of `node` that is eliminated, and couples `node` with that one's others: `clique`, in which
  // `node` is too.
  void inherit(std::uint32_t node, std::uint32_t eliminated, std::span<const std::uint32_t> clique) {
    merged_.clear();
    const auto mine = neighbours(node);
    ATL_ASSERT(std::binary_search(mine.begin(), mine.end(), eliminated), node, eliminated);
    ATL_ASSERT(std::binary_search(clique.begin(), clique.end(), node), node, clique.size());
    auto at = mine.begin();
    for (const std::uint32_t other : clique) {
      for (; at != mine.end() && *at < other; ++at) {
        if (*at != eliminated) merged_.push_back(*at);
      }
      if (at != mine.end() && *at == other) ++at;
      if (other != node) merged_.push_back(other);
    }
    for (; at != mine.end(); ++at) {
      if (*at != eliminated) merged_.push_back(*at);
    }
    List& list = lists_[node];
    if (merged_.size() > list.room) {
      list.room = 2 * merged_.size();
      list.begin = pool_.size();
      pool_.resize(pool_.size() + list.room);
    }
    ends_ += merged_.size();
    ends_ -= list.count;
    list.count = merged_.size();
    ATL_ASSERT(list.begin + list.count <= pool_.size(), node, list.begin, list.count, pool_.size());
    std::copy(merged_.begin(), merged_.end(), pool_.begin() + static_cast<std::ptrdiff_t>(list.begin));
  }

  // Removes a node's own list, after inherit() of all its neighbours.
  void drop(std::uint32_t node) { ends_ -= lists_[node].count; }

 private:
  struct List {
    std::size_t begin = 0, count = 0, room = 0;
  };
  std::vector<List> lists_;
  std::vector<std::uint32_t> pool_;
  std::vector<std::uint32_t> merged_;
  std::size_t ends_ = 0;  // of couplings: the sum of all degrees
};

}  // namespace

EliminationOrder min_degree_order(std::size_t nodes, std::span<const std::pair<std::uint32_t, std::uint32_t>> couplings,
                                  std::size_t max) {
  Graph graph(nodes, couplings);
  if (graph.couplings() > max) return {};

  EliminationOrder result;
  result.order.reserve(nodes);
  result.rank.resize(nodes);
  result.start.reserve(nodes + 1);
  result.start.push_back(0);
  result.later.reserve(graph.couplings());
  const auto finish = [&](std::uint32_t node) {
    result.rank[node] = static_cast<std::uint32_t>(result.order.size());
    result.order.push_back(node);
    result.start.push_back(result.later.size());
  };

  Queue queue(nodes);
  for (std::uint32_t node = 0; node < nodes; ++node) queue.push(node, graph.degree(node));
  std::vector<std::uint32_t> clique;
  for (std::size_t left = nodes; left > 0; --left) {
    const std::uint32_t node = queue.front();
    ATL_ASSERT(graph.degree(node) < left, node, graph.degree(node), left);
    const auto neighbours = graph.neighbours(node);
    clique.assign(neighbours.begin(), neighbours.end());
    result.later.insert(result.later.end(), clique.begin(), clique.end());
    finish(node);
    if (clique.size() + 1 == left) {
      // All nodes left are coupled with each other, so their columns are written without a further search.
      if (result.later.size() + clique.size() * (clique.size() - (clique.empty() ? 0 : 1)) / 2 > max) return {};
      for (auto next = clique.begin(); next != clique.end(); ++next) {
        result.later.insert(result.later.end(), next + 1, clique.end());
        finish(*next);
      }
      break;
    }
    queue.remove(node, clique.size());
    for (const std::uint32_t other : clique) {
      queue.remove(other, graph.degree(other));
      graph.inherit(other, node, clique);
      queue.push(other, graph.degree(other));
    }
    graph.drop(node);
    if (result.later.size() + graph.couplings() > max) return {};
  }

  for (std::uint32_t& node : result.later) node = result.rank[node];
  ATL_ASSERT(result.order.size() == nodes, result.order.size(), nodes);
  ATL_ASSERT(result.start.size() == nodes + 1, result.start.size(), nodes);
  ATL_ASSERT(result.start.back() == result.later.size(), result.start.back(), result.later.size());
  ATL_ASSERT(result.later.size() <= max, result.later.size(), max);
  for (std::size_t column = 0; column < nodes; ++column) {
    ATL_ASSERT(result.rank[result.order[column]] == column, column, result.order[column]);
    ATL_ASSERT(result.start[column] <= result.start[column + 1], column, result.start[column],
               result.start[column + 1]);
    std::sort(result.later.begin() + static_cast<std::ptrdiff_t>(result.start[column]),
              result.later.begin() + static_cast<std::ptrdiff_t>(result.start[column + 1]));
  }
  return result;
}

}  // namespace atl::solver
