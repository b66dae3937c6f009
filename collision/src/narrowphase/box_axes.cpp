#include <collision/narrowphase/box_axes.h>

namespace atl::collision {
namespace {

// The second box's centre and axes, in the frame of the first.
Vector3 position_of(const BoxAxes& axes, std::size_t lane) {
  return {axes.position[0][lane], axes.position[1][lane], axes.position[2][lane]};
}
Vector3 second_axis(const BoxAxes& axes, std::size_t lane, int axis) {
  const auto row = [&](std::size_t i) { return axes.rotation[3 * static_cast<std::size_t>(axis) + i][lane]; };
  return {row(0), row(1), row(2)};
}

}  // namespace

void find_box_axes(const Vector3& half_first, const Vector3& half_second, const Pose& second, BoxAxes& axes) {
  const Pose first{Vector3::Zero(), Quaternion::Identity()};
  BoxBlock block;
  block.position_first.fill(first.position.data());
  block.orientation_first.fill(first.orientation.coeffs().data());
  block.half_first.fill(half_first.data());
  block.position_second.fill(second.position.data());
  block.orientation_second.fill(second.orientation.coeffs().data());
  block.half_second.fill(half_second.data());
  widest_box_axes_kernel()(block, axes);
}

Vector3 box_axis(const BoxAxes& axes, std::size_t lane, int code) {
  Vector3 axis;
  if (code <= 3) {
    axis = Vector3::Unit(code - 1);
  } else if (code <= 6) {
    axis = second_axis(axes, lane, code - 4);
  } else {
    axis = Vector3::Unit((code - 7) / 3).cross(second_axis(axes, lane, (code - 7) % 3)).normalized();
  }
  return axis.dot(position_of(axes, lane)) < 0 ? Vector3(-axis) : axis;
}

Vector3 best_box_axis(const BoxAxes& axes, std::size_t lane) {
  const bool on_edges = axes.edge[lane] > axes.face[lane];
  const int code = static_cast<int>(on_edges ? axes.edge_code[lane] : axes.face_code[lane]);
  return code == 0 ? Vector3(Vector3::Zero()) : box_axis(axes, lane, code);
}

}  // namespace atl::collision
