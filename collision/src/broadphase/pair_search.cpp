#include <collision/broadphase/pair_search.h>
#include <jobs/assert.h>

#include <algorithm>

namespace atl::collision {
namespace {

// Fixed shapes that wait are looked at one by one by so many shapes, before a tree is built of them. To build one into
// the tree takes 0.25 us, to look at it 1.5 ns, of a million: what is spent in all is at most twice the least.
constexpr std::size_t max_looks = 128;

using Kind = Proxies::Kind;

// The pairs that a shape has to report, known or not.
struct PartnerQuery {
  const Proxies& proxies;
  const CollisionFilters& filters;
  const MoveBuffer& moves;
  bool moving_ask;  // in pairs with a fixed shape the moving one is asked, whichever moved

  void find(std::uint32_t shape, std::vector<Pair>& found) const {
    const auto report = [&](std::uint32_t other) {
      if (filters.allowed(shape, other)) found.push_back(Pair::of(shape, other));
    };
    const auto consider = [&](std::uint32_t other) {
      // If both shapes moved, only the lower one reports the pair. This shape moved.
      if (other > shape || !moves.contains(other)) report(other);
    };
    const Kind kind = proxies.kind(shape);
    if (kind == Kind::Free || meets_nothing(filters.filter(shape))) return;
    if (kind == Kind::HalfSpace) {
      const Plane& plane = proxies.plane(shape);
      proxies.moving().query_if([&plane](const Aabb& box) { return touches(plane, box); }, consider);
      return;
    }
    const Aabb& fat = proxies.fat_box(shape);
    const bool moved = moves.contains(shape);
    if (moved) proxies.moving().query(fat, consider);
    if (kind == Kind::Fixed) return;
    if (moving_ask) {
      proxies.fixed().query(fat, [&](std::uint32_t other) {
        if (moved || moves.contains(other)) report(other);
      });
    } else {
      proxies.fixed().query(fat, consider);
    }
    if (!moved) return;
    for (const Proxies::HalfSpace& half_space : proxies.half_spaces()) {
      if (touches(half_space.plane, fat)) consider(half_space.shape);
    }
  }
};

// Tells which side queries for the pairs of fixed and moving shapes: the moving ones, if more fixed shapes were added
// or moved than there are moving ones.
bool moving_shapes_ask(const Proxies& proxies, std::span<const std::uint32_t> moved) {
  if (moved.size() <= proxies.moving().size()) return false;
  const auto is_fixed = [&](std::uint32_t shape) { return proxies.kind(shape) == Kind::Fixed; };
  const auto fixed = static_cast<std::size_t>(std::count_if(moved.begin(), moved.end(), is_fixed));
  return fixed > proxies.moving().size();
}

// Counts the asking shapes that may meet fixed ones.
std::size_t count_askers_of_fixed(const Proxies& proxies, const CollisionFilters& filters,
                                  std::span<const std::uint32_t> askers) {
  return static_cast<std::size_t>(std::count_if(askers.begin(), askers.end(), [&](std::uint32_t shape) {
    return proxies.kind(shape) == Kind::Moving && !meets_nothing(filters.filter(shape));
  }));
}

// Each is there once, and has a shape that moves.
void check_new_pairs(std::span<const Pair> pairs, const Proxies& proxies) {
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto [first, second] = pairs[i];
    ATL_ASSERT(i == 0 || pairs[i - 1] < pairs[i], i, first, second);
    ATL_ASSERT(proxies.contains(first) && proxies.contains(second), first, second);
    ATL_ASSERT(proxies.kind(first) == Kind::Moving || proxies.kind(second) == Kind::Moving, first, second);
  }
}

}  // namespace

// Half-spaces that moved, and all moving shapes.
void PairSearch::list_askers(const Proxies& proxies, std::span<const std::uint32_t> moved) {
  askers_.clear();
  for (const std::uint32_t shape : moved) {
    if (proxies.is_half_space(shape)) askers_.push_back(shape);
  }
  proxies.moving().for_each([this](std::uint32_t shape) { askers_.push_back(shape); });
}

std::span<const Pair> PairSearch::find(Proxies& proxies, const CollisionFilters& filters, const MoveBuffer& moves,
                                       const PairSet& known, std::size_t& looks, jobs::Arena& arena) {
  new_pairs_.clear();
  // Every pair has a moving shape.
  if (proxies.moving().size() == 0) return new_pairs_;
  proxies.renew_moving(arena);
  const PartnerQuery query{proxies, filters, moves, moving_shapes_ask(proxies, moves.shapes())};
  if (query.moving_ask) list_askers(proxies, moves.shapes());
  const std::span<const std::uint32_t> askers = query.moving_ask ? askers_ : moves.shapes();
  if (proxies.fixed().is_behind()) {
    looks += count_askers_of_fixed(proxies, filters, askers);
    if (looks > max_looks) {
      proxies.take_in_fixed(arena);
      looks = 0;
    }
  }
  proxies.rebuild_fixed_if_worn(arena);

  constexpr std::size_t grain = 64;
  const std::size_t chunks = jobs::Arena::chunk_count(askers.size(), grain);
  if (found_.size() < chunks) found_.resize(chunks);
  arena.parallel_for(askers.size(), grain, [&](std::size_t begin, std::size_t end) {
    std::vector<Pair>& found = found_[begin / grain];
    found.clear();
    for (std::size_t i = begin; i < end; ++i) query.find(askers[i], found);
    known.drop_contained(found, 0);
  });

  for (std::size_t chunk = 0; chunk < chunks; ++chunk) {
    new_pairs_.insert(new_pairs_.end(), found_[chunk].begin(), found_[chunk].end());
  }
  // Each pair is found once, so that sorted pairs depend neither on the order of moves nor on the trees' shape.
  sort_pairs(new_pairs_, sort_scratch_);
  if constexpr (jobs::with_asserts) check_new_pairs(new_pairs_, proxies);
  return new_pairs_;
}

}  // namespace atl::collision
