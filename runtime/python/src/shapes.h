#pragma once
/// The fields of a body's definition, for the class of it and for World.add_body().

#include <atoll/body.h>

#include "fields.h"

namespace atl::python {

/// Calls `take` with a Field for each.
template <typename Take>
void with_body_fields(const Take& take) {
  take(Field{"type", &BodyDef::type, "how it moves"}, Field{"shape", &BodyDef::shape, "what it is, in its own frame"},
       Field{"position", &BodyDef::position, "m, shape (3,), world frame, of its frame's origin"},
       Field{"orientation", &BodyDef::orientation, "shape (4,): x, y, z, w; normalised on use"},
       Field{"velocity", &BodyDef::velocity, "m/s, shape (3,), world frame, of the centre of mass"},
       Field{"angular_velocity", &BodyDef::angular_velocity, "rad/s, shape (3,), world frame"},
       Field{"density", &BodyDef::density, "kg/m^3, > 0; used where there is no mass"},
       Field{"mass", &BodyDef::mass, "kg, > 0"},
       Field{"inertia", &BodyDef::inertia, "kg m^2, shape (3, 3), body frame, about the centre of mass; needs mass"},
       Field{"centre_of_mass", &BodyDef::centre_of_mass, "m, shape (3,), body frame; needs inertia"},
       Field{"material", &BodyDef::material, "what its surface is like"},
       Field{"materials", &BodyDef::materials, "of a surface's triangles or cells: number k > 0 has materials[k - 1]"},
       Field{"surface_velocity", &BodyDef::surface_velocity, "m/s, shape (3,), body frame: as a conveyor's belt"},
       Field{"surface_angular_velocity", &BodyDef::surface_angular_velocity,
             "rad/s, shape (3,), body frame, about its origin: as a turntable"},
       Field{"gravity_scale", &BodyDef::gravity_scale, "times the world's gravity"},
       Field{"linear_damping", &BodyDef::linear_damping, "1/s, >= 0"},
       Field{"angular_damping", &BodyDef::angular_damping, "1/s, >= 0"},
       Field{"locks", &BodyDef::locks, "of dynamic bodies"},
       Field{"max_speed", &BodyDef::max_speed, "m/s, > 0, of dynamic bodies, as a step begins and as it ends"},
       Field{"max_angular_speed", &BodyDef::max_angular_speed, "rad/s, > 0, likewise"},
       Field{"awake", &BodyDef::awake, "false: asleep as it is added, with Settings.sleeping"},
       Field{"may_sleep", &BodyDef::may_sleep, "false: it stays awake, and so does what it touches"},
       Field{"filter", &BodyDef::filter, "whom it may touch"},
       Field{"continuous", &BodyDef::continuous, "looks for what it may have passed through after every step"},
       Field{"sensor", &BodyDef::sensor, "touches nothing, and tells which bodies are in it"},
       Field{"notices_static", &BodyDef::notices_static, "a sensor: static bodies, too"},
       Field{"notices_sensors", &BodyDef::notices_sensors, "a sensor: other sensors, too"},
       Field{"contact_event_force", &BodyDef::contact_event_force,
             "N, >= 0: contact events tell of its contacts that go on, too, while they carry at least this"},
       Field{"name", &BodyDef::name, "for people, and World.find_body()"},
       Field{"user_data", &BodyDef::user_data, "yours, 64 bits"});
}

}  // namespace atl::python
