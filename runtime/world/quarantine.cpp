#include "world/quarantine.h"

#include <jobs/assert.h>

#include <algorithm>

namespace atl {

const char* quarantine_reason(Quarantine reason) {
  constexpr const char* reasons[] = {"its state is not finite",
                                     "it is farther than 1e12 m from the origin",
                                     "its speed is above 1e6 m/s",
                                     "its angular speed is above 1e6 rad/s",
                                     "the speed of its surface is above 1e6 m/s or rad/s",
                                     "forces would take its speed above 1e6 m/s in one step",
                                     "torques would take its angular speed above 1e6 rad/s in one step"};
  return reasons[static_cast<std::size_t>(reason)];
}

std::size_t QuarantineList::find(std::uint32_t body) const {
  const auto place = std::lower_bound(bodies_.begin(), bodies_.end(), body,
                                      [](const Quarantined& entry, std::uint32_t b) { return entry.id.index < b; });
  return place != bodies_.end() && place->id.index == body ? static_cast<std::size_t>(place - bodies_.begin())
                                                           : bodies_.size();
}

void QuarantineList::add(const Quarantined& body) {
  ATL_ASSERT(!contains(body.id.index), body.id.index);
  const auto place = std::lower_bound(bodies_.begin(), bodies_.end(), body.id,
                                      [](const Quarantined& entry, BodyId id) { return entry.id < id; });
  bodies_.insert(place, body);
}

void QuarantineList::disable(std::uint32_t body) {
  ATL_ASSERT(!contains(body), body);
  disabled_.insert(std::lower_bound(disabled_.begin(), disabled_.end(), body), body);
}

void QuarantineList::remove(std::uint32_t body) {
  if (is_disabled(body)) {
    disabled_.erase(std::lower_bound(disabled_.begin(), disabled_.end(), body));
    return;
  }
  const auto place = static_cast<std::ptrdiff_t>(find(body));
  ATL_ASSERT(find(body) < bodies_.size(), body, bodies_.size());
  bodies_.erase(bodies_.begin() + place);
}

void QuarantineList::clear() {
  bodies_.clear();
  disabled_.clear();
  clear_suspects();
}

void QuarantineList::suspect(std::uint32_t body) {
  ATL_ASSERT(body < suspected_.size(), body, suspected_.size());
  if (suspected_[body] == to_check) return;
  suspected_[body] = to_check;
  suspects_.push_back(body);
}

void QuarantineList::suspect_checked(std::uint32_t body) {
  if (suspected_[body] == to_check) return;
  suspected_[body] = checked;
  any_checked_ = true;
}

const solver::BodyPose* QuarantineList::pose_before(std::uint32_t body) const {
  const auto found = poses_before_.find(body);
  return found == poses_before_.end() ? nullptr : &found->second;
}

void QuarantineList::clear_suspects() {
  if (any_checked_) {
    std::fill(suspected_.begin(), suspected_.end(), std::uint8_t{0});
    any_checked_ = false;
  } else {
    for (const std::uint32_t body : suspects_) suspected_[body] = 0;
  }
  suspects_.clear();
  poses_before_.clear();
}

}  // namespace atl
