// Bodies that only act on each other, under force laws, contact filters, modifiers and observers, of which some throw
// now and then: all forces that are added, and no others, change the momentum; what is thrown comes through; and the
// world goes on from whole substeps.

#include <atoll/contact_callbacks.h>
#include <atoll/forces.h>
#include <atoll/queries.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "consistency.h"
#include "finding.h"
#include "support/motion.h"
#include "target.h"

namespace {

using namespace atl;

// No exception of the standard library's or ours.
struct Enough {};

// Throws at its last call.
class Patience {
 public:
  explicit Patience(fuzz::Bytes& bytes) : left_(bytes.one_in(3) ? 1 + static_cast<int>(bytes.below(20)) : 0) {}
  void spend() {
    if (left_ > 0 && --left_ == 0) throw Enough{};
  }

 private:
  int left_;
};

// Bodies that overlap by little, so that they press on each other and are not torn apart.
void add_body(World& world, fuzz::Bytes& bytes, fuzz::Definitions& definitions) {
  const ConvexShape shape = definitions.convex();
  BodyDef def{.shape = std::visit([](const auto& solid) { return Shape(solid); }, shape),
              .position = definitions.vector(0.8),
              .orientation = definitions.orientation().normalized(),
              .material = definitions.material()};
  if (bytes.flag()) def.velocity = definitions.vector(2);
  const auto deepest = Queries(world).closest_point({shape, def.position, def.orientation}, 0);
  if (!deepest || deepest->distance > -0.02) world.add_body(def);
}

World world_of(fuzz::Bytes& bytes, fuzz::Definitions& definitions) {
  World world({.gravity = bytes.flag() ? Vector3(Vector3::Zero()) : definitions.vector(10),
               .settings = {.substeps = definitions.integer(1, 8)}});
  for (int left = 6; left > 0; --left) add_body(world, bytes, definitions);
  const std::vector<BodyId> ids = world.bodies();
  for (std::size_t i = 1; i < ids.size() && bytes.flag(); ++i) {
    const JointKind kind = definitions.joint_kind();
    if (std::holds_alternative<GearJoint>(kind)) continue;  // its housing is not there to take what it pushes with
    const Vector3 middle = 0.5 * (world.centre_of_mass(ids[i]) + world.centre_of_mass(ids[i - 1]));
    try {
      world.add_joint(joint_at(world, kind, ids[i - 1], ids[i], middle));
    } catch (const Error&) {
    }
  }
  return world;
}

// A force on one body, and one between two, at points off their middles. Both are the same at all times: those that
// change act on what touches something as they were when a substep began, on other bodies as they are in the middle.
class Law {
 public:
  Law(fuzz::Bytes& bytes, fuzz::Definitions& definitions, double dt)
      : patience_(bytes), dt_(dt), between_(definitions.vector(500)) {
    if (bytes.flag()) force_ = definitions.vector(500);
  }

  void operator()(Forces& forces) {
    fuzz::require(forces.time() >= last_ && forces.time() <= dt_, "a law is asked out of time");
    last_ = forces.time();
    const std::vector<BodyId> ids = forces.world().bodies();
    patience_.spend();
    const Vector3 middle = 0.5 * (forces.world().pose(ids[0]).position + forces.world().pose(ids.back()).position);
    forces.add_at(ids[0], between_, middle);
    forces.add_at(ids.back(), -between_, middle);
    forces.add(ids[0], force_);
    patience_.spend();
    fuzz::require_refused("a force that is not finite", [&] {
      forces.add(ids[0], {std::numeric_limits<double>::infinity(), 0, 0});
    });
  }

  const Vector3& force() const { return force_; }

 private:
  Patience patience_;
  double dt_;
  Vector3 between_;
  Vector3 force_ = Vector3::Zero();
  double last_ = 0;
};

void set_functions(World& world, fuzz::Bytes& bytes) {
  if (bytes.flag()) {
    world.set_contact_filter([patience = Patience(bytes)](const ContactCandidate& of) mutable {
      patience.spend();
      return (of.a.index + of.b.index) % 4 != 0;
    });
  }
  if (bytes.flag()) {
    world.set_contact_modifier(
        [patience = Patience(bytes), friction = bytes.within(0, 2)](ModifiableContact& contact) mutable {
          contact.friction = friction;
          contact.restitution = 0.5;
          contact.run_surface(contact.b, {friction, 0, 0.5});
          patience.spend();
        });
  }
  if (bytes.flag()) {
    world.add_step_observer([patience = Patience(bytes), left = 3](const World&, const StepReport&, double) mutable {
      patience.spend();
      fuzz::require(left > 0, "an observer is called that has had enough");
      return --left > 0;
    });
  }
}

double scale_of(const World& world) {
  double scale = 0;
  for (const BodyId id : world.bodies()) scale += world.mass(id) * (0.1 + world.velocity(id).norm());
  return scale;
}

// Bodies that continuous collision stopped in the last step, or that broke; none told if the step didn't come to its
// end.
using Lost = std::shared_ptr<std::optional<std::int64_t>>;

Lost watch(World& world) {
  auto lost = std::make_shared<std::optional<std::int64_t>>();
  world.add_step_observer([lost](const World&, const StepReport& report, double) {
    *lost = report.counts.stopped + report.quarantined;
    return true;
  });
  return lost;
}

void check_momentum(const World& world, const MotionReport& before, double scale, const Vector3& force, double time) {
  double mass = 0;
  for (const BodyId id : world.bodies()) mass += world.mass(id);
  const Vector3 pushed = time * (mass * world.gravity() + force);
  const double off = (test::motion_of(world).momentum - before.momentum - pushed).norm();
  scale += scale_of(world) + pushed.norm();
  fuzz::require(off <= 1e-5 * scale, "momentum is off by " + std::to_string(off) + " of " + std::to_string(scale) +
                                         " N s, of which forces give " + fuzz::text_of(pushed));
}

void step(World& world, const Lost& lost, fuzz::Bytes& bytes, fuzz::Definitions& definitions) {
  const double dt = bytes.flag() ? 1.0 / 64 : definitions.number(0.001, 0.05);
  Law law(bytes, definitions, dt);
  const MotionReport before = test::motion_of(world);
  const double scale = scale_of(world), from = world.time();
  const bool lawful = bytes.flag();
  lost->reset();
  try {
    lawful ? world.step(dt, std::ref(law)) : world.step(dt);
    fuzz::require(std::abs(world.time() - from - dt) < 1e-9, "a step takes another time");
  } catch (const Enough&) {
  }
  const double passed = world.time() - from;
  const double substeps = passed / dt * world.settings().substeps;
  fuzz::require(std::abs(substeps - std::round(substeps)) < 1e-6, "a step ends within a substep");
  fuzz::check_world(world);
  // A body that is stopped misses the forces of the rest of its step.
  if (*lost != 0) return;
  check_momentum(world, before, scale, lawful ? law.force() : Vector3(Vector3::Zero()), passed);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  atl::fuzz::Bytes bytes({data, size});
  atl::fuzz::Definitions definitions(bytes, atl::fuzz::Numbers::Usual);
  atl::World world = world_of(bytes, definitions);
  const Lost lost = watch(world);
  for (int left = 8; left > 0 && !bytes.empty(); --left) {
    if (bytes.one_in(3)) set_functions(world, bytes);
    step(world, lost, bytes, definitions);
    if (!world.quarantined().empty()) break;
  }
  return 0;
}
