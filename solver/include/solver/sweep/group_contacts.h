#pragma once

#include <solver/direct/solve_input.h>
#include <solver/sweep/colouring.h>
#include <solver/sweep/contact_block.h>
#include <solver/sweep/group_bodies.h>
#include <solver/sweep/group_report.h>
#include <solver/sweep/kernels.h>

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace atl::solver {

/// The contacts of an island group in coloured blocks for the wide kernels. Memory is reused.
class GroupContacts {
 public:
  /// Collects and colours the contacts of a new group. Their blocks get bodies, slots and masks, and still need
  /// preparing.
  void collect(const SolveInput& input, const IslandGroup& group, const GroupBodies& bodies);

  bool empty() const { return contacts_.empty(); }
  bool friction() const { return friction_; }  ///< some contact has it
  bool restitution() const { return restitution_; }
  std::span<const Colour> colours() const { return colouring_.colours(); }
  std::size_t block_count() const { return colouring_.block_count(); }
  /// m: the least separation as the step begins, once blocks are prepared; 0 where nothing overlaps.
  float deepest() const;
  std::span<const ContactBlock> blocks() const { return std::span(blocks_).first(block_count()); }
  std::span<const PlanarBlock> planar_blocks() const { return planar_blocks_; }
  std::span<const SurfaceBlock> surface_blocks() const { return surface_blocks_; }

  /// The data of the contact kernels. `report` says what the group needs; with `splits` the impulses that push bodies
  /// apart are kept separate from those that last. `joined` may be empty: see ContactKernelData.
  ContactKernelData kernel_data(const SolveInput& input, const GroupReport& report, const SubstepConstants& constants,
                                bool splits, SolverBodies& bodies, std::span<const std::uint8_t> joined);
  /// Finds the rims of contacts as the step begins, and how their planes turn. Bodies are loaded, and kernel_data() has
  /// been asked for.
  void find_rims(const SolveInput& input, const SolverBodies& bodies, std::size_t begin, std::size_t end);
  void clear_impulses(const GroupReport& report);
  void clear_split_impulses();

  // Carried impulses after an impact: see FittingBlock.

  void begin_fitting(std::size_t body_count);
  /// Finds the bodies without joints whose velocity carried impulses change by more than `speed`, m/s. Returns whether
  /// there are any. `joined` as in ContactKernelData, or empty: contacts of joined bodies are in balance with what
  /// joints carry over, and keep theirs.
  bool find_struck(const SolverBodies& bodies, std::span<const std::uint8_t> joined, float speed, std::size_t begin,
                   std::size_t end);
  /// By index into SolverBodies: 1, or 2 if it is joined.
  const std::uint8_t* struck() const { return struck_.data(); }
  FittingBlock* fitting() { return fitting_.data(); }

  /// See jobs/arrays.h.
  auto arrays() const {
    return std::tie(contacts_, colouring_, blocks_, bounces_, surface_blocks_, split_blocks_, planar_blocks_,
                    turning_blocks_, rim_blocks_, struck_, fitting_, pushes_, step_impulses_);
  }

  /// Start recording the contacts that push in some substep, and their total impulse. It is recorded by block, and
  /// reported by slot in the end, see SolveInput::pushed.
  void begin_pushes();
  void record_pushes(std::size_t begin, std::size_t end);
  void add_impulses(std::size_t begin, std::size_t end);  ///< once a substep, when they are final
  void tell_pushes(float* by_slot) const;

 private:
  std::vector<LocalContact> contacts_;
  bool friction_ = false;
  bool restitution_ = false;
  Colouring colouring_;
  std::vector<ContactBlock> blocks_;
  // One a block, where the group needs them.
  std::vector<BounceBlock> bounces_;
  std::vector<SurfaceBlock> surface_blocks_;
  std::vector<SplitBlock> split_blocks_;
  std::vector<PlanarBlock> planar_blocks_;
  std::vector<TurningBlock> turning_blocks_;
  std::vector<RimBlock> rim_blocks_;
  std::vector<std::uint8_t> struck_;
  std::vector<FittingBlock> fitting_;
  std::vector<std::uint8_t> pushes_;                           // a bit a lane: it has pushed, or there is no contact
  std::vector<std::array<float, block_lanes>> step_impulses_;  // N s, along the normals in this step, but for bounces
};

/// Sets the surface effects of touching pairs in this step. Returns true if any is more than plain friction.
bool update_surface_contacts(const SolveInput& input, const IslandGroup& group);

}  // namespace atl::solver
