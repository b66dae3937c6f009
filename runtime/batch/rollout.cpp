// Rollouts of a batch: all is checked, then each world makes its run in a row.

#include <atoll/error.h>
#include <atoll/rollout.h>
#include <jobs/assert.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <string>
#include <type_traits>

#include "columns.h"

namespace atl {
namespace {

// The largest target that World::set_servo_target() takes.
constexpr double largest_target = 1e15;

[[noreturn]] void fail(const std::string& found, const std::string& expected) {
  throw Error("Batch: found " + found + "; expected " + expected);
}

std::size_t width_of(const Control& control) {
  const auto width = [](const auto& of) -> std::size_t {
    if constexpr (requires { of.axis; }) return of.axis ? 1 : 3;
    return 1;
  };
  return std::visit(width, control);
}

std::string name_of(const Control& control) {
  const auto name = [](const auto& of) -> std::string {
    using Of = std::decay_t<decltype(of)>;
    if constexpr (requires { of.joint; }) {
      return std::string(std::is_same_v<Of, MotorSpeed> ? "speed" : "target") + " of coordinate " +
             std::to_string(of.coordinate) + " of joint " + std::to_string(of.joint);
    } else {
      return std::string(std::is_same_v<Of, BodyForce> ? "force" : "torque") + " on body " + std::to_string(of.body);
    }
  };
  return std::visit(name, control);
}

std::string name_of(const Rollout& rollout, std::size_t number) {
  return "controls[" + std::to_string(number) + "], the " + name_of(rollout.controls[number]);
}

void check_sizes(const Rollout& rollout, std::size_t values, std::size_t worlds, std::size_t width) {
  if (!(rollout.dt >= 1e-12 && rollout.dt <= 1))
    fail("dt of " + std::to_string(rollout.dt) + " s", "one in [1e-12, 1]");
  if (rollout.count < 1) fail("a count of " + std::to_string(rollout.count), "1 or more");
  const std::size_t of_world = rollout.steps * width;
  if (values != of_world && values != worlds * of_world) {
    fail(std::to_string(values) + " values", std::to_string(worlds) + " worlds x " + std::to_string(rollout.steps) +
                                                 " control steps x " + std::to_string(width) + " numbers = " +
                                                 std::to_string(worlds * of_world) + ", or those of one for all alike");
  }
  if (rollout.reset && !rollout.start.empty()) fail("both reset and start", "one of them, or neither");
  if (rollout.start.size() > 1 && rollout.start.size() != worlds) {
    fail(std::to_string(rollout.start.size()) + " snapshots to start at",
         "one for all, or " + std::to_string(worlds) + ", one a world");
  }
}

// Throws unless all controls name joints and bodies of the scene.
void check_names(const Batch& batch, const Rollout& rollout) {
  for (std::size_t i = 0; i < rollout.controls.size(); ++i) {
    const auto check = [&](const auto& of) {
      if constexpr (requires { of.joint; }) {
        const std::size_t joints = batch.joints().size();
        if (of.joint >= joints) fail(name_of(rollout, i), "a joint below " + std::to_string(joints));
      } else {
        const std::size_t bodies = batch.bodies().size();
        if (of.body >= bodies) fail(name_of(rollout, i), "a body below " + std::to_string(bodies));
      }
    };
    std::visit(check, rollout.controls[i]);
  }
}

bool is_usable(const Control& control, double value) {
  return std::isfinite(value) && (!std::holds_alternative<ServoTarget>(control) || std::abs(value) <= largest_target);
}

// `values` of one world; `of_world` says which that is in messages.
void check_values(const Rollout& rollout, const double* values, const std::string& of_world) {
  for (std::size_t step = 0; step < rollout.steps; ++step) {
    const double* const first = values;
    for (std::size_t i = 0; i < rollout.controls.size(); ++i) {
      const Control& control = rollout.controls[i];
      for (const double* const end = values + width_of(control); values != end; ++values) {
        if (is_usable(control, *values)) continue;
        std::ostringstream found;
        found << *values << " at values" << of_world << "[" << step << "][" << values - first << "], for "
              << name_of(rollout, i);
        fail(found.str(), std::isfinite(*values) ? "a number of at most 1e15 in size" : "a finite number");
      }
    }
  }
}

// Nothing where the joint has no such coordinate, or is gone.
const JointAxis* axis_along(const World& world, JointId joint, std::size_t coordinate) {
  try {
    return &world.joint_axis(joint, coordinate);
  } catch (const Error&) {
    return nullptr;
  }
}

// Throws unless a world has the joints and bodies that the controls act on.
void check_controls(const Batch& batch, const Rollout& rollout, const World& world, const std::string& where) {
  for (std::size_t i = 0; i < rollout.controls.size(); ++i) {
    const auto check = [&](const auto& of) {
      if constexpr (requires { of.joint; }) {
        constexpr bool as_servo = std::is_same_v<std::decay_t<decltype(of)>, ServoTarget>;
        const JointAxis* axis = axis_along(world, batch.joints()[of.joint], of.coordinate);
        if (axis != nullptr && axis->motor && (!as_servo || axis->motor->servo)) return;
        const std::string what = as_servo ? "servo" : "motor";
        fail(name_of(rollout, i) + ", without a " + what + " there" + where, "one, see World::set_joint_axis");
      } else {
        const BodyId body = batch.bodies()[of.body];
        if (!world.contains(body)) fail(name_of(rollout, i) + ", which was removed" + where, "a body that is there");
        if (world.type(body) != BodyType::Dynamic) {
          fail(name_of(rollout, i) + ", which isn't dynamic" + where, "a dynamic body");
        }
      }
    };
    std::visit(check, rollout.controls[i]);
  }
}

// Throws unless a world has the bodies that the scene's constant forces act on.
void check_constant_forces(const Batch& batch, const World& world, const std::string& where) {
  for (std::size_t i = 0; i < batch.bodies().size(); ++i) {
    if (batch.scene().bodies[i].force.isZero(0) || world.contains(batch.bodies()[i])) continue;
    fail("body " + std::to_string(i) + ", which the scene pushes, removed" + where, "a body that is there");
  }
}

void check_places(const Batch& batch, std::span<const std::size_t> places) {
  for (const std::size_t place : places) {
    if (place >= batch.size()) fail("place " + std::to_string(place), "one below " + std::to_string(batch.size()));
  }
}

// The values of all worlds, which are checked.
struct Values {
  std::span<const double> all;
  std::size_t width = 0;    // of a control step
  std::size_t a_world = 0;  // 0 if those of one are for all
  std::vector<std::size_t> numbers;

  Values(Batch& batch, const Rollout& rollout, std::span<const double> values, std::span<const std::size_t> places)
      : all(values), width(width_of(rollout.controls)) {
    const std::size_t worlds = places.empty() ? batch.size() : places.size();
    check_sizes(rollout, values.size(), worlds, width);
    check_names(batch, rollout);
    check_places(batch, places);
    numbers = numbers_of(batch, places);
    const bool alike = values.size() == rollout.steps * width;
    a_world = alike ? 0 : rollout.steps * width;
    batch.for_each(
        [&](World&, std::size_t place) {
          check_values(rollout, of(place), alike ? "" : "[" + std::to_string(numbers[place]) + "]");
        },
        places);
  }

  const double* of(std::size_t place) const { return all.data() + numbers[place] * a_world; }
};

// Puts worlds to where they begin, and checks that they have what the controls act on. If one hasn't, all go back.
void begin(Batch& batch, const Rollout& rollout, std::span<const std::size_t> places,
           const std::vector<std::size_t>& numbers) {
  const bool moves = rollout.reset || !rollout.start.empty();
  std::vector<Snapshot> before(moves ? batch.size() : 0);
  if (moves) batch.for_each([&](World& world, std::size_t place) { world.save(before[place]); }, places);
  try {
    if (rollout.reset) batch.reset(places);
    batch.for_each(
        [&](World& world, std::size_t place) {
          if (!rollout.start.empty()) world.restore(rollout.start[rollout.start.size() == 1 ? 0 : numbers[place]]);
          const std::string where = " in world " + std::to_string(place);
          check_controls(batch, rollout, world, where);
          check_constant_forces(batch, world, where);
        },
        places);
  } catch (...) {
    if (moves) batch.for_each([&](World& world, std::size_t place) { world.restore(before[place]); }, places);
    throw;
  }
}

// Sets motors and servos to the values of a control step.
void set_motors(const Batch& batch, const Rollout& rollout, const double* values, World& world) {
  for (const Control& control : rollout.controls) {
    if (const auto* motor = std::get_if<MotorSpeed>(&control)) {
      world.set_motor_speed(batch.joints()[motor->joint], *values, motor->coordinate);
    } else if (const auto* servo = std::get_if<ServoTarget>(&control)) {
      world.set_servo_target(batch.joints()[servo->joint], *values, servo->coordinate);
    }
    values += width_of(control);
  }
}

Vector3 along(std::optional<Axis> axis, const double* values) {
  if (!axis) return {values[0], values[1], values[2]};
  Vector3 vector = Vector3::Zero();
  vector[static_cast<Eigen::Index>(*axis)] = *values;
  return vector;
}

// Gives the values of a control step to the world's next step.
void push(const Batch& batch, const Rollout& rollout, const double* values, World& world) {
  for (const Control& control : rollout.controls) {
    if (const auto* force = std::get_if<BodyForce>(&control)) {
      world.apply_force(batch.bodies()[force->body], along(force->axis, values));
    } else if (const auto* torque = std::get_if<BodyTorque>(&control)) {
      world.apply_force(batch.bodies()[torque->body], Vector3::Zero(), along(torque->axis, values));
    }
    values += width_of(control);
  }
}

void make_step(const Batch& batch, const Rollout& rollout, const double* values, World& world) {
  set_motors(batch, rollout, values, world);
  for (int i = 0; i < rollout.count; ++i) {
    push(batch, rollout, values, world);
    apply_forces(batch.scene(), world, batch.bodies());
    world.step(rollout.dt);
  }
}

}  // namespace

std::size_t width_of(std::span<const Control> controls) {
  std::size_t width = 0;
  for (const Control& control : controls) width += width_of(control);
  return width;
}

void set_controls(Batch& batch, std::span<const Control> controls, std::span<const double> values,
                  std::span<const std::size_t> places) {
  const Rollout once{.controls = {controls.begin(), controls.end()}, .steps = 1};
  const Values given(batch, once, values, places);
  begin(batch, once, places, given.numbers);
  batch.for_each(
      [&](World& world, std::size_t place) {
        set_motors(batch, once, given.of(place), world);
        push(batch, once, given.of(place), world);
      },
      places);
}

std::vector<std::vector<double>> roll_out(Batch& batch, const Rollout& rollout, std::span<const double> values,
                                          std::span<const std::size_t> places) {
  const Values given(batch, rollout, values, places);
  const std::size_t worlds = places.empty() ? batch.size() : places.size();
  std::vector<std::vector<double>> kept;
  for (const Batch::Column column : rollout.keep) {
    kept.emplace_back(worlds * rollout.steps * Batch::rows_of(column) * count_in(column, batch));
  }
  begin(batch, rollout, places, given.numbers);
  batch.for_each(
      [&](World& world, std::size_t place) {
        const double* now = given.of(place);
        std::vector<double*> to(kept.size());
        for (std::size_t step = 0; step < rollout.steps; ++step, now += given.width) {
          make_step(batch, rollout, now, world);
          for (std::size_t i = 0; i < kept.size(); ++i) {
            const std::size_t size = Batch::rows_of(rollout.keep[i]) * count_in(rollout.keep[i], batch);
            const std::size_t before = given.numbers[place] * rollout.steps + step;
            ATL_ASSERT((before + 1) * size <= kept[i].size(), place, step, i, before, kept[i].size());
            to[i] = kept[i].data() + before * size;
          }
          read_columns(world, batch, rollout.keep, to);
        }
      },
      places);
  return kept;
}

}  // namespace atl
