// Many worlds of one scene, and arrays over all of them.

#include <atoll/batch.h>
#include <atoll/rollout.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "batches.h"
#include "callbacks.h"
#include "fields.h"
#include "parts.h"
#include "signals.h"

namespace atl::python {
namespace {

// Some steps at a time, so that a signal is noticed soon, and all worlds have made as many when it ends the call.
void take_steps(Batch& batch, double dt, int count, std::span<const std::size_t> places) {
  using Clock = std::chrono::steady_clock;
  SignalCheck check_signals;
  int max = 1;
  int left = count;
  do {
    const int some = std::min(left, max);
    const Clock::time_point start = Clock::now();
    batch.step(dt, some, places);
    left -= some;
    if (Clock::now() - start < std::chrono::milliseconds(25) && max < 1 << 20) max *= 2;
    check_signals();
  } while (left > 0);
}

void bind_steps(nb::class_<Batch>& batch) {
  batch
      .def(
          "step",
          [](Batch& self, std::optional<double> dt, int count, const nb::object& worlds) {
            const double seconds = dt.value_or(self.scene().dt);
            call(self, worlds, [&](auto places) { take_steps(self, seconds, count, places); });
          },
          nb::arg("dt") = nb::none(), nb::arg("count") = 1, nb::arg("worlds") = nb::none(),
          "So many steps of dt seconds, the scene's if None. Many at once cost less than one by one. Ctrl-C ends them "
          "where all of these worlds have made as many.",
          nb::sig("def step(self, dt: float | None = None, count: int = 1, worlds: " ATOLL_WORLDS " = None) -> None"))
      .def(
          "reset",
          [](Batch& self, const nb::object& worlds) { call(self, worlds, [&](auto places) { self.reset(places); }); },
          nb::arg("worlds") = nb::none(), "Back to where they started, or to where save_start() was called last.",
          nb::sig("def reset(self, worlds: " ATOLL_WORLDS " = None) -> None"))
      .def(
          "save_start",
          [](Batch& self, const nb::object& worlds) {
            call(self, worlds, [&](auto places) { self.save_start(places); });
          },
          nb::arg("worlds") = nb::none(), "Lets these start from where they are now.",
          nb::sig("def save_start(self, worlds: " ATOLL_WORLDS " = None) -> None"))
      .def(
          "hashes",
          [](const Batch& self) {
            const std::vector<std::uint64_t> hashes = self.hashes();
            return nb::steal(array_of(hashes.data(), {hashes.size()}));
          },
          "World.state_hash() of all worlds, shape (worlds,)",
          nb::sig("def hashes(self) -> numpy.typing.NDArray[numpy.uint64]"))
      .def("quarantined", &Batch::quarantined, "How many bodies of each world are in quarantine.");
}

// The control steps in values for so many worlds, of so many numbers each, or for all alike.
std::size_t steps_in(const Values& values, std::size_t worlds, std::size_t width) {
  const std::size_t dimensions = values.ndim();
  const bool fits =
      (dimensions == 2 || (dimensions == 3 && values.shape(0) == worlds)) && values.shape(dimensions - 1) == width;
  if (fits) return values.shape(dimensions - 2);
  std::string shape;
  for (std::size_t i = 0; i < dimensions; ++i) shape += (i == 0 ? "" : ", ") + std::to_string(values.shape(i));
  const std::string step = "steps, " + std::to_string(width) + ")";
  throw Error("Batch.rollout: values have the shape (" + shape + "); expected (" + std::to_string(worlds) + ", " +
              step + ", or (" + step + " for all alike");
}

// Reads the start of a rollout: None, "reset", one snapshot, or one per world.
std::vector<Snapshot> take_start(const nb::object& start, Rollout& rollout) {
  if (start.is_none()) return {};
  if (nb::isinstance<nb::str>(start)) {
    const auto word = nb::cast<std::string>(start);
    if (word != "reset") throw Error("Batch.rollout: start is \"" + word + "\"; expected \"reset\", or snapshots");
    rollout.reset = true;
    return {};
  }
  if (nb::isinstance<Snapshot>(start)) return {nb::cast<Snapshot>(start)};
  std::vector<Snapshot> snapshots = nb::cast<std::vector<Snapshot>>(start);
  if (snapshots.empty()) throw Error("Batch.rollout: start is an empty list; expected a snapshot a world, or None");
  return snapshots;
}

nb::dict roll_out(Batch& self, std::vector<Control> controls, const Values& values, std::optional<double> dt, int count,
                  const nb::object& start, const std::vector<std::string>& keep, const nb::object& worlds) {
  const Chosen chosen(self, worlds);
  const std::size_t of = !chosen.any ? 0 : chosen.places.empty() ? self.size() : chosen.places.size();
  Rollout rollout{.controls = std::move(controls), .count = count, .dt = dt.value_or(self.scene().dt)};
  rollout.steps = steps_in(values, of, width_of(rollout.controls));
  for (const std::string& name : keep) rollout.keep.push_back(column_named("Batch.rollout: keep has", name));
  const std::vector<Snapshot> snapshots = take_start(start, rollout);
  rollout.start = snapshots;
  std::vector<std::vector<double>> kept(keep.size());
  if (chosen.any) {
    const nb::gil_scoped_release release;
    kept = atl::roll_out(self, rollout, span_of(values), chosen.places);
  }
  nb::dict arrays;
  for (std::size_t i = 0; i < keep.size(); ++i) {
    const Batch::Column column = rollout.keep[i];
    const std::size_t each = is_of_joints(column) ? self.joints().size() : self.bodies().size();
    arrays[keep[i].c_str()] = array_owning(std::move(kept[i]), {of, rollout.steps, each, Batch::rows_of(column)});
  }
  return arrays;
}

void bind_rollouts(nb::module_& module, nb::class_<Batch>& batch) {
  nb::class_<MotorSpeed> speed(module, "MotorSpeed", "A control of a rollout: a motor's speed, m/s or rad/s.");
  bind_struct(speed, Field{"joint", &MotorSpeed::joint, "its place in Batch.joints"},
              Field{"coordinate", &MotorSpeed::coordinate, "of the joint"});
  nb::class_<ServoTarget> target(module, "ServoTarget", "A control of a rollout: a servo's target, m or rad.");
  bind_struct(target, Field{"joint", &ServoTarget::joint, "its place in Batch.joints"},
              Field{"coordinate", &ServoTarget::coordinate, "of the joint"});
  nb::class_<BodyForce> force(
      module, "BodyForce",
      "A control of a rollout: a force through a dynamic body's centre of mass, N, world frame. "
      "A number along an axis, or x, y and z without one.");
  bind_struct(force, Field{"body", &BodyForce::body, "its place in Batch.bodies"},
              Field{"axis", &BodyForce::axis, "or None"});
  nb::class_<BodyTorque> torque(module, "BodyTorque",
                                "A control of a rollout: a torque on a dynamic body, N m, world frame, likewise.");
  bind_struct(torque, Field{"body", &BodyTorque::body, "its place in Batch.bodies"},
              Field{"axis", &BodyTorque::axis, "or None"});

  batch.def(
      "set_controls",
      [](Batch& self, const std::vector<Control>& controls, const Values& values, const nb::object& worlds) {
        call(self, worlds, [&](auto places) { atl::set_controls(self, controls, span_of(values), places); });
      },
      nb::arg("controls"), nb::arg("values"), nb::arg("worlds") = nb::none(),
      "Sets motors, servos, forces and torques of all worlds in one call, as a control step of rollout() does ahead of "
      "its "
      "steps. values: shape (worlds, numbers), or (numbers,) for all alike. Motors and servos keep their numbers, "
      "forces "
      "and torques are of the next step. Raises Error as rollout() does, with all worlds as they were.");
  batch.def(
      "rollout", &roll_out, nb::arg("controls"), nb::arg("values"), nb::kw_only(), nb::arg("dt") = nb::none(),
      nb::arg("count") = 1, nb::arg("start") = nb::none(),
      nb::arg("keep") = std::vector<std::string>{"positions", "velocities"}, nb::arg("worlds") = nb::none(),
      "Runs worlds through many control steps in one call, and tells of the end of each.\n\n"
      "controls: what the values act on. values: shape (worlds, steps, numbers), or (steps, numbers) for all alike; a "
      "control takes one number, a force or torque without an axis three. Each holds for `count` steps of dt seconds, "
      "the scene's if None: motors and servos keep it, forces act in each.\n"
      "start: None for where the worlds are, \"reset\" for where they started, as reset() puts them, or a Snapshot for "
      "all, or a list of one a world. They stay where the last step takes them.\n"
      "keep: which of the arrays of the batch to return, by the names that read() takes, with an axis for the control "
      "steps: (worlds, steps, bodies, 3) and the like.\n\n"
      "The bits are those of the same calls one by one. Raises Error on a wrong shape, a number that isn't finite, a "
      "joint without the motor or servo, a body that isn't dynamic, or a snapshot of other bodies, before the first "
      "step and with all worlds as they were.",
      nb::sig(
          "def rollout(self, controls: collections.abc.Sequence[MotorSpeed | ServoTarget | BodyForce | BodyTorque], "
          "values: numpy.typing.NDArray[numpy.float64], *, dt: float | None = None, count: int = 1, start: Snapshot "
          "| collections.abc.Sequence[Snapshot] | str | None = None, keep: collections.abc.Sequence[str] = "
          "('positions', 'velocities'), worlds: " ATOLL_WORLDS
          " = None) -> dict[str, numpy.typing.NDArray[numpy.float64]]"));
}

}  // namespace

void bind_batch(nb::module_& module) {
  nb::class_<Batch> batch(
      module, "Batch", nb::type_slots(batch_slots),
      "Many worlds of one scene, stepped side by side. Each comes to the bits that it comes to by itself, whatever its "
      "place, the number of worlds and the threads. Where `worlds` is asked for, that is a mask (a bool a world), "
      "places, "
      "or None for all; arrays have a row for each of these.");
  batch
      .def(
          "__init__",
          [](Batch* self, const std::variant<std::string, Scene>& scene, std::size_t worlds, int threads) {
            const auto* text = std::get_if<std::string>(&scene);
            new (self) Batch(text != nullptr ? load_scene(*text) : std::get<Scene>(scene), worlds, threads);
          },
          nb::arg("scene"), nb::arg("worlds"), nb::arg("threads") = 0,
          "scene: a Scene, or what load_scene() takes. worlds: how many. threads: workers; 0 for as many as the "
          "machine "
          "has.")
      .def("__len__", &Batch::size)
      .def_prop_ro("threads", &Batch::threads)
      .def_prop_ro(
          "scene", [](const Batch& self) { return self.scene(); }, "a copy")
      .def_prop_ro(
          "bodies", [](const Batch& self) { return self.bodies(); }, "the same ids in all worlds")
      .def_prop_ro(
          "joints", [](const Batch& self) { return self.joints(); }, "the same ids in all worlds")
      .def(
          "__getitem__",
          [](Batch& self, std::ptrdiff_t place) -> World& {
            const auto size = static_cast<std::ptrdiff_t>(self.size());
            if (place < -size || place >= size) throw nb::index_error("a batch's world that there is not");
            return self.world(static_cast<std::size_t>(place < 0 ? place + size : place));
          },
          nb::arg("place"), nb::rv_policy::reference_internal, "A world, to ask or to change by any call.")
      .def(
          "__iter__",
          [](nb::object self) {
            nb::list worlds;
            for (std::size_t i = 0; i < nb::cast<Batch&>(self).size(); ++i) worlds.append(self[i]);
            return nb::iter(worlds);
          },
          nb::sig("def __iter__(self) -> collections.abc.Iterator[World]"))
      .def("__repr__", [](const Batch& self) {
        return "<Batch of " + std::to_string(self.size()) + " worlds of " + std::to_string(self.bodies().size()) +
               " bodies>";
      });
  bind_batch_arrays(batch);
  bind_batch_changes(module, batch);
  bind_steps(batch);
  bind_rollouts(module, batch);
}

}  // namespace atl::python
