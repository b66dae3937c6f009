// The public face of Mechanism: checks arguments and hands on.

#include <atoll/error.h>

#include <Eigen/Cholesky>
#include <sstream>

#include "mechanism/dynamics.h"
#include "mechanism/inverse_kinematics.h"
#include "world/body_definition.h"
#include "world/refuse.h"

namespace atl {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using mechanism::Kinematics;
using mechanism::Link;
using mechanism::Motion;
using mechanism::Stage;
using mechanism::Tree;
using mechanism::Weights;

VectorXd zeros(std::size_t count) { return VectorXd::Zero(static_cast<Eigen::Index>(count)); }

void check_numbers(const std::string& field, const VectorXd& values, std::size_t count) {
  if (static_cast<std::size_t>(values.size()) != count) {
    throw Error(field + " has " + std::to_string(values.size()) + " numbers; expected " + std::to_string(count));
  }
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    check_finite(field + "[" + std::to_string(i) + "]", values[i]);
  }
}

// q with unit quaternions.
VectorXd checked_configuration(const std::string& field, const Tree& tree, VectorXd q) {
  check_numbers(field, q, tree.nq);
  for (const Link& link : tree.links) {
    for (const Stage& stage : link.stages) {
      if (stage.has_axis()) continue;
      const auto first = static_cast<Eigen::Index>(stage.q + (stage.motion == Motion::Free ? 3 : 0));
      const Eigen::Vector4d quaternion = q.segment<4>(first);
      const double length = quaternion.stableNorm();
      if (!(length > 0)) {
        refuse(field + "[" + std::to_string(first) + ":" + std::to_string(first + 4) + "]", quaternion,
               "a quaternion that is not 0");
      }
      q.segment<4>(first) = quaternion / length;
    }
  }
  return q;
}

std::size_t link_of(const char* call, const Tree& tree, BodyId body) {
  for (std::size_t i = 0; i < tree.links.size(); ++i) {
    if (tree.links[i].body == body) return i;
  }
  std::ostringstream message;
  message << call << ": body (index " << body.index << ", generation " << body.generation
          << ") is not in the tree; expected one of its " << tree.links.size() << " bodies";
  throw Error(message.str());
}

// The mechanism as the world has it now.
struct Present {
  const Tree& tree;
  const World& world;
  VectorXd q;
  VectorXd v;
  Kinematics at;

  Present(const Tree& of, const World& in, bool at_rest = false) : tree(of), world(in) {
    check_unchanged(tree, world);
    q = read_q(tree, world);
    v = at_rest ? zeros(tree.nv) : read_v(tree, world);
    at = kinematics(tree, world, q, v);
  }
  Weights weights() const { return mechanism::weights(tree, world, at); }
};

}  // namespace

Mechanism::Mechanism(World& world, BodyId base)
    : world_(&world), tree_(std::make_shared<const Tree>(mechanism::make_tree(world, base))) {}

std::size_t Mechanism::nq() const { return tree_->nq; }
std::size_t Mechanism::nv() const { return tree_->nv; }
bool Mechanism::is_floating() const { return tree_->floating; }
BodyId Mechanism::base() const { return tree_->base; }
const std::vector<BodyId>& Mechanism::bodies() const { return tree_->bodies; }
const std::vector<MechanismJoint>& Mechanism::joints() const { return tree_->joints; }
const std::vector<JointId>& Mechanism::loops() const { return tree_->loops; }

VectorXd Mechanism::q() const {
  check_unchanged(*tree_, *world_);
  return read_q(*tree_, *world_);
}

VectorXd Mechanism::v() const {
  check_unchanged(*tree_, *world_);
  return read_v(*tree_, *world_);
}

void Mechanism::set(const VectorXd& q, const VectorXd& v) {
  check_unchanged(*tree_, *world_);
  const VectorXd configuration = checked_configuration("Mechanism::set: q", *tree_, q);
  check_numbers("Mechanism::set: v", v, tree_->nv);
  const Kinematics at = kinematics(*tree_, *world_, configuration, v);
  const auto count = static_cast<Eigen::Index>(tree_->links.size());
  Eigen::Matrix3Xd positions(3, count), linear(3, count), angular(3, count);
  Eigen::Matrix4Xd orientations(4, count);
  const BodyRecords& records = MechanismAccess::stores(*world_).records;
  for (Eigen::Index i = 0; i < count; ++i) {
    const auto link = static_cast<std::size_t>(i);
    const Pose& pose = at.poses[link];
    const Vector3 centre = pose.position + pose.orientation * records.centre[tree_->bodies[link].index];
    positions.col(i) = pose.position;
    orientations.col(i) = pose.orientation.coeffs();
    linear.col(i) = velocity_at(at, at.velocity[link], centre);
    angular.col(i) = at.velocity[link].head<3>();
  }
  world_->set_poses(tree_->bodies, positions, orientations);
  world_->set_velocities(tree_->bodies, linear, angular);
  for (const Link& link : tree_->links) {
    for (const Stage& stage : link.stages) {
      if (stage.motion != Motion::Turn || stage.locked) continue;
      world_->count_turns_from(link.joint, configuration[static_cast<Eigen::Index>(stage.q)], stage.coordinate);
    }
  }
}

VectorXd Mechanism::integrate(const VectorXd& q, const VectorXd& v) const {
  check_numbers("Mechanism::integrate: v", v, tree_->nv);
  return mechanism::integrate(*tree_, checked_configuration("Mechanism::integrate: q", *tree_, q), v);
}

void Mechanism::apply(const VectorXd& tau) {
  check_numbers("Mechanism::apply: tau", tau, tree_->nv);
  const Present now(*tree_, *world_, true);
  // A force along an axis of a joint that does work with its rate: a moment about a turn's, a push along a slide's.
  const auto add = [&](BodyId body, const Vector3& force, const Vector3& torque, const Vector3& point) {
    if (world_->type(body) != BodyType::Dynamic) return;
    world_->apply_force(body, force, torque + (point - world_->centre_of_mass(body)).cross(force));
  };
  const auto pose_of = [&](std::size_t link) {
    return link == Link::none ? world_->pose(tree_->base) : now.at.poses[link];
  };
  for (std::size_t i = 0; i < tree_->links.size(); ++i) {
    const Link& link = tree_->links[i];
    Vector3 force = Vector3::Zero();
    Vector3 torque = Vector3::Zero();
    mechanism::for_each_place(link, [&](Eigen::Index k) {
      const mechanism::Vector6 axis = now.at.axes.col(k);
      const bool turns = !axis.head<3>().isZero(0);
      (turns ? torque : force) += tau[k] * (turns ? axis.head<3>() : axis.tail<3>());
    });
    if (force.isZero(0) && torque.isZero(0)) continue;
    // Turns are about the origin of the second frame, which slides move.
    const Pose second = link.joint == JointId{}
                            ? now.at.poses[i]
                            : mechanism::product(pose_of(link.reversed ? link.parent : i), link.frame_second);
    add(link.body, force, torque, second.position);
    const BodyId carrier = link.parent == Link::none ? tree_->base : tree_->links[link.parent].body;
    if (link.joint != JointId{}) add(carrier, -force, -torque, second.position);
  }
}

MatrixXd Mechanism::mass_matrix() const {
  const Present now(*tree_, *world_, true);
  return mechanism::mass_matrix(*tree_, now.at, now.weights());
}

VectorXd Mechanism::bias() const { return inverse_dynamics(zeros(tree_->nv)); }

VectorXd Mechanism::gravity() const {
  const Present now(*tree_, *world_, true);
  return mechanism::inverse_dynamics(*tree_, now.at, now.weights(), zeros(tree_->nv));
}

VectorXd Mechanism::inverse_dynamics(const VectorXd& acceleration) const {
  check_numbers("Mechanism::inverse_dynamics: acceleration", acceleration, tree_->nv);
  const Present now(*tree_, *world_);
  return mechanism::inverse_dynamics(*tree_, now.at, now.weights(), acceleration);
}

VectorXd Mechanism::forward_dynamics(const VectorXd& tau) const {
  check_numbers("Mechanism::forward_dynamics: tau", tau, tree_->nv);
  const Present now(*tree_, *world_);
  const Weights weights = now.weights();
  const VectorXd bias = mechanism::inverse_dynamics(*tree_, now.at, weights, zeros(tree_->nv));
  return mechanism::mass_matrix(*tree_, now.at, weights).ldlt().solve(tau - bias);
}

MatrixXd Mechanism::jacobian(BodyId body, const Vector3& point) const {
  const std::size_t link = link_of("Mechanism::jacobian", *tree_, body);
  check_finite("Mechanism::jacobian: point", point);
  const Present now(*tree_, *world_, true);
  const Pose& pose = now.at.poses[link];
  return jacobian_at(*tree_, now.at, link, pose.position + pose.orientation * point);
}

Vector3 Mechanism::centre_of_mass() const { return Present(*tree_, *world_, true).weights().centre_of_all(); }

MatrixXd Mechanism::centre_of_mass_jacobian() const {
  const Present now(*tree_, *world_, true);
  const Weights weights = now.weights();
  MatrixXd sum = MatrixXd::Zero(3, static_cast<Eigen::Index>(tree_->nv));
  for (std::size_t i = 0; i < tree_->links.size(); ++i) {
    sum += weights.mass[i] / weights.total() * jacobian_at(*tree_, now.at, i, weights.centre[i]).topRows<3>();
  }
  return sum;
}

MechanismMomentum Mechanism::momentum() const {
  const Present now(*tree_, *world_);
  return mechanism::momentum(now.at, now.weights());
}

double Mechanism::kinetic_energy() const {
  const Present now(*tree_, *world_);
  const Weights weights = now.weights();
  double twice = now.v.dot(weights.armature.cwiseProduct(now.v));
  for (std::size_t i = 0; i < tree_->links.size(); ++i) {
    twice += now.at.velocity[i].dot(weights.inertia[i] * now.at.velocity[i]);
  }
  return 0.5 * twice;
}

double Mechanism::potential_energy() const {
  const Weights weights = Present(*tree_, *world_, true).weights();
  double sum = 0;
  for (std::size_t i = 0; i < weights.mass.size(); ++i)
    sum -= weights.mass[i] * weights.gravity[i].dot(weights.centre[i]);
  return sum;
}

InverseKinematics Mechanism::inverse_kinematics(BodyId body, const Vector3& point, const Vector3& target,
                                                const std::optional<Quaternion>& orientation) const {
  const std::size_t link = link_of("Mechanism::inverse_kinematics", *tree_, body);
  check_finite("Mechanism::inverse_kinematics: point", point);
  check_finite("Mechanism::inverse_kinematics: target", target);
  std::optional<Quaternion> turned;
  if (orientation) turned = checked_orientation("Mechanism::inverse_kinematics: orientation", *orientation);
  check_unchanged(*tree_, *world_);
  return mechanism::inverse_kinematics(*tree_, *world_, {link, point, target, turned});
}

}  // namespace atl
