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
  if (column == Batch::Column::Orientations) {
    std::copy_n(world.orientations().col(body.index).data(), rows, to);
  } else {
    std::copy_n(vector_of(world, body, column).data(), rows, to);
  }
}

void read_joint(const World& world, JointId joint, Batch::Column column, std::size_t rows, double* to) {
  const JointState state = world.joint_state(joint);
  const double* from = column == Batch::Column::JointPositions ? state.position.data()
                       : column == Batch::Column::JointSpeeds  ? state.speed.data()
                       : column == Batch::Column::JointMotors  ? state.motor.data()
                       : column == Batch::Column::JointForces  ? state.force.data()
                                                               : state.torque.data();
  std::copy_n(from, rows, to);
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
