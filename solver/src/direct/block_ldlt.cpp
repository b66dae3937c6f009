#include <jobs/assert.h>
#include <solver/direct/block_ldlt.h>

#include <algorithm>
#include <type_traits>
#include <utility>

namespace atl::solver {
namespace {

// Calls with a size as a constant: `Size` itself, or if that is 0 the one found out now.
template <int Size, class Function>
inline auto with_size(std::uint32_t size, Function&& function) {
  if constexpr (Size > 0) {
    return function(std::integral_constant<int, Size>{});
  } else {
    static_assert(BlockLdlt::max_size == 6);
    switch (size) {
      case 1:
        return function(std::integral_constant<int, 1>{});
      case 2:
        return function(std::integral_constant<int, 2>{});
      case 3:
        return function(std::integral_constant<int, 3>{});
      case 4:
        return function(std::integral_constant<int, 4>{});
      case 5:
        return function(std::integral_constant<int, 5>{});
      default:
        return function(std::integral_constant<int, 6>{});
    }
  }
}

// Calls with the size of all nodes as a constant where it is a common one, else with 0.
template <class Function>
inline auto with_common_size(int size, Function&& function) {
  switch (size) {
    case 3:
      return function(std::integral_constant<int, 3>{});
    case 5:
      return function(std::integral_constant<int, 5>{});
    case 6:
      return function(std::integral_constant<int, 6>{});
    default:
      return function(std::integral_constant<int, 0>{});
  }
}

// Blocks are by columns, without gaps. Loops of constant length are what the compiler unrolls and packs.

// A becomes its unit lower factor under the diagonal and the inverse pivots on it.
template <int C>
inline bool factor_pivot(double* a) {
  for (int c = 0; c < C; ++c) {
    const double pivot = a[c + C * c];
    if (!(pivot > 0)) return false;
    const double inverse = 1 / pivot;
    a[c + C * c] = inverse;
    for (int k = c + 1; k < C; ++k) {
      const double scaled = a[k + C * c] * inverse;
      for (int i = k; i < C; ++i) a[i + C * k] -= a[i + C * c] * scaled;
    }
    for (int i = c + 1; i < C; ++i) a[i + C * c] *= inverse;
  }
  return true;
}

// A block under the pivot becomes that of L D.
template <int R, int C>
inline void divide(double* block, const double* pivot) {
  for (int c = 1; c < C; ++c) {
    for (int k = 0; k < c; ++k) {
      for (int r = 0; r < R; ++r) block[r + R * c] -= block[r + R * k] * pivot[c + C * k];
    }
  }
}

template <int R, int C>
inline void scale(double* scaled, const double* block, const double* pivot) {
  for (int c = 0; c < C; ++c) {
    for (int r = 0; r < R; ++r) scaled[r + R * c] = block[r + R * c] * pivot[c + C * c];
  }
}

// target -= block scaled^T, in the lower triangle.
template <int R, int C>
inline void subtract_square(double* target, const double* block, const double* scaled) {
  for (int k = 0; k < R; ++k) {
    for (int r = k; r < R; ++r) {
      double value = target[r + R * k];
      for (int c = 0; c < C; ++c) value -= block[r + R * c] * scaled[k + R * c];
      target[r + R * k] = value;
    }
  }
}

// target -= block scaled^T, of R rows and any number of columns.
template <int R, int C>
inline void subtract_product(double* target, const double* block, const double* scaled, int columns) {
  for (int k = 0; k < columns; ++k) {
    double value[R];
    for (int r = 0; r < R; ++r) value[r] = target[r + R * k];
    for (int c = 0; c < C; ++c) {
      for (int r = 0; r < R; ++r) value[r] -= block[r + R * c] * scaled[k + columns * c];
    }
    for (int r = 0; r < R; ++r) target[r + R * k] = value[r];
  }
}

// In solve() each node waits for what the one before wrote, and much longer if it loads in one piece what was stored in
// two, as happens where the compiler packs either. So a vector's part is N separate numbers there: loops over them are
// unrolled before the compiler looks for what to pack, and to and from memory they go one by one.

template <int N, class Function>
inline void unrolled(Function&& function) {
  [&]<int... I>(std::integer_sequence<int, I...>) { (function(std::integral_constant<int, I>{}), ...); }
  (std::make_integer_sequence<int, N>{});
}

template <int N>
inline void load(double* to, const volatile double* from) {
  unrolled<N>([&](auto i) { to[i] = from[i]; });
}

template <int N>
inline void store(volatile double* to, const double* from) {
  unrolled<N>([&](auto i) { to[i] = from[i]; });
}

// y = L^-1 y with the unit lower triangle of a pivot.
template <int C>
inline void solve_lower(const double* pivot, double* y) {
  unrolled<C>([&](auto c) {
    unrolled<C>([&](auto i) {
      if constexpr (i > c) y[i] -= pivot[i + C * c] * y[c];
    });
  });
}

// x = L^-T x
template <int C>
inline void solve_upper(const double* pivot, double* x) {
  unrolled<C>([&](auto n) {
    constexpr int i = C - 1 - n;
    unrolled<C>([&](auto c) {
      if constexpr (c < i) x[c] -= pivot[i + C * c] * x[i];
    });
  });
}

template <int R, int C>
inline void subtract_vector(double* value, const double* block, const double* y) {
  unrolled<C>([&](auto c) { unrolled<R>([&](auto r) { value[r] -= block[r + R * c] * y[c]; }); });
}

// value -= block^T x; backwards, since the last of x is known first.
template <int R, int C>
inline void subtract_transposed(double* value, const double* block, const double* x) {
  unrolled<R>([&](auto n) {
    constexpr int r = R - 1 - n;
    unrolled<C>([&](auto c) { value[c] -= block[r + R * c] * x[r]; });
  });
}

constexpr std::size_t block_values = BlockLdlt::max_size * BlockLdlt::max_size;

// Y = block L^-1, with the unit lower triangle of the pivot.
inline void divide_by_unit(double* y, const double* block, const double* pivot, int rows, int columns) {
  for (int c = columns - 1; c >= 0; --c) {
    for (int r = 0; r < rows; ++r) y[r + rows * c] = block[r + rows * c];
    for (int k = c + 1; k < columns; ++k) {
      for (int r = 0; r < rows; ++r) y[r + rows * c] -= y[r + rows * k] * pivot[k + columns * c];
    }
  }
}

// target -= A y, or A^T y, with A of so many rows and columns before it is transposed.
inline void subtract_times(double* target, const double* a, int rows, int inner, const double* y, int columns) {
  for (int c = 0; c < columns; ++c) {
    for (int k = 0; k < inner; ++k) {
      for (int r = 0; r < rows; ++r) target[r + rows * c] -= a[r + rows * k] * y[k + inner * c];
    }
  }
}
inline void subtract_transposed_times(double* target, const double* a, int inner, int rows, const double* y,
                                      int columns) {
  for (int c = 0; c < columns; ++c) {
    for (int r = 0; r < rows; ++r) {
      double sum = 0;
      for (int k = 0; k < inner; ++k) sum += a[k + inner * r] * y[k + inner * c];
      target[r + rows * c] -= sum;
    }
  }
}

// (L D L^T)^-1 of a pivot, whole.
inline void invert_pivot(double* to, const double* pivot, int size) {
  double lower[block_values];  // L^-1
  for (int c = 0; c < size; ++c) {
    for (int r = 0; r < size; ++r) lower[r + size * c] = r == c ? 1 : 0;
    for (int r = c + 1; r < size; ++r) {
      for (int k = c; k < r; ++k) lower[r + size * c] -= pivot[r + size * k] * lower[k + size * c];
    }
  }
  for (int c = 0; c < size; ++c) {
    for (int r = 0; r <= c; ++r) {
      double sum = 0;
      for (int k = c; k < size; ++k) sum += lower[k + size * r] * pivot[k + size * k] * lower[k + size * c];
      to[r + size * c] = to[c + size * r] = sum;
    }
  }
}

}  // namespace

bool BlockLdlt::analyse(std::span<const std::uint8_t> sizes,
                        std::span<const std::pair<std::uint32_t, std::uint32_t>> couplings, std::size_t max_blocks) {
  const std::size_t count = sizes.size();
  EliminationOrder elimination = min_degree_order(count, couplings, max_blocks);
  const bool fits = elimination.order.size() == count;
  columns_.clear();
  below_.clear();
  coupled_.clear();
  values_.clear();
  row_.assign(1, 0);
  rank_ = std::move(elimination.rank);
  if (!fits) return false;

  common_size_ = count == 0 ? 0 : sizes.front();
  for (const std::uint8_t size : sizes) {
    ATL_ASSERT(size >= 1 && size <= max_size, size);
    row_.push_back(row_.back() + size);
    if (size != common_size_) common_size_ = 0;
  }

  columns_.resize(count);
  below_.reserve(elimination.later.size());
  std::uint32_t values = 0;
  for (std::size_t rank = 0; rank < count; ++rank) {
    const std::uint32_t node = elimination.order[rank];
    Column& column = columns_[rank];
    column.size = sizes[node];
    column.row = row_[node];
    column.diagonal = values;
    values += column.size * column.size;
    for (std::size_t i = elimination.start[rank]; i < elimination.start[rank + 1]; ++i) {
      const std::uint32_t other = elimination.order[elimination.later[i]];
      below_.push_back({.values = values, .diagonal = 0, .row = row_[other], .size = sizes[other]});
      values += column.size * sizes[other];
    }
    column.end = static_cast<std::uint32_t>(below_.size());
  }
  values_.assign(values, 0.0);

  for (std::size_t rank = 0; rank < count; ++rank) {
    for (std::size_t i = elimination.start[rank]; i < elimination.start[rank + 1]; ++i) {
      const std::uint32_t first = elimination.later[i];
      ATL_ASSERT(first > rank && first < count, rank, first, count);
      below_[i].diagonal = columns_[first].diagonal;
      // Whatever is coupled with both is also under the first, in the same order.
      std::size_t at = elimination.start[first];
      for (std::size_t k = i + 1; k < elimination.start[rank + 1]; ++k, ++at) {
        while (elimination.later[at] != elimination.later[k]) ++at;
        ATL_ASSERT(at < elimination.start[first + 1], rank, first, at, elimination.start[first + 1]);
        coupled_.push_back(below_[at].values);
      }
    }
  }
  return true;
}

std::size_t BlockLdlt::block_index(std::uint32_t a, std::uint32_t b) const {
  ATL_ASSERT(a < rank_.size() && b < rank_.size(), a, b, rank_.size());
  const std::uint32_t rank = std::min(rank_[a], rank_[b]);
  const Column& column = columns_[rank];
  if (a == b) return column.diagonal;
  const std::uint32_t later = columns_[std::max(rank_[a], rank_[b])].diagonal;
  // Diagonal blocks are in order of elimination, too.
  const auto begin = below_.begin() + (rank == 0 ? 0 : columns_[rank - 1].end);
  const auto found =
      std::lower_bound(begin, below_.begin() + column.end, later,
                       [](const Below& block, std::uint32_t diagonal) { return block.diagonal < diagonal; });
  ATL_ASSERT(found != below_.begin() + column.end && found->diagonal == later, a, b);  // else nothing couples them
  return found->values;
}

void BlockLdlt::clear() { std::fill(values_.begin(), values_.end(), 0.0); }

BlockLdlt::BlockView BlockLdlt::diagonal(std::uint32_t node) {
  const Column& column = columns_[rank_[node]];
  return {values_.data() + column.diagonal, static_cast<Eigen::Index>(column.size),
          static_cast<Eigen::Index>(column.size)};
}

void BlockLdlt::add(std::uint32_t row, std::uint32_t column, const Eigen::Ref<const Eigen::MatrixXd>& values) {
  double* const block = this->values(block_index(row, column));
  if (is_earlier(column, row)) {
    BlockView(block, values.rows(), values.cols()) += values;
  } else {
    BlockView(block, values.cols(), values.rows()) += values.transpose();
  }
}

// Column by column, each subtracts its share from what is eliminated later.
template <int Size>
bool BlockLdlt::factor_all() {
  double* const values = values_.data();
  const Below* below = below_.data();
  const std::uint32_t* coupled = coupled_.data();
  for (const Column& column : columns_) {
    const Below* const end = below_.data() + column.end;
    const bool positive = with_size<Size>(column.size, [&](auto columns) {
      constexpr int C = columns();
      double* const pivot = values + column.diagonal;
      if (!factor_pivot<C>(pivot)) return false;
      for (const Below* i = below; i != end; ++i) {
        with_size<Size>(i->size, [&](auto rows) { divide<rows(), C>(values + i->values, pivot); });
      }
      for (; below != end; ++below) {
        double scaled[max_size * C];
        with_size<Size>(below->size, [&](auto rows) {
          constexpr int R = rows();
          double* const block = values + below->values;
          scale<R, C>(scaled, block, pivot);
          subtract_square<R, C>(values + below->diagonal, block, scaled);
        });
        const int width = Size > 0 ? Size : static_cast<int>(below->size);
        for (const Below* k = below + 1; k != end; ++k) {
          with_size<Size>(k->size, [&](auto rows) {
            subtract_product<rows(), C>(values + *coupled++, values + k->values, scaled, width);
          });
        }
        std::copy_n(scaled, width * C, values + below->values);
      }
      return true;
    });
    if (!positive) return false;
  }
  ATL_ASSERT(coupled == coupled_.data() + coupled_.size(), coupled - coupled_.data(), coupled_.size());
  return true;
}

template <int Size>
void BlockLdlt::solve_all(double* b) const {
  const double* const values = values_.data();
  const Below* below = below_.data();
  for (const Column& column : columns_) {
    const Below* const end = below_.data() + column.end;
    with_size<Size>(column.size, [&](auto columns) {
      constexpr int C = columns();
      double y[C];
      load<C>(y, b + column.row);
      solve_lower<C>(values + column.diagonal, y);
      store<C>(b + column.row, y);
      for (; below != end; ++below) {
        with_size<Size>(below->size, [&](auto rows) {
          constexpr int R = rows();
          double value[R];
          load<R>(value, b + below->row);
          subtract_vector<R, C>(value, values + below->values, y);
          store<R>(b + below->row, value);
        });
      }
    });
  }
  for (std::size_t rank = columns_.size(); rank-- > 0;) {
    const Column& column = columns_[rank];
    const Below* const begin = below_.data() + (rank == 0 ? 0 : columns_[rank - 1].end);
    with_size<Size>(column.size, [&](auto columns) {
      constexpr int C = columns();
      const double* const pivot = values + column.diagonal;
      double x[C];
      load<C>(x, b + column.row);
      unrolled<C>([&](auto c) { x[c] *= pivot[c + C * c]; });
      // The values computed last are subtracted last, so that less work waits for them.
      while (below != begin) {
        --below;
        with_size<Size>(below->size, [&](auto rows) {
          constexpr int R = rows();
          double other[R];
          load<R>(other, b + below->row);
          subtract_transposed<R, C>(x, values + below->values, other);
        });
      }
      solve_upper<C>(pivot, x);
      store<C>(b + column.row, x);
    });
  }
}

// The last column first: what is below a block of the inverse follows from the blocks of the columns after it.
template <int Size>
void BlockLdlt::invert_all(double* inverse) const {
  const std::uint32_t* coupled = coupled_.data() + coupled_.size();
  double* const divided = inverse + values_.size();  // L_below L_pivot^-1, block by block
  for (std::size_t rank = columns_.size(); rank-- > 0;) {
    const Column& column = columns_[rank];
    const Below* const begin = below_.data() + (rank == 0 ? 0 : columns_[rank - 1].end);
    const auto count = static_cast<std::size_t>(below_.data() + column.end - begin);
    const int columns = Size > 0 ? Size : static_cast<int>(column.size);
    const double* const pivot = values_.data() + column.diagonal;
    const auto rows_of = [begin](std::size_t i) { return Size > 0 ? Size : static_cast<int>(begin[i].size); };
    coupled -= count * (count - 1) / 2;
    for (std::size_t i = 0; i < count; ++i) {
      divide_by_unit(&divided[i * block_values], &values_[begin[i].values], pivot, rows_of(i), columns);
    }
    double* const diagonal = inverse + column.diagonal;
    invert_pivot(diagonal, pivot, columns);
    // The block of each pair has the rows of the later one.
    const auto pair = [&](std::size_t i, std::size_t k) {
      return inverse + coupled[i * count - i * (i + 1) / 2 + (k - i - 1)];
    };
    for (std::size_t i = 0; i < count; ++i) {
      double* const block = inverse + begin[i].values;
      const int rows = rows_of(i);
      std::fill_n(block, rows * columns, 0.0);
      for (std::size_t k = 0; k < count; ++k) {
        const double* const y = &divided[k * block_values];
        if (k < i) subtract_times(block, pair(k, i), rows, rows_of(k), y, columns);
        if (k == i) subtract_times(block, inverse + begin[i].diagonal, rows, rows, y, columns);
        if (k > i) subtract_transposed_times(block, pair(i, k), rows_of(k), rows, y, columns);
      }
      subtract_transposed_times(diagonal, &divided[i * block_values], rows, columns, block, columns);
    }
  }
}

bool BlockLdlt::factor() {
  return with_common_size(common_size_, [&](auto size) { return factor_all<size()>(); });
}

void BlockLdlt::solve(std::span<double> b) const {
  ATL_ASSERT(b.size() == rows(), b.size(), rows());
  with_common_size(common_size_, [&](auto size) { solve_all<size()>(b.data()); });
}

void BlockLdlt::invert(std::vector<double>& inverse) const {
  std::size_t longest = 0;
  for (std::size_t rank = 0; rank < columns_.size(); ++rank) {
    longest = std::max<std::size_t>(longest, columns_[rank].end - (rank == 0 ? 0 : columns_[rank - 1].end));
  }
  inverse.resize(values_.size() + longest * block_values);
  with_common_size(common_size_, [&](auto size) { invert_all<size()>(inverse.data()); });
}

}  // namespace atl::solver
