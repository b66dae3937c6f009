#include "view/film_contacts.h"

#include <cmath>
#include <utility>

#include "view/film_codes.h"

namespace atl::view {

bool FilmContacts::takes(std::size_t count) {
  if (!end_ && kept_ + count > max_) end_ = frames_;
  return !end_;
}

void FilmContacts::begin_frame(double precision) {
  precision_ = precision;
  counts_.push_back(0);
}

void FilmContacts::add(std::uint32_t first, std::uint32_t second, const Vector3& point, const Vector3& normal,
                       double force) {
  Point kept{.first = first, .second = second, .place = {}, .normal = {}, .force = force_code(force)};
  for (int i = 0; i < 3; ++i) {
    kept.place[i] = rounded(point[i] / precision_);
    kept.normal[i] = static_cast<std::int8_t>(std::lround(127 * normal[i]));
  }
  points_.push_back(kept);
  ++counts_.back();
  ++kept_;
}

void FilmContacts::end_frame(std::size_t chunk_frames) {
  ++frames_;
  if (counts_.size() == chunk_frames) end_chunk();
}

void FilmContacts::end_chunk() {
  if (counts_.empty()) return;
  Packer packer;
  packer.add(static_cast<std::uint32_t>(counts_.size()));
  packer.add(counts_.data(), counts_.size() * sizeof(std::uint32_t));
  const auto add_column = [&](const auto& of) {
    for (const Point& point : points_) packer.add(of(point));
  };
  add_column([](const Point& point) { return point.first; });
  add_column([](const Point& point) { return point.second; });
  for (std::size_t i = 0; i < 3; ++i) add_column([i](const Point& point) { return point.place[i]; });
  for (std::size_t i = 0; i < 3; ++i) add_column([i](const Point& point) { return point.normal[i]; });
  add_column([](const Point& point) { return point.force; });
  done_.add(std::move(packer), Packer::Likes::Repeats);
  counts_.clear();
  points_.clear();
}

std::vector<std::string> FilmContacts::finish() {
  end_chunk();
  return done_.take();
}

}  // namespace atl::view
