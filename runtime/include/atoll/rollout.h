#pragma once

#include <atoll/batch.h>
#include <atoll/body.h>
#include <atoll/snapshot.h>

#include <cstddef>
#include <optional>
#include <span>
#include <variant>
#include <vector>

namespace atl {

// The targets of a rollout's numbers. Joints and bodies go by their places in Batch::joints() and Batch::bodies().

/// The speed of the motor along a joint's coordinate: a number, m/s or rad/s.
struct MotorSpeed {
  std::size_t joint = 0;
  std::size_t coordinate = 0;
};

/// The target of the servo along a joint's coordinate: a number, m or rad, at most 1e15 in size.
struct ServoTarget {
  std::size_t joint = 0;
  std::size_t coordinate = 0;
};

/// A force through a dynamic body's centre of mass, N, world frame: a number along an axis, or x, y and z without one.
struct BodyForce {
  std::size_t body = 0;
  std::optional<Axis> axis = {};
};

/// A torque on a dynamic body, N m, likewise.
struct BodyTorque {
  std::size_t body = 0;
  std::optional<Axis> axis = {};
};

using Control = std::variant<MotorSpeed, ServoTarget, BodyForce, BodyTorque>;

/// How many numbers these take, in order.
std::size_t width_of(std::span<const Control> controls);

/// A run of a batch without a look in between, as a plan is tried out: so many control steps, in each of which every
/// world makes `count` steps of dt seconds under the same controls.
struct Rollout {
  std::vector<Control> controls = {};    ///< what the values act on
  std::size_t steps = 0;                 ///< control steps
  int count = 1;                         ///< steps of the world in each of them, 1 or more
  double dt = 1.0 / 60;                  ///< s, in [1e-12, 1]
  std::vector<Batch::Column> keep = {};  ///< what is told of the end of each control step
  // The start of the worlds: their current state, unless one of these is given.
  bool reset = false;                    ///< at their starts, as Batch::reset() puts them
  std::span<const Snapshot> start = {};  ///< all at this one, or each at its own, in the order of the places
};

/// All of it in one call, a world in a row while it is in cache. It comes to the bits that the controls' calls of each
/// world come to, in their order: set_motor_speed() and set_servo_target() as a control step begins, apply_force(), and
/// then step() under the scene's constant forces, for each of its steps. Controls of one body add up. The worlds stay
/// where their last step took them.
///
/// `values`: width_of(controls) numbers a control step, step by step, world by world; or of one world, for all alike.
/// `places`: of the worlds; all of them, if none. Returns a vector for each of `keep`: world by world, control step by
/// control step, as Batch::read() has the column.
///
/// Throws Error on wrong sizes, numbers that are not finite, a coordinate without the motor or servo, a body that is
/// not dynamic, and what Batch's calls and World::restore() throw it on: before the first step, with the worlds as they
/// were.
std::vector<std::vector<double>> roll_out(Batch& batch, const Rollout& rollout, std::span<const double> values,
                                          std::span<const std::size_t> places = {});

/// Sets all of these at once, as a control step of roll_out() does ahead of its steps: motors and servos keep their
/// numbers, forces and torques add to those of the next step. `values`: width_of(controls) numbers world by world, in
/// the order of `places`, or of one world for all alike. Throws Error as roll_out() does, with all worlds as they were.
void set_controls(Batch& batch, std::span<const Control> controls, std::span<const double> values,
                  std::span<const std::size_t> places = {});

}  // namespace atl
