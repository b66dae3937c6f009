#include <features/with_surfaces.h>
#include <jobs/arrays.h>
#include <jobs/assert.h>
#include <solver/constraints/contact_arm.h>
#include <solver/sweep/group_contacts.h>

#include <algorithm>
#include <array>

#include "integrate/rows3.h"

namespace atl::solver {
namespace {

// The plane of a contact turns with the face that it is of.
void find_plane_turns(const SolveInput& input, const SolverBodies& bodies, const ContactBlock& block,
                      TurningBlock& turning) {
  for (std::size_t lane = 0; lane < block_lanes; ++lane) {
    const ShapeRows& first = bodies.shape[static_cast<std::size_t>(block.first[lane])];
    const ShapeRows& second = bodies.shape[static_cast<std::size_t>(block.second[lane])];
    static constexpr float none[3] = {0, 0, 0};
    const float* turn = none;
    if (block.slot[lane] >= 0 && (first.kind > 0 || second.kind > 0)) {
      const collision::Contact& contact = input.contacts[block.slot[lane]];
      if (contact.on_face) turn = contact.reference_is_second ? second.half_turn : first.half_turn;
    }
    for (int k = 0; k < 3; ++k) turning.plane_turn[k][lane] = turn[k];
  }
}

}  // namespace

void GroupContacts::collect(const SolveInput& input, const IslandGroup& group, const GroupBodies& bodies) {
  contacts_.clear();
  friction_ = restitution_ = false;
  const std::span<const TouchingPair> touching = input.islands.contacts(group.begin, group.end);
  for (std::size_t i = 0; i < touching.size(); ++i) {
    // Slots are in no order: what is needed soon is asked of memory now.
    constexpr std::size_t ahead = 16;
    if (i + ahead < touching.size()) __builtin_prefetch(&input.manifolds[touching[i + ahead].slot]);
    const TouchingPair& pair = touching[i];
    const collision::ContactManifold& manifold = input.manifolds[pair.slot];
    const std::uint32_t first = bodies.local(input, group, pair.first);
    const std::uint32_t second = bodies.local(input, group, pair.second);
    const bool rubs = manifold.friction > 0;
    const bool bounces = manifold.restitution > 0;
    const bool rolls = input.bodies.ball[pair.first] || input.bodies.ball[pair.second];  // it has one point
    const int movable = first == 0 ? 1 : second == 0 ? 2 : 0;
    const int kind = 8 * movable + 4 * rolls + 2 * rubs + bounces;
    ATL_ASSERT(std::max(first, second) >= bodies.first_dynamic(), pair.slot, first, second, bodies.first_dynamic());
    ATL_ASSERT(std::max(first, second) < bodies.count(), pair.slot, first, second, bodies.count());
    contacts_.push_back({first, second, pair.slot, static_cast<std::uint8_t>(kind)});
    friction_ |= rubs;
    restitution_ |= bounces;
  }
  colouring_.build(contacts_, bodies.first_dynamic(), bodies.count(), blocks_);
}

ContactKernelData GroupContacts::kernel_data(const SolveInput& input, const GroupReport& report,
                                             const SubstepConstants& constants, bool splits, SolverBodies& bodies,
                                             std::span<const std::uint8_t> joined) {
  const auto one_a_block = [&](auto& blocks, bool needed) {
    if (needed && blocks.size() < block_count()) blocks.resize(block_count());
    return needed ? blocks.data() : nullptr;
  };
  return {.bodies = bodies,
          .blocks = blocks_.data(),
          .bounces = one_a_block(bounces_, report.restitution),
          .manifolds = input.manifolds,
          .constants = constants,
          .surface_blocks = one_a_block(surface_blocks_, report.surfaces),
          .surface_contacts = input.surface_contacts,
          .rises = input.rises,
          .split_blocks = one_a_block(split_blocks_, splits),
          .planar_blocks = one_a_block(planar_blocks_, !bodies.locks.empty()),
          .turning_blocks = one_a_block(turning_blocks_, !bodies.shape.empty()),
          .rim_blocks = one_a_block(rim_blocks_, bodies.roll),
          .joined = joined.empty() ? nullptr : joined.data(),
          .leaves_out = !input.settings.everything};
}

void GroupContacts::find_rims(const SolveInput& input, const SolverBodies& bodies, std::size_t begin, std::size_t end) {
  for (std::size_t b = begin; b < end; ++b) {
    ContactBlock& block = blocks_[b];
    block.traits.rims = false;
    if (!bodies.shape.empty()) find_plane_turns(input, bodies, block, turning_blocks_[b]);
    if (!bodies.roll) continue;
    constexpr std::size_t ahead = 2;
    if (b + ahead < end) {
      for (const std::int32_t slot : blocks_[b + ahead].slot) {
        __builtin_prefetch(&input.contacts[slot < 0 ? 0 : slot]);
        __builtin_prefetch(&input.manifolds[slot < 0 ? 0 : slot]);
      }
    }
    const auto find = [&](std::size_t lane, bool second) {
      const std::int32_t slot = block.slot[lane];
      const std::int32_t local = second ? block.second[lane] : block.first[lane];
      ContactArm arm;
      if (slot >= 0 && bodies.shape[static_cast<std::size_t>(local)].kind == 2) {
        const collision::Contact& contact = input.contacts[slot];
        const collision::ContactManifold& manifold = input.manifolds[slot];
        arm = contact_arm(input.bodies, second ? contact.body_second : contact.body_first, *input.colliders,
                          second ? contact.pair.second : contact.pair.first,
                          get3(second ? manifold.anchor_second : manifold.anchor_first),
                          (second ? -1 : 1) * get3(manifold.normal));
      }
      block.traits.rims |= !arm.rim.isZero(0);
      auto& rim = second ? rim_blocks_[b].rim_second : rim_blocks_[b].rim_first;
      auto& axis = second ? rim_blocks_[b].axis_second : rim_blocks_[b].axis_first;
      for (int k = 0; k < 3; ++k) {
        rim[k][lane] = static_cast<float>(arm.rim[k]);
        axis[k][lane] = static_cast<float>(arm.axis[k]);
      }
    };
    for (std::size_t lane = 0; lane < block_lanes; ++lane) {
      find(lane, false);
      find(lane, true);
    }
  }
}

float GroupContacts::deepest() const {
  std::array<float, block_lanes> min = {};  // which compilers make lanes of
  for (const ContactBlock& block : std::span(blocks_).first(block_count())) {
    for (std::size_t i = 0; i < block.traits.points; ++i) {
      for (std::size_t lane = 0; lane < block_lanes; ++lane) {
        min[lane] = std::min(min[lane], block.start_separation[i][lane]);
      }
    }
  }
  return *std::min_element(min.begin(), min.end());
}

void GroupContacts::begin_pushes() {
  pushes_.assign(block_count(), 0);
  step_impulses_.assign(block_count(), {});
  for (std::size_t b = 0; b < block_count(); ++b) {
    for (unsigned lane = 0; lane < block_lanes; ++lane) pushes_[b] |= (blocks_[b].slot[lane] < 0 ? 1u : 0u) << lane;
  }
}

// Blocks whose contacts have all pushed are passed over: those that rest have from the first substep on.
void GroupContacts::record_pushes(std::size_t begin, std::size_t end) {
  static_assert(block_lanes == 8, "a bit a lane");
  for (std::size_t b = begin; b < end; ++b) {
    if (pushes_[b] == 0xff) continue;
    const ContactBlock& block = blocks_[b];
    for (unsigned lane = 0; lane < block_lanes; ++lane) {
      float max = 0;
      for (std::size_t i = 0; i < block.traits.points; ++i) max = std::max(max, block.normal_impulse[i][lane]);
      pushes_[b] |= (max > 0 ? 1u : 0u) << lane;
    }
  }
}

void GroupContacts::add_impulses(std::size_t begin, std::size_t end) {
  ATL_ASSERT(step_impulses_.size() == block_count() && end <= block_count(), step_impulses_.size(), block_count(), end);
  for (std::size_t b = begin; b < end; ++b) {
    const ContactBlock& block = blocks_[b];
    for (std::size_t i = 0; i < block.traits.points; ++i) {
      for (std::size_t lane = 0; lane < block_lanes; ++lane) step_impulses_[b][lane] += block.normal_impulse[i][lane];
    }
  }
}

void GroupContacts::tell_pushes(float* by_slot) const {
  for (std::size_t b = 0; b < block_count(); ++b) {
    const bool bounces = blocks_[b].traits.bounces;
    for (std::size_t lane = 0; lane < block_lanes; ++lane) {
      const std::int32_t slot = blocks_[b].slot[lane];
      if (slot < 0) continue;
      float spent = 0;
      for (std::size_t i = 0; bounces && i < blocks_[b].traits.points; ++i) spent += bounces_[b].spent[i][lane];
      const bool pushes = spent > 0 || (pushes_[b] >> lane & 1u) != 0;
      ATL_ASSERT(!(spent < 0) && !(step_impulses_[b][lane] < 0), slot, spent, step_impulses_[b][lane]);
      by_slot[slot] = pushes ? step_impulses_[b][lane] + spent : not_pushed;
    }
  }
}

void GroupContacts::clear_impulses(const GroupReport& report) {
  for (std::size_t b = 0; b < block_count(); ++b) {
    ContactBlock& block = blocks_[b];
    for (auto& point : block.normal_impulse) std::fill_n(point, block_lanes, 0.0f);
    for (auto& axis : block.friction_impulse) std::fill_n(axis, block_lanes, 0.0f);
    std::fill_n(block.torsional_impulse, block_lanes, 0.0f);
    if (!report.surfaces) continue;
    for (auto& axis : surface_blocks_[b].rolling_impulse) std::fill_n(axis, block_lanes, 0.0f);
  }
}

void GroupContacts::clear_split_impulses() { std::fill_n(split_blocks_.begin(), block_count(), SplitBlock{}); }

void GroupContacts::begin_fitting(std::size_t body_count) {
  struck_.resize(body_count);
  if (fitting_.size() < block_count()) fitting_.resize(block_count());
}

bool GroupContacts::find_struck(const SolverBodies& bodies, std::span<const std::uint8_t> joined, float speed,
                                std::size_t begin, std::size_t end) {
  unsigned any = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const float* const now = bodies.velocity[i].linear;
    const float* const free = bodies.free_velocity[i].linear;
    const float x = now[0] - free[0], y = now[1] - free[1], z = now[2] - free[2];
    const bool is_joined = i < joined.size() && joined[i] != 0;
    struck_[i] = is_joined ? 2 : x * x + y * y + z * z > speed * speed;
    any |= struck_[i] & 1u;
  }
  return any != 0;
}

bool update_surface_contacts(const SolveInput& input, const IslandGroup& group) {
  if (!with_surfaces || input.surface_contacts == nullptr) return false;
  bool any = input.settings.everything;
  for (const TouchingPair& pair : input.islands.contacts(group.begin, group.end)) {
    any |= update_surface_contact(pair, input.bodies, input.manifolds[pair.slot], 0.5 * input.dt,
                                  input.added_slip(pair.slot), input.surface_contacts[pair.slot]);
    any |= input.rises != nullptr && input.rises[pair.slot] != 0;
  }
  return any;
}

}  // namespace atl::solver
