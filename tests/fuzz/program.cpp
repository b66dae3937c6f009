#include "program.h"

#include <atoll/contact_callbacks.h>
#include <atoll/forces.h>

#include <algorithm>
#include <array>
#include <iostream>
#include <span>
#include <utility>
#include <vector>

#include "consistency.h"
#include "finding.h"
#include "program_run.h"

namespace atl::fuzz {

std::string Run::call(const char* name, const Lockstep::Call& make) {
  std::string error = worlds.call(name, make);
  if (limits.trace) std::cerr << result.calls << ' ' << name << ' ' << error << '\n';
  result.refused += !error.empty();
  return error;
}

void Run::step(const char* name, const std::function<StepReport(World& world)>& take) {
  if (result.steps >= limits.steps) return;
  std::vector<StepReport> reports(worlds.worlds().size());
  const std::string error = worlds.step([&](World& world, std::size_t number) { reports[number] = take(world); });
  if (limits.trace) std::cerr << result.calls << ' ' << name << ' ' << error << '\n';
  if (!error.empty()) return;
  ++result.steps;
  result.quarantined += static_cast<int>(reports.front().quarantined);
  check_world(worlds.first());
  const std::vector<BodyId> there = worlds.first().bodies();
  const auto asleep = std::ranges::count_if(there, [&](BodyId id) { return worlds.first().is_asleep(id); });
  require(asleep == reports.front().counts.asleep, "a report counts other sleepers than there are");
  for (std::size_t i = 1; i < reports.size(); ++i) {
    check_same_reports(reports.front(), reports[i]);
    check_same_results(worlds.first(), worlds.worlds()[i]);
  }
}

double Run::time_step() {
  if (!bytes.one_in(8)) return 1.0 / 60;
  return definitions.has_normal_numbers() ? definitions.number(0.001, 0.05) : definitions.number(1e-4, 1);
}

BodyId Run::body() {
  if (bodies.empty()) return {};
  const std::uint32_t choice = bytes.byte();
  if (choice == 255) return {.index = bytes.byte(), .generation = bytes.byte()};
  if (choice >= 232) return bodies[choice % bodies.size()];
  const std::vector<BodyId> there = worlds.first().bodies();
  return there.empty() ? bodies.back() : there[choice % there.size()];
}

JointId Run::joint() {
  if (joints.empty()) return {};
  const std::uint32_t choice = bytes.byte();
  if (choice == 255) return {.index = bytes.byte(), .generation = bytes.byte()};
  if (choice >= 232) return joints[choice % joints.size()];
  const std::vector<JointId> there = worlds.first().joints();
  return there.empty() ? joints.back() : there[choice % there.size()];
}

namespace {

void add_body(Run& run) {
  const std::optional<BodyDef> def = chosen([&] { return run.definitions.body(); });
  if (!def || run.worlds.first().body_count() >= run.limits.bodies) return;
  BodyId id;
  const std::string error = run.call("add_body", [&](World& world, std::size_t) { id = world.add_body(*def); });
  if (!error.empty()) return;
  run.bodies.push_back(id);
  check_shape(def->shape);
}

void remove_body(Run& run) {
  const BodyId id = run.body();
  run.call("remove_body", [&](World& world, std::size_t) { world.remove_body(id); });
}

void add_joint(Run& run) {
  if (run.bodies.empty() || run.worlds.first().joint_count() >= run.limits.joints) return;
  const BodyId first = run.body();
  const BodyId second = run.body();
  const std::optional<JointDef> def = chosen([&] { return run.definitions.joint(run.worlds.first(), first, second); });
  if (!def) return;
  JointId id;
  const std::string error = run.call("add_joint", [&](World& world, std::size_t) { id = world.add_joint(*def); });
  if (error.empty()) run.joints.push_back(id);
}

void remove_joint(Run& run) {
  const JointId id = run.joint();
  run.call("remove_joint", [&](World& world, std::size_t) { world.remove_joint(id); });
}

void step(Run& run) {
  for (std::uint32_t left = 1 + run.bytes.below(3); left > 0 && run.result.steps < run.limits.steps; --left) {
    const double dt = run.time_step();
    run.step("step", [dt](World& world) { return world.step(dt); });
  }
}

void forced_step(Run& run) {
  if (run.result.steps >= run.limits.steps) return;
  const double strength = run.definitions.number(0, 200);
  const std::uint32_t mood = run.bytes.below(8);
  const double dt = run.time_step();
  const auto law = [&](Forces& forces) {
    if (mood == 1 && forces.time() > 0.5 * dt) throw Error("a law that gives up");
    const std::vector<BodyId> bodies = forces.world().bodies();
    for (const BodyId id : bodies) {
      if (mood == 2 && id.index % 2 == 0) continue;
      forces.add(id, -strength * forces.world().pose(id).position.normalized());
      if (mood == 3) forces.add_at(id, {0, 0, strength}, forces.world().pose(id).position + Vector3(0.1, 0, 0));
    }
  };
  run.step("forced_step", [&](World& world) { return world.step(dt, law); });
}

void move_body(Run& run) {
  const BodyId id = run.body();
  switch (run.bytes.below(7)) {
    case 0: {
      const Pose pose{run.definitions.vector(3), run.definitions.orientation()};
      run.call("set_pose", [&](World& world, std::size_t) { world.set_pose(id, pose); });
      break;
    }
    case 1: {
      const Vector3 linear = run.definitions.vector(8);
      const Vector3 angular = run.definitions.vector(8);
      run.call("set_velocity", [&](World& world, std::size_t) { world.set_velocity(id, linear, angular); });
      break;
    }
    case 2: {
      const Pose pose{run.definitions.vector(3), run.definitions.orientation()};
      const double dt = run.definitions.number(0.01, 0.1);
      run.call("move_to", [&](World& world, std::size_t) { world.move_to(id, pose, dt); });
      break;
    }
    case 3: {
      const Vector3 force = run.definitions.vector(1e4);
      const Vector3 torque = run.definitions.vector(1e3);
      run.call("apply_force", [&](World& world, std::size_t) { world.apply_force(id, force, torque); });
      break;
    }
    case 4: {
      const Vector3 impulse = run.definitions.vector(1e3);
      const Vector3 point = run.definitions.vector(2);
      run.call("apply_impulse", [&](World& world, std::size_t) { world.apply_impulse(id, impulse, point); });
      break;
    }
    case 5: {
      const Vector3 velocity = run.definitions.vector(3), spin = run.definitions.vector(3);
      run.call("set_surface_velocity",
               [&](World& world, std::size_t) { world.set_surface_velocity(id, velocity, spin); });
      break;
    }
    default:
      run.call("wake", [&](World& world, std::size_t) { world.wake(id); });
  }
}

void change_body(Run& run) {
  const BodyId id = run.body();
  switch (run.bytes.below(11)) {
    case 0: {
      const CollisionFilter filter = run.definitions.filter();
      run.call("set_filter", [&](World& world, std::size_t) { world.set_filter(id, filter); });
      break;
    }
    case 1: {
      const Material material = run.definitions.material();
      run.call("set_material", [&](World& world, std::size_t) { world.set_material(id, material); });
      break;
    }
    case 2: {
      const double mass = run.definitions.number(0.1, 1000);
      run.call("set_mass", [&](World& world, std::size_t) { world.set_mass(id, mass); });
      break;
    }
    case 3: {
      const double scale = run.definitions.number(-1, 2);
      run.call("set_gravity_scale", [&](World& world, std::size_t) { world.set_gravity_scale(id, scale); });
      break;
    }
    case 4: {
      const double linear = run.definitions.number(0, 2);
      const double angular = run.definitions.number(0, 2);
      run.call("set_damping", [&](World& world, std::size_t) { world.set_damping(id, linear, angular); });
      break;
    }
    case 5: {
      const World& world = run.worlds.first();
      const BodyType type = world.contains(id) ? world.type(id) : BodyType::Dynamic;
      const std::optional<Shape> shape = chosen([&] { return run.definitions.shape(type); });
      if (!shape) return;
      run.call("set_shape", [&](World& of, std::size_t) { of.set_shape(id, *shape); });
      break;
    }
    case 6: {
      const std::uint64_t data = run.bytes.bits<std::uint64_t>();
      run.call("set_user_data", [&](World& world, std::size_t) { world.set_user_data(id, data); });
      break;
    }
    case 7: {
      const std::string name = run.definitions.name();
      run.call("set_name", [&](World& world, std::size_t) { world.set_name(id, name); });
      run.worlds.first().find_body(name);
      break;
    }
    case 8: {
      const BodyId other = run.body();
      const bool enabled = run.bytes.flag();
      run.call("set_collision_enabled",
               [&](World& world, std::size_t) { world.set_collision_enabled(id, other, enabled); });
      break;
    }
    case 9:
      run.call("release", [&](World& world, std::size_t) { world.release(id); });
      break;
    default:
      run.call("refilter", [&](World& world, std::size_t) { world.refilter(id); });
  }
}

void change_joint(Run& run) {
  const JointId id = run.joint();
  const std::size_t coordinate = run.bytes.one_in(4) ? run.bytes.byte() : run.bytes.below(3);
  switch (run.bytes.below(6)) {
    case 0: {
      const JointKind kind = run.definitions.joint_kind();
      run.call("set_joint", [&](World& world, std::size_t) { world.set_joint(id, kind); });
      break;
    }
    case 1: {
      const JointAxis axis = run.definitions.axis(run.bytes.flag());
      run.call("set_joint_axis", [&](World& world, std::size_t) { world.set_joint_axis(id, axis, coordinate); });
      break;
    }
    case 2: {
      const double speed = run.definitions.number(-5, 5);
      run.call("set_motor_speed", [&](World& world, std::size_t) { world.set_motor_speed(id, speed, coordinate); });
      break;
    }
    case 3: {
      const double target = run.definitions.number(-1, 1);
      run.call("set_servo_target", [&](World& world, std::size_t) { world.set_servo_target(id, target, coordinate); });
      break;
    }
    case 4: {
      const bool enabled = run.bytes.flag();
      run.call("set_joint_enabled", [&](World& world, std::size_t) { world.set_joint_enabled(id, enabled); });
      break;
    }
    default:
      run.call("joint_axis", [&](World& world, std::size_t) { world.joint_axis(id, coordinate); });
  }
}

void change_settings(Run& run) {
  const Settings settings = run.definitions.settings(run.worlds.first().settings());
  run.call("set_settings", [&](World& world, std::size_t) {
    Settings its = settings;
    its.simd = world.settings().simd;
    world.set_settings(its);
  });
}

void change_gravity(Run& run) {
  if (run.bytes.one_in(4)) {
    const auto number = [&](double max) { return run.definitions.number(0, max); };
    const MaterialPair pair{1, 1 + run.bytes.below(2), number(1.2), number(1.2), number(1)};
    run.call("set_material_pair", [&](World& world, std::size_t) { world.set_material_pair(pair); });
  }
  const Vector3 gravity = run.bytes.flag() ? Vector3(0, 0, -9.81) : run.definitions.vector(12);
  run.call("set_gravity", [&](World& world, std::size_t) { world.set_gravity(gravity); });
}

// Functions without a memory of their own, that do the same in every world. Some give up, and some try what they must
// not do.
void set_functions(Run& run) {
  const std::uint32_t mood = run.bytes.below(8);
  if (run.bytes.flag()) {
    ContactFilter filter;
    if (mood != 0) {
      filter = [mood](const ContactCandidate& of) {
        if (mood == 1 && of.b.index % 7 == 6) throw Error("a filter that gives up");
        return (of.a.index + mood * of.b.index + of.child_b) % 5 != 0;
      };
    }
    run.call("set_contact_filter", [&](World& world, std::size_t) { world.set_contact_filter(filter); });
    return;
  }
  ContactModifier modifier;
  const double number = run.definitions.number(0, 1);
  if (mood != 0) {
    modifier = [mood, number](ModifiableContact& contact) {
      if (mood == 1 && contact.b.index % 7 == 6) throw Error("a modifier that gives up");
      const std::uint32_t which = (contact.a.index + contact.b.index + mood) % 6;
      if (which == 0) contact.friction = number;
      if (which == 1) contact.restitution = number;
      if (which == 2) contact.run_surface(contact.b, {number, 0.3, 0});
      if (which == 3) contact.points.back().enabled = false;
      if (which == 4) contact.enabled = contact.world.velocity(contact.b).z() < 0;
    };
  }
  run.call("set_contact_modifier", [&](World& world, std::size_t) { world.set_contact_modifier(modifier); });
}

void set_many(Run& run) {
  std::vector<BodyId> ids;
  for (std::uint32_t left = run.bytes.below(4); left > 0; --left) ids.push_back(run.body());
  const auto columns = static_cast<Eigen::Index>(ids.size() + (run.bytes.one_in(12) ? 1 : 0));
  Eigen::Matrix3Xd first(3, columns), second(3, columns);
  Eigen::Matrix4Xd turns(4, columns);
  for (Eigen::Index i = 0; i < columns; ++i) {
    first.col(i) = run.definitions.vector(3);
    second.col(i) = run.definitions.vector(3);
    turns.col(i) = run.definitions.orientation().coeffs();
  }
  switch (run.bytes.below(3)) {
    case 0:
      run.call("set_poses", [&](World& world, std::size_t) { world.set_poses(ids, first, turns); });
      break;
    case 1:
      run.call("set_velocities", [&](World& world, std::size_t) { world.set_velocities(ids, first, second); });
      break;
    default:
      run.call("apply_forces", [&](World& world, std::size_t) { world.apply_forces(ids, first, second); });
  }
}

void ask(Run& run) { check_queries(run.worlds.worlds(), run.definitions, run.bytes); }
void ask_for_some(Run& run) { check_filtered_queries(run.worlds.worlds(), run.definitions, run.bytes); }

// Another body like each that there is can be made.
void copy_body(Run& run) {
  const BodyId id = run.body();
  const World& world = run.worlds.first();
  if (!world.contains(id) || world.body_count() >= run.limits.bodies) return;
  const BodyDef def = world.definition(id);
  BodyId copy;
  const std::string error = run.call("add_body", [&](World& of, std::size_t) { copy = of.add_body(def); });
  require(error.empty(), "a body's own definition is refused: " + error);
  run.bodies.push_back(copy);
}

void move_worlds(Run& run) {
  for (World& world : run.worlds.worlds()) {
    World moved = std::move(world);
    world = std::move(moved);
  }
}

using Kind = void (*)(Run& run);
constexpr auto first_kinds_of_call =
    std::to_array<Kind>({add_body,       add_body,    add_body,     step,           step,
                         step,           step,        step,         forced_step,    remove_body,
                         add_joint,      add_joint,   remove_joint, move_body,      move_body,
                         change_body,    change_body, change_joint, change_joint,   change_settings,
                         change_gravity, save,        restore,      record,         set_functions,
                         set_many,       ask,         ask,          write_as_scene, copy_body,
                         move_worlds});
constexpr auto other_kinds_of_call = std::to_array<Kind>(
    {fall_asleep, change_often, ask_for_some, ask_for_some, keep_views, change_instructions, end_while_recording,
     use_files_that_cannot_be, overstep, make_a_world, switch_joints, define_what_cannot_be, break_and_release,
     change_target, redefine, switch_bodies, redefine_joint});

Kind choose_kind(Run& run) {
  constexpr std::size_t first = first_kinds_of_call.size(), other = other_kinds_of_call.size();
  const std::size_t choice = run.bytes.below(run.limits.first_kinds ? first : first + other);
  return choice < first ? first_kinds_of_call[choice] : other_kinds_of_call[choice - first];
}

}  // namespace

ProgramResult run_program(std::span<const std::uint8_t> input, Numbers numbers, std::span<const Variant> variants,
                          const ProgramLimits& limits) {
  Bytes bytes(input);
  Definitions definitions(bytes, numbers);
  Lockstep worlds(variants);
  Run run{bytes, definitions, worlds, limits};
  run.bodies.push_back(worlds.first().add_body({.type = BodyType::Static, .shape = HalfSpace{}}));
  for (std::size_t i = 1; i < variants.size(); ++i) {
    worlds.worlds()[i].add_body({.type = BodyType::Static, .shape = HalfSpace{}});
  }
  while (!bytes.empty() && run.result.calls < limits.calls) {
    choose_kind(run)(run);
    ++run.result.calls;
  }
  if (worlds.first().is_recording()) stop_recording(run, {});
  look_at_views(run);
  check_world(worlds.first());
  run.result.hash = worlds.first().state_hash();
  return run.result;
}

}  // namespace atl::fuzz
