#include "definitions.h"

#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace atl::fuzz {

double Definitions::number(double lower, double upper) {
  if (!has_normal_numbers() && bytes_.one_in(12)) return bytes_.any();
  return bytes_.within(lower, upper);
}

int Definitions::integer(int lower, int upper) {
  constexpr std::array<int, 8> wrong = {
      0, -1, 1025, 1 << 20, 1 << 30, std::numeric_limits<int>::max(), std::numeric_limits<int>::min(), -7};
  if (!has_normal_numbers() && bytes_.one_in(12)) return wrong[bytes_.below(wrong.size())];
  return lower + static_cast<int>(bytes_.below(static_cast<std::size_t>(upper - lower + 1)));
}

Vector3 Definitions::vector(double reach) {
  const double x = number(-reach, reach);
  const double y = number(-reach, reach);
  const double z = number(-reach, reach);
  return {x, y, z};
}

Quaternion Definitions::orientation() {
  if (bytes_.flag()) return Quaternion::Identity();
  Quaternion turn;
  for (double& x : turn.coeffs()) x = number(-1, 1);
  if (has_normal_numbers() && turn.norm() < 0.01) return Quaternion::Identity();
  return turn;
}

std::string Definitions::name() {
  if (bytes_.flag()) return {};
  std::string name;
  for (std::uint32_t left = bytes_.below(5); left > 0; --left) {
    name += has_normal_numbers() ? static_cast<char>('a' + bytes_.below(3)) : static_cast<char>(bytes_.byte());
  }
  return name;
}

ConvexHull Definitions::hull() {
  std::vector<Vector3> points;
  if (has_normal_numbers()) {
    for (const double x : {-1, 1}) points.push_back({0.2 * x, 0.1, -0.2});
    points.push_back({0, -0.3, -0.2});
    points.push_back({0, 0, 0.3});
  }
  for (std::uint32_t left = bytes_.below(12); left > 0; --left) points.push_back(vector(0.6));
  const ConvexHull made(points);
  if (bytes_.flag()) return made;
  const double factor = number(0.5, 2);
  return made.scaled({factor, bytes_.flag() ? -factor : factor, number(0.5, 2)});
}

TriangleMesh Definitions::mesh() {
  // A grid, bent up and down.
  constexpr std::uint32_t side = 4;
  std::vector<Vector3> vertices;
  for (std::uint32_t i = 0; i < side * side; ++i) {
    const double height = number(-0.3, 0.3);
    vertices.push_back({2.0 * (i % side) - 3, 2.0 * (i / side) - 3, height});
  }
  std::vector<TriangleMesh::Indices> triangles;
  for (std::uint32_t y = 0; y + 1 < side; ++y) {
    for (std::uint32_t x = 0; x + 1 < side; ++x) {
      const std::uint32_t corner = y * side + x;
      triangles.push_back({corner, corner + 1, corner + side + 1});
      triangles.push_back({corner, corner + side + 1, corner + side});
    }
  }
  if (!has_normal_numbers() && bytes_.one_in(4)) {
    triangles[bytes_.below(triangles.size())][bytes_.below(3)] =
        bytes_.flag() ? bytes_.below(20) : bytes_.bits<std::uint32_t>();
  }
  const TriangleMesh made(vertices, triangles, bytes_.flag() ? number(0, 3) : 0.0);
  return bytes_.flag() ? made : made.scaled({number(0.5, 2), -1, number(0.5, 2)});
}

HeightField Definitions::height_field() {
  const auto columns = static_cast<std::uint32_t>(integer(2, 5));
  const auto rows = static_cast<std::uint32_t>(integer(2, 5));
  std::vector<double> heights(has_normal_numbers() || !bytes_.one_in(8) ? std::uint64_t{columns} * rows % 64
                                                                        : bytes_.below(64));
  for (double& height : heights) height = number(-0.3, 0.3);
  const double spacing_x = number(0.5, 2);
  const double spacing_y = number(0.5, 2);
  return HeightField(columns, rows, spacing_x, spacing_y, std::move(heights), bytes_.flag());
}

ConvexShape Definitions::convex() {
  switch (bytes_.below(8)) {
    case 0:
      return Box{{number(0.1, 0.6), number(0.1, 0.6), number(0.1, 0.6)}};
    case 1:
      return Sphere{number(0.1, 0.6)};
    case 2:
      return Capsule{number(0.1, 0.4), number(0.1, 0.5)};
    case 3:
      return Cylinder{number(0.1, 0.6), number(0.1, 0.6)};
    case 4:
      return Cone{number(0.1, 0.6), number(0.1, 0.6)};
    case 5:
      return Ellipsoid{{number(0.1, 0.6), number(0.1, 0.6), number(0.1, 0.6)}};
    case 6:
      // Neither ball may hold the other.
      return TaperedCapsule{{number(0.1, 0.4), number(0.1, 0.4)}, number(0.16, 0.5)};
    default:
      return hull();
  }
}

Compound Definitions::compound() {
  Compound compound;
  const int count = integer(1, 4);
  for (int i = 0; i < count && i < 5; ++i) {
    CompoundChild child{.shape = convex()};
    child.position = vector(0.5);
    child.orientation = orientation();
    child.density_factor = number(0.2, 4);
    if (bytes_.one_in(3)) child.material = material();
    if (bytes_.one_in(3)) child.filter = filter();
    compound.children.push_back(child);
  }
  return compound;
}

Shape Definitions::shape(BodyType type) {
  const bool may_be_surface = type != BodyType::Dynamic || (!has_normal_numbers() && bytes_.one_in(16));
  if (may_be_surface && bytes_.flag()) {
    switch (bytes_.below(3)) {
      case 0: {
        HalfSpace plane{{0, 0, 1}, number(-1, 1)};
        if (bytes_.one_in(3)) plane.normal = Vector3(0.1, 0, 1) + 0.1 * vector(1);
        return plane;
      }
      case 1:
        return mesh();
      default:
        return height_field();
    }
  }
  if (bytes_.one_in(6)) return compound();
  return std::visit([](const auto& solid) { return Shape(solid); }, convex());
}

Material Definitions::material() {
  Material material;
  material.friction = number(0, 1.2);
  if (bytes_.one_in(3)) material.restitution = number(0, 1);
  if (bytes_.one_in(4)) material.rolling_friction = number(0, 0.1);
  if (bytes_.one_in(4)) material.torsional_friction = number(0, 0.1);
  if (bytes_.one_in(4)) material.friction_rule = static_cast<CombineRule>(bytes_.below(6));
  if (bytes_.one_in(4)) material.restitution_rule = static_cast<CombineRule>(bytes_.below(6));
  if (bytes_.one_in(4)) material.id = bytes_.below(3);
  if (bytes_.one_in(6)) Eigen::Map<Vector3>(material.friction_direction.data()) = vector(2);
  material.friction_across = number(0, 1.2);
  return material;
}

CollisionFilter Definitions::filter() {
  return {.category = bytes_.bits<std::uint8_t>() | 1u,
          .mask = bytes_.flag() ? ~0u : bytes_.bits<std::uint8_t>(),
          .group = bytes_.flag() ? 0 : static_cast<std::int32_t>(bytes_.below(5)) - 2};
}

namespace {

// Resets the settings that contradict a target.
void give_way_to_target(Settings& settings) {
  if (!settings.target.is_set()) return;
  settings.stabilisation = Stabilisation::Soft;
  if (settings.target.penetration) settings.contact_hertz.reset();
  if (settings.target.joint_gap) settings.joint_hertz.reset();
}

}  // namespace

BodyDef Definitions::body() {
  BodyDef def;
  const std::uint32_t type = bytes_.below(8);
  def.type = type == 0 ? BodyType::Static : type == 1 ? BodyType::Kinematic : BodyType::Dynamic;
  def.shape = shape(def.type);
  def.position = vector(2);
  if (def.type == BodyType::Dynamic) def.position.z() += 2;
  def.orientation = orientation();
  if (def.type != BodyType::Static || (!has_normal_numbers() && bytes_.one_in(8))) {
    if (bytes_.flag()) def.velocity = vector(bytes_.one_in(6) ? 100 : 4);
    if (bytes_.one_in(3)) def.angular_velocity = vector(bytes_.one_in(6) ? 60 : 4);
  }
  if (bytes_.one_in(4)) def.density = number(10, 8000);
  if (bytes_.one_in(4)) def.mass = number(0.1, 1000);
  if (def.mass && bytes_.one_in(3)) {
    const double moment = number(0.5, 1) * *def.mass;
    def.inertia = Vector3(moment, number(0.7, 1) * moment, moment).asDiagonal();
    if (!has_normal_numbers() && bytes_.flag()) def.inertia->coeffRef(bytes_.below(3), 0) = number(-1, 1);
  }
  if (bytes_.flag()) def.material = material();
  if (bytes_.one_in(6)) def.surface_velocity = vector(2);
  if (bytes_.one_in(6)) def.surface_angular_velocity = vector(2);
  if (bytes_.one_in(6)) def.gravity_scale = number(-1, 2);
  if (bytes_.one_in(6)) def.linear_damping = number(0, 2);
  if (bytes_.one_in(6)) def.angular_damping = number(0, 2);
  if (def.type == BodyType::Dynamic && bytes_.one_in(10)) {
    const std::uint8_t locks = bytes_.byte();
    for (std::size_t i = 0; i < 3; ++i) {
      def.locks.linear[i] = (locks >> i & 1) != 0;
      def.locks.angular[i] = (locks >> (i + 3) & 1) != 0;
    }
  }
  if (bytes_.one_in(4)) def.filter = filter();
  def.continuous = bytes_.one_in(5);
  def.sensor = bytes_.one_in(12);
  if (def.sensor) def.notices_static = bytes_.flag(), def.notices_sensors = bytes_.flag();
  if (bytes_.one_in(8)) def.contact_event_force = number(0, 100);
  if (bytes_.one_in(12)) def.max_speed = number(0.1, 20);
  if (bytes_.one_in(12)) def.max_angular_speed = number(0.1, 20);
  def.may_sleep = !bytes_.one_in(10);
  def.awake = def.type != BodyType::Dynamic || !def.may_sleep || !bytes_.one_in(8);
  if (!def.awake) def.velocity = def.angular_velocity = Vector3::Zero();
  const bool is_solid = !std::holds_alternative<HalfSpace>(def.shape) &&
                        !std::holds_alternative<TriangleMesh>(def.shape) &&
                        !std::holds_alternative<HeightField>(def.shape);
  if (has_normal_numbers() && !is_solid) def.sensor = false;
  def.name = name();
  def.user_data = bytes_.byte();
  return def;
}

JointAxis Definitions::axis(bool angle) {
  const double reach = angle ? 1.5 : 0.6;
  JointAxis axis;
  if (bytes_.flag()) {
    axis.range.lower = number(-reach, 0);
    axis.range.upper = bytes_.one_in(4) ? axis.range.lower : number(0, reach);
    if (bytes_.one_in(3)) axis.range.restitution = number(0, 1);
  }
  if (bytes_.one_in(3)) {
    JointSpring spring{.hertz = number(0.2, 20), .damping_ratio = number(0, 2), .rest = number(-reach, reach)};
    if (bytes_.one_in(3)) spring.stiffness = number(0, 1e4);
    if (bytes_.one_in(3)) spring.damping = number(0, 1e2);
    axis.spring = spring;
  }
  if (bytes_.one_in(3)) {
    JointMotor motor{.speed = number(-4, 4), .max_force = bytes_.one_in(5) ? unlimited : number(0, 500)};
    if (bytes_.one_in(3)) {
      motor.servo = JointServo{
          .target = number(-reach, reach), .stiffness = number(1, 1e4), .damping = bytes_.flag() ? number(0, 100) : 0};
    }
    if (!has_normal_numbers() && bytes_.one_in(8)) motor.max_force.reset();
    axis.motor = motor;
  }
  if (bytes_.one_in(8)) axis.armature = number(0, 2);
  if (bytes_.one_in(8)) axis.friction = number(0, 50);
  return axis;
}

JointKind Definitions::joint_kind() {
  switch (bytes_.below(10)) {
    case 0:
      return BallJoint{.friction = bytes_.one_in(3) ? number(0, 10) : 0};
    case 1:
      return HingeJoint{axis(true)};
    case 2:
      return SliderJoint{axis(false)};
    case 3:
      return FixedJoint{};
    case 4: {
      DistanceJoint rope{axis(false)};
      rope.distance.range = {.lower = bytes_.flag() ? 0 : number(0.1, 0.6), .upper = number(0.7, 2)};
      if (bytes_.flag()) rope.distance.range.lower = rope.distance.range.upper;
      if (rope.distance.spring) rope.distance.spring->rest = number(0.1, 2);
      if (rope.distance.motor && rope.distance.motor->servo) rope.distance.motor->servo->target = number(0.1, 2);
      return rope;
    }
    case 5:
      return UniversalJoint{axis(true), axis(true)};
    case 6: {
      ConeTwistJoint cone{.swing_limit = bytes_.flag() ? unlimited : number(0.1, 3), .twist = axis(true)};
      if (bytes_.one_in(3)) cone.swing_friction = number(0, 10);
      return cone;
    }
    case 7: {
      SixDofJoint six;
      for (JointAxis& offset : six.offset) offset = axis(false);
      for (JointAxis& turn : six.turn) turn = axis(true);
      return six;
    }
    case 8:
      return GearJoint{.ratio = bytes_.flag() ? number(0.2, 3) : number(-3, -0.2), .rack = bytes_.flag()};
    default: {
      WheelJoint wheel{
          .suspension = axis(false), .steering = bytes_.flag() ? axis(true) : JointAxis{{0, 0}}, .spin = axis(true)};
      if (!wheel.suspension.motor && !wheel.suspension.spring) wheel.suspension.spring = JointSpring{};
      return wheel;
    }
  }
}

JointDef Definitions::tendon(const World& world) {
  const std::vector<JointId> joints = world.joints();
  TendonJoint tendon{.length = axis(true)};
  const std::uint32_t count = 1 + bytes_.below(3);
  for (std::uint32_t i = 0; i < count; ++i) {
    TendonTerm term{.joint = joints[bytes_.below(joints.size())], .coordinate = bytes_.one_in(8) ? 1u : 0u};
    term.polynomial[1] = number(-2, 2);
    if (bytes_.one_in(4)) term.polynomial[2] = number(-1, 1);
    tendon.terms.push_back(term);
  }
  return {.kind = tendon};
}

JointDef Definitions::joint(const World& world, BodyId first, BodyId second) {
  if (bytes_.one_in(8) && world.joint_count() > 0) return tendon(world);
  const JointKind kind = joint_kind();
  JointDef def{.kind = kind, .first = first, .second = second};
  if (bytes_.one_in(4) || !world.contains(first) || !world.contains(second)) {
    def.frame_first = {vector(0.5), orientation()};
    def.frame_second = {vector(0.5), orientation()};
  } else {
    // The frames fit the current poses, so that nothing has to be pulled together.
    const Vector3 middle = 0.5 * (world.pose(first).position + world.pose(second).position);
    const Vector3 axis = std::array<Vector3, 3>{Vector3::UnitX(), Vector3::UnitY(), Vector3(1, 2, 3)}[bytes_.below(3)];
    def = joint_at(world, kind, first, second, middle, axis);
    if (std::holds_alternative<DistanceJoint>(kind)) def.frame_first = def.frame_second = {};
  }
  def.collide = bytes_.flag();
  if (bytes_.one_in(6)) def.break_force = number(10, 1e5);
  if (bytes_.one_in(6)) def.break_torque = number(10, 1e5);
  def.name = name();
  def.user_data = bytes_.byte();
  return def;
}

Settings Definitions::with_target(Settings settings) {
  ErrorTarget& target = settings.target;
  target = {};
  const std::uint32_t limited = bytes_.below(16);  // a bit an error
  if (limited & 1) target.penetration = number(1e-5, 0.01);
  if (limited & 2) target.joint_gap = number(1e-5, 0.01);
  if (limited & 4) target.residual = number(1e-3, 0.1);
  if (limited & 8) target.motion = number(1e-4, 0.1);
  target.min_substeps = integer(1, 4);
  target.max_substeps = integer(4, 24);
  if (has_normal_numbers() || !bytes_.one_in(8)) give_way_to_target(settings);
  return settings;
}

Settings Definitions::settings(Settings settings) {
  for (std::uint32_t changes = 1 + bytes_.below(3); changes > 0; --changes) {
    switch (bytes_.below(20)) {
      case 0:
        settings.substeps = integer(1, 8);
        break;
      case 1:
        settings.iterations = integer(1, 4);
        break;
      case 2:
        settings.relax_iterations = integer(0, 3);
        break;
      case 3:
        settings.tolerance = number(0, 0.01);
        break;
      case 4:
        settings.friction = bytes_.flag() ? FrictionModel::Cone : FrictionModel::Pyramid;
        break;
      case 5:
        settings.warm_starting = bytes_.flag();
        break;
      case 6:
        settings.stabilisation = static_cast<Stabilisation>(bytes_.below(3));
        break;
      case 7:
        settings.correction = number(0.05, 1);
        break;
      case 8:
        settings.slop = number(0, 0.01);
        break;
      case 9:
        settings.contact_hertz = number(1, 60);
        if (bytes_.flag()) settings.contact_hertz.reset();
        break;
      case 10:
        settings.contact_damping_ratio = number(0, 20);
        break;
      case 11:
        settings.contact_push_speed = number(0.1, 10);
        break;
      case 12:
        settings.restitution_threshold = number(0, 2);
        if (bytes_.flag()) settings.restitution_threshold.reset();
        break;
      case 13:
        settings.contact_solver = static_cast<ContactSolver>(bytes_.below(3));
        break;
      case 14:
        settings.joint_solver = static_cast<JointSolver>(bytes_.below(3));
        break;
      case 15:
        settings.joint_hertz = number(1, 120);
        settings.joint_damping_ratio = number(0, 5);
        break;
      case 16:
        settings.sleeping = bytes_.flag();
        settings.time_to_sleep = number(0.05, 0.5);
        settings.sleep_speed = number(0.01, 1);
        break;
      case 17:
        settings.contact_events = bytes_.flag();
        if (bytes_.flag()) settings.contact_event_force = number(0, 100);
        break;
      case 18:
        settings.keep_contact_problem = bytes_.flag();
        settings.accelerations = bytes_.flag();
        break;
      default:
        settings.run_everything = bytes_.flag();
        settings.profile = bytes_.flag();
    }
  }
  give_way_to_target(settings);
  return settings;
}

QueryShape Definitions::query_shape() {
  QueryShape query;
  if (!bytes_.one_in(4)) query.shape = convex();
  query.position = vector(3);
  query.orientation = orientation();
  return query;
}

ShapeCast Definitions::shape_cast() {
  ShapeCast cast{.shape = convex()};
  cast.position = vector(4);
  cast.orientation = orientation();
  cast.translation = vector(6);
  return cast;
}

Ray Definitions::ray() {
  Ray ray{.origin = vector(4)};
  ray.direction = vector(1);
  if (has_normal_numbers() && ray.direction.norm() < 0.01) ray.direction = {0, 0, -1};
  if (bytes_.flag()) ray.max_distance = number(0, 10);
  ray.both_sides = bytes_.flag();
  return ray;
}

}  // namespace atl::fuzz
