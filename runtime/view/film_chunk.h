#pragma once

#include <atoll/types.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "view/packed.h"

namespace atl::view {

/// Flags of a body in a frame.
enum BodyFlag : std::uint8_t {
  body_present = 1,
  body_asleep = 2,
  body_quarantined = 4,
  body_refined = 8,  ///< its island got finer substeps than the settings'
  body_direct = 16,  ///< the contacts of its island were solved at once
};

/// A body as a frame shows it.
struct BodySight {
  Pose pose;
  std::uint8_t flags = 0;    ///< of BodyFlag; 0 where there is no such body
  double force = 0;          ///< N, sum of the normal forces at its contact points
  std::uint32_t island = 0;  ///< the lowest number of a body of its island, plus 1; 0 of what is in none
};

/// Poses as small numbers: rounded, predicted from the two frames before as if velocities stayed, and kept as
/// differences from that. What rests takes next to nothing once deflated, what moves some 4 bytes a frame. Frames come
/// in chunks that stand for themselves, so that a page can begin anywhere.
class FilmChunks {
 public:
  static constexpr std::size_t max_frames = 60;
  static constexpr double turn_units = 2048;  ///< a quaternion's components are rounded to this part of 1

  /// Adds a frame with all bodies by number; new ones come at the end. `precision` in m.
  void add_frame(const std::vector<BodySight>& bodies, double precision);
  /// Ends the chunk under way. Each is base64 of a zlib stream of: frames, bodies, escapes (uint32 each); a row of a
  /// byte a frame for each body, of its position's x, y and z, its quaternion's x, y, z and w, flags, force and island;
  /// and the escapes (int32), which are the differences that no byte holds, by frames, then bodies, then rows.
  std::vector<std::string> finish();

 private:
  // The history of a body from which its next numbers are predicted.
  struct Track {
    std::array<std::int32_t, 7> last = {}, before = {};
    int known = 0;  // of these
    std::uint8_t flags = 0, force = 0;
    std::uint32_t island = 0;
  };
  enum Row : std::size_t { first_pose_row = 0, flags_row = 7, force_row = 8, island_row = 9, row_count = 10 };

  std::uint8_t& cell(std::size_t row, std::size_t body) { return rows_[row][body * max_frames + frames_]; }
  void write(std::uint8_t& cell, std::int32_t difference);
  void add_body(std::size_t number, const BodySight& body, double precision);
  void end_chunk();

  std::vector<Track> tracks_;
  std::array<std::vector<std::uint8_t>, row_count> rows_;  // max_frames bytes a body
  std::vector<std::int32_t> escapes_;
  std::size_t frames_ = 0;  // in this chunk
  PackedTexts done_;
};

}  // namespace atl::view
