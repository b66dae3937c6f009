#pragma once

#include <jobs/arrays.h>
#include <solver/sweep/contact_block.h>
#include <solver/sweep/joint_block.h>

#include <cstdint>
#include <span>
#include <vector>

namespace atl::solver {

/// A contact as the kernels see it: bodies by index into SolverBodies.
struct LocalContact {
  std::uint32_t first;
  std::uint32_t second;
  std::uint32_t slot;
  std::uint8_t kind = 0;  ///< below contact_kinds; those alike share blocks, so that kernels can leave out more
};
inline constexpr std::size_t contact_kinds = 24;

/// A joint, by the group's own numbers of its bodies, with what decides which joints it can share a block with.
struct LocalJoint {
  std::uint32_t first;
  std::uint32_t second;
  std::uint32_t joint;
  bool point;
  std::uint8_t rows;
};

/// Blocks that may be solved at once: no two share a dynamic body.
struct Colour {
  std::size_t begin_block;
  std::size_t end_block;
  bool serial;  ///< not so: these must be solved one after another
};

/// Colours contacts or joints greedily, in order, each with the first colour that neither of its dynamic bodies has; an
/// island's colours are thus its own, whatever shares the group. Writes bodies, slots and masks of the blocks,
/// colour after colour; a block's other fields are left. A body with more than 64 contacts gets the rest of
/// them one by one.
///
/// Bodies below `first_dynamic` may appear in any number of contacts of a colour.
class Colouring {
 public:
  void build(std::span<const LocalContact> contacts, std::uint32_t first_dynamic, std::uint32_t body_count,
             std::vector<ContactBlock>& blocks);
  /// Within a colour joints with many rows come before those with few, so that few lanes are idle. Counts the blocks'
  /// rows, too.
  void build(std::span<const LocalJoint> joints, std::uint32_t first_dynamic, std::uint32_t body_count,
             std::vector<JointBlock>& blocks);

  std::span<const Colour> colours() const { return colours_; }
  std::size_t block_count() const { return colours_.empty() ? 0 : colours_.back().end_block; }

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(used_, colour_of_, lane_of_, next_lane_, colours_); }

 private:
  template <typename Constraint>
  void assign_colours(std::span<const Constraint> constraints, std::uint32_t first_dynamic, std::uint32_t body_count);
  template <typename Constraint>
  void assign_lanes(std::span<const Constraint> constraints);
  template <typename Constraint, typename Block>
  void fill(std::span<const Constraint> constraints, std::uint32_t first_dynamic, std::vector<Block>& blocks) const;

  std::vector<std::uint64_t> used_;  // by body: the colours of its contacts
  std::vector<std::uint8_t> colour_of_;
  std::size_t used_colours_ = 0;        // with what is left over, if anything is
  std::vector<std::uint32_t> lane_of_;  // counted through all blocks
  std::vector<std::uint32_t> next_lane_;
  std::vector<Colour> colours_;
};

}  // namespace atl::solver
