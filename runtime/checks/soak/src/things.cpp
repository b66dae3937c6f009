#include "things.h"

#include <array>
#include <cmath>

#include "scene/src/loose_solids.h"

namespace atl::soak {
namespace {

constexpr double gap = 0.02;  // m, between parts of a thing that may touch

Material material(Random& random) {
  Material of = {.friction = random.uniform(0.1, 1)};
  if (chance(random, 4)) of.restitution = random.uniform(0, 0.8);
  if (chance(random, 4)) of.rolling_friction = random.uniform(0, 0.02);
  if (chance(random, 4)) of.torsional_friction = random.uniform(0, 0.02);
  return of;
}

BodyDef body(Random& random, const Shape& shape, const Vector3& position = Vector3::Zero()) {
  BodyDef def = {.shape = shape, .position = position, .density = random.uniform(300, 3000)};
  def.material = material(random);
  def.user_data = random.next() % 8;
  def.filter.category = chance(random, 2) ? 2 : 4;
  return def;
}

// A solid with an inner radius of 0.12 m or more, within 0.6 m of the middle.
ConvexShape solid(Random& random) {
  const double radius = random.uniform(0.15, 0.4), half_height = random.uniform(0.15, 0.35);
  switch (pick(random, 6)) {
    case 0:
      return Sphere{radius};
    case 1:
      return Box{random.in_box(Vector3::Constant(0.1)) + Vector3::Constant(0.25)};
    case 2:
      return Capsule{0.6 * radius + 0.06, half_height};
    case 3:
      return Cylinder{radius, half_height};
    case 4:
      return Cone{radius + 0.1, half_height + 0.1};
    default:
      return scene::random_rock(random, random.uniform(0.3, 0.45), 12, 40);
  }
}

Shape as_shape(const ConvexShape& shape) {
  return std::visit([](const auto& of) { return Shape(of); }, shape);
}

constexpr double reach = 0.65;  // m, of a solid

Thing single(Random& random) {
  Thing thing = {.kind = "solid", .half = Vector3::Constant(reach)};
  BodyDef def = body(random, as_shape(solid(random)));
  def.orientation = random.rotation();
  def.velocity = random.in_box({2, 2, 2});
  def.angular_velocity = random.in_box({5, 5, 5});
  if (chance(random, 4)) def.linear_damping = def.angular_damping = 0.2;
  if (chance(random, 8)) def.gravity_scale = 0.5;
  def.continuous = chance(random, 6);
  thing.bodies.push_back(def);
  return thing;
}

Thing bullet(Random& random) {
  Thing thing = {.kind = "bullet", .half = Vector3::Constant(0.3)};
  BodyDef def = body(random, Sphere{random.uniform(0.05, 0.12)});
  def.velocity = random.in_box({40, 40, 20}) - Vector3(0, 0, 20);
  def.continuous = true;
  thing.bodies.push_back(def);
  return thing;
}

Thing locked(Random& random) {
  Thing thing = single(random);
  thing.kind = "locked solid";
  BodyDef& def = thing.bodies.front();
  def.locks = chance(random, 2) ? MotionLocks::plane(Axis::Y) : MotionLocks{.angular = {true, true, true}};
  return thing;
}

Thing compound(Random& random) {
  Thing thing = {.kind = "compound", .half = {1.1, 0.6, 0.6}};
  Compound shape;
  shape.children.push_back({.shape = Box{{0.4, 0.1, 0.1}}});
  for (const double side : {-1.0, 1.0}) {
    shape.children.push_back({.shape = solid(random),
                              .position = {side * 0.45, 0, 0},
                              .orientation = random.rotation(),
                              .density_factor = random.uniform(0.5, 2),
                              .material = material(random)});
  }
  thing.bodies.push_back(body(random, shape));
  return thing;
}

Thing chain(Random& random) {
  Thing thing = {.kind = "chain", .half = {0.3, 0.3, 1.2}};
  constexpr int links = 7;
  for (int i = 0; i < links; ++i) {
    thing.bodies.push_back(body(random, Capsule{0.06, 0.09}, {0, 0, 0.3 * (i - links / 2)}));
    if (i == 0) continue;
    thing.links.push_back({.kind = BallJoint{.friction = random.uniform(0, 0.1)},
                           .first = static_cast<std::size_t>(i - 1),
                           .second = static_cast<std::size_t>(i),
                           .at = {{0, 0, 0.3 * (i - links / 2) - 0.15}}});
  }
  for (Link& link : thing.links) link.at_second = link.at;
  return thing;
}

Thing rope(Random& random) {
  Thing thing = {.kind = "rope", .half = {1.2, 0.3, 0.3}};
  constexpr int balls = 5;
  const bool rods = chance(random, 2);
  for (int i = 0; i < balls; ++i) {
    const Vector3 place(0.45 * (i - balls / 2), 0, 0);
    thing.bodies.push_back(body(random, Sphere{0.15}, place));
    if (i == 0) continue;
    thing.links.push_back({.kind = DistanceJoint{{.range = {rods ? 0.45 : 0, 0.45}}},
                           .first = static_cast<std::size_t>(i - 1),
                           .second = static_cast<std::size_t>(i),
                           .at = {thing.bodies[static_cast<std::size_t>(i - 1)].position},
                           .at_second = {place}});
  }
  return thing;
}

// Two boxes side by side, joined in the middle between them.
Thing pair(Random& random, const char* kind, const JointKind& joint, const Quaternion& turn = Quaternion::Identity()) {
  Thing thing = {.kind = kind, .half = {0.9, 0.4, 0.4}};
  for (const double side : {-1.0, 1.0}) {
    thing.bodies.push_back(
        body(random, Box{{0.3, random.uniform(0.1, 0.25), random.uniform(0.1, 0.25)}}, {side * (0.3 + gap), 0, 0}));
  }
  thing.links.push_back({.kind = joint, .first = 0, .second = 1, .at = {Vector3::Zero(), turn}});
  thing.links.back().at_second = thing.links.back().at;
  return thing;
}

const Quaternion x_to_z(std::sqrt(0.5), 0, -std::sqrt(0.5), 0);  // the frame's x axis points up
const Quaternion x_to_y(std::sqrt(0.5), 0, 0, std::sqrt(0.5));   // or along y

Thing door(Random& random) {
  JointAxis angle = {.range = {-1, 1, 0.3}, .motor = JointMotor{.speed = random.uniform(-2, 2), .max_force = 20}};
  if (chance(random, 2)) angle.range = {};
  return pair(random, "door", HingeJoint{angle}, x_to_z);
}

Thing servo(Random& random) {
  const JointServo servo = {.target = random.uniform(-0.5, 0.5), .stiffness = 200, .damping = 20};
  return pair(random, "servo",
              HingeJoint{{.motor = JointMotor{.max_force = 100, .servo = servo}, .armature = random.uniform(0, 0.5)}},
              x_to_y);
}

Thing slider(Random& random) {
  JointAxis offset = {.range = {-0.01, 0.4}, .spring = JointSpring{.hertz = random.uniform(0.5, 8), .rest = 0.1}};
  if (chance(random, 2)) offset.spring = JointSpring{.stiffness = random.uniform(100, 1e4), .damping = 10};
  return pair(random, "slider", SliderJoint{offset});
}

Thing cross(Random& random) {
  return pair(random, "cross",
              UniversalJoint{{.range = {-1, 1}}, {.range = {-1, 1}, .spring = JointSpring{.hertz = 2}}});
}

Thing cone(Random& random) {
  return pair(
      random, "cone",
      ConeTwistJoint{.swing_limit = random.uniform(0.2, 1), .twist = {.range = {-0.5, 0.5}}, .swing_friction = 0.5});
}

Thing six(Random& random) {
  const JointAxis locked = {.range = {0, 0}};
  return pair(
      random, "six axes",
      SixDofJoint{.offset = {JointAxis{.range = {-0.01, 0.2}, .spring = JointSpring{.hertz = 4}}, locked, locked},
                  .turn = {JointAxis{.spring = JointSpring{.hertz = 3, .damping_ratio = 0.2}}, locked,
                           JointAxis{.range = {-0.4, 0.4}}}});
}

Thing glued(Random& random) {
  Thing thing = {.kind = "glued boxes", .half = {1.1, 0.4, 0.4}};
  constexpr int boxes = 4;
  for (int i = 0; i < boxes; ++i) {
    const double x = 0.5 * (i - 1.5);
    thing.bodies.push_back(body(random, Box{{0.24, 0.2, 0.2}}, {x, 0, 0}));
    if (i == 0) continue;
    thing.links.push_back({.kind = FixedJoint{},
                           .first = static_cast<std::size_t>(i - 1),
                           .second = static_cast<std::size_t>(i),
                           .at = {{x - 0.25, 0, 0}},
                           .at_second = {{x - 0.25, 0, 0}},
                           .break_force = random.uniform(2e3, 5e4)});
  }
  return thing;
}

// Two wheels hinged to a bar, which turn each other as gears.
Thing gears(Random& random) {
  Thing thing = {.kind = "gears", .half = {0.9, 0.5, 0.5}};
  thing.bodies.push_back(body(random, Box{{0.7, 0.05, 0.1}}));
  for (const double side : {-1.0, 1.0}) {
    BodyDef wheel = body(random, Cylinder{0.3, 0.08}, {side * 0.4, 0.2, 0});
    wheel.orientation = Quaternion(std::sqrt(0.5), std::sqrt(0.5), 0, 0);  // its axis along y
    const std::size_t number = thing.bodies.size();
    thing.bodies.push_back(wheel);
    const Pose hub = {wheel.position, x_to_y};
    JointAxis angle = {};
    if (side < 0) angle.motor = JointMotor{.speed = 3, .max_force = 10};
    thing.links.push_back({.kind = HingeJoint{angle}, .first = 0, .second = number, .at = hub, .at_second = hub});
  }
  thing.links.push_back({.kind = GearJoint{.ratio = 1.5},
                         .first = 1,
                         .second = 2,
                         .at = {thing.bodies[1].position, x_to_y},
                         .at_second = {thing.bodies[2].position, x_to_y}});
  return thing;
}

Thing cart(Random& random) {
  Thing thing = {.kind = "cart", .half = {0.9, 0.7, 0.5}};
  BodyDef chassis = body(random, Box{{0.6, 0.25, 0.1}});
  chassis.density = 1000;
  thing.bodies.push_back(chassis);
  for (int i = 0; i < 4; ++i) {
    const Vector3 hub(i < 2 ? 0.45 : -0.45, i % 2 == 0 ? 0.45 : -0.45, -0.1);
    BodyDef wheel = body(random, Sphere{0.17}, hub);
    wheel.density = 500;
    WheelJoint joint = {.suspension = {.range = {-0.1, 0.1}, .spring = JointSpring{.hertz = 5, .damping_ratio = 0.7}}};
    if (i < 2) {
      joint.steering = {.range = {-0.6, 0.6}, .spring = JointSpring{.hertz = 5, .rest = random.uniform(-0.3, 0.3)}};
    } else {
      joint.spin.motor = JointMotor{.speed = random.uniform(-10, 10), .max_force = 20};
    }
    thing.links.push_back({.kind = joint, .first = 0, .second = thing.bodies.size(), .at = {hub}, .at_second = {hub}});
    thing.bodies.push_back(wheel);
  }
  return thing;
}

Thing stack(Random& random) {
  Thing thing = {.kind = "stack", .half = {0.4, 0.4, 1}};
  const double heavy = chance(random, 2) ? random.uniform(1, 50) : 1;
  for (int i = 0; i < 4; ++i) {
    thing.bodies.push_back(body(random, Box{{0.3, 0.3, 0.2}}, {0, 0, (0.4 + gap) * (i - 1.5)}));
    if (i == 3) thing.bodies.back().density *= heavy;
  }
  return thing;
}

Thing sensor(Random& random) {
  Thing thing = {.kind = "sensor", .half = {1, 1, 1}};
  BodyDef def = body(random, as_shape(solid(random)));
  def.type = BodyType::Static;
  def.sensor = true;
  def.filter = {};
  thing.bodies.push_back(def);
  return thing;
}

Thing obstacle(Random& random) {
  Thing thing = {.kind = "obstacle", .half = {1, 1, 0.5}};
  BodyDef def = body(random, Box{{0.8, 0.8, 0.1}});
  def.type = chance(random, 2) ? BodyType::Static : BodyType::Kinematic;
  def.filter = {};
  if (def.type == BodyType::Static) {
    def.orientation = Quaternion(1, 0.1, random.uniform(-0.2, 0.2), 0).normalized();
    def.surface_velocity = {random.uniform(-2, 2), 0, 0};
  } else {
    def.angular_velocity = {0, 0, random.uniform(-2, 2)};
  }
  thing.bodies.push_back(def);
  return thing;
}

using Maker = Thing (*)(Random& random);
constexpr std::array makers = {&single, &compound, &chain,  &single, &rope,  &door,    &glued, &single,
                               &servo,  &slider,   &stack,  &cross,  &cone,  &six,     &gears, &single,
                               &cart,   &bullet,   &locked, &sensor, &stack, &obstacle};

Pose in_body(const BodyDef& body, const Pose& frame) {
  const Quaternion turn = body.orientation.conjugate();
  return {turn * (frame.position - body.position), turn * frame.orientation};
}

}  // namespace

std::size_t thing_kinds() { return makers.size(); }

Thing make_thing(std::size_t kind, Random& random) { return makers[kind](random); }

BodyDef placed(const BodyDef& body, const Pose& thing) {
  BodyDef def = body;
  def.position = thing.position + thing.orientation * body.position;
  def.orientation = thing.orientation * body.orientation;
  return def;
}

JointDef joint_of(const Link& link, const Thing& thing, BodyId first, BodyId second) {
  return {.kind = link.kind,
          .first = first,
          .second = second,
          .frame_first = in_body(thing.bodies[link.first], link.at),
          .frame_second = in_body(thing.bodies[link.second], link.at_second),
          .break_force = link.break_force};
}

}  // namespace atl::soak
