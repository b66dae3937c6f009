#include <solver/colouring.h>

#include <algorithm>
#include <array>
#include <bit>

namespace atl::solver {
namespace {

constexpr std::uint8_t overflow = 64;

void clear_lanes(ContactBlock& block) {
  std::fill_n(block.first, block_lanes, 0);
  std::fill_n(block.second, block_lanes, 0);
  std::fill_n(block.slot, block_lanes, -1);
  block.write_first = 0;
  block.write_second = 0;
}

void set_lane(ContactBlock& block, std::size_t lane, const LocalContact& contact, std::uint32_t first_dynamic) {
  block.first[lane] = static_cast<std::int32_t>(contact.first);
  block.second[lane] = static_cast<std::int32_t>(contact.second);
  block.slot[lane] = static_cast<std::int32_t>(contact.slot);
  const auto bit = static_cast<std::uint8_t>(1u << lane);
  if (contact.first >= first_dynamic) block.write_first |= bit;
  if (contact.second >= first_dynamic) block.write_second |= bit;
}

}  // namespace

void Colouring::build(std::span<const LocalContact> contacts, std::uint32_t first_dynamic, std::uint32_t body_count,
                      std::vector<ContactBlock>& blocks) {
  used_.assign(body_count, 0);
  colour_of_.resize(contacts.size());
  std::array<std::size_t, overflow + 1> size = {};
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const LocalContact& contact = contacts[i];
    std::uint64_t taken = 0;
    if (contact.first >= first_dynamic) taken |= used_[contact.first];
    if (contact.second >= first_dynamic) taken |= used_[contact.second];
    const auto colour = static_cast<std::uint8_t>(std::countr_one(taken));
    colour_of_[i] = colour;
    ++size[colour];
    if (colour == overflow) continue;
    used_[contact.first] |= std::uint64_t{1} << colour;
    used_[contact.second] |= std::uint64_t{1} << colour;
  }

  colours_.clear();
  std::array<std::size_t, overflow + 1> first_block = {};
  std::size_t block_count = 0;
  for (std::size_t colour = 0; colour <= overflow; ++colour) {
    first_block[colour] = block_count;
    if (size[colour] == 0) continue;
    const bool serial = colour == overflow;
    const std::size_t count = serial ? size[colour] : (size[colour] + block_lanes - 1) / block_lanes;
    colours_.push_back({block_count, block_count + count, serial});
    block_count += count;
  }
  if (blocks.size() < block_count) blocks.resize(block_count);
  for (std::size_t b = 0; b < block_count; ++b) clear_lanes(blocks[b]);

  std::array<std::size_t, overflow + 1> placed = {};
  for (std::size_t i = 0; i < contacts.size(); ++i) {
    const std::uint8_t colour = colour_of_[i];
    const std::size_t place = placed[colour]++;
    const bool serial = colour == overflow;
    ContactBlock& block = blocks[first_block[colour] + (serial ? place : place / block_lanes)];
    set_lane(block, serial ? 0 : place % block_lanes, contacts[i], first_dynamic);
  }
}

}  // namespace atl::solver
