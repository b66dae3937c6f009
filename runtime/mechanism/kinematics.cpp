#include "mechanism/kinematics.h"

#include <jobs/assert.h>
#include <solver/integrate/free_flight.h>

namespace atl::mechanism {
namespace {

auto numbers(const VectorXd& values, std::size_t first, std::size_t count) {
  return values.segment(static_cast<Eigen::Index>(first), static_cast<Eigen::Index>(count));
}
auto numbers(VectorXd& values, std::size_t first, std::size_t count) {
  return values.segment(static_cast<Eigen::Index>(first), static_cast<Eigen::Index>(count));
}

Quaternion quaternion_at(const VectorXd& q, std::size_t first) {
  return Quaternion(Eigen::Vector4d(numbers(q, first, 4)));
}

// In the world, of a frame on a body.
Quaternion orientation_of(const World& world, BodyId body, const Pose& frame) {
  return world.pose(body).orientation * frame.orientation;
}

// Lets a frame, and what moves with it, go on over one stage after the other.
struct Walk {
  const Tree& tree;
  const World& world;
  const VectorXd& q;
  const VectorXd& v;
  Kinematics& result;
  Pose frame = {};
  Vector6 velocity = Vector6::Zero();
  Vector6 drift = Vector6::Zero();

  double value_of(const Link& link, const Stage& stage) const {
    return stage.locked ? axis_of(world, link, stage).range.lower : q[static_cast<Eigen::Index>(stage.q)];
  }

  Pose pose_of(const Link& link, const Stage& stage) const {
    switch (stage.motion) {
      case Motion::Turn:
        return {Vector3::Zero(), solver::rotation_by(value_of(link, stage) * Vector3::Unit(stage.axis))};
      case Motion::Slide:
        return {value_of(link, stage) * Vector3::Unit(stage.axis), Quaternion::Identity()};
      case Motion::Ball:
        return {Vector3::Zero(), quaternion_at(q, stage.q)};
      case Motion::Free:
        break;
    }
    return {Vector3(numbers(q, stage.q, 3)), quaternion_at(q, stage.q + 3)};
  }

  Vector6 turning(const Vector3& axis) const {
    Vector6 motion;
    motion << axis, (frame.position - result.origin).cross(axis);
    return motion;
  }
  static Vector6 sliding(const Vector3& axis) {
    Vector6 motion;
    motion << Vector3::Zero(), axis;
    return motion;
  }

  // Takes the axes from the frame at which the stage begins. `sign`: -1 where the link is before the stage.
  void put_axes(const Stage& stage, double sign) {
    if (stage.locked) return;
    const auto put = [&](std::size_t place, const Vector6& motion) {
      result.axes.col(static_cast<Eigen::Index>(stage.v + place)) = sign * motion;
    };
    const Matrix3 axes = frame.orientation.toRotationMatrix();
    if (stage.motion == Motion::Turn) put(0, turning(axes.col(stage.axis)));
    if (stage.motion == Motion::Slide) put(0, sliding(axes.col(stage.axis)));
    for (int axis = 0; axis < 3 && stage.motion == Motion::Ball; ++axis) {
      put(static_cast<std::size_t>(axis), turning(axes.col(axis)));
    }
  }

  Vector6 rate_of(const Stage& stage) const {
    Vector6 rate = Vector6::Zero();
    for (std::size_t i = stage.v; i < stage.v + stage.v_count(); ++i) {
      const auto place = static_cast<Eigen::Index>(i);
      rate += v[place] * result.axes.col(place);
    }
    return rate;
  }

  // The axes of a stage move with the frame before it.
  void forward(const Link& link, const Stage& stage) {
    put_axes(stage, 1);
    const Vector6 rate = rate_of(stage);
    drift += cross_motion(velocity, rate);
    velocity += rate;
    frame = product(frame, pose_of(link, stage));
  }

  // From the second frame of a joint to the first one.
  void backward(const Link& link, const Stage& stage) {
    frame = product(frame, inverse(pose_of(link, stage)));
    put_axes(stage, -1);
    const Vector6 rate = rate_of(stage);
    velocity += rate;
    drift += cross_motion(velocity, rate);
  }

  // Its axes are the world's, at the origin of the body's frame, which moves.
  void put_free(const Link& link, const Stage& stage) {
    frame = pose_of(link, stage);
    for (int axis = 0; axis < 3; ++axis) {
      const auto place = static_cast<Eigen::Index>(stage.v) + axis;
      result.axes.col(place) = sliding(Vector3::Unit(axis));
      result.axes.col(place + 3) = turning(Vector3::Unit(axis));
    }
    velocity = rate_of(stage);
    drift = sliding(numbers(v, stage.v, 3).head<3>().cross(numbers(v, stage.v + 3, 3).head<3>()));
  }

  void take(const Link& link) {
    if (link.joint == JointId{}) return put_free(link, link.stages[0]);
    frame = product(frame, link.reversed ? link.frame_second : link.frame_first);
    if (link.reversed) {
      for (std::size_t i = link.stages.size(); i-- > 0;) backward(link, link.stages[i]);
    } else {
      for (const Stage& stage : link.stages) forward(link, stage);
    }
    frame = product(frame, inverse(link.reversed ? link.frame_first : link.frame_second));
  }
};

}  // namespace

Pose product(const Pose& a, const Pose& b) {
  return {a.position + a.orientation * b.position, a.orientation * b.orientation};
}

Pose inverse(const Pose& a) {
  const Quaternion back = a.orientation.conjugate();
  return {-(back * a.position), back};
}

Vector6 cross_motion(const Vector6& velocity, const Vector6& motion) {
  const Vector3 w = velocity.head<3>();
  Vector6 result;
  result << w.cross(motion.head<3>()), w.cross(motion.tail<3>()) + velocity.tail<3>().cross(motion.head<3>());
  return result;
}

Vector6 cross_force(const Vector6& velocity, const Vector6& force) {
  const Vector3 w = velocity.head<3>();
  Vector6 result;
  result << w.cross(force.head<3>()) + velocity.tail<3>().cross(force.tail<3>()), w.cross(force.tail<3>());
  return result;
}

VectorXd read_q(const Tree& tree, const World& world) {
  VectorXd q(static_cast<Eigen::Index>(tree.nq));
  for (const Link& link : tree.links) {
    for (const Stage& stage : link.stages) {
      if (stage.motion == Motion::Free) {
        const Pose pose = world.pose(link.body);
        numbers(q, stage.q, 7) << pose.position, pose.orientation.coeffs();
      } else if (stage.motion == Motion::Ball) {
        const JointDef& joint = world.joint(link.joint);
        const Quaternion first = orientation_of(world, joint.first, link.frame_first);
        const Quaternion second = orientation_of(world, joint.second, link.frame_second);
        numbers(q, stage.q, 4) = (first.conjugate() * second).normalized().coeffs();
      } else if (!stage.locked) {
        q[static_cast<Eigen::Index>(stage.q)] = world.joint_state(link.joint).position[stage.coordinate];
      }
    }
  }
  return q;
}

VectorXd read_v(const Tree& tree, const World& world) {
  VectorXd v(static_cast<Eigen::Index>(tree.nv));
  for (const Link& link : tree.links) {
    for (const Stage& stage : link.stages) {
      if (stage.motion == Motion::Free) {
        const Vector3 spin = world.angular_velocity(link.body);
        const Vector3 arm = world.pose(link.body).position - world.centre_of_mass(link.body);
        numbers(v, stage.v, 6) << world.velocity(link.body) + spin.cross(arm), spin;
      } else if (stage.motion == Motion::Ball) {
        const JointDef& joint = world.joint(link.joint);
        const Quaternion first = orientation_of(world, joint.first, link.frame_first);
        const Vector3 spin = world.angular_velocity(joint.second) - world.angular_velocity(joint.first);
        numbers(v, stage.v, 3) = first.conjugate() * spin;
      } else if (!stage.locked) {
        v[static_cast<Eigen::Index>(stage.v)] = world.joint_state(link.joint).speed[stage.coordinate];
      }
    }
  }
  return v;
}

Kinematics kinematics(const Tree& tree, const World& world, const VectorXd& q, const VectorXd& v) {
  ATL_ASSERT(static_cast<std::size_t>(q.size()) == tree.nq && static_cast<std::size_t>(v.size()) == tree.nv, q.size(),
             tree.nq, v.size(), tree.nv);
  Kinematics result{.origin = world.centre_of_mass(tree.links[0].body),
                    .axes = Matrix6X::Zero(6, static_cast<Eigen::Index>(tree.nv))};
  Walk base{tree, world, q, v, result};
  if (!tree.floating) {
    const Vector3 spin = world.angular_velocity(tree.base);
    const Vector3 velocity = world.velocity(tree.base);
    const Vector3 centre = world.centre_of_mass(tree.base);
    base.frame = world.pose(tree.base);
    base.velocity << spin, velocity + (centre - result.origin).cross(spin);
    // Its centre and its turning keep their velocities.
    base.drift << Vector3::Zero(), velocity.cross(spin);
  }
  for (const Link& link : tree.links) {
    Walk walk = base;
    if (link.parent != Link::none) {
      walk.frame = result.poses[link.parent];
      walk.velocity = result.velocity[link.parent];
      walk.drift = result.drift[link.parent];
    }
    walk.take(link);
    walk.frame.orientation.normalize();
    result.poses.push_back(walk.frame);
    result.velocity.push_back(walk.velocity);
    result.drift.push_back(walk.drift);
  }
  return result;
}

VectorXd integrate(const Tree& tree, const VectorXd& q, const VectorXd& v) {
  VectorXd result = q;
  const auto turn = [&](std::size_t at, std::size_t by) {
    const Quaternion turned = solver::rotation_by(Vector3(numbers(v, by, 3))) * quaternion_at(q, at);
    numbers(result, at, 4) = turned.normalized().coeffs();
  };
  for (const Link& link : tree.links) {
    for (const Stage& stage : link.stages) {
      if (stage.motion == Motion::Free) {
        numbers(result, stage.q, 3) += numbers(v, stage.v, 3);
        turn(stage.q + 3, stage.v + 3);
      } else if (stage.motion == Motion::Ball) {
        turn(stage.q, stage.v);
      } else if (!stage.locked) {
        result[static_cast<Eigen::Index>(stage.q)] += v[static_cast<Eigen::Index>(stage.v)];
      }
    }
  }
  return result;
}

MatrixXd jacobian_at(const Tree& tree, const Kinematics& at, std::size_t link, const Vector3& point) {
  ATL_ASSERT(link < tree.links.size(), link, tree.links.size());
  MatrixXd jacobian = MatrixXd::Zero(6, static_cast<Eigen::Index>(tree.nv));
  for (std::size_t i = link; i != Link::none; i = tree.links[i].parent) {
    for_each_place(tree.links[i], [&](Eigen::Index column) {
      const Vector6 axis = at.axes.col(column);
      jacobian.col(column) << velocity_at(at, axis, point), axis.head<3>();
    });
  }
  return jacobian;
}

}  // namespace atl::mechanism
