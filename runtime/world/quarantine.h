#pragma once

#include <atoll/quarantine.h>
#include <jobs/append.h>
#include <jobs/compact_array.h>
#include <solver/integrate/body_table.h>
#include <solver/integrate/motion.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <span>

namespace atl {

/// The bodies that are out of the world: in quarantine, or disabled. And those that callers touched since the last
/// step, which may have to go to quarantine.
class QuarantineList {
 public:
  /// For a world of so many bodies.
  void resize(std::size_t count) { jobs::append(suspected_, count, std::uint8_t{0}); }

  /// True if the body is out of the world, in quarantine or disabled.
  bool contains(std::uint32_t body) const { return is_quarantined(body) || is_disabled(body); }
  bool is_quarantined(std::uint32_t body) const { return !bodies_.empty() && find(body) < bodies_.size(); }
  bool is_disabled(std::uint32_t body) const { return std::binary_search(disabled_.begin(), disabled_.end(), body); }
  std::span<const std::uint32_t> disabled() const { return disabled_; }  ///< in order
  std::span<const Quarantined> bodies() const { return bodies_; }        ///< in order of id
  const Quarantined& entry(std::uint32_t body) const { return bodies_[find(body)]; }
  void add(const Quarantined& body);
  void disable(std::uint32_t body);
  /// Takes the body off the list that has it.
  void remove(std::uint32_t body);
  void clear();  ///< suspects too

  /// The body's state was changed from outside, so the next step is to check it.
  void suspect(std::uint32_t body);
  /// The same of a body that is new and was checked: it counts as a suspect, but costs the step nothing.
  void suspect_checked(std::uint32_t body);
  /// Keeps the pose of a body that is about to be moved to a place where it can't stay.
  void remember_pose(std::uint32_t body, const solver::BodyPose& pose) { poses_before_.insert_or_assign(body, pose); }
  /// The pose that remember_pose() last kept for the body since the last step, or nullptr.
  const solver::BodyPose* pose_before(std::uint32_t body) const;
  bool remembers_poses() const { return !poses_before_.empty(); }
  bool is_suspect(std::uint32_t body) const { return suspected_[body] != 0; }
  /// The bodies to check, each once; callers must not rely on their order.
  std::span<const std::uint32_t> suspects() const { return suspects_; }
  void clear_suspects();

 private:
  std::size_t find(std::uint32_t body) const;  // its place, or the number of bodies

  static constexpr std::uint8_t to_check = 1;
  static constexpr std::uint8_t checked = 2;

  // See WorldState::check_members().
  static void check_members(QuarantineList& list) {
    auto& [bodies, disabled, suspected, poses_before, /**/ suspects, any_checked] = list;
    static_cast<void>(bodies);
  }

  jobs::CompactArray<Quarantined> bodies_;      // in order of id
  jobs::CompactArray<std::uint32_t> disabled_;  // in order
  jobs::CompactArray<std::uint8_t> suspected_;  // by body: 0 or one of these two
  jobs::CompactArray<std::uint32_t> suspects_;  // to check
  bool any_checked_ = false;
  std::map<std::uint32_t, solver::BodyPose> poses_before_;
};

}  // namespace atl
