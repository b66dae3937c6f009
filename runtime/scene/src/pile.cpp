#include <algorithm>

#include "building_blocks.h"
#include "builtin.h"
#include "random.h"

namespace atl::scene {
namespace pile {

constexpr double container_half = 10;  // m, of the square floor's edge
constexpr double smallest_gap = 0.01;  // m, between the bounds of neighbours at the start
constexpr double largest_gap = 0.05;   // m
constexpr double drop = 0.5;           // m, from the lowest layer's bounds to the floor

struct LooseBox {
  Vector3 half_extents;
  Quaternion orientation;
  Vector3 bounds;  ///< half extents of the axis-aligned bounding box
  Vector3 centre;
};

LooseBox random_box(Random& random) {
  LooseBox box;
  box.half_extents = random.in_box(Vector3::Constant(0.25)) + Vector3::Constant(0.5);
  box.orientation = random.rotation();
  box.bounds = box.orientation.toRotationMatrix().cwiseAbs() * box.half_extents;
  box.centre = box.bounds;
  return box;
}

// Fills rows along x, rows to layers along y and layers upwards, all by the boxes' bounds with random
// gaps: a grid would have to leave every box the room of the largest, and drop the pile from twice the
// height. A row (and a layer) is shifted by a random share of the room it leaves, so none leans to a side.
class LayeredGrid {
 public:
  LayeredGrid(std::size_t count, Random& random) : random_(random) {
    for (std::size_t i = 0; i < count; ++i) add(random_box(random_));
    close_layer();
  }

  const std::vector<LooseBox>& boxes() const { return boxes_; }

 private:
  static constexpr double width = 2 * container_half;

  double gap() { return random_.uniform(smallest_gap, largest_gap); }

  void add(LooseBox box) {
    if (row_end_ + 2 * box.bounds.x() + largest_gap > width) close_row();
    if (row_start_ + 2 * box.bounds.y() + largest_gap > width) close_layer();
    const double front = row_start_ + gap(), left = row_end_ + gap(), below = layer_start_ + gap();
    box.centre = box.bounds + Vector3(left, front, below);
    row_end_ = box.centre.x() + box.bounds.x();
    row_back_ = std::max(row_back_, box.centre.y() + box.bounds.y());
    layer_top_ = std::max(layer_top_, box.centre.z() + box.bounds.z());
    boxes_.push_back(box);
  }

  void close_row() {
    const double shift = random_.uniform(0, width - row_end_) - container_half;
    for (std::size_t i = row_first_; i < boxes_.size(); ++i) boxes_[i].centre.x() += shift;
    row_first_ = boxes_.size();
    row_end_ = 0;
    row_start_ = row_back_;
  }

  void close_layer() {
    if (row_first_ < boxes_.size()) close_row();
    const double shift = random_.uniform(0, width - row_back_) - container_half;
    for (std::size_t i = layer_first_; i < boxes_.size(); ++i) boxes_[i].centre.y() += shift;
    layer_first_ = boxes_.size();
    row_start_ = row_back_ = 0;
    layer_start_ = layer_top_;
  }

  Random& random_;
  std::vector<LooseBox> boxes_;
  std::size_t row_first_ = 0, layer_first_ = 0;
  double row_end_ = 0, row_start_ = 0, row_back_ = 0, layer_start_ = drop, layer_top_ = drop;
};

}  // namespace pile

Scene build_pile(const ParameterValues& values, std::uint64_t seed) {
  using namespace pile;
  Scene scene = scene_on_ground(600, false);
  add_walls(scene, container_half);
  Random random(seed);
  const LayeredGrid grid(static_cast<std::size_t>(values.integer("bodies")), random);
  std::size_t number = 0;
  for (const LooseBox& box : grid.boxes()) {
    SceneBody& body = scene.bodies.emplace_back(unit_box(number++, box.centre));
    body.def.shape = Box{box.half_extents};
    body.def.orientation = box.orientation;
  }
  return scene;
}

}  // namespace atl::scene
