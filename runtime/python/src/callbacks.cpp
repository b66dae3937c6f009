// Callbacks to Python functions: contact filters and modifiers, and force laws.

#include "callbacks.h"

#include <atoll/batch.h>
#include <atoll/contact_callbacks.h>
#include <atoll/forces.h>
#include <atoll/world.h>

#include <cstddef>
#include <optional>
#include <string>
#include <utility>

#include "arrays.h"
#include "fields.h"
#include "parts.h"

namespace atl::python {
namespace {

using Candidate = Lent<const ContactCandidate>;
using Contact = Lent<ModifiableContact>;
using Law = Lent<Forces>;

struct Point {
  nb::object contact;
  std::size_t number;

  ModifiablePoint& get() const { return nb::cast<Contact&>(contact).get().points[number]; }
};

const auto takes_a_bool = nb::for_setter(nb::sig("def enabled(self, value: bool, /) -> None"));

void bind_candidate(nb::module_& module) {
  nb::class_<Candidate>(module, "ContactCandidate", "Two shapes whose bounds have come to overlap.")
      .def_prop_ro(
          "world", [](const Candidate& self) -> const World& { return self.get().world; }, nb::rv_policy::reference)
      .def_prop_ro(
          "a", [](const Candidate& self) { return self.get().a; }, "of the two the one with the lower index")
      .def_prop_ro("b", [](const Candidate& self) { return self.get().b; })
      .def_prop_ro(
          "child_a", [](const Candidate& self) { return self.get().child_a; }, "in a compound")
      .def_prop_ro("child_b", [](const Candidate& self) { return self.get().child_b; });
}

void bind_contact(nb::module_& module) {
  nb::class_<Point>(module, "ModifiablePoint", "A manifold point of a ModifiableContact.")
      .def_prop_ro(
          "position", [](const Point& self) { return self.get().position; }, "m, shape (3,)")
      .def_prop_ro(
          "separation", [](const Point& self) { return self.get().separation; }, "m")
      .def_prop_ro("feature_id", [](const Point& self) { return self.get().feature_id; })
      .def_prop_rw(
          "enabled", [](const Point& self) { return self.get().enabled; },
          [](const Point& self, nb::handle on) { self.get().enabled = is_true(on); }, takes_a_bool);
  nb::class_<Contact>(module, "ModifiableContact",
                      "Two shapes that touch, or may come to within the step. Valid while the function runs.")
      .def_prop_ro(
          "world", [](const Contact& self) -> const World& { return self.get().world; }, nb::rv_policy::reference)
      .def_prop_ro(
          "a", [](const Contact& self) { return self.get().a; }, "of the two the one with the lower index")
      .def_prop_ro("b", [](const Contact& self) { return self.get().b; })
      .def_prop_ro(
          "child_a", [](const Contact& self) { return self.get().child_a; }, "in a compound")
      .def_prop_ro("child_b", [](const Contact& self) { return self.get().child_b; })
      .def_prop_ro(
          "part", [](const Contact& self) { return self.get().part; }, "of a mesh or height field")
      .def_prop_ro(
          "normal", [](const Contact& self) { return self.get().normal; }, "shape (3,), from a to b")
      .def_prop_ro(
          "points",
          [](nb::object self) {
            nb::list points;
            const std::size_t count = nb::cast<Contact&>(self).get().points.size();
            for (std::size_t i = 0; i < count; ++i) points.append(Point{self, i});
            return points;
          },
          nb::sig("def points(self) -> list[ModifiablePoint]"))
      .def_prop_rw(
          "friction", [](const Contact& self) { return self.get().friction; },
          [](Contact& self, double value) { self.get().friction = value; }, "Coulomb's coefficient, >= 0")
      .def_prop_rw(
          "restitution", [](const Contact& self) { return self.get().restitution; },
          [](Contact& self, double value) { self.get().restitution = value; }, "in [0, 1]")
      .def_prop_rw(
          "surface_velocity", [](const Contact& self) { return self.get().surface_velocity; },
          [](Contact& self, const Vector3& value) { self.get().surface_velocity = value; },
          "m/s, shape (3,): b's less a's")
      .def_prop_rw(
          "enabled", [](const Contact& self) { return self.get().enabled; },
          [](Contact& self, nb::handle on) { self.get().enabled = is_true(on); }, takes_a_bool)
      .def(
          "run_surface",
          [](Contact& self, BodyId of, const Vector3& velocity) { self.get().run_surface(of, velocity); },
          nb::arg("of"), nb::arg("velocity"), "Lets the surface of one of the two run along its body (m/s).");
}

void bind_forces(nb::module_& module) {
  nb::class_<Law>(module, "Forces", "What a force law is asked for. Valid while the law runs.")
      .def_prop_ro(
          "world", [](const Law& self) -> const World& { return self.get().world(); }, nb::rv_policy::reference)
      .def_prop_ro(
          "time", [](const Law& self) { return self.get().time(); }, "s since the step began")
      .def(
          "add",
          [](Law& self, BodyId body, const Vector3& force, const Vector3& torque) {
            self.get().add(body, force, torque);
          },
          nb::arg("body"), nb::arg("force"), nb::arg("torque") = Vector3(0, 0, 0), "N and N m")
      .def(
          "add_at",
          [](Law& self, BodyId body, const Vector3& force, const Vector3& point) {
            self.get().add_at(body, force, point);
          },
          nb::arg("body"), nb::arg("force"), nb::arg("point"), "N, at a point (m)")
      .def(
          "add_all",
          [](Law& self, const Rows<3>& forces, const std::optional<Rows<3>>& torques) {
            Forces& to = self.get();
            const auto rows = static_cast<std::size_t>(to.forces().cols());
            if (forces.shape(0) != rows || (torques && torques->shape(0) != rows)) {
              throw Error("Forces.add_all: found " + std::to_string(forces.shape(0)) + " rows; expected " +
                          std::to_string(rows) + ", one a body index");
            }
            to.forces() += columns_of<3>(forces);
            if (torques) to.torques() += columns_of<3>(*torques);
          },
          nb::arg("forces"), nb::arg("torques") = nb::none(), "N and N m, shape (n, 3), a row a body index");
}

int visit_functions(const World& world, visitproc visit, void* arg) {
  const auto [first, last] = held_functions().equal_range(&world);
  for (auto held = first; held != last; ++held) Py_VISIT(held->second->ptr());
  return 0;
}

// Nobody can reach the world any more, so it is not stepping.
void clear_functions(World& world) {
  if (held_functions().count(&world) == 0) return;
  world.set_contact_filter({});
  world.set_contact_modifier({});
}

// Worlds of a batch are its own: it has their functions visited.
bool owns_world(PyObject* self) { return nb::inst_state(self) == std::pair(true, true); }

int visit_world(PyObject* self, visitproc visit, void* arg) {
  Py_VISIT(Py_TYPE(self));
  return owns_world(self) ? visit_functions(*nb::inst_ptr<World>(self), visit, arg) : 0;
}

int clear_world(PyObject* self) {
  if (owns_world(self)) clear_functions(*nb::inst_ptr<World>(self));
  return 0;
}

int visit_batch(PyObject* self, visitproc visit, void* arg) {
  Py_VISIT(Py_TYPE(self));
  if (!nb::inst_ready(self) || held_functions().empty()) return 0;
  const Batch& batch = *nb::inst_ptr<Batch>(self);
  for (std::size_t i = 0; i < batch.size(); ++i) {
    if (const int stop = visit_functions(batch.world(i), visit, arg); stop != 0) return stop;
  }
  return 0;
}

int clear_batch(PyObject* self) {
  if (!nb::inst_ready(self)) return 0;
  Batch& batch = *nb::inst_ptr<Batch>(self);
  for (std::size_t i = 0; i < batch.size(); ++i) clear_functions(batch.world(i));
  return 0;
}

}  // namespace

PyType_Slot world_slots[3] = {{Py_tp_traverse, reinterpret_cast<void*>(&visit_world)},
                              {Py_tp_clear, reinterpret_cast<void*>(&clear_world)},
                              {0, nullptr}};
PyType_Slot batch_slots[3] = {{Py_tp_traverse, reinterpret_cast<void*>(&visit_batch)},
                              {Py_tp_clear, reinterpret_cast<void*>(&clear_batch)},
                              {0, nullptr}};

void bind_callbacks(nb::module_& module) {
  bind_candidate(module);
  bind_contact(module);
  bind_forces(module);
}

}  // namespace atl::python
