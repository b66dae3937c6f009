#include <collision/continuous/ccd_culling.h>
#include <collision/narrowphase/box_axes.h>
#include <collision/shapes/shape.h>
#include <jobs/assert.h>

#include <algorithm>
#include <array>

namespace atl::collision {
namespace {

using jobs::block_lanes;

// True if a plane across `direction` (unit, from the first to the second), with the surfaces `gap` (m) apart as the
// step starts, keeps the shapes apart during the step. They come towards each other by at most `closing`; the part of
// it that is a shift counts only along the direction.
bool keeps_apart(double gap, const Vector3& direction, const Approach& approach) {
  const double goal = (ccd_gap_share + ccd_tolerance) * approach.size;
  const double turning = approach.closing - approach.shift.norm();
  return gap - goal > turning + std::max(0.0, approach.shift.dot(direction));
}

// Boxes near a box, eight at a time: those are kept that the best axis of the two doesn't keep apart.
class NearBoxes {
 public:
  NearBoxes(const NarrowphaseKernels& kernels, const Shape& box, const Pose& start, std::vector<Approach>& kept)
      : kernels_(kernels), start_(start), core_depth_(core_share * box.inner_radius), kept_(kept) {
    block_.position_first.fill(start_.position.data());
    block_.orientation_first.fill(start_.orientation.coeffs().data());
    block_.half_first.fill(box.half_extents.data());
  }

  void add(const Approach& approach, const Shape& box, const Pose& start) {
    starts_[count_] = start;
    approaches_[count_] = approach;
    block_.position_second[count_] = starts_[count_].position.data();
    block_.orientation_second[count_] = starts_[count_].orientation.coeffs().data();
    block_.half_second[count_] = box.half_extents.data();
    if (++count_ == block_lanes) finish();
  }

  void finish() {
    if (count_ == 0) return;
    for (std::size_t lane = count_; lane < block_lanes; ++lane) {
      block_.position_second[lane] = block_.position_second[0];
      block_.orientation_second[lane] = block_.orientation_second[0];
      block_.half_second[lane] = block_.half_second[0];
    }
    kernels_.find_box_axes(block_, axes_);
    for (std::size_t lane = 0; lane < count_; ++lane) {
      Approach& approach = approaches_[lane];
      const double gap = std::max(axes_.face[lane], axes_.edge[lane]);
      const Vector3 axis = best_box_axis(axes_, lane);
      const Vector3 direction = start_.orientation * axis;
      if (gap > 0 && keeps_apart(gap, direction, approach)) continue;
      // The core's half extents are that much less; the other's core, in its own frame, is at least as much farther.
      const double core_depth = approach.both_stop ? core_share * approach.size : core_depth_ * axis.lpNorm<1>();
      const double core_gap = gap + core_depth;
      approach.passes_core = core_gap > 0 && keeps_apart(core_gap, direction, approach);
      kept_.push_back(approach);
    }
    count_ = 0;
  }

 private:
  const NarrowphaseKernels& kernels_;
  Pose start_;
  double core_depth_;
  std::vector<Approach>& kept_;
  BoxBlock block_;
  BoxAxes axes_;
  std::array<Pose, block_lanes> starts_;
  std::array<Approach, block_lanes> approaches_;
  std::size_t count_ = 0;
};

}  // namespace

void find_approaching(const CcdStep& step, const FastBody& fast, const Vector3& aside, std::uint32_t collider,
                      std::span<const CcdPair> candidates, std::vector<Approach>& approaching) {
  approaching.clear();
  const auto first = std::ranges::lower_bound(candidates, collider, {}, &CcdPair::own);
  const auto last = std::ranges::upper_bound(candidates, collider, {}, &CcdPair::own);
  if (first == last) return;
  const ColliderTable& colliders = step.motions.colliders;
  const Shape& shape = colliders.shape[collider];
  const Pose start = placed(fast.start, colliders.local[collider]);
  const Vector3 own_shift = fast.shift + aside;
  NearBoxes boxes(step.kernels, shape, start, approaching);
  for (const CcdPair& near : std::span(first, last)) {
    const std::uint32_t other = near.other;
    const Shape& other_shape = colliders.shape[other];
    const FastBody* moved = step.find_fast(colliders.body[other]);
    Approach approach;
    approach.other = other;
    approach.apart = near.apart;
    approach.shift = moved ? Vector3(own_shift - moved->shift) : own_shift;
    approach.closing = approach.shift.norm() + fast.turn + (moved ? moved->turn : 0);
    approach.size = std::min(shape.inner_radius, other_shape.inner_radius);
    ATL_ASSERT(approach.size > 0 && approach.size < infinity, collider, other, approach.size);
    approach.both_stop = moved != nullptr && moved->stops;
    approach.passes_core = false;
    // An approach of up to half the smaller one's size is covered by the speculative margin.
    const bool slow = approach.closing <= approach_share * approach.size;
    if (slow && !presses(fast, !near.apart, other_shape.kind)) continue;
    if (!is_convex_solid(other_shape.kind)) {
      approaching.push_back(approach);
      continue;
    }
    const Pose at = moved ? placed(moved->start, colliders.local[other]) : colliders.pose(other, step.motions.poses);
    const auto [direction, gap] = centre_line(shape, start, other_shape, at);
    if (keeps_apart(gap, direction, approach)) continue;
    if (shape.kind == ShapeKind::Box && other_shape.kind == ShapeKind::Box) {
      boxes.add(approach, other_shape, at);
    } else {
      approaching.push_back(approach);
    }
  }
  boxes.finish();
  // The supports of a held body are found in this order, which must not depend on the order of candidates.
  std::sort(approaching.begin(), approaching.end(),
            [](const Approach& a, const Approach& b) { return a.other < b.other; });
}

}  // namespace atl::collision
