// Arrays over all worlds of a batch.

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "batches.h"
#include "fields.h"

namespace atl::python {
namespace {

// Columns by the names of their arrays.
constexpr std::array<std::pair<const char*, Batch::Column>, 14> columns = {{
    {"positions", Batch::Column::Positions},
    {"origins", Batch::Column::Origins},
    {"orientations", Batch::Column::Orientations},
    {"velocities", Batch::Column::Velocities},
    {"angular_velocities", Batch::Column::AngularVelocities},
    {"accelerations", Batch::Column::Accelerations},
    {"angular_accelerations", Batch::Column::AngularAccelerations},
    {"contact_forces", Batch::Column::ContactForces},
    {"contact_torques", Batch::Column::ContactTorques},
    {"joint_positions", Batch::Column::JointPositions},
    {"joint_speeds", Batch::Column::JointSpeeds},
    {"joint_motors", Batch::Column::JointMotors},
    {"joint_forces", Batch::Column::JointForces},
    {"joint_torques", Batch::Column::JointTorques},
}};

// Arrays of their own of columns.
std::vector<nb::object> read_columns(const Batch& batch, const std::vector<Batch::Column>& of,
                                     const nb::object& worlds = nb::none()) {
  const Chosen chosen(batch, worlds);
  const std::size_t places = !chosen.any ? 0 : chosen.places.empty() ? batch.size() : chosen.places.size();
  const auto count = [&](Batch::Column column) {
    return is_of_joints(column) ? batch.joints().size() : batch.bodies().size();
  };
  std::vector<std::vector<double>> numbers;
  for (const Batch::Column column : of) numbers.emplace_back(places * count(column) * Batch::rows_of(column));
  const std::vector<std::span<double>> spans(numbers.begin(), numbers.end());
  if (chosen.any) {
    const nb::gil_scoped_release release;
    atl::read_columns(batch, of, spans, chosen.places);
  }
  std::vector<nb::object> arrays;
  for (std::size_t i = 0; i < of.size(); ++i) {
    arrays.push_back(array_owning(std::move(numbers[i]), {places, count(of[i]), Batch::rows_of(of[i])}));
  }
  return arrays;
}

nb::object of_type(const nb::object& array, const nb::object& dtype) {
  return array.attr("astype")(dtype, nb::arg("copy") = false);
}

template <Batch::Column column>
void bind_column(nb::class_<Batch>& batch, const char* name, const char* doc) {
  const std::string signature = std::string("def ") + name + "(self) -> numpy.typing.NDArray[numpy.float64]";
  batch.def_prop_ro(
      name,
      [](const Batch& self) {
        return nb::module_::import_("atoll._arrays").attr("copied")(read_columns(self, {column})[0]);
      },
      doc, nb::sig(signature.c_str()));
}

void bind_arrays(nb::class_<Batch>& batch) {
  bind_column<Batch::Column::Positions>(batch, "positions", "m, shape (worlds, bodies, 3), of centres of mass; a copy");
  bind_column<Batch::Column::Origins>(batch, "origins", "m, shape (worlds, bodies, 3), of the bodies' frames; a copy");
  bind_column<Batch::Column::Orientations>(batch, "orientations", "shape (worlds, bodies, 4): x, y, z, w; a copy");
  bind_column<Batch::Column::Velocities>(batch, "velocities", "m/s, shape (worlds, bodies, 3); a copy");
  bind_column<Batch::Column::AngularVelocities>(batch, "angular_velocities",
                                                "rad/s, shape (worlds, bodies, 3); a copy");
  bind_column<Batch::Column::Accelerations>(batch, "accelerations",
                                            "m/s^2, shape (worlds, bodies, 3), with Settings.accelerations; a copy");
  bind_column<Batch::Column::AngularAccelerations>(batch, "angular_accelerations",
                                                   "rad/s^2, shape (worlds, bodies, 3), likewise; a copy");
  bind_column<Batch::Column::ContactForces>(
      batch, "contact_forces",
      "N, shape (worlds, bodies, 3): what contacts exert on bodies in the last substep; a copy");
  bind_column<Batch::Column::ContactTorques>(batch, "contact_torques",
                                             "N m, shape (worlds, bodies, 3), likewise, about centres of mass; a copy");
  bind_column<Batch::Column::JointPositions>(batch, "joint_positions",
                                             "m or rad, shape (worlds, joints, 6), of the coordinates as "
                                             "JointState.position has them; a copy");
  bind_column<Batch::Column::JointSpeeds>(batch, "joint_speeds",
                                          "m/s or rad/s, shape (worlds, joints, 6), likewise; a copy");
  bind_column<Batch::Column::JointMotors>(batch, "joint_motors",
                                          "N or N m, shape (worlds, joints, 6): JointState.motor; a copy");
  bind_column<Batch::Column::JointForces>(batch, "joint_forces",
                                          "N, shape (worlds, joints, 3): JointState.force; a copy");
  bind_column<Batch::Column::JointTorques>(batch, "joint_torques",
                                           "N m, shape (worlds, joints, 3): JointState.torque; a copy");
}

// A point that carries force, in one of many worlds.
struct WorldContact {
  std::int64_t world;
  ContactForce contact;
};

nb::object contacts_of(Batch& batch) {
  static const std::vector<Member> members = [] {
    std::vector<Member> all = {{"world", "i8", offsetof(WorldContact, world)}};
    for (Member member : contact_force_members()) {
      member.offset += offsetof(WorldContact, contact);
      all.push_back(member);
    }
    return all;
  }();
  std::vector<std::span<const ContactForce>> found(batch.size());
  std::vector<WorldContact> contacts;
  {
    const nb::gil_scoped_release release;
    batch.for_each([&](World& world, std::size_t place) { found[place] = world.contact_forces(); });
    for (std::size_t place = 0; place < found.size(); ++place) {
      for (const ContactForce& contact : found[place]) contacts.push_back({static_cast<std::int64_t>(place), contact});
    }
  }
  return records_of<WorldContact>(contacts, members);
}

nb::object sensor_counts(Batch& batch, const std::vector<std::size_t>& sensors) {
  std::vector<double> counts(batch.size() * sensors.size());
  for (const std::size_t sensor : sensors) {
    if (sensor < batch.bodies().size()) continue;
    throw Error("Batch.sensor_counts: found body " + std::to_string(sensor) + "; expected one below " +
                std::to_string(batch.bodies().size()));
  }
  {
    const nb::gil_scoped_release release;
    batch.for_each([&](World& world, std::size_t place) {
      for (std::size_t i = 0; i < sensors.size(); ++i) {
        const std::size_t count = world.bodies_in(batch.bodies()[sensors[i]]).size();
        counts[place * sensors.size() + i] = static_cast<double>(count);
      }
    });
  }
  return array_owning(std::move(counts), {batch.size(), sensors.size()});
}

void bind_reads(nb::class_<Batch>& batch) {
  batch
      .def(
          "read",
          [](const Batch& self, const std::string& name, const nb::object& dtype) {
            return of_type(read_columns(self, {column_named("Batch.read: found", name)})[0], dtype);
          },
          nb::arg("name"), nb::arg("dtype") = "float64",
          "One of the arrays above by its name, as an array of your own, of another type of numbers where asked for.",
          nb::sig("def read(self, name: str, dtype: numpy.typing.DTypeLike = 'float64') -> "
                  "numpy.typing.NDArray[typing.Any]"))
      .def(
          "read_all",
          [](const Batch& self, const std::vector<std::string>& names, const nb::object& dtype,
             const nb::object& worlds) {
            std::vector<Batch::Column> of;
            for (const std::string& name : names) of.push_back(column_named("Batch.read_all: found", name));
            nb::list arrays;
            for (const nb::object& array : read_columns(self, of, worlds)) arrays.append(of_type(array, dtype));
            return arrays;
          },
          nb::arg("names"), nb::arg("dtype") = "float64", nb::arg("worlds") = nb::none(),
          "Several of them in one pass over the worlds, or some of these, for little more than one takes.",
          nb::sig("def read_all(self, names: collections.abc.Sequence[str], dtype: numpy.typing.DTypeLike = 'float64', "
                  "worlds: " ATOLL_WORLDS " = None) -> list[numpy.typing.NDArray[typing.Any]]"))
      .def("contact_points", &contacts_of,
           "A structured array of the contacts of all worlds: the records of World.contact_forces(), with `world`.",
           nb::sig("def contact_points(self) -> numpy.typing.NDArray[numpy.void]"))
      .def("sensor_counts", &sensor_counts, nb::arg("sensors"),
           "How many bodies are in these sensors, by their places in `bodies`, shape (worlds, sensors).",
           nb::sig("def sensor_counts(self, sensors: collections.abc.Sequence[int]) -> "
                   "numpy.typing.NDArray[numpy.float64]"));
}

}  // namespace

Batch::Column column_named(const char* call, const std::string& name) {
  std::string known;
  for (const auto& [of, column] : columns) {
    if (name == of) return column;
    known += (known.empty() ? "" : ", ") + std::string(of);
  }
  throw Error(std::string(call) + " \"" + name + "\"; expected of " + known);
}

void bind_batch_arrays(nb::class_<Batch>& batch) {
  bind_arrays(batch);
  bind_reads(batch);
}

}  // namespace atl::python
