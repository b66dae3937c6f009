#pragma once

#include <collision/shapes/aabb.h>
#include <collision/shapes/triangle.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <variant>
#include <vector>

namespace atl::collision {

/// Heights over a grid in the x-y plane, two triangles a cell, front upwards. Made once and never changed. Nothing
/// is stored by triangle: a field may have a billion of them. A triangle with a corner that is a hole isn't there.
struct HeightField {
  std::uint32_t columns = 0;            ///< samples along x, >= 2
  std::uint32_t rows = 0;               ///< samples along y, >= 2
  double spacing_x = 1;                 ///< m, > 0; sample (0, 0) lies at the origin
  double spacing_y = 1;                 ///< m, > 0
  std::vector<double> heights;          ///< m, along z; row after row: sample (i, j) at j * columns + i; NaN: a hole
  double lowest = 0, highest = 0;       ///< m; 0 if all are holes
  double bounding_radius = 0;           ///< m, about the origin
  bool smooth = false;                  ///< it stands for a smooth surface
  std::vector<std::uint8_t> materials;  ///< numbers, by cell, row after row; empty: all 0
  std::uint64_t content = 0;            ///< hash of all of these

  std::uint32_t triangle_count() const { return 2 * (columns - 1) * (rows - 1); }
  /// Triangles 2 c and 2 c + 1 are those of cell c, row after row, below and above the diagonal, which runs from
  /// sample (i, j) to (i + 1, j + 1). Below: vertices (i, j), (i + 1, j), (i + 1, j + 1); above: (i, j),
  /// (i + 1, j + 1), (i, j + 1).
  Triangle triangle(std::uint32_t index) const;
  /// The same in two steps: vertices and normal, then the rest.
  Triangle face(std::uint32_t index) const;
  void complete(std::uint32_t index, Triangle& face) const;

  double height(std::uint32_t column, std::uint32_t row) const { return heights[std::size_t{row} * columns + column]; }
  std::uint8_t material(std::uint32_t index) const {
    return materials.empty() ? std::uint8_t{0} : materials[index / 2];
  }
  /// True if one of the triangle's corners is a hole.
  bool is_hole(std::uint32_t index) const;

  /// The cell that a triangle belongs to.
  struct Cell {
    std::uint32_t column, row;
  };
  Cell cell(std::uint32_t index) const { return {index / 2 % (columns - 1), index / 2 / (columns - 1)}; }

  /// Cells first <= i < end whose stretch along an axis meets that of a box.
  struct CellRange {
    std::uint32_t first;
    std::uint32_t end;
  };
  CellRange columns_between(double lower, double upper) const;
  CellRange rows_between(double lower, double upper) const;

  /// Calls visit(triangle), in order, for every triangle whose box overlaps.
  template <typename Visit>
  void query(const Aabb& box, const Visit& visit) const {
    const CellRange across = columns_between(box.lower[0], box.upper[0]);
    const CellRange along = rows_between(box.lower[1], box.upper[1]);
    for (std::uint32_t j = along.first; j < along.end; ++j) {
      for (std::uint32_t i = across.first; i < across.end; ++i) {
        const double a = height(i, j);
        const double b = height(i + 1, j);
        const double c = height(i + 1, j + 1);
        const double d = height(i, j + 1);
        if (std::isnan(a + c)) continue;
        const double diagonal_low = std::min(a, c);
        const double diagonal_high = std::max(a, c);
        const std::uint32_t below = 2 * (j * (columns - 1) + i);
        // In this order of arguments the result is NaN if the corner is a hole.
        if (std::min(b, diagonal_low) <= box.upper[2] && std::max(b, diagonal_high) >= box.lower[2]) visit(below);
        if (std::min(d, diagonal_low) <= box.upper[2] && std::max(d, diagonal_high) >= box.lower[2]) visit(below + 1);
      }
    }
  }
};

/// Error text where there is no field: fewer than 2 columns or rows, more triangles than 32 bits count, a spacing
/// that isn't positive (or beyond 1e30 m), another number of heights than columns * rows, or one that is infinite
/// (or beyond 1e30 m). NaN stands for a hole. Materials are as many as there are cells, or none.
std::variant<HeightField, std::string> build_height_field(std::uint32_t columns, std::uint32_t rows, double spacing_x,
                                                          double spacing_y, std::vector<double> heights,
                                                          bool smooth = false,
                                                          std::vector<std::uint8_t> materials = {});

/// The field with other heights in a rectangle of samples, of so many columns, from a sample on, row after row. Error
/// text where the rectangle is not within the field, or a height is infinite.
std::variant<HeightField, std::string> with_heights(const HeightField& field, std::uint32_t column, std::uint32_t row,
                                                    std::uint32_t columns, std::span<const double> heights);

}  // namespace atl::collision
