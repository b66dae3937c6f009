#include <collision/continuous/ccd_candidates.h>
#include <jobs/assert.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace atl::collision {
namespace {

constexpr std::size_t grain = 16;  // of loops over fast bodies

// True if a box contains bounds, with room for the rounding of these.
bool holds(const Aabb& box, const Vector3& lower, const Vector3& upper) {
  const double slack = 1e-12 * (lower.cwiseAbs().maxCoeff() + upper.cwiseAbs().maxCoeff());
  bool inside = true;
  for (std::size_t i = 0; i < 3; ++i) {
    const auto axis = static_cast<Eigen::Index>(i);
    inside &= static_cast<double>(box.lower[i]) <= lower[axis] - slack &&
              upper[axis] + slack <= static_cast<double>(box.upper[i]);
  }
  return inside;
}

// True if a collider stayed inside its fat AABB during all of this step. The bounding spheres at both ends settle most
// cases, at less cost than the swept boxes.
bool stayed_inside(const CcdStep& step, const FastBody& fast, std::uint32_t collider, const Aabb& fat) {
  const ColliderTable& colliders = step.motions.colliders;
  const PoseView& poses = step.motions.poses;
  const Vector3& at = colliders.local[collider].position;
  const Vector3 start = fast.start.position + fast.start.orientation * at;
  const Vector3 end = poses[fast.body].position + poses[fast.body].orientation * at;
  const Vector3 around = Vector3::Constant(colliders.shape[collider].bounding_radius + fast.bulge);
  if (holds(fat, start.cwiseMin(end) - around, start.cwiseMax(end) + around)) return true;
  return fat.contains(step.swept_aabb(fast, collider, Vector3::Zero()));
}

// Replaces the AABBs that bodies left by ones that cover their motion, so that fast bodies find each other. All motions
// are as the solver made them, before any body is put back.
void update_left_aabbs(const CcdStep& step, Broadphase& broadphase, jobs::Arena& arena) {
  const ColliderTable& colliders = step.motions.colliders;
  // With few fast bodies, queries of the tree take less time than a pass over all contacts.
  constexpr std::size_t few = 16;
  const bool queried = few * step.fast.size() < step.active_bodies;
  arena.parallel_for(step.fast.size(), grain, [&](std::size_t begin, std::size_t end) {
    for (FastBody& fast : step.fast.subspan(begin, end - begin)) {
      if (!step.motions.is_finite(fast.body)) continue;
      fast.queried = queried;
      colliders.for_each_of(fast.body, [&](std::uint32_t collider) {
        if (fast.left_aabb || stayed_inside(step, fast, collider, broadphase.proxies().fat_box(collider))) return;
        fast.left_aabb = fast.queried = true;
      });
    }
  });
  for (const FastBody& fast : step.fast) {
    if (!fast.left_aabb) continue;
    colliders.for_each_of(fast.body, [&](std::uint32_t collider) {
      broadphase.move_box(collider, step.swept_aabb(fast, collider, Vector3::Zero()));
    });
  }
}

// True if two shapes provably don't meet in this step, by one of two bounds. Either they approach by so little that the
// speculative margin covers it; or they were found `apart`, in all parts, and have moved less than their gap since. The
// origins of shapes move on a straight line, plus a bulge where the body's turning carries an offset shape along an
// arc. A point that is farthest on a line from where it was is one of the ends, so both ends are tested.
bool stay_apart(const CcdStep& step, const Contact& contact, bool apart, const FastBody* first,
                const FastBody* second) {
  const ColliderTable& colliders = step.motions.colliders;
  const PoseView& poses = step.motions.poses;
  const auto shift_of = [](const FastBody* fast) -> Vector3 { return fast ? fast->shift : Vector3::Zero(); };
  const Vector3 shift = shift_of(second) - shift_of(first);
  const double size = contact.size;
  const double closing = shift.norm() + (first ? first->turn : 0) + (second ? second->turn : 0);
  const auto [own, other] = contact.pair;
  const auto presses_on = [&](const FastBody* fast, std::uint32_t met) {
    return fast && presses(*fast, !apart, colliders.shape[met].kind);
  };
  if (closing <= approach_share * size && !presses_on(first, other) && !presses_on(second, own)) return true;
  if (!apart || !(contact.gap > 0)) return false;

  const Eigen::Map<const Vector3> from(contact.apart_from.data());
  double bulge = 0;
  const auto at_start = [&](std::uint32_t collider, const FastBody* fast) -> Vector3 {
    if (!fast) return colliders.position(collider, poses);
    if (colliders.has_local_offset[collider]) bulge += fast->bulge;
    return fast->start.position + fast->start.orientation * colliders.local[collider].position;
  };
  const Vector3 start = at_start(other, second) - at_start(own, first) - from;
  const Vector3 end = colliders.position(other, poses) - colliders.position(own, poses) - from;
  const double moved = std::sqrt(std::max(start.squaredNorm(), end.squaredNorm())) + bulge;
  const double turned = step.turned[contact.body_first] + step.turned[contact.body_second] - contact.turned;
  const double left = static_cast<double>(contact.gap) - moved - static_cast<double>(contact.radius) * turned;
  return left > (ccd_gap_share + ccd_tolerance) * size;
}

}  // namespace

// Finds candidates among the contacts of fast bodies, touching or not, in a range of the order of contacts.
void CcdCandidates::find_by_contacts(const CcdStep& step, std::size_t begin, std::size_t end, Scratch& scratch) {
  const std::span<const Contact> contacts = step.cache.contacts;
  const ContactOrder& order = step.cache.order();
  const ColliderTable& colliders = step.motions.colliders;
  scratch.contacts.clear();
  const auto is_first = [&](std::size_t entry) {  // of a pair's parts
    return entry == 0 || order.pair_at(entry - 1) != order.pair_at(entry);
  };
  for (std::size_t entry = begin; entry < end; ++entry) {
    const Pair pair = order.pair_at(entry);
    const std::uint32_t first = step.places[colliders.body[pair.first]];
    const std::uint32_t second = step.places[colliders.body[pair.second]];
    if ((first | second) == 0 || !is_first(entry)) continue;
    // The first line of it is all that is read.
    __builtin_prefetch(&contacts[order[entry]]);
    scratch.contacts.push_back({static_cast<std::uint32_t>(entry), first, second});
  }
  const auto fast = [&](std::uint32_t place) { return place == 0 ? nullptr : &step.fast[place - 1]; };
  for (const FastContact& found : scratch.contacts) {
    const Contact& contact = contacts[order[found.entry]];
    if (step.passes(contact.pair)) continue;
    ATL_ASSERT(found.fast_first <= step.fast.size() && found.fast_second <= step.fast.size(), found.fast_first,
               found.fast_second, step.fast.size());
    const FastBody* first = fast(found.fast_first);
    const FastBody* second = fast(found.fast_second);
    bool apart = contact.count == 0;
    for (std::size_t part = found.entry + 1; part < order.size() && !is_first(part); ++part) {
      apart = apart && contacts[order[part]].count == 0;
    }
    if (stay_apart(step, contact, apart, first, second)) continue;
    const auto [of_first, of_second] = contact.pair;
    if (first) scratch.candidates.push_back({found.fast_first - 1, {of_first, of_second, apart}});
    if (second) scratch.candidates.push_back({found.fast_second - 1, {of_second, of_first, apart}});
  }
}

// Finds candidates near a fast body in the tree of boxes. A candidate that is fast itself gets the pair too.
void CcdCandidates::find_by_tree(const CcdStep& step, std::uint32_t number, const Broadphase& broadphase,
                                 Scratch& scratch) {
  query_candidates(step, step.fast[number], Vector3::Zero(), broadphase, scratch.pairs);
  for (const CcdPair& near : scratch.pairs) {
    scratch.candidates.push_back({number, near});
    const std::uint32_t place = step.places[step.motions.colliders.body[near.other]];
    if (place == 0 || step.fast[place - 1].queried) continue;
    scratch.candidates.push_back({place - 1, {near.other, near.own, near.apart}});
  }
}

void CcdCandidates::find(CcdStep& step, Broadphase& broadphase, jobs::Arena& arena) {
  broadphase.take_in(arena);
  update_left_aabbs(step, broadphase, arena);
  scratch_.for_each([](Scratch& of_worker) { of_worker.candidates.clear(); });
  const std::span<const FastBody> fast = step.fast;
  const bool by_contacts = std::any_of(fast.begin(), fast.end(), [](const FastBody& body) { return !body.queried; });
  constexpr std::size_t contact_grain = 512;
  arena.parallel_for(by_contacts ? step.cache.order().size() : 0, contact_grain,
                     [&](std::size_t begin, std::size_t end) { find_by_contacts(step, begin, end, scratch_.local()); });
  arena.parallel_for(fast.size(), grain, [&](std::size_t begin, std::size_t end) {
    for (std::size_t i = begin; i < end; ++i) {
      if (fast[i].queried) find_by_tree(step, static_cast<std::uint32_t>(i), broadphase, scratch_.local());
    }
  });
  if (step.decide != nullptr) decide(step);
  sort_by_body(fast.size());
}

// Leaves out what passes by the decisions that are made here.
void CcdCandidates::decide(CcdStep& step) {
  std::vector<Pair> undecided;
  std::vector<CcdPair> found;
  scratch_.for_each([&](const Scratch& of_worker) {
    for (const Candidate& near : of_worker.candidates) found.push_back(near.pair);
  });
  list_undecided(step, found, undecided);
  if (undecided.empty()) return;
  step.passing = (*step.decide)(undecided);
  ATL_ASSERT(std::is_sorted(step.passing.begin(), step.passing.end()), step.passing.size());
  scratch_.for_each([&](Scratch& of_worker) {
    std::erase_if(of_worker.candidates,
                  [&](const Candidate& near) { return step.passes(Pair::of(near.pair.own, near.pair.other)); });
  });
}

// Found in any order: each body will have its own in order.
void CcdCandidates::sort_by_body(std::size_t fast_bodies) {
  begin_.assign(fast_bodies + 1, 0);
  scratch_.for_each([this](const Scratch& of_worker) {
    for (const Candidate& near : of_worker.candidates) ++begin_[near.fast];
  });
  std::partial_sum(begin_.begin(), begin_.end(), begin_.begin());
  pairs_.resize(begin_.back());
  scratch_.for_each([this](const Scratch& of_worker) {
    for (const Candidate& near : of_worker.candidates) pairs_[--begin_[near.fast]] = near.pair;
  });
  ATL_ASSERT(begin_.front() == 0, begin_.front(), fast_bodies);
}

void CcdCandidates::list(std::size_t fast, std::vector<CcdPair>& pairs) const {
  ATL_ASSERT(fast + 1 < begin_.size() && begin_[fast] <= begin_[fast + 1], fast, begin_.size());
  pairs.assign(pairs_.begin() + begin_[fast], pairs_.begin() + begin_[fast + 1]);
  std::sort(pairs.begin(), pairs.end());
  const auto same = [](const CcdPair& a, const CcdPair& b) { return a.own == b.own && a.other == b.other; };
  pairs.erase(std::unique(pairs.begin(), pairs.end(), same), pairs.end());
}

void list_undecided(const CcdStep& step, std::span<const CcdPair> pairs, std::vector<Pair>& undecided) {
  for (const CcdPair& near : pairs) {
    const Pair pair = Pair::of(near.own, near.other);
    if (!step.cache.pairs.contains(pair)) undecided.push_back(pair);
  }
  std::sort(undecided.begin(), undecided.end());
  undecided.erase(std::unique(undecided.begin(), undecided.end()), undecided.end());
}

void query_candidates(const CcdStep& step, const FastBody& fast, const Vector3& aside, const Broadphase& broadphase,
                      std::vector<CcdPair>& pairs) {
  pairs.clear();
  step.motions.colliders.for_each_of(fast.body, [&](std::uint32_t own) {
    broadphase.proxies().query_box(step.swept_aabb(fast, own, aside), [&](std::uint32_t other) {
      if (!broadphase.filters().allowed(own, other) || step.passes(Pair::of(own, other))) return;
      pairs.push_back({own, other, !step.cache.touches(Pair::of(own, other))});
    });
  });
  std::sort(pairs.begin(), pairs.end());
}

}  // namespace atl::collision
