#pragma once
/// Memory of bodies' poses and velocities that somebody may still look at: see World::keep_views().

#include <solver/integrate/body_table.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>
#include <vector>

namespace atl {

class ViewedColumns {
 public:
  bool keeps = false;

  /// Ahead of a growth to so many bodies: where columns need other memory for it, what they had stays.
  void make_room(solver::BodyTable& bodies, std::size_t count) {
    if (!keeps) return;
    for (const auto& [column, width] : columns_of(bodies)) {
      if (count * width <= column->capacity()) continue;
      jobs::CompactArray<double> larger;
      larger.reserve(std::max(count * width, 2 * column->capacity()));
      larger = *column;
      kept_.push_back(std::exchange(*column, std::move(larger)));
    }
  }
  /// Ahead of the end of all columns.
  void leave(solver::BodyTable& bodies) {
    if (!keeps) return;
    for (const auto& [column, width] : columns_of(bodies)) kept_.push_back(std::move(*column));
  }

 private:
  using Column = std::pair<jobs::CompactArray<double>*, std::size_t>;  // and numbers a body
  static std::array<Column, 4> columns_of(solver::BodyTable& bodies) {
    return {Column{&bodies.positions, 3}, Column{&bodies.orientations, 4}, Column{&bodies.velocities, 3},
            Column{&bodies.angular_velocities, 3}};
  }

  std::vector<jobs::CompactArray<double>> kept_;
};

}  // namespace atl
