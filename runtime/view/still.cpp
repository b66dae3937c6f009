#include "view/still.h"

#include <atoll/error.h>
#include <atoll/world.h>
#include <png.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <ostream>

#include "view/film_shapes.h"
#include "view/triangles.h"

namespace atl::view {
namespace {

constexpr int samples = 2;                           // of a pixel, each way
constexpr double near_plane = 1e-3;                  // of the distance to the middle
constexpr double half_angle = std::numbers::pi / 8;  // of the picture's height
constexpr double outline = 0.72;                     // brightness where another body begins

// From the right and above, behind the camera.
const Vector3 light = Vector3(0.35, -0.6, 1).normalized();

struct Room {
  Vector3 middle = Vector3::Zero();
  double radius = 1;
};

// A ball about what moves.
Room room_of(const World& world) {
  Eigen::AlignedBox3d box;
  for (const BodyId id : world.bodies()) {
    if (world.type(id) == BodyType::Static || world.is_quarantined(id)) continue;
    const Vector3 reach = Vector3::Constant(reach_of(world.definition(id).shape));
    const Vector3 place = world.pose(id).position;
    box.extend(place - reach);
    box.extend(place + reach);
  }
  if (box.isEmpty()) return {};
  return {box.center(), std::max(0.5 * box.diagonal().norm(), 1e-6)};
}

// A square of a half-space about what moves, in the body's frame.
Triangles square_of(const HalfSpace& half_space, const Room& room, const Pose& pose) {
  const Vector3 normal = half_space.normal.stableNormalized();
  const Vector3 middle = pose.orientation.conjugate() * (room.middle - pose.position);
  const Vector3 foot = middle + (half_space.offset / half_space.normal.stableNorm() - normal.dot(middle)) * normal;
  const Vector3 along = 2.5 * room.radius * normal.unitOrthogonal();
  const Vector3 across = normal.cross(along);
  return {{foot - along - across, foot + along - across, foot + along + across, foot - along + across},
          {{0, 1, 2}, {0, 2, 3}}};
}

}  // namespace

Still::Still(const World& world, const StillOptions& options) : width_(options.width), height_(options.height) {
  const auto fits = [](int size) { return size >= 1 && size <= 8192; };
  if (!fits(width_) || !fits(height_)) {
    throw Error("Still: found a picture of " + std::to_string(width_) + " x " + std::to_string(height_) +
                " pixels; expected 1 to 8192 each way");
  }
  const std::size_t count =
      std::size_t{samples * samples} * static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_);
  nearest_.assign(count, 0);
  shown_.assign(count, 0);
  add_bodies(world);
  for (std::uint32_t face = 0; face < faces_.size(); ++face) draw(face);
}

void Still::add_bodies(const World& world) {
  const Room room = room_of(world);
  const double narrow = std::min(1.0, static_cast<double>(width_) / height_);
  const double far = 0.85 * room.radius / std::sin(half_angle) / narrow;
  forward_ = -Vector3(0.45, -0.8, 0.4).normalized();
  eye_ = room.middle - far * forward_;
  right_ = forward_.cross(Vector3::UnitZ()).normalized();
  up_ = right_.cross(forward_);
  focal_ = samples * height_ / (2 * std::tan(half_angle));

  for (const BodyId id : world.bodies()) {
    const BodyDef body = world.definition(id);
    const Pose pose = world.pose(id);
    const auto* half_space = std::get_if<HalfSpace>(&body.shape);
    const Triangles surface = half_space != nullptr ? square_of(*half_space, room, pose) : triangles_of(body.shape);
    const Colour colour = body.type == BodyType::Static ? static_colour : body_colour(id.index);
    for (const auto& [a, b, c] : surface.triangles) {
      const auto place = [&](std::uint32_t vertex) {
        return Vector3(pose.position + pose.orientation * surface.vertices[vertex]);
      };
      add_face({place(a), place(b), place(c)}, colour, id.index);
    }
  }
}

// Projects a face into the camera's plane if its front is visible, clipped at the near plane.
void Still::add_face(const std::array<Vector3, 3>& corners, const Colour& colour, std::uint32_t body) {
  const Vector3 normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).stableNormalized();
  if (!(normal.dot(eye_ - corners[0]) > 0)) return;
  const double nearest = near_plane * (eye_ - corners[0]).norm();
  std::vector<Vector3> seen;  // camera frame, z forward
  for (std::size_t i = 0; i < 3; ++i) {
    const auto in_camera = [&](const Vector3& corner) {
      const Vector3 from_eye = corner - eye_;
      return Vector3(right_.dot(from_eye), up_.dot(from_eye), forward_.dot(from_eye));
    };
    const Vector3 a = in_camera(corners[i]), b = in_camera(corners[(i + 1) % 3]);
    if (a.z() >= nearest) seen.push_back(a);
    if ((a.z() < nearest) != (b.z() < nearest)) {
      seen.push_back(a + (nearest - a.z()) / (b.z() - a.z()) * (b - a));
    }
  }
  if (seen.size() < 3) return;
  const double shade = 0.55 + 0.5 * std::max(0.0, normal.dot(light));
  Face face{.corners = {}, .colour = {}, .body = body, .depth = 0};
  face.colour = {std::min(1.0, colour.r * shade), std::min(1.0, colour.g * shade), std::min(1.0, colour.b * shade)};
  for (const Vector3& corner : seen) {
    face.depth = std::max(face.depth, corner.z());
    face.corners.emplace_back(0.5 * samples * width_ + focal_ * corner.x() / corner.z(),
                              0.5 * samples * height_ - focal_ * corner.y() / corner.z(), 1 / corner.z());
  }
  faces_.push_back(std::move(face));
}

void Still::draw(std::uint32_t number) {
  const Face& face = faces_[number];
  const int wide = samples * width_, high = samples * height_;
  for (std::size_t k = 1; k + 1 < face.corners.size(); ++k) {
    const Vector3 &a = face.corners[0], &b = face.corners[k], &c = face.corners[k + 1];
    const auto side = [](const Vector3& from, const Vector3& to, double x, double y) {
      return (to.x() - from.x()) * (y - from.y()) - (to.y() - from.y()) * (x - from.x());
    };
    const double area = side(a, b, c.x(), c.y());
    if (area == 0 || !std::isfinite(area)) continue;
    const auto bound = [](double value, int max) { return static_cast<int>(std::clamp(value, 0.0, double(max))); };
    const int left = bound(std::floor(std::min({a.x(), b.x(), c.x()})), wide);
    const int right = bound(std::ceil(std::max({a.x(), b.x(), c.x()})), wide);
    const int top = bound(std::floor(std::min({a.y(), b.y(), c.y()})), high);
    const int bottom = bound(std::ceil(std::max({a.y(), b.y(), c.y()})), high);
    for (int y = top; y < bottom; ++y) {
      for (int x = left; x < right; ++x) {
        const double of_a = side(b, c, x + 0.5, y + 0.5) / area, of_b = side(c, a, x + 0.5, y + 0.5) / area;
        const double of_c = 1 - of_a - of_b;
        if (of_a < 0 || of_b < 0 || of_c < 0) continue;
        const auto here = static_cast<float>(of_a * a.z() + of_b * b.z() + of_c * c.z());
        const std::size_t at =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(wide) + static_cast<std::size_t>(x);
        if (here <= nearest_[at]) continue;
        nearest_[at] = here;
        shown_[at] = number + 1;
      }
    }
  }
}

// The mean of its samples, darker where bodies meet.
Colour Still::pixel(int x, int y) const {
  Colour sum = {0, 0, 0};
  const int wide = samples * width_, high = samples * height_;
  const auto body_at = [&](int column, int row) -> std::int64_t {
    const std::uint32_t face =
        shown_[static_cast<std::size_t>(std::min(row, high - 1)) * static_cast<std::size_t>(wide) +
               static_cast<std::size_t>(std::min(column, wide - 1))];
    return face == 0 ? -1 : std::int64_t{faces_[face - 1].body};
  };
  for (int row = samples * y; row < samples * (y + 1); ++row) {
    for (int column = samples * x; column < samples * (x + 1); ++column) {
      const std::uint32_t face =
          shown_[static_cast<std::size_t>(row) * static_cast<std::size_t>(wide) + static_cast<std::size_t>(column)];
      const Colour colour = face == 0 ? Colour{0.965, 0.973, 0.98} : faces_[face - 1].colour;
      const std::int64_t body = body_at(column, row);
      const double part = body == body_at(column + 1, row) && body == body_at(column, row + 1) ? 1 : outline;
      sum = {sum.r + part * colour.r, sum.g + part * colour.g, sum.b + part * colour.b};
    }
  }
  constexpr double share = 1.0 / (samples * samples);
  return {share * sum.r, share * sum.g, share * sum.b};
}

void Still::write_png(std::ostream& out) const {
  std::vector<std::uint8_t> pixels;
  pixels.reserve(3 * static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
  for (int y = 0; y < height_; ++y) {
    for (int x = 0; x < width_; ++x) {
      const Colour colour = pixel(x, y);
      for (const double part : {colour.r, colour.g, colour.b}) {
        pixels.push_back(static_cast<std::uint8_t>(std::lround(255 * part)));
      }
    }
  }
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  image.width = static_cast<png_uint_32>(width_);
  image.height = static_cast<png_uint_32>(height_);
  image.format = PNG_FORMAT_RGB;
  png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(image);
  std::vector<char> file(size);
  if (png_image_write_to_memory(&image, file.data(), &size, 0, pixels.data(), 0, nullptr) == 0) {
    throw Error(std::string("the picture could not be written: ") + image.message);
  }
  out.write(file.data(), static_cast<std::streamsize>(size));
}

void Still::write_svg(std::ostream& out) const {
  std::vector<std::uint8_t> shows(faces_.size(), 0);
  for (const std::uint32_t face : shown_) {
    if (face != 0) shows[face - 1] = 1;
  }
  std::vector<std::uint32_t> order;
  for (std::uint32_t face = 0; face < faces_.size(); ++face) {
    if (shows[face] != 0) order.push_back(face);
  }
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return faces_[a].depth > faces_[b].depth; });
  out << "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 " << width_ << " " << height_ << "\">\n"
      << "<rect width=\"" << width_ << "\" height=\"" << height_ << "\" fill=\"#f6f8fa\"/>\n"
      << "<g stroke-width=\".4\" stroke-linejoin=\"round\">\n";
  char text[64];
  for (const std::uint32_t number : order) {
    const Face& face = faces_[number];
    const auto byte = [](double part) { return static_cast<unsigned>(std::lround(255 * part)); };
    std::snprintf(text, sizeof text, "#%02x%02x%02x", byte(face.colour.r), byte(face.colour.g), byte(face.colour.b));
    out << "<path fill=\"" << text << "\" stroke=\"" << text << "\" d=\"M";
    for (const Vector3& corner : face.corners) {
      // No line needs to end farther from the picture than this.
      const auto within = [](double value) { return std::clamp(value / samples, -1e5, 1e5); };
      std::snprintf(text, sizeof text, "%.1f %.1f", within(corner.x()), within(corner.y()));
      out << (&corner == &face.corners.front() ? "" : "L") << text;
    }
    out << "z\"/>\n";
  }
  out << "</g>\n</svg>\n";
}

}  // namespace atl::view
