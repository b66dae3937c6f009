// Two bodies, near each other more often than not: their manifolds are well formed and as deep as the audit says, the
// same wherever the pair is and whichever body came first, and what they do to each other makes no momentum or energy.

#include <atoll/contact_callbacks.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>
#include <string>
#include <variant>
#include <vector>

#include "consistency.h"
#include "motion.h"
#include "support/motion.h"
#include "target.h"

namespace {

using namespace atl;

constexpr double infinity = std::numeric_limits<double>::infinity();
using Pair = std::array<BodyDef, 2>;

double overlap_of(const Pair& pair) {
  const auto placed = [](const BodyDef& def) {
    return PlacedShape{def.type, def.shape, {def.position, def.orientation.normalized()}};
  };
  return overlap(placed(pair[0]), placed(pair[1]));
}

bool is_surface(const BodyDef& def) {
  return std::holds_alternative<TriangleMesh>(def.shape) || std::holds_alternative<HeightField>(def.shape);
}

Pair pair_of(fuzz::Bytes& bytes) {
  fuzz::Definitions definitions(bytes, fuzz::Numbers::Usual);
  Pair pair;
  for (BodyDef& def : pair) {
    def.type = &def == &pair[0] && bytes.one_in(4) ? BodyType::Static : BodyType::Dynamic;
    def.shape = definitions.shape(def.type);
    if (auto* compound = std::get_if<Compound>(&def.shape)) {
      for (CompoundChild& child : compound->children) child.filter.reset();
    }
    def.position = definitions.vector(0.8);
    def.orientation = definitions.orientation();
    def.material = definitions.material();
    if (def.type == BodyType::Static || bytes.flag()) continue;
    def.velocity = definitions.vector(2);
    def.angular_velocity = definitions.vector(2);
  }
  // The second goes along a line to where it is so deep in the first, if there is such a place.
  if (is_surface(pair[0]) || bytes.one_in(4)) return pair;
  const double depth = bytes.flag() ? 0 : bytes.within(-0.01, 0.05);
  const Vector3 from = pair[1].position;
  const Vector3 towards = Vector3(0, 0, 3) + definitions.vector(0.5);
  double lower = 0, upper = 1;
  for (int i = 0; i < 25; ++i) {
    const double middle = 0.5 * (lower + upper);
    pair[1].position = from + middle * towards;
    (overlap_of(pair) > depth ? lower : upper) = middle;
  }
  return pair;
}

struct Touching {
  std::size_t manifolds = 0;
  double depth = -infinity;                // m, of the deepest point
  Vector3 normal = Vector3::Zero();        // there, from the body given first to the other one
  std::vector<std::uint64_t> feature_ids;  // in order
};

void note(const ModifiableContact& contact, bool swapped, Touching& touching) {
  fuzz::require(!contact.points.empty() && contact.points.size() <= 4, "a manifold has too few points, or too many");
  fuzz::require(std::abs(contact.normal.norm() - 1) < 1e-5, "a manifold's normal is no unit vector");
  std::set<std::uint64_t> ids;
  for (const ModifiablePoint& point : contact.points) {
    fuzz::require_finite(point.position, "a manifold point");
    fuzz::require_finite(point.separation, "a manifold point's separation");
    fuzz::require(ids.insert(point.feature_id).second, "two points of a manifold are of the same features");
    touching.feature_ids.push_back(point.feature_id);
    if (-point.separation <= touching.depth) continue;
    touching.depth = -point.separation;
    touching.normal = swapped ? Vector3(-contact.normal) : contact.normal;
  }
  ++touching.manifolds;
}

Touching touch(Pair pair, const Vector3& shift, bool swapped) {
  World world({.gravity = Vector3::Zero()});
  for (BodyDef& def : pair) def.position += shift;
  if (swapped) std::swap(pair[0], pair[1]);
  for (const BodyDef& def : pair) world.add_body(def);
  Touching touching;
  world.set_contact_modifier([&](ModifiableContact& contact) {
    note(contact, swapped, touching);
    contact.enabled = false;
  });
  world.step(1e-6);
  return touching;
}

// m: of two directions that are about as good, either is taken, and deep within, another than the best may be found.
double tolerance(double depth) { return depth < 0.01 ? 1e-3 + 0.15 * depth : infinity; }

void require_alike(const Touching& a, const Touching& b, double tolerance, const char* what) {
  const double off = std::abs(a.depth - b.depth);
  fuzz::require(std::max(a.depth, b.depth) < 0 || off <= tolerance,
                std::string(what) + ": a depth of " + std::to_string(a.depth) + " m is " + std::to_string(b.depth));
}

void check_manifolds(const Pair& pair) {
  const Touching here = touch(pair, Vector3::Zero(), false);
  require_alike(here, touch(pair, {1024, -512, 2048}, false), 1e-6, "elsewhere");
  require_alike(here, touch(pair, Vector3::Zero(), true), tolerance(here.depth), "in the other order");
  if (is_surface(pair[0])) return;
  const double depth = overlap_of(pair);
  fuzz::require(depth < 1e-6 || here.manifolds > 0, "bodies that overlap have no manifold");
  if (depth < 1e-6) return;
  fuzz::require(here.depth > depth - 1e-3 && here.depth < depth + tolerance(depth),
                "bodies overlap by " + std::to_string(depth) + " m, and manifolds by " + std::to_string(here.depth));
}

void check_motion(const Pair& pair, fuzz::Bytes& bytes) {
  World world({.gravity = Vector3::Zero(), .settings = {.substeps = 1 + static_cast<int>(bytes.below(8))}});
  const bool is_free = pair[0].type == BodyType::Dynamic;
  double mass = 0;
  for (const BodyDef& def : pair) {
    const BodyId id = world.add_body(def);
    if (def.type == BodyType::Dynamic) mass += world.mass(id);
  }
  const double pushed = 0.5 * mass * std::pow(world.settings().contact_push_speed, 2);
  const double max = (1 + 1e-6) * test::motion_of(world).kinetic + (overlap_of(pair) > 0 ? pushed : 1e-9 * pushed);
  for (int i = 0; i < 6; ++i) {
    const MotionReport before = test::motion_of(world);
    fuzz::require(world.step(1.0 / 60).quarantined == 0, "a body breaks");
    fuzz::check_world(world);
    const MotionReport after = test::motion_of(world);
    if (is_free) {
      // Arms are those with which the step begins: they are off by how far a contact slides in it, or closes.
      const double speed = world.settings().contact_push_speed + std::sqrt((before.kinetic + after.kinetic) / mass);
      const double arm = 0.02 + 2 * speed / 60;
      fuzz::require_same_momentum(before, after, 1e-5 * mass * speed, arm * mass * speed);
    }
    fuzz::require(after.kinetic <= max,
                  "contacts make energy: " + std::to_string(after.kinetic) + " J, at most " + std::to_string(max));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  atl::fuzz::Bytes bytes({data, size});
  const Pair pair = pair_of(bytes);
  check_manifolds(pair);
  check_motion(pair, bytes);
  return 0;
}
