#include "mechanism/dynamics.h"

#include <jobs/assert.h>

namespace atl::mechanism {
namespace {

Matrix3 cross_matrix(const Vector3& of) {
  Matrix3 matrix;
  matrix << 0, -of.z(), of.y(), of.z(), 0, -of.x(), -of.y(), of.x(), 0;
  return matrix;
}

// Featherstone, (2.63).
Matrix6 spatial_inertia(double mass, const Vector3& centre, const Matrix3& inertia) {
  const Matrix3 cross = cross_matrix(centre);
  Matrix6 result;
  result << inertia - mass * cross * cross, mass * cross, -mass * cross, mass * Matrix3::Identity();
  return result;
}

}  // namespace

double Weights::total() const {
  double sum = 0;
  for (const double of : mass) sum += of;
  return sum;
}

Vector3 Weights::centre_of_all() const {
  Vector3 sum = Vector3::Zero();
  for (std::size_t i = 0; i < mass.size(); ++i) sum += mass[i] * centre[i];
  return sum / total();
}

Weights weights(const Tree& tree, const World& world, const Kinematics& at) {
  const BodyRecords& records = MechanismAccess::stores(world).records;
  Weights result;
  result.armature = VectorXd::Zero(static_cast<Eigen::Index>(tree.nv));
  for (std::size_t i = 0; i < tree.links.size(); ++i) {
    const Link& link = tree.links[i];
    const BodyConstants& body = *records.constants[link.body.index];
    const Matrix3 axes = at.poses[i].orientation.toRotationMatrix();
    result.mass.push_back(1 / body.inverse_mass);
    result.centre.push_back(at.poses[i].position + axes * body.centre);
    result.gravity.push_back(body.gravity_scale * world.gravity());
    const Matrix3 inertia = axes * body.inertia * axes.transpose();
    result.inertia.push_back(spatial_inertia(result.mass[i], result.centre[i] - at.origin, inertia));
    for (const Stage& stage : link.stages) {
      if (!stage.has_axis() || stage.locked) continue;
      result.armature[static_cast<Eigen::Index>(stage.v)] = axis_of(world, link, stage).armature;
    }
  }
  return result;
}

// Featherstone, section 6.2: of vectors in one frame the composite inertias are sums.
MatrixXd mass_matrix(const Tree& tree, const Kinematics& at, const Weights& weights) {
  ATL_ASSERT(weights.mass.size() == tree.links.size() && at.poses.size() == tree.links.size(), weights.mass.size(),
             at.poses.size(), tree.links.size());
  MatrixXd matrix = weights.armature.asDiagonal();
  std::vector<Matrix6> composite = weights.inertia;
  for (std::size_t i = tree.links.size(); i-- > 0;) {
    const Link& link = tree.links[i];
    for_each_place(link, [&](Eigen::Index column) {
      const Vector6 force = composite[i] * at.axes.col(column);
      for_each_place(link, [&](Eigen::Index row) {
        if (row <= column) matrix(row, column) += at.axes.col(row).dot(force);
        if (row < column) matrix(column, row) = matrix(row, column);
      });
      for (std::size_t above = link.parent; above != Link::none; above = tree.links[above].parent) {
        for_each_place(tree.links[above], [&](Eigen::Index row) {
          matrix(row, column) = matrix(column, row) = at.axes.col(row).dot(force);
        });
      }
    });
    if (link.parent != Link::none) composite[link.parent] += composite[i];
  }
  ATL_ASSERT((matrix.diagonal().array() > 0).all(), tree.nv);
  return matrix;
}

// Featherstone, section 5.3, with the weight as a force on each body, as bodies may feel gravity differently.
VectorXd inverse_dynamics(const Tree& tree, const Kinematics& at, const Weights& weights,
                          const VectorXd& acceleration) {
  std::vector<Vector6> relative(tree.links.size(), Vector6::Zero());  // acceleration by v'
  std::vector<Vector6> force(tree.links.size());
  for (std::size_t i = 0; i < tree.links.size(); ++i) {
    const Link& link = tree.links[i];
    if (link.parent != Link::none) relative[i] = relative[link.parent];
    for_each_place(link, [&](Eigen::Index k) { relative[i] += acceleration[k] * at.axes.col(k); });
    const Vector3 weight = weights.mass[i] * weights.gravity[i];
    Vector6 outside;
    outside << (weights.centre[i] - at.origin).cross(weight), weight;
    force[i] = weights.inertia[i] * (at.drift[i] + relative[i]) +
               cross_force(at.velocity[i], weights.inertia[i] * at.velocity[i]) - outside;
  }
  VectorXd tau = weights.armature.cwiseProduct(acceleration);
  for (std::size_t i = tree.links.size(); i-- > 0;) {
    const Link& link = tree.links[i];
    for_each_place(link, [&](Eigen::Index k) { tau[k] += at.axes.col(k).dot(force[i]); });
    if (link.parent != Link::none) force[link.parent] += force[i];
  }
  return tau;
}

MechanismMomentum momentum(const Kinematics& at, const Weights& weights) {
  Vector6 sum = Vector6::Zero();
  for (std::size_t i = 0; i < weights.mass.size(); ++i) sum += weights.inertia[i] * at.velocity[i];
  const Vector3 linear = sum.tail<3>();
  return {.linear = linear, .angular = sum.head<3>() - (weights.centre_of_all() - at.origin).cross(linear)};
}

}  // namespace atl::mechanism
