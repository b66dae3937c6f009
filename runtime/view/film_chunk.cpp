#include "view/film_chunk.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

#include "view/film_codes.h"

namespace atl::view {
namespace {

constexpr std::uint8_t escape = 255;

// Wraps to 32 bits, as the page's integer arithmetic does.
std::int32_t wrapped(std::int64_t value) { return static_cast<std::int32_t>(static_cast<std::uint32_t>(value)); }

}  // namespace

void FilmChunks::write(std::uint8_t& cell, std::int32_t difference) {
  // Small ones of either sign: 0, -1, 1, -2, ...
  const std::uint32_t code =
      (static_cast<std::uint32_t>(difference) << 1) ^ static_cast<std::uint32_t>(difference >> 31);
  if (code < escape) {
    cell = static_cast<std::uint8_t>(code);
  } else {
    cell = escape;
    escapes_.push_back(difference);
  }
}

void FilmChunks::add_body(std::size_t number, const BodySight& body, double precision) {
  Track& track = tracks_[number];
  cell(flags_row, number) = body.flags ^ track.flags;
  track.flags = body.flags;
  if ((body.flags & body_present) == 0) return;
  std::array<std::int32_t, 7> now;
  for (int i = 0; i < 3; ++i) now[i] = rounded(body.pose.position[i] / precision);
  double along = 0;
  for (int i = 0; i < 4; ++i) along += body.pose.orientation.coeffs()[i] * track.last[3 + i];
  for (int i = 0; i < 4; ++i)
    now[3 + i] = rounded((along < 0 ? -turn_units : turn_units) * body.pose.orientation.coeffs()[i]);
  for (std::size_t i = 0; i < now.size(); ++i) {
    const std::int64_t predicted = track.known == 0   ? 0
                                   : track.known == 1 ? track.last[i]
                                                      : 2 * std::int64_t{track.last[i]} - track.before[i];
    write(cell(first_pose_row + i, number), wrapped(now[i] - predicted));
  }
  track.before = track.last;
  track.last = now;
  track.known = std::min(track.known + 1, 2);
  const std::uint8_t force = force_code(body.force);
  cell(force_row, number) = static_cast<std::uint8_t>(force - track.force);
  track.force = force;
  write(cell(island_row, number), wrapped(std::int64_t{body.island} - track.island));
  track.island = body.island;
}

void FilmChunks::add_frame(const std::vector<BodySight>& bodies, double precision) {
  if (tracks_.size() < bodies.size()) {
    tracks_.resize(bodies.size());
    for (std::vector<std::uint8_t>& row : rows_) row.resize(bodies.size() * max_frames, 0);
  }
  for (std::size_t number = 0; number < bodies.size(); ++number) add_body(number, bodies[number], precision);
  if (++frames_ == max_frames) end_chunk();
}

void FilmChunks::end_chunk() {
  if (frames_ == 0) return;
  Packer packer;
  packer.add(static_cast<std::uint32_t>(frames_));
  packer.add(static_cast<std::uint32_t>(tracks_.size()));
  packer.add(static_cast<std::uint32_t>(escapes_.size()));
  for (std::vector<std::uint8_t>& row : rows_) {
    for (std::size_t body = 0; body < tracks_.size(); ++body) packer.add(&row[body * max_frames], frames_);
    std::fill(row.begin(), row.end(), std::uint8_t{0});
  }
  packer.add(escapes_.data(), escapes_.size() * sizeof(std::int32_t));
  done_.add(std::move(packer), Packer::Likes::Runs);
  std::fill(tracks_.begin(), tracks_.end(), Track{});
  escapes_.clear();
  frames_ = 0;
}

std::vector<std::string> FilmChunks::finish() {
  end_chunk();
  return done_.take();
}

}  // namespace atl::view
