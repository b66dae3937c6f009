// Joints: what acts along a coordinate, the kinds there are, and what they tell.

#include <atoll/joint.h>
#include <atoll/world.h>

#include "fields.h"
#include "parts.h"

namespace atl::python {
namespace {

void bind_axis(nb::module_& module) {
  module.attr("unlimited") = unlimited;
  nb::class_<JointRange> range(module, "JointRange",
                               "The range of a coordinate, m or rad; locked where both are equal.");
  bind_struct(range, Field{"lower", &JointRange::lower, "<= upper"}, Field{"upper", &JointRange::upper, ">= lower"},
              Field{"restitution", &JointRange::restitution, "in [0, 1]"});
  nb::class_<JointSpring> spring(module, "JointSpring",
                                 "A damped spring that pulls a coordinate to its rest: as a frequency, or, with a "
                                 "stiffness or a damping, linear.");
  bind_definition(spring, Field{"hertz", &JointSpring::hertz, "> 0"},
                  Field{"damping_ratio", &JointSpring::damping_ratio, ">= 0; 1 is critical"},
                  Field{"rest", &JointSpring::rest, "m or rad"},
                  Field{"stiffness", &JointSpring::stiffness, "N/m or N m/rad, >= 0"},
                  Field{"damping", &JointSpring::damping, "N s/m or N m s/rad, >= 0"});
  nb::class_<JointServo> servo(module, "JointServo", "What makes a motor a servo: gains, of which at least one pulls.");
  bind_definition(servo, Field{"target", &JointServo::target, "m or rad"},
                  Field{"stiffness", &JointServo::stiffness, "N/m or N m/rad, >= 0"},
                  Field{"damping", &JointServo::damping, "N s/m or N m s/rad, >= 0"});
  nb::class_<JointMotor> motor(
      module, "JointMotor", "Drives a coordinate at a speed, or with a servo to a place, by no more than max_force.");
  bind_definition(motor, Field{"speed", &JointMotor::speed, "m/s or rad/s"},
                  Field{"max_force", &JointMotor::max_force, "N or N m, >= 0, or unlimited; to be given"},
                  Field{"servo", &JointMotor::servo, "if it is one"});
  nb::class_<JointAxis> axis(module, "JointAxis", "A coordinate of a joint, and what acts along it.");
  bind_definition(
      axis, Field{"range", &JointAxis::range, "its ends"}, Field{"spring", &JointAxis::spring, "if any"},
      Field{"motor", &JointAxis::motor, "if any"},
      Field{"armature", &JointAxis::armature, "kg or kg m^2, >= 0: inertia that moves with the coordinate"},
      Field{"friction", &JointAxis::friction, "N or N m, >= 0: dry friction, beside a motor or without one"});
}

void bind_kinds(nb::module_& module) {
  nb::class_<BallServo> servo(module, "BallServo", "Turns a ball joint to an orientation, by the shortest way.");
  bind_definition(servo, Field{"target", &BallServo::target, "x, y, z, w, of the second frame in the first"},
                  Field{"angular_velocity", &BallServo::angular_velocity, "rad/s, about the axes of the target"},
                  Field{"stiffness", &BallServo::stiffness, "N m/rad, >= 0"},
                  Field{"damping", &BallServo::damping, "N m s/rad, >= 0"},
                  Field{"max_torque", &BallServo::max_torque, "N m, >= 0, about each axis of the target"});
  nb::class_<BallJoint> ball(module, "BallJoint", "The origins of the frames stay together: 3 rows.");
  bind_struct(ball, Field{"friction", &BallJoint::friction, "N m, >= 0: torque that holds back turning"},
              Field{"servo", &BallJoint::servo, "if it has one"});
  nb::class_<HingeJoint> hinge(module, "HingeJoint", "Origins together and x axes parallel: 5 rows.");
  bind_struct(hinge, Field{"angle", &HingeJoint::angle, "rad, about x"});
  nb::class_<SliderJoint> slider(module, "SliderJoint", "Slides along the x axis of the first frame: 5 rows.");
  bind_struct(slider, Field{"offset", &SliderJoint::offset, "m, along x"});
  nb::class_<FixedJoint>(module, "FixedJoint", "The frames stay together: 6 rows.")
      .def(nb::init<>())
      .def(
          "__getstate__", [](const FixedJoint&) { return nb::make_tuple(); },
          nb::sig("def __getstate__(self) -> tuple[()]"))
      .def(
          "__setstate__", [](FixedJoint& self, const nb::tuple&) { new (&self) FixedJoint{}; },
          nb::sig("def __setstate__(self, state: tuple[()], /) -> None"))
      .def("__repr__", [](const FixedJoint&) { return "FixedJoint()"; });
  nb::class_<DistanceJoint> distance(module, "DistanceJoint", "The distance of the origins: 1 row. A rod, or a rope.");
  bind_struct(distance, Field{"distance", &DistanceJoint::distance, "m"});
  nb::class_<UniversalJoint> universal(module, "UniversalJoint", "Two hinges in a cross: 4 rows.");
  bind_struct(universal, Field{"first", &UniversalJoint::first, "rad, about the first frame's x axis"},
              Field{"second", &UniversalJoint::second, "rad, about the second frame's y axis"});
  nb::class_<ConeTwistJoint> cone(
      module, "ConeTwistJoint",
      "Origins together: 3 rows, and limits of the swing between the x axes and of the twist.");
  bind_struct(cone, Field{"swing_limit", &ConeTwistJoint::swing_limit, "rad, in (0, pi), or unlimited"},
              Field{"twist", &ConeTwistJoint::twist, "rad"},
              Field{"swing_friction", &ConeTwistJoint::swing_friction, "N m, >= 0"});
  nb::enum_<SixDofTurns>(module, "SixDofTurns", "What the turns of a SixDofJoint are.")
      .value("VECTOR", SixDofTurns::Vector, "Twice the vector part of the relative quaternion.")
      .value("ANGLES_XYZ", SixDofTurns::AnglesXYZ,
             "Angles, rad, of three hinges that carry each other, the first first.")
      .value("ANGLES_XZY", SixDofTurns::AnglesXZY, "Likewise, with the one about z in the middle.");
  nb::class_<SixDofJoint> six(module, "SixDofJoint",
                              "Each of six coordinates is locked, limited or free: offsets along the axes of the first "
                              "frame, m, and turns about them.");
  bind_struct(six, Field{"offset", &SixDofJoint::offset, "three axes"}, Field{"turn", &SixDofJoint::turn, "three axes"},
              Field{"turns", &SixDofJoint::turns, "what the turns are"});
  nb::class_<GearJoint> gear(module, "GearJoint",
                             "Turns of two bodies about their frames' x axes stay in a ratio: 1 row.");
  bind_struct(gear, Field{"ratio", &GearJoint::ratio, "not 0; rad/m of a rack"},
              Field{"rack", &GearJoint::rack, "the second moves along its x axis instead"});
  nb::class_<WheelJoint> wheel(
      module, "WheelJoint",
      "A wheel, the second body, at a chassis: suspension along z, steering about it, spin about "
      "the wheel's y axis.");
  bind_definition(wheel, Field{"suspension", &WheelJoint::suspension, "m"},
                  Field{"steering", &WheelJoint::steering, "rad"}, Field{"spin", &WheelJoint::spin, "rad"});
  nb::class_<TendonTerm> term(module, "TendonTerm", "A coordinate of another joint, by a polynomial.");
  bind_struct(term, Field{"joint", &TendonTerm::joint, "its id; not a tendon's"},
              Field{"coordinate", &TendonTerm::coordinate, "one that the joint's kind names"},
              Field{"polynomial", &TendonTerm::polynomial, "five factors, of the powers of the coordinate from 0 on"});
  nb::class_<TendonJoint> tendon(
      module, "TendonJoint",
      "Couples coordinates of other joints: the sum of its terms is a coordinate as any other. Locked at 0, it makes "
      "one "
      "joint mimic another. 1 row. Its bodies are those of these joints, and frames do nothing.");
  bind_struct(tendon, Field{"terms", &TendonJoint::terms, "1 to 4 of TendonTerm"},
              Field{"length", &TendonJoint::length, "m, or rad"});
}

}  // namespace

void bind_joints(nb::module_& module) {
  bind_axis(module);
  bind_kinds(module);

  nb::class_<JointDef> def(module, "JointDef", "Everything a joint starts with.");
  bind_definition(def, Field{"kind", &JointDef::kind, "a BallJoint, HingeJoint, ..."},
                  Field{"first", &JointDef::first, "a body"}, Field{"second", &JointDef::second, "another"},
                  Field{"frame_first", &JointDef::frame_first, "where the joint is, in the first body's frame"},
                  Field{"frame_second", &JointDef::frame_second, "in the second's"},
                  Field{"collide", &JointDef::collide, "whether the two may touch"},
                  Field{"break_force", &JointDef::break_force, "N, > 0"},
                  Field{"break_torque", &JointDef::break_torque, "N m, > 0"},
                  Field{"name", &JointDef::name, "for people"},
                  Field{"user_data", &JointDef::user_data, "yours, 64 bits"});
  nb::class_<JointState> state(module, "JointState", "What a joint does, as of the end of the last step.");
  bind_result(state, Field{"enabled", &JointState::enabled, ""}, Field{"broken", &JointState::broken, ""},
              Field{"force", &JointState::force, "N, shape (3,), on the second body, world frame"},
              Field{"torque", &JointState::torque, "N m, shape (3,), about its frame's origin"},
              Field{"position", &JointState::position, "m or rad, of the coordinates in the order that its kind names"},
              Field{"speed", &JointState::speed, "m/s or rad/s"},
              Field{"motor", &JointState::motor, "N or N m, what motors and servos exert along the coordinates"});
  const char* numbers = "Coordinates by number, as JointState and calls of World have them.";
  nb::enum_<UniversalCoordinate::Number>(module, "UniversalCoordinate", numbers, nb::is_arithmetic())
      .value("FIRST", UniversalCoordinate::First)
      .value("SECOND", UniversalCoordinate::Second);
  nb::enum_<ConeTwistCoordinate::Number>(module, "ConeTwistCoordinate", numbers, nb::is_arithmetic())
      .value("SWING", ConeTwistCoordinate::Swing)
      .value("TWIST", ConeTwistCoordinate::Twist);
  nb::enum_<SixDofCoordinate::Number>(module, "SixDofCoordinate", numbers, nb::is_arithmetic())
      .value("OFFSET_X", SixDofCoordinate::OffsetX)
      .value("OFFSET_Y", SixDofCoordinate::OffsetY)
      .value("OFFSET_Z", SixDofCoordinate::OffsetZ)
      .value("TURN_X", SixDofCoordinate::TurnX)
      .value("TURN_Y", SixDofCoordinate::TurnY)
      .value("TURN_Z", SixDofCoordinate::TurnZ);
  nb::enum_<WheelCoordinate::Number>(module, "WheelCoordinate", numbers, nb::is_arithmetic())
      .value("SUSPENSION", WheelCoordinate::Suspension)
      .value("STEERING", WheelCoordinate::Steering)
      .value("SPIN", WheelCoordinate::Spin);
  nb::enum_<JointEventKind>(module, "JointEventKind", "What happened to a joint.")
      .value("BROKE", JointEventKind::Broke)
      .value("REACHED_LIMIT", JointEventKind::ReachedLimit)
      .value("LEFT_LIMIT", JointEventKind::LeftLimit);
  nb::class_<JointEvent> event(module, "JointEvent", "A joint that broke, or came to or from an end of its range.");
  event.def_ro("joint", &JointEvent::joint)
      .def_ro("kind", &JointEvent::kind)
      .def_ro("force", &JointEvent::force, "N, shape (3,)")
      .def_ro("torque", &JointEvent::torque, "N m, shape (3,)");
  module.def(
      "joint_at", &joint_at, nb::arg("world"), nb::arg("kind"), nb::arg("first"), nb::arg("second"), nb::arg("point"),
      nb::arg("axis") = Vector3(1, 0, 0),
      "The definition of a joint at a point (m) of the world, with the x axis of its frames along `axis`, as the "
      "bodies are placed now. For World.add_joint().");
}

}  // namespace atl::python
