#include "columns.h"

#include <algorithm>
#include <numeric>

namespace atl {
namespace {

void read_body(const World& world, BodyId body, Batch::Column column, std::size_t rows, double* to) {
  if (column == Batch::Column::Origins) {
    const Vector3 origin = world.pose(body).position;
    std::copy_n(origin.data(), rows, to);
    return;
  }
  const double* from = column == Batch::Column::Positions      ? world.positions().data()
                       : column == Batch::Column::Orientations ? world.orientations().data()
                       : column == Batch::Column::Velocities   ? world.velocities().data()
                                                               : world.angular_velocities().data();
  std::copy_n(from + rows * body.index, rows, to);
}

void read_joint(const World& world, JointId joint, Batch::Column column, std::size_t rows, double* to) {
  const JointState state = world.joint_state(joint);
  std::copy_n(column == Batch::Column::JointPositions ? state.position.data() : state.speed.data(), rows, to);
}

}  // namespace

std::size_t count_in(Batch::Column column, const Batch& batch) {
  return is_of_joints(column) ? batch.joints().size() : batch.bodies().size();
}

std::vector<std::size_t> numbers_of(const Batch& batch, std::span<const std::size_t> places) {
  std::vector<std::size_t> numbers(batch.size());
  if (places.empty()) std::iota(numbers.begin(), numbers.end(), std::size_t{0});
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (places[i] < numbers.size()) numbers[places[i]] = i;
  }
  return numbers;
}

void read_column(const World& world, const Batch& batch, Batch::Column column, double* to) {
  const std::size_t rows = Batch::rows_of(column);
  const auto read_all = [&](const auto& ids, const auto& read) {
    for (const auto id : ids) {
      if (world.contains(id)) {
        read(world, id, column, rows, to);
      } else {
        std::fill_n(to, rows, 0.0);
      }
      to += rows;
    }
  };
  if (is_of_joints(column)) return read_all(batch.joints(), read_joint);
  read_all(batch.bodies(), read_body);
}

}  // namespace atl
