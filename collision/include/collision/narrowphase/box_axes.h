#pragma once

#include <collision/shapes/pose.h>
#include <jobs/block_lanes.h>

#include <array>
#include <string_view>

namespace atl::collision {

/// A block of up to eight pairs of boxes, one a lane. Unused lanes repeat a used one.
struct BoxBlock {
  template <typename T>
  using Lanes = std::array<T, jobs::block_lanes>;

  Lanes<const double*> position_first;     ///< x, y, z, m, world
  Lanes<const double*> orientation_first;  ///< x, y, z, w
  Lanes<const double*> half_first;         ///< half extents, m
  Lanes<const double*> position_second;
  Lanes<const double*> orientation_second;
  Lanes<const double*> half_second;
};

/// How the boxes of a block lie to each other, and the axes that part them best, by lane: signed distances in m,
/// negative where they overlap. Codes of axes are those of FCL: 1-3 a face axis of the first, 4-6 of the second,
/// 7-15 the cross product of edge (code - 7) / 3 of the first and (code - 7) % 3 of the second; 0 where there is none.
struct alignas(64) BoxAxes {
  using Row = std::array<double, jobs::block_lanes>;

  std::array<Row, 3> position;     ///< of the second, in the frame of the first
  std::array<Row, 4> orientation;  ///< x, y, z, w
  std::array<Row, 9> rotation;     ///< the same as a matrix, by columns
  Row face;                        ///< of the faces' axes; of equals, the first
  Row face_code;
  Row edge;  ///< of the edges' axes
  Row edge_code;
  Row centres;  ///< along the line of the centres
};

/// The kernel for one instruction set; the same bits on each.
using BoxAxesKernel = void (*)(const BoxBlock& block, BoxAxes& axes);
/// Finds a kernel by the solver's name of the set; null if this machine doesn't run it.
BoxAxesKernel find_box_axes_kernel(std::string_view name);
/// The kernel of the widest instruction set that this machine runs.
BoxAxesKernel widest_box_axes_kernel();

/// Finds the axes of a single pair, in lane 0. `second` is the second box's pose in the frame of the first.
void find_box_axes(const Vector3& half_first, const Vector3& half_second, const Pose& second, BoxAxes& axes);

/// Unit, in the frame of the first box, from it to the second: the axis with a code, which isn't 0.
Vector3 box_axis(const BoxAxes& axes, std::size_t lane, int code);

/// The axis, of faces and edges alike, with the largest separation. Zero if there is none, as for numbers not finite.
Vector3 best_box_axis(const BoxAxes& axes, std::size_t lane);

}  // namespace atl::collision
