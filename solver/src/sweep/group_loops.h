#pragma once

#include <features/with_joints.h>
#include <solver/sweep/group_parts.h>

#include <atomic>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "sweep/group_setup.h"

namespace atl::solver {

// The largest of what several workers find, none of it negative: bit patterns are then in order of the numbers.
class LargestOf {
 public:
  void add(float value) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    std::uint32_t max = bits_.load(std::memory_order_relaxed);
    while (bits > max && !bits_.compare_exchange_weak(max, bits, std::memory_order_relaxed)) {
    }
  }
  float value() const { return std::bit_cast<float>(bits_.load(std::memory_order_relaxed)); }

 private:
  std::atomic<std::uint32_t> bits_{0};
};

// Loops over the parts of a group, each in chunks of a few microseconds. The function called gets the range of a chunk.
// `Executor` shares a loop out, or runs it: jobs::WorkerTeam, or a stand-in for one.
template <typename Executor>
class GroupLoops {
 public:
  GroupLoops(Executor& executor, const GroupParts& parts, const GroupSetup& setup)
      : executor_(executor), parts_(parts), setup_(setup) {}

  // Blocks of contacts: in any order, or colour by colour.
  template <typename Kernel>
  void each_contact_block(const Kernel& kernel) {
    executor_.parallel_for(setup_.block_count, contact_block_grain, kernel);
  }
  template <typename Kernel>
  void each_contact_colour(const Kernel& kernel) {
    each_colour(parts_.contacts.colours(), contact_colour_grain, kernel);
  }

  // Loop over blocks of swept joints; nothing runs if there are none. Functions that work on rows do so in double, row
  // by row, and get smaller chunks.
  template <typename Kernel>
  void each_joint_block(const Kernel& kernel) {
    if (setup_.sweeps_joints) executor_.parallel_for(parts_.joints.block_count(), joint_grain, kernel);
  }
  template <typename Kernel>
  void each_joint_row_block(const Kernel& kernel) {
    if (setup_.sweeps_joints) executor_.parallel_for(parts_.joints.block_count(), joint_row_grain, kernel);
  }
  template <typename Kernel>
  void each_joint_colour(const Kernel& kernel) {
    if (setup_.sweeps_joints) each_colour(parts_.joints.colours(), joint_grain, kernel);
  }

  // Dynamic bodies by their place in the group; or all by their numbers, in multiples of block_lanes.
  template <typename Kernel>
  void each_body(const Kernel& kernel) {
    executor_.parallel_for(setup_.body_ids.size(), body_grain, kernel);
  }
  template <typename Kernel>
  void each_body_block(const Kernel& kernel) {
    executor_.parallel_for(parts_.bodies.padded_count() / block_lanes, body_block_grain,
                           [&](std::size_t begin, std::size_t end) { kernel(begin * block_lanes, end * block_lanes); });
  }

  // Joints that hang together and are solved at once: phase(system).
  template <typename Phase>
  void each_system(const Phase& phase) {
    if (!with_joints || !setup_.joined) return;
    const std::span<const std::uint32_t> components = parts_.joined_motion.direct();
    executor_.parallel_for(components.size(), 1, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) phase(setup_.input.joint_systems->of(components[i]));
    });
  }

  static constexpr std::size_t body_grain = 128;

 private:
  static constexpr std::size_t contact_colour_grain = 8;
  static constexpr std::size_t contact_block_grain = 16;
  static constexpr std::size_t joint_grain = 24;
  static constexpr std::size_t joint_row_grain = 4;
  static constexpr std::size_t body_block_grain = 256 / block_lanes;

  template <typename Kernel>
  void each_colour(std::span<const Colour> colours, std::size_t grain, const Kernel& kernel) {
    for (const Colour& colour : colours) {
      if (colour.serial) {
        kernel(colour.begin_block, colour.end_block);
      } else {
        executor_.parallel_for(colour.end_block - colour.begin_block, grain, [&](std::size_t begin, std::size_t end) {
          kernel(colour.begin_block + begin, colour.begin_block + end);
        });
      }
    }
  }

  Executor& executor_;
  const GroupParts& parts_;
  const GroupSetup& setup_;
};

}  // namespace atl::solver
