#include "lattice.h"

namespace atl::scene {

double Lattice::size() const {
  if (taper == std::array{0, 0}) return double(count[0]) * count[1] * count[2];
  double size = 0;
  for (int k = 0; k < count[2]; ++k) {
    size += (count[0] - double(k) * taper[0]) * (count[1] - double(k) * taper[1]);
  }
  return size;
}

std::vector<Vector3> Lattice::points() const {
  std::vector<Vector3> points;
  points.reserve(static_cast<std::size_t>(size()));
  for (int k = 0; k < count[2]; ++k) {
    const int nx = count[0] - k * taper[0], ny = count[1] - k * taper[1];
    const double shift_x = k % 2 == 0 ? 0 : stagger[0], shift_y = k % 2 == 0 ? 0 : stagger[1];
    for (int j = 0; j < ny; ++j) {
      for (int i = 0; i < nx; ++i) {
        points.emplace_back((i - 0.5 * (nx - 1) + shift_x) * spacing.x(), (j - 0.5 * (ny - 1) + shift_y) * spacing.y(),
                            k * spacing.z());
      }
    }
  }
  return points;
}

}  // namespace atl::scene
