#include <collision/shapes/height_field.h>
#include <jobs/assert.h>
#include <jobs/hash.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "shapes/text.h"

namespace atl::collision {
namespace {

constexpr double largest_length = 1e30;
// A cell narrower than this part of its longest side has triangles whose normals rounding decides, as those of a
// TriangleMesh.
constexpr double min_width = 1e-10;

bool is_length(double value) { return value > 0 && value <= largest_length; }

// Stretch i is [i, i + 1] * spacing. The quotient may be rounded across a whole number, so one stretch more on
// either side is looked at.
HeightField::CellRange cells_between(double lower, double upper, double spacing, std::uint32_t cells) {
  if (!(lower <= upper)) return {0, 0};
  const double last = cells;
  auto first = static_cast<std::uint32_t>(std::clamp(std::floor(lower / spacing) - 1, 0.0, last));
  auto end = static_cast<std::uint32_t>(std::clamp(std::floor(upper / spacing) + 2, 0.0, last));
  while (first < end && (first + 1.0) * spacing < lower) ++first;
  while (end > first && (end - 1.0) * spacing > upper) --end;
  ATL_ASSERT(first <= end && end <= cells, first, end, cells);
  return {first, end};
}

Vector3 upward(double slope_x, double slope_y) { return Vector3(-slope_x, -slope_y, 1).normalized(); }

// The normals of a cell's two triangles.
struct Normals {
  const HeightField& field;

  Vector3 below(std::uint32_t i, std::uint32_t j) const {
    const double corner = field.height(i + 1, j);
    return upward((corner - field.height(i, j)) / field.spacing_x,
                  (field.height(i + 1, j + 1) - corner) / field.spacing_y);
  }
  Vector3 above(std::uint32_t i, std::uint32_t j) const {
    const double corner = field.height(i, j + 1);
    return upward((field.height(i + 1, j + 1) - corner) / field.spacing_x,
                  (corner - field.height(i, j)) / field.spacing_y);
  }
};

// The smooth surface's normal at a sample, by central differences, at the border and beside holes by one-sided ones,
// and where a hole is on either side, that of the triangle.
Vector3 sample_normal(const HeightField& field, std::uint32_t i, std::uint32_t j, const Vector3& of_triangle) {
  const auto ground = [&](std::uint32_t column, std::uint32_t row) { return !std::isnan(field.height(column, row)); };
  const std::uint32_t left = i > 0 && ground(i - 1, j) ? i - 1 : i;
  const std::uint32_t right = i + 1 < field.columns && ground(i + 1, j) ? i + 1 : i;
  const std::uint32_t below = j > 0 && ground(i, j - 1) ? j - 1 : j;
  const std::uint32_t above = j + 1 < field.rows && ground(i, j + 1) ? j + 1 : j;
  if (left == right || below == above) return of_triangle;
  return upward((field.height(right, j) - field.height(left, j)) / ((right - left) * field.spacing_x),
                (field.height(i, above) - field.height(i, below)) / ((above - below) * field.spacing_y));
}

}  // namespace

HeightField::CellRange HeightField::columns_between(double lower, double upper) const {
  return cells_between(lower, upper, spacing_x, columns - 1);
}

HeightField::CellRange HeightField::rows_between(double lower, double upper) const {
  return cells_between(lower, upper, spacing_y, rows - 1);
}

Triangle HeightField::triangle(std::uint32_t index) const {
  Triangle result = face(index);
  complete(index, result);
  return result;
}

Triangle HeightField::face(std::uint32_t index) const {
  ATL_ASSERT(index < triangle_count(), index, triangle_count());
  const auto [i, j] = cell(index);
  const auto sample = [&](std::uint32_t column, std::uint32_t row) {
    return Vector3(column * spacing_x, row * spacing_y, height(column, row));
  };
  const bool is_below = index % 2 == 0;
  Triangle result;
  result.normal = is_below ? Normals{*this}.below(i, j) : Normals{*this}.above(i, j);
  result.vertices = {sample(i, j), is_below ? sample(i + 1, j) : sample(i + 1, j + 1),
                     is_below ? sample(i + 1, j + 1) : sample(i, j + 1)};
  return result;
}

bool HeightField::is_hole(std::uint32_t index) const {
  const auto [i, j] = cell(index);
  const double third = index % 2 == 0 ? height(i + 1, j) : height(i, j + 1);
  return std::isnan(height(i, j) + height(i + 1, j + 1) + third);
}

void HeightField::complete(std::uint32_t index, Triangle& face) const {
  const auto [i, j] = cell(index);
  const Normals normals{*this};
  const bool is_below = index % 2 == 0;
  face.neighbour_normals = {face.normal, face.normal, face.normal};
  std::array<bool, 3> inside;  // by edge: there is a triangle beyond it
  if (is_below) {
    inside = {j > 0, i + 2 < columns, true};
    if (inside[0]) face.neighbour_normals[0] = normals.above(i, j - 1);
    if (inside[1]) face.neighbour_normals[1] = normals.above(i + 1, j);
    face.neighbour_normals[2] = normals.above(i, j);
  } else {
    inside = {true, j + 2 < rows, i > 0};
    face.neighbour_normals[0] = normals.below(i, j);
    if (inside[1]) face.neighbour_normals[1] = normals.below(i, j + 1);
    if (inside[2]) face.neighbour_normals[2] = normals.below(i - 1, j);
  }
  for (std::size_t e = 0; e < 3; ++e) {
    if (!face.neighbour_normals[e].hasNaN()) continue;
    inside[e] = false;  // a hole
    face.neighbour_normals[e] = face.normal;
  }
  if (smooth) {
    const auto at = [&](std::uint32_t column, std::uint32_t row) {
      return sample_normal(*this, column, row, face.normal);
    };
    face.corner_normals = {at(i, j), is_below ? at(i + 1, j) : at(i + 1, j + 1),
                           is_below ? at(i + 1, j + 1) : at(i, j + 1)};
  }
  for (std::size_t e = 0; e < 3; ++e) {
    const Vector3 edge = face.vertices[(e + 1) % 3] - face.vertices[e];
    if (!inside[e] || is_convex_edge(face.normal, face.neighbour_normals[e], edge)) {
      face.convex_edges = static_cast<std::uint8_t>(face.convex_edges | 1u << e);
    }
  }
}

namespace {

std::uint64_t content_of(const HeightField& field) {
  jobs::Hash hash;
  hash.add(std::uint64_t{field.columns} << 32 | field.rows);
  hash.add(field.spacing_x);
  hash.add(field.spacing_y);
  hash.add_all(field.heights);
  if (field.smooth) hash.add(std::uint64_t{1});
  for (const std::uint8_t number : field.materials) hash.add(std::uint64_t{number});
  return hash.value();
}

}  // namespace

std::variant<HeightField, std::string> build_height_field(std::uint32_t columns, std::uint32_t rows, double spacing_x,
                                                          double spacing_y, std::vector<double> heights, bool smooth,
                                                          std::vector<std::uint8_t> materials) {
  if (columns < 2 || rows < 2) {
    return text("found ", columns, " columns and ", rows, " rows of samples, expected at least 2 of each");
  }
  if (2 * (columns - 1.0) * (rows - 1.0) >= std::numeric_limits<std::uint32_t>::max()) {
    return text("found ", columns, " columns and ", rows, " rows of samples, expected fewer than 2^31 cells");
  }
  if (!is_length(spacing_x) || !is_length(spacing_y)) {
    return text("found spacings of ", spacing_x, " and ", spacing_y, " m, expected them positive, up to 1e30 m");
  }
  const std::size_t count = std::size_t{columns} * rows;
  if (heights.size() != count) {
    return text("found ", heights.size(), " heights, expected columns * rows = ", columns, " * ", rows, " = ", count);
  }
  if (const std::size_t cells = std::size_t{columns - 1} * (rows - 1);
      !materials.empty() && materials.size() != cells) {
    return text("found numbers of materials for ", materials.size(), " cells, expected ", cells, ", or none");
  }
  HeightField field;
  field.lowest = std::numeric_limits<double>::infinity();
  field.highest = -field.lowest;
  for (std::size_t i = 0; i < count; ++i) {
    if (std::isnan(heights[i])) {
      heights[i] = std::numeric_limits<double>::quiet_NaN();  // of the same bits, whatever computed it
      continue;
    }
    if (!(std::abs(heights[i]) <= largest_length)) {
      return text("found a height of ", heights[i], " at column ", i % columns, ", row ", i / columns,
                  ", expected a number up to 1e30 m, or NaN for a hole");
    }
    field.lowest = std::min(field.lowest, heights[i]);
    field.highest = std::max(field.highest, heights[i]);
  }
  if (field.lowest > field.highest) field.lowest = field.highest = 0;
  const double longest = std::max({spacing_x, spacing_y, field.highest - field.lowest});
  if (!(std::min(spacing_x, spacing_y) > min_width * longest)) {
    return text("found spacings of ", spacing_x, " and ", spacing_y, " m and heights from ", field.lowest, " to ",
                field.highest, " m, expected spacings above 1e-10 of each other and of the heights' range");
  }
  field.columns = columns;
  field.rows = rows;
  field.spacing_x = spacing_x;
  field.spacing_y = spacing_y;
  field.heights = std::move(heights);
  field.smooth = smooth;
  field.materials = std::move(materials);
  const double farthest_up = std::max(std::abs(field.lowest), std::abs(field.highest));
  field.bounding_radius = Vector3((columns - 1) * spacing_x, (rows - 1) * spacing_y, farthest_up).norm();
  field.content = content_of(field);
  return field;
}

std::variant<HeightField, std::string> with_heights(const HeightField& field, std::uint32_t column, std::uint32_t row,
                                                    std::uint32_t columns, std::span<const double> heights) {
  const std::size_t rows = columns > 0 ? heights.size() / columns : 0;
  if (rows * columns != heights.size() || heights.empty() || std::size_t{column} + columns > field.columns ||
      row + rows > field.rows) {
    return text("found ", heights.size(), " heights in ", columns, " columns from column ", column, ", row ", row,
                " on, expected whole rows within the field's ", field.columns, " columns and ", field.rows, " rows");
  }
  std::vector<double> all = field.heights;
  for (std::size_t i = 0; i < rows; ++i) {
    std::copy_n(heights.begin() + static_cast<std::ptrdiff_t>(i * columns), columns,
                all.begin() + static_cast<std::ptrdiff_t>((row + i) * field.columns + column));
  }
  return build_height_field(field.columns, field.rows, field.spacing_x, field.spacing_y, std::move(all), field.smooth,
                            field.materials);
}

}  // namespace atl::collision
