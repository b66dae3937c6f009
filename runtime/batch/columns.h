#pragma once

#include <atoll/batch.h>

namespace atl {

/// How many bodies, or joints, a column of a batch has.
std::size_t count_in(Batch::Column column, const Batch& batch);

/// Writes columns of one world of the batch, rows_of(column) numbers a body or a joint. Those that it lacks have zeros.
void read_columns(const World& world, const Batch& batch, std::span<const Batch::Column> columns,
                  std::span<double* const> to);

/// By world: its number among `places`, of which none stand for all. What is no place is left to who visits them.
std::vector<std::size_t> numbers_of(const Batch& batch, std::span<const std::size_t> places);

}  // namespace atl
