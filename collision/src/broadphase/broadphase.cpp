#include <collision/broadphase/broadphase.h>

namespace atl::collision {

void Broadphase::begin(std::uint32_t shape, const Filter& filter) {
  filters_.add(shape, filter);
  moves_.make_room_for(shape);
  moves_.mark(shape);
}

void Broadphase::add_box(std::uint32_t shape, const Aabb& fat, bool fixed, const Filter& filter) {
  begin(shape, filter);
  proxies_.add_box(shape, fat, fixed);
}

void Broadphase::add_half_space(std::uint32_t shape, const Plane& plane, const Filter& filter) {
  begin(shape, filter);
  proxies_.add_half_space(shape, plane);
}

void Broadphase::remove(std::uint32_t shape) {
  proxies_.remove(shape);
  filters_.remove(shape);
}

void Broadphase::move_box(std::uint32_t shape, const Aabb& fat) {
  restore_box(shape, fat);
  mark_moved(shape);
}

void Broadphase::move_half_space(std::uint32_t shape, const Plane& plane) {
  restore_half_space(shape, plane);
  mark_moved(shape);
}

void Broadphase::set_filter(std::uint32_t shape, const Filter& filter) {
  filters_.set(shape, filter);
  mark_moved(shape);
}

void Broadphase::mark_shapes_of(std::uint32_t owner) {
  filters_.for_each_shape_of(owner, [this](std::uint32_t shape) { mark_moved(shape); });
}

void Broadphase::disable_pair(std::uint32_t owner_a, std::uint32_t owner_b) {
  if (!filters_.disable_pair(owner_a, owner_b)) return;
  mark_shapes_of(owner_a);
  mark_shapes_of(owner_b);
}

void Broadphase::enable_pair(std::uint32_t owner_a, std::uint32_t owner_b) {
  if (!filters_.enable_pair(owner_a, owner_b)) return;
  mark_shapes_of(owner_a);
  mark_shapes_of(owner_b);
}

}  // namespace atl::collision
