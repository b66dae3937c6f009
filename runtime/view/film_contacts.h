#pragma once

#include <atoll/types.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "view/packed.h"

namespace atl::view {

/// Contact points of each frame, up to a number of points in all.
class FilmContacts {
 public:
  /// At most so many points.
  explicit FilmContacts(std::size_t max) : max_(max) {}

  /// True if there is room for that many points in the next frame. If there isn't, that frame and all later ones have
  /// none.
  bool takes(std::size_t count);
  /// Places are rounded to `precision` (m).
  void begin_frame(double precision);
  /// Adds a point to the frame under way: place in m, unit normal, force in N.
  void add(std::uint32_t first, std::uint32_t second, const Vector3& point, const Vector3& normal, double force);
  void end_frame(std::size_t chunk_frames);
  /// Chunks as those of FilmChunks: frames, points of each (uint32); then of all points the first body's number, the
  /// second's (uint32), x, y and z (int32, times the precision), x, y and z of the normal (int8, 127 is 1), and the
  /// code of the force.
  std::vector<std::string> finish();
  /// The frame from which on points are left out.
  std::optional<std::size_t> end() const { return end_; }

 private:
  struct Point {
    std::uint32_t first, second;
    std::array<std::int32_t, 3> place;
    std::array<std::int8_t, 3> normal;
    std::uint8_t force;
  };

  void end_chunk();

  std::size_t max_;
  std::size_t kept_ = 0;
  std::size_t frames_ = 0;
  std::optional<std::size_t> end_ = {};
  std::vector<std::uint32_t> counts_;  // by frame of the chunk under way
  double precision_ = 1;
  std::vector<Point> points_;
  PackedTexts done_;
};

}  // namespace atl::view
