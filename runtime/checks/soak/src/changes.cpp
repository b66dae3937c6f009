#include "changes.h"

#include <atoll/contact_callbacks.h>
#include <atoll/queries.h>

#include <algorithm>
#include <array>
#include <string>

namespace atl::soak {
namespace {

constexpr std::size_t max_ropes = 8;
constexpr double rope_reach = 1.5;                                 // m, between what a rope may tie together
constexpr std::int64_t rope_stays = 200;                           // steps at most
constexpr std::int64_t settings_stay = 150, functions_stay = 400;  // steps

// Each is one that a user may choose, of the same problem.
struct Choice {
  const char* name;
  void (*set)(Settings& settings);
};
constexpr std::array choices = {
    Choice{"defaults", [](Settings&) {}},
    Choice{"8 substeps", [](Settings& s) { s.substeps = 8; }},
    Choice{"2 substeps of 2 iterations", [](Settings& s) { s.substeps = s.iterations = 2; }},
    Choice{"pyramid", [](Settings& s) { s.friction = FrictionModel::Pyramid; }},
    Choice{"split impulses",
           [](Settings& s) {
             s.stabilisation = Stabilisation::SplitImpulse;
             s.iterations = 4;
           }},
    Choice{"direct joints", [](Settings& s) { s.joint_solver = JointSolver::Direct; }},
    Choice{"iterative joints", [](Settings& s) { s.joint_solver = JointSolver::Iterative; }},
    Choice{"direct contacts", [](Settings& s) { s.contact_solver = ContactSolver::Direct; }},
    Choice{"iterative contacts", [](Settings& s) { s.contact_solver = ContactSolver::Iterative; }},
    Choice{"tolerance of 1 mm/s",
           [](Settings& s) {
             s.tolerance = 1e-3;
             s.iterations = 4;
           }},
    Choice{"no sleeping", [](Settings& s) { s.sleeping = false; }},
    Choice{"all features", [](Settings& s) { s.run_everything = true; }},
    Choice{"no warm starting",
           [](Settings& s) {
             s.warm_starting = false;
             s.iterations = 4;
           }},
    Choice{"contact problem kept", [](Settings& s) { s.keep_contact_problem = true; }},
};
static_assert(static_cast<std::int64_t>(choices.size()) * settings_stay == settings_cycle);

}  // namespace

void set_functions(World& world, bool set) {
  if (!set) {
    world.set_contact_filter({});
    world.set_contact_modifier({});
    return;
  }
  world.set_contact_filter([](const ContactCandidate& pair) {
    return pair.world.user_data(pair.a) != 7 || pair.world.user_data(pair.b) != 7;
  });
  world.set_contact_modifier([](ModifiableContact& contact) {
    if (contact.world.user_data(contact.b) == 3) contact.friction *= 0.5;
  });
}

Changes::Changes(Twin& twin, Population& population, Random& random)
    : twin_(twin), population_(population), random_(random) {}

void Changes::make(std::int64_t step, SoakTally& tally) {
  if (step % settings_stay == 0) change_settings();
  if (step % functions_stay == 0) {
    asks_functions_ = !asks_functions_;
    twin_.each([&](World& world) { set_functions(world, asks_functions_); });
  }
  tie(step, tally);
  ++tally.changes;
  switch (pick(random_, 8)) {
    case 0:
    case 1:
      return change_body();
    case 2:
      return move_body();
    case 3:
    case 4:
      return change_joint();
    case 5:
      return change_filters();
    default:
      --tally.changes;
  }
}

void Changes::change_body() {
  const Resident* thing = population_.draw();
  if (thing == nullptr) return;
  const std::size_t part = pick(random_, thing->bodies.size());
  const BodyId id = thing->bodies[part];
  const double value = random_.uniform(0, 1);
  switch (pick(random_, 8)) {
    case 0:
      return twin_.each([&](World& world) { world.set_material(id, {.friction = value, .restitution = 0.5 * value}); });
    case 1:
      return twin_.each([&](World& world) { world.set_mass(id, thing->masses[part] * (0.5 + value)); });
    case 2:
      // Within what it was: a ball of the least inner radius of a solid.
      if (thing->bodies.size() > 1) return;
      return twin_.each([&](World& world) { world.set_shape(id, Sphere{0.05 + 0.05 * value}); });
    case 3:
      return twin_.each([&](World& world) { world.set_name(id, "named " + std::to_string(value)); });
    case 4:
      return twin_.each([&](World& world) { world.set_user_data(id, static_cast<std::uint64_t>(8 * value)); });
    case 5:
      return twin_.each([&](World& world) { world.set_gravity_scale(id, 0.5 + value); });
    case 6:
      return twin_.each([&](World& world) { world.set_damping(id, value, value); });
    default:
      return twin_.each([&](World& world) { world.wake(id); });
  }
}

void Changes::move_body() {
  const std::optional<BodyId> id = population_.draw_body();
  if (!id) return;
  const Vector3 change = random_.in_box({3, 3, 3});
  const World& world = twin_.world();
  const double mass = world.mass(*id);
  const Vector3 place = world.centre_of_mass(*id), velocity = world.velocity(*id) + change;
  switch (pick(random_, 4)) {
    case 0:
      return twin_.each([&](World& of) { of.apply_impulse(*id, mass * change, place); });
    case 1:
      return twin_.each([&](World& of) { of.apply_force(*id, 20 * mass * change); });
    case 2:
      return twin_.each([&](World& of) { of.set_velocity(*id, velocity, change); });
    default:
      break;
  }
  // To another place, if it is alone and there is room.
  if (population_.name_of(*id) != std::string("solid")) return;
  const Vector3 target = place_above(pick(random_, place_count));
  if (!Queries(world).overlapping({.shape = Sphere{0.8}, .position = target}).empty()) return;
  twin_.each([&](World& of) { of.set_pose(*id, {target, of.pose(*id).orientation}); });
}

void Changes::change_joint() {
  const Resident* thing = population_.draw();
  if (thing == nullptr || thing->joints.empty()) return;
  const JointId id = thing->joints[pick(random_, thing->joints.size())];
  const World& world = twin_.world();
  const JointKind& kind = world.joint(id).kind;
  const double value = random_.uniform(-1, 1);
  const auto* hinge = std::get_if<HingeJoint>(&kind);
  if (hinge != nullptr && hinge->angle.motor) {
    if (hinge->angle.motor->servo) {
      return twin_.each([&](World& of) { of.set_servo_target(id, value); });
    }
    return twin_.each([&](World& of) { of.set_motor_speed(id, 3 * value); });
  }
  if (const auto* slider = std::get_if<SliderJoint>(&kind)) {
    JointAxis axis = slider->offset;
    axis.range.upper = 0.3 + 0.1 * value;
    return twin_.each([&](World& of) { of.set_joint_axis(id, axis); });
  }
  // Off for good: on again it would pull from wherever its bodies are by then.
  if (chance(random_, 8)) twin_.each([&](World& of) { of.set_joint_enabled(id, false); });
}

void Changes::change_filters() {
  const std::optional<BodyId> a = population_.draw_body(), b = population_.draw_body();
  if (!a || !b || a == b) return;
  const bool value = chance(random_, 2);
  switch (pick(random_, 3)) {
    case 0:
      // The ground's category is in all masks.
      return twin_.each(
          [&](World& world) { world.set_filter(*a, {.category = value ? 2u : 4u, .mask = value ? ~0u : ~4u}); });
    case 1:
      return twin_.each([&](World& world) { world.set_collision_enabled(*a, *b, value); });
    default:
      return twin_.each([&](World& world) { world.refilter(*a); });
  }
}

void Changes::change_settings() {
  choice_ = (choice_ + 1) % choices.size();
  const Vector3 gravity = Vector3(0, 0, -9.81) + random_.in_box({1, 1, 1});
  twin_.each([&](World& world) {
    Settings settings = {.sleeping = true, .contact_events = true, .simd = world.settings().simd};
    choices[choice_].set(settings);
    world.set_settings(settings);
    world.set_gravity(gravity);
  });
}

const char* Changes::settings_name() const { return choices[choice_].name; }

void Changes::tie(std::int64_t step, SoakTally& tally) {
  const World& world = twin_.world();
  for (const Rope& rope : ropes_) {
    if (rope.until == step && world.contains(rope.joint)) {
      twin_.each([&](World& of) { of.remove_joint(rope.joint); });
    }
  }
  std::erase_if(ropes_, [&](const Rope& rope) { return rope.until <= step || !world.contains(rope.joint); });
  if (ropes_.size() >= max_ropes) return;
  const std::optional<BodyId> id = population_.draw_body();
  if (!id) return;
  const Vector3 place = world.centre_of_mass(*id);
  for (const BodyId other : Queries(world).overlapping({.shape = Sphere{rope_reach}, .position = place},
                                                       {.static_bodies = false, .kinematic_bodies = false})) {
    const double length = (world.pose(other).position - world.pose(*id).position).norm();
    const bool tied = population_.name_of(other) == population_.name_of(*id);
    const bool locked = std::string(population_.name_of(other)) == "locked solid" ||
                        std::string(population_.name_of(*id)) == "locked solid";
    if (other == *id || tied || locked || !(length > 0.2)) continue;
    const JointDef rope = {.kind = DistanceJoint{{.range = {0, length + 0.05}}},
                           .first = *id,
                           .second = other,
                           .collide = true,
                           .break_force = random_.uniform(1e3, 1e5),
                           .name = "rope"};
    ropes_.push_back({twin_.each([&](World& of) { return of.add_joint(rope); }),
                      step + 1 + static_cast<std::int64_t>(pick(random_, rope_stays))});
    ++tally.tied;
    return;
  }
}

}  // namespace atl::soak
