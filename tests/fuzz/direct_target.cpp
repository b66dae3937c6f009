// Sparse systems of any graph, of numbers that are well and badly conditioned: the order of elimination is one, and as
// much is filled in as it says; what is factored solves the system as well as dense algebra does; and no bit depends on
// the order in which couplings are given.

#include <solver/direct/block_ldlt.h>
#include <solver/direct/elimination_order.h>

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "bytes.h"
#include "finding.h"
#include "target.h"

namespace {

using namespace atl;
using Couplings = std::vector<std::pair<std::uint32_t, std::uint32_t>>;
using Eigen::MatrixXd, Eigen::VectorXd;

struct Graph {
  std::vector<std::uint8_t> sizes;
  Couplings couplings;
};

Graph graph_of(fuzz::Bytes& bytes) {
  Graph graph;
  const std::uint32_t nodes = 1 + bytes.below(24);
  const bool alike = bytes.one_in(3);
  for (std::uint32_t i = 0; i < nodes; ++i) {
    graph.sizes.push_back(static_cast<std::uint8_t>(alike ? 1 + nodes % 6 : 1 + bytes.below(6)));
    if (i > 0 && !bytes.one_in(6)) graph.couplings.push_back({bytes.below(i), i});  // most hang together
  }
  for (std::uint32_t left = bytes.below(16); left > 0 && nodes > 1; --left) {
    const std::uint32_t a = bytes.below(nodes), b = bytes.below(nodes);
    if (a != b) graph.couplings.push_back({a, b});
  }
  return graph;
}

Couplings otherwise(Couplings couplings) {
  std::reverse(couplings.begin(), couplings.end());
  for (auto& [a, b] : couplings) std::swap(a, b);
  return couplings;
}

void check_order(const Graph& graph) {
  const std::size_t nodes = graph.sizes.size();
  const solver::EliminationOrder found = solver::min_degree_order(nodes, graph.couplings);
  std::vector<std::uint32_t> sorted = found.order, all(nodes);
  std::sort(sorted.begin(), sorted.end());
  std::iota(all.begin(), all.end(), 0);
  fuzz::require(sorted == all, "an order of elimination has not every node once");
  for (std::uint32_t i = 0; i < nodes; ++i)
    fuzz::require(found.rank[found.order[i]] == i, "ranks are not of the order");

  // By brute force: a node that is eliminated couples all that are left of its neighbours.
  std::vector<std::set<std::uint32_t>> near(nodes);
  const auto couple = [&](std::uint32_t a, std::uint32_t b) { near[a].insert(b), near[b].insert(a); };
  for (const auto& [a, b] : graph.couplings) couple(found.rank[a], found.rank[b]);
  for (std::uint32_t i = 0; i < nodes; ++i) {
    const std::vector<std::uint32_t> later(near[i].upper_bound(i), near[i].end());
    const std::vector<std::uint32_t> said(found.later.begin() + static_cast<std::ptrdiff_t>(found.start[i]),
                                          found.later.begin() + static_cast<std::ptrdiff_t>(found.start[i + 1]));
    fuzz::require(later == said, "an order of elimination fills in other blocks");
    for (std::size_t j = 0; j < later.size(); ++j) {
      for (std::size_t k = j + 1; k < later.size(); ++k) couple(later[j], later[k]);
    }
  }
  const std::size_t fill = found.later.size();
  fuzz::require(solver::min_degree_order(nodes, otherwise(graph.couplings)).order == found.order,
                "an order of elimination depends on how couplings are given");
  fuzz::require(solver::min_degree_order(nodes, graph.couplings, fill).order == found.order &&
                    (fill == 0 || solver::min_degree_order(nodes, graph.couplings, fill - 1).order.empty()),
                "fill is limited to another number than what is asked for");
}

// A sum of a square a coupling, and one a node, of sizes that differ: symmetric and positive definite.
class System {
 public:
  System(const Graph& graph, const Couplings& couplings, fuzz::Bytes bytes) {
    fuzz::require(blocks_.analyse(graph.sizes, couplings), "a factor of any size is refused");
    blocks_.clear();
    dense_.setZero(rows(), rows());
    const double spread = bytes.below(7);
    const auto any = [&](std::uint32_t node) {
      const double size = std::pow(10.0, bytes.within(-spread, 0));
      return (size * MatrixXd::NullaryExpr(graph.sizes[node], 6, [&] { return bytes.within(-1, 1); })).eval();
    };
    for (std::uint32_t node = 0; node < graph.sizes.size(); ++node) {
      const MatrixXd own = any(node);
      add(node, node, own * own.transpose() + 1e-9 * MatrixXd::Identity(own.rows(), own.rows()));
    }
    for (const auto& [a, b] : graph.couplings) {
      const MatrixXd of_a = any(a), of_b = any(b);
      add(a, a, of_a * of_a.transpose());
      add(b, b, of_b * of_b.transpose());
      add(a, b, of_a * of_b.transpose());
    }
  }

  Eigen::Index rows() const { return static_cast<Eigen::Index>(blocks_.rows()); }
  const MatrixXd& dense() const { return dense_; }

  /// Empty if there is no factor.
  VectorXd solve(VectorXd b) {
    if (!blocks_.factor()) return {};
    blocks_.solve({b.data(), static_cast<std::size_t>(b.size())});
    return b;
  }

 private:
  void add(std::uint32_t a, std::uint32_t b, const MatrixXd& values) {
    const auto row = static_cast<Eigen::Index>(blocks_.row(a)), column = static_cast<Eigen::Index>(blocks_.row(b));
    dense_.block(row, column, values.rows(), values.cols()) += values;
    if (a == b) {
      blocks_.diagonal(a) += values;
      return;
    }
    dense_.block(column, row, values.cols(), values.rows()) += values.transpose();
    blocks_.add(a, b, values);
  }

  solver::BlockLdlt blocks_;
  MatrixXd dense_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  atl::fuzz::Bytes bytes({data, size});
  const Graph graph = graph_of(bytes);
  check_order(graph);
  System system(graph, graph.couplings, bytes), other(graph, otherwise(graph.couplings), bytes);
  const VectorXd b = VectorXd::NullaryExpr(system.rows(), [&] { return bytes.within(-1, 1); });
  const VectorXd x = system.solve(b);
  atl::fuzz::require(x.size() == b.size(), "a positive definite system has no factor");
  atl::fuzz::require_finite(x, "a solution");
  // Backward stable: the residual is that of rounding the matrix, however large the solution is.
  const double residual = (system.dense() * x - b).norm(), scale = system.dense().norm() * x.norm() + b.norm();
  atl::fuzz::require(residual <= 1e-13 * scale,
                     "a solution is off by " + std::to_string(residual / scale) + " of its terms");
  atl::fuzz::require(other.solve(b) == x, "a solution depends on the order in which couplings are given");
  return 0;
}
