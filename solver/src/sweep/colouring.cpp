#include <jobs/assert.h>
#include <solver/sweep/colouring.h>

#include <algorithm>
#include <bit>

namespace atl::solver {
namespace {

constexpr std::size_t overflow = 64;

// Within a colour constraints are in order of their sort key, and blocks begin anew where another kind does.
constexpr std::size_t sort_key(const LocalContact& contact) { return contact.kind; }
constexpr std::size_t sort_key_count(const LocalContact*) { return contact_kinds; }
constexpr bool starts_kind(const LocalContact*, std::size_t) { return false; }

constexpr std::size_t max_rows = 6;
// A point alone; a point with rows, from many to few; rows alone.
constexpr std::size_t sort_key(const LocalJoint& joint) {
  const std::size_t rows = joint.rows;
  if (joint.point) return rows == 0 ? 0 : 1 + max_rows - rows;
  return 1 + max_rows + max_rows - rows;
}
constexpr std::size_t sort_key_count(const LocalJoint*) { return 2 + 2 * max_rows; }
constexpr bool starts_kind(const LocalJoint*, std::size_t key) { return key == 1 || key == 1 + max_rows; }

constexpr std::size_t round_up(std::size_t lane) { return (lane + block_lanes - 1) / block_lanes * block_lanes; }

auto& label_of(ContactBlock& block) { return block.slot; }
auto& label_of(JointBlock& block) { return block.joint; }
std::uint32_t label_of(const LocalContact& contact) { return contact.slot; }
std::uint32_t label_of(const LocalJoint& joint) { return joint.joint; }

template <typename Block>
void clear_lanes(Block& block) {
  std::fill_n(block.first, block_lanes, 0);
  std::fill_n(block.second, block_lanes, 0);
  std::fill_n(label_of(block), block_lanes, -1);
  block.write_first = 0;
  block.write_second = 0;
}

template <typename Block, typename Constraint>
void set_lane(Block& block, std::size_t lane, const Constraint& constraint, std::uint32_t first_dynamic) {
  block.first[lane] = static_cast<std::int32_t>(constraint.first);
  block.second[lane] = static_cast<std::int32_t>(constraint.second);
  label_of(block)[lane] = static_cast<std::int32_t>(label_of(constraint));
  const auto bit = static_cast<std::uint8_t>(1u << lane);
  if (constraint.first >= first_dynamic) block.write_first |= bit;
  if (constraint.second >= first_dynamic) block.write_second |= bit;
}

void set_movable(ContactBlock& block) {
  std::int32_t first = 0, second = 0;
  block.contacts = 0;
  for (std::size_t lane = 0; lane < block_lanes; ++lane) {
    first |= block.first[lane];
    second |= block.second[lane];
    if (block.slot[lane] >= 0) ++block.contacts;
  }
  block.movable = first == 0 ? MovableSides::Second : second == 0 ? MovableSides::First : MovableSides::Both;
}

// No two lanes of a colour write the same body, or the order of writes would decide.
template <typename Block>
void check_colours(std::span<const Colour> colours, const std::vector<Block>& blocks, std::uint32_t body_count) {
  std::vector<std::size_t> colour_of_last_write(body_count, colours.size());
  for (std::size_t colour = 0; colour < colours.size(); ++colour) {
    if (colours[colour].serial) continue;
    for (std::size_t b = colours[colour].begin_block; b < colours[colour].end_block; ++b) {
      for (std::size_t lane = 0; lane < block_lanes; ++lane) {
        const auto mark = [&](std::int32_t body, unsigned writes) {
          if ((writes >> lane & 1u) == 0) return;
          ATL_ASSERT(body > 0 && static_cast<std::uint32_t>(body) < body_count, body, body_count, b, lane);
          std::size_t& last = colour_of_last_write[static_cast<std::size_t>(body)];
          ATL_ASSERT(last != colour, body, colour, b, lane);
          last = colour;
        };
        mark(blocks[b].first[lane], blocks[b].write_first);
        mark(blocks[b].second[lane], blocks[b].write_second);
      }
    }
  }
}

}  // namespace

template <typename Constraint>
void Colouring::assign_colours(std::span<const Constraint> constraints, std::uint32_t first_dynamic,
                               std::uint32_t body_count) {
  used_.assign(body_count, 0);
  colour_of_.resize(constraints.size());
  used_colours_ = 0;
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    const Constraint& constraint = constraints[i];
    ATL_ASSERT(constraint.first < body_count && constraint.second < body_count, constraint.first, constraint.second,
               body_count);
    ATL_ASSERT(constraint.first != constraint.second, constraint.first);
    std::uint64_t taken = 0;
    if (constraint.first >= first_dynamic) taken |= used_[constraint.first];
    if (constraint.second >= first_dynamic) taken |= used_[constraint.second];
    const auto colour = static_cast<std::uint8_t>(std::countr_one(taken));
    colour_of_[i] = colour;
    used_colours_ = std::max(used_colours_, colour + std::size_t{1});
    if (colour == overflow) continue;
    used_[constraint.first] |= std::uint64_t{1} << colour;
    used_[constraint.second] |= std::uint64_t{1} << colour;
  }
}

// Orders constraints by colour, then sort key, then as given. Those left over get a block each.
template <typename Constraint>
void Colouring::assign_lanes(std::span<const Constraint> constraints) {
  constexpr const Constraint* kind = nullptr;
  constexpr std::size_t keys = sort_key_count(kind);
  next_lane_.assign(used_colours_ * keys, 0);
  const auto place = [&](std::size_t i) -> std::uint32_t& {
    return next_lane_[colour_of_[i] * keys + sort_key(constraints[i])];
  };
  for (std::size_t i = 0; i < constraints.size(); ++i) ++place(i);

  colours_.clear();
  std::size_t lane = 0;
  for (std::size_t colour = 0; colour < used_colours_; ++colour) {
    const bool serial = colour == overflow;
    const std::size_t begin = lane;
    for (std::size_t key = 0; key < keys; ++key) {
      if (starts_kind(kind, key)) lane = round_up(lane);
      std::uint32_t& next = next_lane_[colour * keys + key];
      const std::size_t count = next;
      next = static_cast<std::uint32_t>(lane);
      lane += serial ? count * block_lanes : count;
    }
    lane = round_up(lane);
    if (lane > begin) colours_.push_back({begin / block_lanes, lane / block_lanes, serial});
  }

  lane_of_.resize(constraints.size());
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    std::uint32_t& next = place(i);
    lane_of_[i] = next;
    next += colour_of_[i] == overflow ? static_cast<std::uint32_t>(block_lanes) : 1;
  }
}

template <typename Constraint, typename Block>
void Colouring::fill(std::span<const Constraint> constraints, std::uint32_t first_dynamic,
                     std::vector<Block>& blocks) const {
  if (blocks.size() < block_count()) blocks.resize(block_count());
  for (std::size_t b = 0; b < block_count(); ++b) clear_lanes(blocks[b]);
  for (std::size_t i = 0; i < constraints.size(); ++i) {
    ATL_ASSERT(lane_of_[i] / block_lanes < block_count(), lane_of_[i], block_count());
    set_lane(blocks[lane_of_[i] / block_lanes], lane_of_[i] % block_lanes, constraints[i], first_dynamic);
  }
  if constexpr (jobs::with_asserts) check_colours(colours(), blocks, static_cast<std::uint32_t>(used_.size()));
}

void Colouring::build(std::span<const LocalContact> contacts, std::uint32_t first_dynamic, std::uint32_t body_count,
                      std::vector<ContactBlock>& blocks) {
  assign_colours(contacts, first_dynamic, body_count);
  assign_lanes(contacts);
  fill(contacts, first_dynamic, blocks);
  for (std::size_t b = 0; b < block_count(); ++b) set_movable(blocks[b]);
}

void Colouring::build(std::span<const LocalJoint> joints, std::uint32_t first_dynamic, std::uint32_t body_count,
                      std::vector<JointBlock>& blocks) {
  assign_colours(joints, first_dynamic, body_count);
  assign_lanes(joints);
  fill(joints, first_dynamic, blocks);
  for (std::size_t b = 0; b < block_count(); ++b) {
    blocks[b].rows = 0;
    blocks[b].point = 0;
  }
  for (std::size_t i = 0; i < joints.size(); ++i) {
    JointBlock& block = blocks[lane_of_[i] / block_lanes];
    block.rows = std::max(block.rows, joints[i].rows);
    block.point = joints[i].point ? 1 : 0;
  }
  std::uint32_t row = 0;
  for (std::size_t b = 0; b < block_count(); ++b) {
    blocks[b].first_row = row;
    row += blocks[b].rows;
  }
}

}  // namespace atl::solver
