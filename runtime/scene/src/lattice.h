#pragma once

#include <atoll/types.h>

#include <array>
#include <vector>

namespace atl::scene {

/// Points in horizontal layers, every layer a rectangular grid centred above the origin. With a taper
/// of one body a layer the brick bond of a wall and the steps of a pyramid follow from the centring.
struct Lattice {
  std::array<int, 3> count = {1, 1, 1};    ///< along x and y in the lowest layer, and of layers
  Vector3 spacing = {1, 1, 1};             ///< m, between neighbours
  std::array<int, 2> taper = {0, 0};       ///< how many fewer each layer has than the one below
  std::array<double, 2> stagger = {0, 0};  ///< shift of every second layer, as a share of the spacing

  /// The number of points; a double, so that no counts overflow it.
  double size() const;
  /// x runs fastest, layers from below. The middle of the lowest layer is the origin.
  std::vector<Vector3> points() const;
};

}  // namespace atl::scene
