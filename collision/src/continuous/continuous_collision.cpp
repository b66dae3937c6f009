#include <collision/continuous/continuous_collision.h>
#include <collision/narrowphase/distance.h>
#include <collision/shapes/shape.h>
#include <jobs/assert.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace atl::collision {
namespace {

struct Core {
  Shape shape;
  Vector3 centre = Vector3::Zero();  // of it, in the frame of the whole shape
};

Core core_of(const Shape& shape) {
  const double off = core_share * shape.inner_radius;
  switch (shape.kind) {
    case ShapeKind::Capsule:
      return {Shape::capsule(shape.radius - off, shape.half_height)};
    case ShapeKind::Box:
      return {Shape::box(shape.half_extents - Vector3::Constant(off))};
    case ShapeKind::Cylinder:
      return {Shape::cylinder(shape.radius - off, shape.half_height - off)};
    case ShapeKind::Ellipsoid:
      return {Shape::ellipsoid((1 - core_share) * shape.half_extents)};
    default:
      return {Shape::sphere(shape.inner_radius - off), mass_properties(shape).centre};
  }
}

// True if no point of the shape is farther from its core than the core is deep, except the corners of boxes.
bool has_even_core(ShapeKind kind) { return kind <= ShapeKind::Cylinder; }

// True if a core that starts at the other's surface ends off it, and its centre has met it nowhere. The nearest places
// at both ends don't tell: in a room they may be two walls.
bool stays_outside(const Shape& core, const Motion& motion, const Shape& other, const Motion& other_motion,
                   double tolerance) {
  constexpr double anywhere = std::numeric_limits<double>::infinity();
  Distance after;
  find_distance(core, motion.at(1), other, other_motion.at(1), anywhere, after);
  SweepHit hit;
  return after.distance > 0 && !sweep(Shape::sphere(0), motion, other, other_motion, {0, tolerance}, 1, hit);
}

// The plane of a hit, and how far (m) beyond it the core ends.
CcdSupport support_of(const SweepHit& hit, const Motion& other, const Shape& core, const Pose& end, double tolerance) {
  const Pose other_end = other.at(1);
  const Vector3 point = other_end.position + other_end.orientation * (other.start.orientation.conjugate() *
                                                                      (hit.point - other.start.position));
  ATL_ASSERT(std::abs(hit.normal.squaredNorm() - 1) < 1e-6, hit.normal.norm(), hit.separation);
  const double reach = reach_along(core, end.orientation.conjugate() * hit.normal);
  return {hit.normal, hit.normal.dot(end.position - point) + reach, tolerance};
}

// The way (m) that a body goes on with what it hits, which nothing stops. A wall that comes would else pass over it,
// and one that goes away would be out of its reach in the next step.
Vector3 way_carried(const SweepHit& hit, const Motion& other) {
  const Pose then = other.at(hit.t), end = other.at(1);
  const Vector3 goes =
      end.position + end.orientation * (then.orientation.conjugate() * (hit.point - then.position)) - hit.point;
  return hit.normal.dot(goes) * hit.normal;
}

// The way that takes a core off all that it is held by: before one plane after the other until none is passed. A core
// that started overlapping would be let through.
std::optional<Vector3> way_aside(std::span<const CcdSupport> held) {
  constexpr int rounds = 20;
  Vector3 aside = Vector3::Zero();
  for (int round = 0; round < rounds; ++round) {
    bool passed = false;
    for (const CcdSupport& surface : held) {
      const double excess = surface.excess + surface.normal.dot(aside);
      if (excess <= -0.25 * surface.tolerance) continue;
      aside -= (excess + 0.5 * surface.tolerance) * surface.normal;
      passed = true;
    }
    if (!passed) return aside;
  }
  return std::nullopt;
}

void check_stops(std::span<const CcdStop> stops, std::size_t fast_bodies) {
  std::size_t covered = 0;
  for (const CcdStop& stop : stops) {
    covered += stop.bodies.size();
    ATL_ASSERT(stop.t >= 0 && stop.t <= 1, stop.bodies.front().body, stop.t);
    ATL_ASSERT(stop.aside.allFinite() && !stop.undecided, stop.bodies.front().body, stop.aside.norm());
  }
  ATL_ASSERT(covered == fast_bodies, covered, fast_bodies);
}

}  // namespace

Aabb CcdStep::swept_aabb(const FastBody& body, std::uint32_t collider, const Vector3& aside) const {
  const Bounds start = motions.bounds_at(collider, placed(body.start, motions.colliders.local[collider]));
  const Bounds end = motions.bounds_now(collider);
  const Vector3 bulge = Vector3::Constant(body.bulge);
  return Aabb::around(start.lower.cwiseMin(end.lower + aside) - bulge, start.upper.cwiseMax(end.upper + aside) + bulge);
}

Motion CcdStep::motion_of(std::uint32_t collider, const Vector3& centre, const Vector3& aside) const {
  const std::uint32_t body = motions.colliders.body[collider];
  Pose local = motions.colliders.local[collider];
  local.position += local.orientation * centre;
  Pose end = placed(motions.poses[body], local);
  end.position += aside;
  const FastBody* moved = find_fast(body);
  if (!moved) return Motion::still(end);
  // The body's centre of mass, about which it turns, in the shape's frame.
  const Vector3 pivot = -(local.orientation.conjugate() * local.position);
  return Motion::between(placed(moved->start, local), end, pivot);
}

// The time at which the body first meets something, as part of the step, up to `first`, if its end pose is shifted by
// `aside`. A shape that its core touches from the start is added to its supports, and doesn't stop it. A core that
// starts inside something that nothing moves only has to keep its centre out of it.
double ContinuousCollision::first_hit(const CcdStep& step, const FastBody& fast, const Vector3& aside, double first,
                                      Scratch& scratch) {
  const ColliderTable& colliders = step.motions.colliders;
  const bool joined = fast.assembly != FastBody::alone;
  colliders.for_each_of(fast.body, [&](std::uint32_t collider) {
    const Shape& shape = colliders.shape[collider];
    find_approaching(step, fast, aside, collider, scratch.pairs, scratch.approaching);
    if (scratch.approaching.empty()) return;
    const Motion motion = step.motion_of(collider, Vector3::Zero(), aside);
    const bool only_deep = joined && !fast.always_swept && has_even_core(shape.kind);
    for (const Approach& approach : scratch.approaching) {
      const std::uint32_t other = approach.other;
      const double tolerance = ccd_tolerance * approach.size;
      const Motion other_motion = step.motion_of(other, Vector3::Zero(), Vector3::Zero());
      const SweepGoal goal{ccd_gap_share * approach.size, tolerance};
      const std::uint32_t other_body = colliders.body[other];
      const bool goes_on = step.dynamic[other_body] == 0 && step.find_fast(other_body) != nullptr;
      const auto stop_at = [&](const SweepHit& at) {
        if (!(at.t < first)) return;
        first = at.t;
        scratch.carried = goes_on ? way_carried(at, other_motion) : Vector3::Zero();
      };
      SweepHit hit;
      if (approach.apart && !only_deep) {
        if (!sweep(shape, motion, colliders.shape[other], other_motion, goal, first, hit)) continue;
        if (!hit.started_overlapping && hit.t > 0) {
          stop_at(hit);
          continue;
        }
      }
      if (approach.passes_core) continue;
      // Returns whether it starts in something, which doesn't hold it; other triangles do.
      const auto sweep_core = [&](const Core& core) {
        const Motion core_motion = core.centre.isZero(0) ? motion : step.motion_of(collider, core.centre, aside);
        bool overlaps = false;
        sweep_each(
            core.shape, core_motion, colliders.shape[other], other_motion, {0, tolerance}, first,
            [&](const SweepHit& core_hit) {
              overlaps |= core_hit.started_overlapping;
              if (core_hit.started_overlapping) return first;
              if (core_hit.t > 0) {
                stop_at(core_hit);
                return first;
              }
              // Bodies of an assembly are shifted together, and stay as they are to each other.
              if (joined && step.assembly_of(other_body) == fast.assembly) return first;
              if (stays_outside(core.shape, core_motion, colliders.shape[other], other_motion, tolerance)) return first;
              scratch.supports.push_back(support_of(core_hit, other_motion, core.shape, core_motion.at(1), tolerance));
              return first;
            });
        return overlaps;
      };
      const double before = first;
      const Core core = core_of(shape);
      const bool overlaps = sweep_core(core);
      if (approach.both_stop && !only_deep) {
        // The other's stop holds for this one too, which would end beyond it otherwise.
        const Core other_core = core_of(colliders.shape[other]);
        const Motion other_core_motion = step.motion_of(other, other_core.centre, Vector3::Zero());
        const bool meets = sweep(other_core.shape, other_core_motion, shape, motion, {0, tolerance}, first, hit);
        if (meets && !hit.started_overlapping && hit.t > 0) stop_at(hit);
      }
      if (overlaps && step.dynamic[other_body] == 0) sweep_core({Shape::sphere(0), core.centre});
      if (first < before && approach.apart && only_deep) {
        SweepHit surface;
        sweep(shape, motion, colliders.shape[other], other_motion, goal, first, surface);
        if (surface.t > 0) stop_at(surface);
      }
    }
  });
  return first;
}

// The part of their motion after which the bodies first meet something of the pairs that are listed for each.
double ContinuousCollision::meet(const CcdStep& step, const CcdStop& stop, const Vector3& aside, ListPairs list_pairs,
                                 Scratch& scratch) {
  scratch.supports.clear();
  scratch.carried.setZero();
  double first = 1;
  for (const FastBody& fast : stop.bodies) {
    list_pairs(fast);
    first = first_hit(step, fast, aside, first, scratch);
  }
  return first;
}

// Ends the way of a body that has met what goes on where neither that passes over it, nor others that go on as well.
void ContinuousCollision::go_on_with_walls(const CcdStep& step, CcdStop& stop, ListPairs list_pairs, Scratch& scratch) {
  constexpr int rounds = 5;
  const FastBody& fast = stop.bodies.front();
  const Pose end = step.motions.poses[fast.body];
  for (int round = 0; round < rounds && stop.t < 1; ++round) {
    const Pose shifted{end.position + stop.aside, end.orientation};
    const Pose held = Motion::between(fast.start, shifted, Vector3::Zero()).at(stop.t);
    stop.aside = held.position + scratch.carried - end.position;
    stop.t = meet(step, stop, stop.aside, list_pairs, scratch);
  }
  stop.t = 1;
}

// Finds how far a fast body, or the fast bodies of an assembly, may go in this step. A shape that the core touches from
// the start would hold the body where it is, for good, if other bodies press on it. Such a body goes all its way,
// shifted aside just enough to keep the core from going through the surfaces that it touches. An assembly is shifted as
// one.
void ContinuousCollision::find_stop(CcdStep& step, const Broadphase& broadphase, CcdStop& stop, Scratch& scratch,
                                    bool decides) const {
  stop.undecided = false;
  const auto list_near = [&](const FastBody& fast) {
    candidates_.list(static_cast<std::size_t>(&fast - step.fast.data()), scratch.pairs);
  };
  stop.t = meet(step, stop, Vector3::Zero(), list_near, scratch);
  if (scratch.supports.empty()) {
    const FastBody& fast = stop.bodies.front();
    const bool may_shift = fast.assembly == FastBody::alone && fast.aside_limit >= 0;
    if (may_shift && !scratch.carried.isZero(0)) go_on_with_walls(step, stop, list_near, scratch);
    return;
  }
  stop.t = 0;
  const std::optional<Vector3> aside = way_aside(scratch.supports);
  if (!aside || !(aside->norm() <= stop.bodies.front().aside_limit)) return;
  if (step.decide != nullptr) {
    std::vector<Pair> undecided;
    for (const FastBody& fast : stop.bodies) {
      query_candidates(step, fast, *aside, broadphase, scratch.pairs);
      list_undecided(step, scratch.pairs, undecided);
    }
    stop.undecided = !undecided.empty() && !decides;
    if (stop.undecided) return;
    if (!undecided.empty()) step.passing = (*step.decide)(undecided);
  }
  const auto list_aside = [&](const FastBody& fast) {
    query_candidates(step, fast, *aside, broadphase, scratch.pairs);
  };
  const double t = meet(step, stop, *aside, list_aside, scratch);
  const bool kept_off = std::all_of(scratch.supports.begin(), scratch.supports.end(),
                                    [](const CcdSupport& support) { return support.excess <= 0; });
  if (!kept_off) return;
  stop.t = t;
  stop.aside = *aside;
}

void ContinuousCollision::list_groups(std::span<const FastBody> fast) {
  stops_.clear();
  for (std::size_t i = 0; i < fast.size();) {
    std::size_t end = i + 1;
    while (fast[i].assembly != FastBody::alone && end < fast.size() && fast[end].assembly == fast[i].assembly) ++end;
    stops_.push_back({fast.subspan(i, end - i)});
    i = end;
  }
}

std::span<const CcdStop> ContinuousCollision::find_stops(CcdStep step, Broadphase& broadphase, jobs::Arena& arena) {
  places_.resize(step.motions.radius.size());
  for (std::size_t i = 0; i < step.fast.size(); ++i) {
    const FastBody& fast = step.fast[i];
    ATL_ASSERT(fast.body < places_.size() && places_[fast.body] == 0, i, fast.body, places_.size());
    ATL_ASSERT(i == 0 || step.fast[i - 1].assembly <= fast.assembly, i, fast.body, fast.assembly);
    places_[fast.body] = static_cast<std::uint32_t>(i + 1);
  }
  step.places = places_;
  candidates_.find(step, broadphase, arena);
  list_groups(step.fast);
  arena.parallel_for(stops_.size(), 1, [&](std::size_t begin, std::size_t end) {
    for (CcdStop& stop : std::span(stops_).subspan(begin, end - begin)) {
      const auto sound = [&](const FastBody& fast) { return step.motions.is_finite(fast.body); };
      const bool all_sound = std::all_of(stop.bodies.begin(), stop.bodies.end(), sound);
      if (all_sound && stop.bodies.front().stops) find_stop(step, broadphase, stop, scratch_.local(), false);
    }
  });
  for (CcdStop& stop : stops_) {
    if (stop.undecided) find_stop(step, broadphase, stop, scratch_.local(), true);
  }
  if constexpr (jobs::with_asserts) check_stops(stops_, step.fast.size());
  for (const FastBody& fast : step.fast) places_[fast.body] = 0;
  return stops_;
}

}  // namespace atl::collision
