#pragma once

#include <atoll/shapes.h>

#include <cstdint>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace atl::view {

/// Shapes as JSON for a page, each once.
class FilmShapes {
 public:
  /// The number of a shape, which is told now if it is new.
  std::uint32_t number_of(const Shape& shape);
  const std::vector<std::string>& texts() const { return texts_; }

 private:
  std::uint32_t number_of_text(std::string text);

  std::vector<std::string> texts_;
  std::map<std::string, std::uint32_t> numbers_;
  struct Geometry {
    std::shared_ptr<const void> data;  // kept, or its place in memory could become another's
    std::uint32_t number;
  };
  std::map<const void*, Geometry> of_geometry_;  // hulls, meshes and height fields
};

/// m: how far a shape reaches from its frame's origin; of a half-space 0.
double reach_of(const Shape& shape);

}  // namespace atl::view
