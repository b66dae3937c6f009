#pragma once

#include <jobs/arrays.h>
#include <solver/direct/elimination_order.h>

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

namespace atl::solver {

/// Factor L D L^T of a symmetric positive definite matrix of small dense blocks, most of which are zero: the system of
/// the joints of an island, in which two are coupled if they share a body. For joints that make no loop the factor has
/// as many blocks as the matrix, so time and memory are linear in their number (Baraff, "Linear-time dynamics using
/// Lagrange multipliers", SIGGRAPH 1996); loops fill some in.
///
/// Blocks only group the scalars: L is unit lower triangular and D a diagonal of numbers, so this is as stable as any
/// Cholesky factor, however badly conditioned the blocks are (Higham, "Accuracy and Stability of Numerical Algorithms",
/// 2002, 10.1).
///
/// analyse() is called when the pattern changes, then clear(), values are added, and factor(), as often as these
/// change, and solve() any number of times. Only analyse() allocates. The order of elimination, and with it every bit,
/// follows from the pattern and the numbers of the nodes alone.
class BlockLdlt {
 public:
  static constexpr int max_size = 6;
  using Block = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::ColMajor, max_size, max_size>;
  using BlockView = Eigen::Map<Eigen::MatrixXd>;

  /// `sizes`: rows of each node's block, in [1, 6]. `couplings`: pairs of different nodes whose block may not be zero,
  /// in any order and any number of times. Returns false, with no nodes left, if the factor had more than `max_blocks`
  /// under its diagonal; that takes no longer than a factor of that many.
  bool analyse(std::span<const std::uint8_t> sizes, std::span<const std::pair<std::uint32_t, std::uint32_t>> couplings,
               std::size_t max_blocks = any_fill);

  std::size_t nodes() const { return rank_.size(); }
  std::size_t rows() const { return static_cast<std::size_t>(row_.empty() ? 0 : row_.back()); }
  /// First row of a node in the vectors of solve().
  std::size_t row(std::uint32_t node) const { return static_cast<std::size_t>(row_[node]); }
  /// Blocks under the diagonal of the factor: what a limit on its size should look at.
  std::size_t factor_blocks() const { return below_.size(); }

  /// Sets all values to zero.
  void clear();
  /// Diagonal block of a node, to be added to: both triangles, though only the lower is looked at.
  BlockView diagonal(std::uint32_t node);
  /// Adds to the block in the rows of `row` and the columns of `column`, which are different and coupled.
  void add(std::uint32_t row, std::uint32_t column, const Eigen::Ref<const Eigen::MatrixXd>& values);

  /// For those that write blocks without looking them up: where the block of two coupled nodes is, or of a node with
  /// itself, until the next analyse(). It is dense and by columns, with the rows of the node that is eliminated later
  /// and the columns of the other: what is known of the block in the other orientation goes in transposed.
  std::size_t block_index(std::uint32_t a, std::uint32_t b) const;
  bool is_earlier(std::uint32_t a, std::uint32_t b) const { return rank_[a] < rank_[b]; }
  double* values(std::size_t block_index) { return values_.data() + block_index; }
  /// Copies all values, to be put back after factor().
  void copy_values(std::vector<double>& to) const { to.assign(values_.begin(), values_.end()); }
  void set_values(const std::vector<double>& from) { std::copy(from.begin(), from.end(), values_.begin()); }

  /// Returns false if a pivot is not positive: then the values are lost and solve() must not be called.
  [[nodiscard]] bool factor();
  /// Replaces b, of length rows(), by the solution of A x = b.
  void solve(std::span<double> b) const;

  /// The blocks of the inverse where the factor has blocks, in the layout of the values: see block_index(). Those on
  /// the diagonal are whole (Takahashi, Fagan and Chin, "Formation of a sparse bus impedance matrix and its application
  /// to short circuit study", PICA 1973). Takes about as long as two factors. `inverse` has room for more behind them.
  void invert(std::vector<double>& inverse) const;

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(rank_, row_, columns_, below_, coupled_, values_); }

 private:
  // A block of the factor under the diagonal: of the row node that is eliminated later.
  struct Below {
    std::uint32_t values;    // index of the first
    std::uint32_t diagonal;  // of the row node's diagonal block
    std::uint32_t row;       // of the row node
    std::uint32_t size;
  };
  struct Column {
    std::uint32_t diagonal = 0;  // index of the first value
    std::uint32_t row = 0;
    std::uint32_t size = 0;
    std::uint32_t end = 0;  // in below_; it begins where the column before ends
  };

  template <int Size>
  bool factor_all();
  template <int Size>
  void solve_all(double* b) const;
  template <int Size>
  void invert_all(double* inverse) const;

  std::vector<std::uint32_t> rank_;     // by node, in order of elimination
  std::vector<std::uint32_t> row_;      // by node, and the end
  std::vector<Column> columns_;         // by rank
  std::vector<Below> below_;            // by column, in order of elimination
  std::vector<std::uint32_t> coupled_;  // values of the block of each pair of a column, in the order factor() goes
  std::vector<double> values_;          // by column
  int common_size_ = 0;                 // of all nodes, or 0 if they differ
};

}  // namespace atl::solver
