// Contacts that follow small motion in closed form. Included once for each instruction set.

#if defined(ATOLL_COLLISION_REFRESH_KERNELS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef ATOLL_COLLISION_REFRESH_KERNELS_INL_H_
#undef ATOLL_COLLISION_REFRESH_KERNELS_INL_H_
#else
#define ATOLL_COLLISION_REFRESH_KERNELS_INL_H_
#endif

#include <collision/contacts/refresh.h>
#include <jobs/lanes-inl.h>

#include "narrowphase/wide-inl.h"

HWY_BEFORE_NAMESPACE();
namespace atl::collision {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;
using namespace jobs::HWY_NAMESPACE;

// The values that the double stage hands to the single precision stage. Turns are measured from the pose at which the
// manifold was computed.
struct alignas(64) Narrowed {
  float shift[3][block_lanes];          // m, world: of the incident's centre against the reference's
  float arm_reference[3][block_lanes];  // m, world: from the shape's origin to its centre of the contact
  float arm_incident[3][block_lanes];
  float orientation_reference[4][block_lanes];
  float half_turn[4][block_lanes];  // quaternion of the incident's turn in the reference frame
};

HWY_INLINE void narrow(WideV value, float* to) {
  const hn::Rebind<float, Wide> d;
  hn::Store(hn::DemoteTo(d, value), d, to);
}
HWY_INLINE void narrow3(const WideV3& v, float (*rows)[block_lanes], std::size_t lane) {
  narrow(v.x, rows[0] + lane);
  narrow(v.y, rows[1] + lane);
  narrow(v.z, rows[2] + lane);
}

// Orientations when manifolds were computed, as columns.
struct alignas(64) OldOrientations {
  float orientation[4][block_lanes];
};

HWY_INLINE WideV promote(const float* from) { return hn::PromoteTo(Wide(), hn::Load(hn::Rebind<float, Wide>(), from)); }

HWY_INLINE void relate_poses(const RefreshBlock& block, const OldOrientations& old, std::size_t lane, Narrowed& to) {
  const auto of = [lane](const auto& pointers) {
    return [&pointers, lane](std::size_t k) { return pointers[lane + k]; };
  };
  const WideQ reference = load_wide4(of(block.orientation_reference));
  const WideQ incident = load_wide4(of(block.orientation_incident));
  const WideV3 centre_reference =
      load_wide3([&](std::size_t k) { return block.contact[lane + k]->centre_reference.data(); });
  const WideV3 centre_incident =
      load_wide3([&](std::size_t k) { return block.contact[lane + k]->centre_incident.data(); });
  const WideQ turned_before = {
      {promote(old.orientation[0] + lane), promote(old.orientation[1] + lane), promote(old.orientation[2] + lane)},
      promote(old.orientation[3] + lane)};
  const WideV3 arm_reference = rotate(reference, centre_reference);
  const WideV3 arm_incident = rotate(incident, centre_incident);
  const WideV3 between = load_wide3(of(block.position_incident)) - load_wide3(of(block.position_reference));
  const WideQ turn = times_conjugate(conjugate_times(reference, incident), turned_before);
  narrow3((between + arm_incident) - arm_reference, to.shift, lane);
  narrow3(arm_reference, to.arm_reference, lane);
  narrow3(arm_incident, to.arm_incident, lane);
  narrow3(reference.v, to.orientation_reference, lane);
  narrow(reference.w, to.orientation_reference[3] + lane);
  narrow3(turn.v, to.half_turn, lane);
  narrow(turn.w, to.half_turn[3] + lane);
}

HWY_INLINE V3 rotate(const V3& u, V w, const V3& v) {
  const V3 t = cross(u, v);
  const V3 twice = t + t;
  return v + w * twice + cross(u, twice);
}

HWY_INLINE V3 negated(const V3& v) { return {hn::Neg(v.x), hn::Neg(v.y), hn::Neg(v.z)}; }
HWY_INLINE unsigned bits_of(M mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(D(), mask, bytes);
  return bytes[0];
}

// Speculative margin of the lanes; see speculative_margin().
HWY_INLINE V margins(const RefreshBlock& block, std::size_t lane, V size) {
  const V4 first = load_rows([&](std::size_t k) { return block.reach_first[lane + k]->shift; });
  const V4 second = load_rows([&](std::size_t k) { return block.reach_second[lane + k]->shift; });
  const V3 closing = V3{first.x, first.y, first.z} - V3{second.x, second.y, second.z};
  const V approach = hn::Add(hn::Add(hn::Sqrt(dot(closing, closing)), first.w), second.w);
  return hn::Add(hn::Mul(splat(margin_share), size), hn::Min(approach, hn::Mul(splat(approach_share), size)));
}

HWY_INLINE unsigned refresh_lanes(const RefreshBlock& block, const Narrowed& pose, std::size_t lane, std::size_t count,
                                  bool all) {
  alignas(64) float sizes[lanes];
  alignas(64) float sides[lanes];
  alignas(64) float tolerances[lanes];
  for (std::size_t k = 0; k < lanes; ++k) {
    sizes[k] = block.contact[lane + k]->size;
    tolerances[k] = block.contact[lane + k]->tolerance;
    sides[k] = block.contact[lane + k]->reference_is_second ? -1.0f : 1.0f;
  }
  const V size = load(sizes);
  const V margin = margins(block, lane, size);
  const V4 normal_row = load_rows([&](std::size_t k) { return block.contact[lane + k]->normal.data(); });

  // The motion since its manifold was computed, in the reference frame.
  const V3 to_world = load3(pose.orientation_reference, lane);
  const V to_world_w = load(pose.orientation_reference[3] + lane);
  const V3 to_local = negated(to_world);
  const V3 shift = rotate(to_local, to_world_w, load3(pose.shift, lane));
  const V3 turn = load3(pose.half_turn, lane);
  const V turn_w = load(pose.half_turn[3] + lane);

  const unsigned used = count >= lane + lanes ? (1u << lanes) - 1 : count > lane ? (1u << (count - lane)) - 1 : 0;
  unsigned valid = used;
  if (!all) {
    const V tolerance = load(tolerances);
    const V limit = hn::Mul(tolerance, size);
    // Either sign of a quaternion is the same turn, and its vector part is as long.
    const M still = hn::And(hn::Lt(dot(shift, shift), hn::Mul(limit, limit)),
                            hn::Lt(dot(turn, turn), hn::Mul(splat(0.25f), hn::Mul(tolerance, tolerance))));
    valid &= bits_of(hn::And(still, hn::Le(margin, hn::Add(normal_row.w, limit))));
  }
  unsigned written = 0;
  for (std::size_t k = 0; k < lanes; ++k) written |= static_cast<unsigned>(block.contact[lane + k]->count > 0) << k;
  written &= valid;
  if (written == 0) return valid;

  const V3 normal_local{normal_row.x, normal_row.y, normal_row.z};
  const V along = dot(normal_local, shift);
  V3 offset[max_points];
  V separation[max_points];
  V weight_sum = zero();
  V weighted_separation = zero();
  V3 centre{zero(), zero(), zero()};
  V present[max_points];  // 1 or 0
  for (std::size_t i = 0; i < max_points; ++i) {
    const V4 row = load_rows([&](std::size_t k) { return block.contact[lane + k]->points[i].data(); });
    const V3 at{row.x, row.y, row.z};
    const V3 t = cross(turn, at);
    const V3 twice = t + t;
    const V3 moved = turn_w * twice + cross(turn, twice);
    offset[i] = at + moved;
    separation[i] = hn::Add(row.w, hn::Add(along, dot(normal_local, moved)));
    const M is_point = hn::Lt(row.w, splat(0.5f * no_point));
    present[i] = hn::IfThenElseZero(is_point, splat(1));
    // Points weigh by how far they are within the margin, so the centre follows the pressure smoothly.
    const V within =
        hn::Add(hn::Max(hn::Sub(margin, separation[i]), zero()), hn::Add(hn::Mul(splat(1e-3f), margin), splat(1e-30f)));
    const V weight = hn::IfThenElseZero(is_point, within);
    weight_sum = hn::Add(weight_sum, weight);
    centre = centre + weight * offset[i];
    weighted_separation = hn::Add(weighted_separation, hn::IfThenElseZero(is_point, hn::Mul(weight, separation[i])));
  }
  // Lanes without points divide 0 by 0, and are not stored.
  const V per_weight = hn::Div(splat(1), weight_sum);
  centre = per_weight * centre;
  const V mean_separation = hn::Mul(per_weight, weighted_separation);

  const V side = load(sides);
  const V3 normal = side * rotate(to_world, to_world_w, normal_local);
  const TangentLanes tangent = tangent_lanes(normal);
  const V3 tangent_local[2] = {rotate(to_local, to_world_w, tangent.first),
                               rotate(to_local, to_world_w, tangent.second)};

  // Friction acts half-way between the surfaces, at the centre.
  const V3 from_centre = rotate(to_world, to_world_w, centre - hn::Mul(splat(0.5f), mean_separation) * normal_local);
  const auto offsets = [&](const auto& pointers) {
    const V4 row = load_rows([&](std::size_t k) { return pointers[lane + k]; });
    return V3{row.x, row.y, row.z};
  };
  const V3 anchor_reference =
      load3(pose.arm_reference, lane) + load3(pose.shift, lane) + from_centre + offsets(block.offset_reference);
  const V3 anchor_incident = load3(pose.arm_incident, lane) + from_centre + offsets(block.offset_incident);
  const M reference_first = hn::Gt(side, zero());
  const V3 anchor_first = select(reference_first, anchor_reference, anchor_incident);
  const V3 anchor_second = select(reference_first, anchor_incident, anchor_reference);

  V x[max_points], y[max_points];
  V friction_radius = zero();
  V points = zero();
  for (std::size_t i = 0; i < max_points; ++i) {
    const V3 from = offset[i] - centre;
    x[i] = hn::Mul(present[i], dot(from, tangent_local[0]));
    y[i] = hn::Mul(present[i], dot(from, tangent_local[1]));
    friction_radius = hn::Add(friction_radius, hn::Sqrt(hn::Add(hn::Mul(x[i], x[i]), hn::Mul(y[i], y[i]))));
    points = hn::Add(points, present[i]);
  }
  friction_radius = hn::Div(friction_radius, points);

  const auto manifold = [&](std::size_t k) { return block.manifold[lane + k]; };
  const V4 old_normal = load_rows([&](std::size_t k) { return manifold(k)->normal; });
  const V4 old_anchor = load_rows([&](std::size_t k) { return manifold(k)->anchor_first; });
  store_rows(
      V4{normal.x, normal.y, normal.z, old_normal.w}, [&](std::size_t k) { return manifold(k)->normal; }, written);
  store_rows(
      V4{anchor_first.x, anchor_first.y, anchor_first.z, old_anchor.w},
      [&](std::size_t k) { return manifold(k)->anchor_first; }, written);
  store_rows(
      V4{anchor_second.x, anchor_second.y, anchor_second.z, friction_radius},
      [&](std::size_t k) { return manifold(k)->anchor_second; }, written);
  store_rows(
      V4{x[0], x[1], x[2], x[3]}, [&](std::size_t k) { return manifold(k)->x; }, written);
  store_rows(
      V4{y[0], y[1], y[2], y[3]}, [&](std::size_t k) { return manifold(k)->y; }, written);
  store_rows(
      V4{separation[0], separation[1], separation[2], separation[3]},
      [&](std::size_t k) { return manifold(k)->separation; }, written);
  return valid;
}

unsigned refresh(const RefreshBlock& block, std::size_t count, bool all) {
  OldOrientations old;
  for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
    const V4 q = load_rows([&](std::size_t k) { return block.contact[lane + k]->orientation.data(); });
    store3(V3{q.x, q.y, q.z}, old.orientation, lane);
    store(q.w, old.orientation[3] + lane);
  }
  Narrowed pose;
  for (std::size_t lane = 0; lane < block_lanes; lane += wide_lanes) relate_poses(block, old, lane, pose);
  unsigned valid = 0;
  for (std::size_t lane = 0; lane < block_lanes; lane += lanes) {
    valid |= refresh_lanes(block, pose, lane, count, all) << lane;
  }
  return valid;
}

}  // namespace HWY_NAMESPACE
}  // namespace atl::collision
HWY_AFTER_NAMESPACE();

#endif  // ATOLL_COLLISION_REFRESH_KERNELS_INL_H_
