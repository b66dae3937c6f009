#include "ragdoll.h"

#include <array>
#include <string>

#include "building_blocks.h"
#include "joining.h"

namespace atl::scene {
namespace {

// Positions on a figure that stands upright: x ahead, y to its left, z up from the pelvis, m.
constexpr double middle = -0.12;  // z, of what is farthest away
constexpr double friction = 2;    // N m
constexpr double damping = 1;     // 1/s

// Soft enough that round limbs don't roll far.
constexpr Material flesh = {.friction = builtin_material.friction, .rolling_friction = 0.01};

const Quaternion upright = Quaternion::Identity();
const Quaternion sideways(0.70710678118654752, 0.70710678118654752, 0, 0);  // a shape's z axis along y, either way

// Adds parts in the figure's frame, and turns them into the world's.
class Figure {
 public:
  Figure(Scene& scene, int number, const Pose& pose)
      : scene_(scene), prefix_("doll_" + std::to_string(number) + "_"), pose_(pose) {}

  std::size_t part(const std::string& name, const Shape& shape, const Vector3& centre, double mass,
                   const Quaternion& orientation = upright) {
    SceneBody body;
    body.name = prefix_ + name;
    const Pose world = in_world({centre, orientation});
    body.def = {.shape = shape,
                .position = world.position,
                .orientation = world.orientation,
                .mass = mass,
                .material = flesh,
                .angular_damping = damping};
    scene_.bodies.push_back(body);
    return scene_.bodies.size() - 1;
  }

  /// The x axis of both frames along `axis`.
  void join(const std::string& name, const JointKind& kind, std::size_t first, std::size_t second, const Vector3& at,
            const Vector3& axis) {
    scene_.joints.push_back(joined(scene_, prefix_ + name, kind, first, second, in_world({at, frame_along(axis)})));
  }

 private:
  Pose in_world(const Pose& local) const {
    return {pose_.position + pose_.orientation * (local.position - Vector3(0, 0, middle)),
            (pose_.orientation * local.orientation).normalized()};
  }

  Scene& scene_;
  std::string prefix_;
  Pose pose_;
};

JointAxis turning(double lower, double upper) {
  return {.range = {lower, upper}, .motor = JointMotor{.speed = 0, .max_force = friction}};
}

ConeTwistJoint cone(double swing, double twist) {
  return {.swing_limit = swing, .twist = turning(-twist, twist), .swing_friction = friction};
}

// Turns are given as twice the sine of half their angle, which at these is the angle to within 4%.
SixDofJoint stiff(double swing, double twist) {
  constexpr JointAxis locked = {.range = {0, 0}};
  return {.offset = {locked, locked, locked},
          .turn = {turning(-twist, twist), turning(-swing, swing), turning(-swing, swing)}};
}

HingeJoint hinge(double lower, double upper) { return {.angle = turning(lower, upper)}; }

// side: 1 for the left, -1 for the right.
void add_arm(Figure& figure, std::size_t chest, const std::string& name, double side) {
  const Vector3 out(0, side, 0);
  const auto at = [&](double y) { return Vector3(0, side * y, 0.46); };
  const std::size_t upper =
      figure.part(name + "_upper_arm", Capsule{.radius = 0.05, .half_height = 0.1}, at(0.345), 2.2, sideways);
  const std::size_t fore =
      figure.part(name + "_forearm", Capsule{.radius = 0.042, .half_height = 0.118}, at(0.67), 1.8, sideways);
  figure.join(name + "_shoulder", cone(1.4, 1), chest, upper, at(0.185), out);
  // The forearm bends ahead.
  figure.join(name + "_elbow", hinge(0, 2.5), upper, fore, at(0.5), {0, 0, -side});
}

void add_leg(Figure& figure, std::size_t pelvis, const std::string& name, double side) {
  const auto at = [&](double x, double z) { return Vector3(x, side * 0.09, z); };
  const std::size_t thigh =
      figure.part(name + "_thigh", Capsule{.radius = 0.075, .half_height = 0.145}, at(0, -0.33), 8);
  const std::size_t shin = figure.part(name + "_shin", Capsule{.radius = 0.055, .half_height = 0.155}, at(0, -0.78), 4);
  const std::size_t foot = figure.part(name + "_foot", Box{{0.12, 0.045, 0.035}}, at(0.06, -1.035), 1);
  figure.join(name + "_hip", cone(1.1, 0.5), pelvis, thigh, at(0, -0.1), {0, 0, -1});
  // The shin bends back, the toes up.
  figure.join(name + "_knee", hinge(0, 2.4), thigh, shin, at(0, -0.56), {0, 1, 0});
  figure.join(name + "_ankle", hinge(-0.6, 0.6), shin, foot, at(0, -0.995), {0, 1, 0});
}

}  // namespace

void add_ragdoll(Scene& scene, int number, const Pose& pose) {
  Figure figure(scene, number, pose);
  const std::size_t pelvis = figure.part("pelvis", Box{{0.1, 0.15, 0.09}}, {0, 0, 0}, 10);
  const std::size_t chest = figure.part("chest", Box{{0.11, 0.17, 0.2}}, {0, 0, 0.32}, 23);
  const std::size_t head = figure.part("head", Sphere{0.11}, {0, 0, 0.69}, 5);
  figure.join("waist", stiff(0.5, 0.4), pelvis, chest, {0, 0, 0.105}, {0, 0, 1});
  figure.join("neck", stiff(0.6, 1), chest, head, {0, 0, 0.55}, {0, 0, 1});
  add_arm(figure, chest, "left", 1);
  add_arm(figure, chest, "right", -1);
  add_leg(figure, pelvis, "left", 1);
  add_leg(figure, pelvis, "right", -1);
}

}  // namespace atl::scene
