#include "columns.h"

#include <algorithm>
#include <numeric>

namespace atl {
namespace {

Vector3 vector_of(const World& world, BodyId body, Batch::Column column) {
  switch (column) {
    case Batch::Column::Origins:
      return world.pose(body).position;
    case Batch::Column::Accelerations:
      return world.accelerations().col(body.index);
    case Batch::Column::AngularAccelerations:
      return world.angular_accelerations().col(body.index);
    case Batch::Column::ContactForces:
      return world.contact_wrench(body).force;
    case Batch::Column::ContactTorques:
      return world.contact_wrench(body).torque;
    case Batch::Column::Velocities:
      return world.velocities().col(body.index);
    case Batch::Column::AngularVelocities:
      return world.angular_velocities().col(body.index);
    default:
      return world.positions().col(body.index);
  }
}

void read_body(const World& world, BodyId body, Batch::Column column, std::size_t rows, double* to) {
  if (!world.contains(body)) {
    std::fill_n(to, rows, 0.0);
  } else if (column == Batch::Column::Orientations) {
    std::copy_n(world.orientations().col(body.index).data(), rows, to);
  } else {
    std::copy_n(vector_of(world, body, column).data(), rows, to);
  }
}

const double* numbers_of(const JointState& state, Batch::Column column) {
  switch (column) {
    case Batch::Column::JointPositions:
      return state.position.data();
    case Batch::Column::JointSpeeds:
      return state.speed.data();
    case Batch::Column::JointMotors:
      return state.motor.data();
    case Batch::Column::JointForces:
      return state.force.data();
    default:
      return state.torque.data();
  }
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

void read_columns(const World& world, const Batch& batch, std::span<const Batch::Column> columns,
                  std::span<double* const> to) {
  for (std::size_t c = 0; c < columns.size(); ++c) {
    if (is_of_joints(columns[c])) continue;
    const std::size_t rows = Batch::rows_of(columns[c]);
    for (std::size_t i = 0; i < batch.bodies().size(); ++i) {
      read_body(world, batch.bodies()[i], columns[c], rows, to[c] + rows * i);
    }
  }
  if (std::none_of(columns.begin(), columns.end(), is_of_joints)) return;
  for (std::size_t i = 0; i < batch.joints().size(); ++i) {
    const bool there = world.contains(batch.joints()[i]);
    const JointState state = there ? world.joint_state(batch.joints()[i]) : JointState{};
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const std::size_t rows = Batch::rows_of(columns[c]);
      if (is_of_joints(columns[c])) std::copy_n(numbers_of(state, columns[c]), rows, to[c] + rows * i);
    }
  }
}

}  // namespace atl
