// An arm of two links turns on a post, picks a crate up, and puts it down on the other side. Its hinges are servos, and
// what the hand holds it holds by a joint.

#include <atoll/atoll.h>

#include <cmath>
#include <iostream>

namespace {

using atl::BodyId;
using atl::JointId;
using atl::Vector3;

constexpr double step = 1.0 / 120;

atl::HingeJoint servo(double target) {
  return {{.motor = atl::JointMotor{.max_force = 2000,
                                    .servo = atl::JointServo{.target = target, .stiffness = 4000, .damping = 400}}}};
}

struct Arm {
  atl::World& world;
  JointId turn;      // about the post
  JointId shoulder;  // up and down

  // Takes the hand there along a smooth way.
  void move(double from_turn, double to_turn, double from_lift, double to_lift, double seconds) {
    const int steps = static_cast<int>(seconds / step);
    for (int i = 1; i <= steps; ++i) {
      const double t = static_cast<double>(i) / steps, way = t * t * (3 - 2 * t);
      world.set_joint(turn, servo(from_turn + way * (to_turn - from_turn)));
      world.set_joint(shoulder, servo(from_lift + way * (to_lift - from_lift)));
      world.step(step);
    }
  }
};

}  // namespace

int main() {
  atl::World world({.gravity = {0, 0, -9.81}});
  world.add_body({.type = atl::BodyType::Static, .shape = atl::HalfSpace{.normal = {0, 0, 1}}});
  const BodyId post = world.add_body({.type = atl::BodyType::Static,
                                      .shape = atl::Cylinder{.radius = 0.1, .half_height = 0.25},
                                      .position = {0, 0, 0.25}});
  const BodyId base = world.add_body({.shape = atl::Box{.half_extents = {0.12, 0.12, 0.05}}, .position = {0, 0, 0.75}});
  const BodyId hand =
      world.add_body({.shape = atl::Box{.half_extents = {0.5, 0.04, 0.04}}, .position = {0.5, 0, 0.75}});
  const BodyId crate =
      world.add_body({.shape = atl::Box{.half_extents = {0.1, 0.1, 0.1}}, .position = {0.9, 0, 0.1}, .density = 300});

  const Vector3 pivot = {0, 0, 0.75};
  const JointId turn = world.add_joint(joint_at(world, servo(0), post, base, pivot, Vector3::UnitZ()));
  const JointId shoulder = world.add_joint(joint_at(world, servo(0), base, hand, pivot, Vector3::UnitY()));
  Arm arm{world, turn, shoulder};

  const double reach_down = std::asin((0.75 - 0.32) / 0.9);  // so that the hand is just above the crate
  arm.move(0, 0, 0, reach_down, 1);
  const JointId grip = world.add_joint(joint_at(world, atl::FixedJoint{}, hand, crate, world.pose(crate).position));
  arm.move(0, 0, reach_down, 0.1, 1);
  const double lifted = world.pose(crate).position.z();
  arm.move(0, 2, 0.1, 0.1, 2);
  arm.move(2, 2, 0.1, reach_down, 1);
  arm.move(2, 2, reach_down, reach_down, 0.5);  // servos lag behind by their damping over their stiffness
  world.remove_joint(grip);
  arm.move(2, 2, reach_down, 0.1, 0.5);

  const Vector3 put = world.pose(crate).position;
  const Vector3 wanted = {0.9 * std::cos(2.0), 0.9 * std::sin(2.0), 0.1};
  std::cout << "the crate was lifted to " << lifted << " m and put at " << put.transpose() << ", wanted "
            << wanted.transpose() << "\n";
  return lifted > 0.4 && (put - wanted).norm() < 0.05 ? 0 : 1;
}
