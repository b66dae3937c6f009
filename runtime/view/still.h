#pragma once

#include <atoll/types.h>

#include <array>
#include <cstdint>
#include <iosfwd>
#include <vector>

#include "view/colour.h"

namespace atl {
class World;
}

namespace atl::view {

struct StillOptions {
  int width = 1200, height = 800;  ///< pixels, in [1, 8192]
};

/// A picture of a world as it is, without a browser: seen from the south and above, so far away that all that moves is
/// in it. Surfaces are drawn from their fronts alone, so that walls in front let what they enclose be seen.
///
/// Triangles are drawn into a depth buffer of twice the size each way, by plane equations (Pineda, "A parallel
/// algorithm for polygon rasterization", SIGGRAPH 1988), which is scaled down. The same bits everywhere.
class Still {
 public:
  explicit Still(const World& world, const StillOptions& options = {});

  void write_png(std::ostream& out) const;
  /// The faces of which something shows, the farthest first.
  void write_svg(std::ostream& out) const;

 private:
  struct Face {
    std::vector<Vector3> corners;  // x and y in pixels, z is 1 / depth
    Colour colour;
    std::uint32_t body;
    double depth;  // m, of the farthest corner
  };

  void add_bodies(const World& world);
  void add_face(const std::array<Vector3, 3>& corners, const Colour& colour, std::uint32_t body);
  void draw(std::uint32_t face);
  Colour pixel(int x, int y) const;

  int width_, height_;
  Vector3 eye_, right_, up_, forward_;  // of the camera, world frame
  double focal_ = 1;                    // pixels, of the large buffer
  std::vector<Face> faces_;
  std::vector<float> nearest_;        // 1 / depth, by sample of the large buffer
  std::vector<std::uint32_t> shown_;  // the face there, plus 1
};

}  // namespace atl::view
