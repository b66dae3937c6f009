#include "solid.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

namespace peer {
namespace {

atl::Pose inverse(const atl::Pose& pose) {
  const atl::Quaternion turn = pose.orientation.conjugate();
  return {turn * -pose.position, turn};
}

// The principal axes; the body's own where those will do, so that a box stays aligned with its body.
atl::Quaternion principal_axes(const atl::Matrix3& inertia, atl::Vector3& moments) {
  atl::Matrix3 mixed = inertia;
  mixed.diagonal().setZero();
  moments = inertia.diagonal();
  if (mixed.cwiseAbs().maxCoeff() <= 1e-9 * moments.maxCoeff()) return atl::Quaternion::Identity();
  const Eigen::SelfAdjointEigenSolver<atl::Matrix3> solver(inertia);
  moments = solver.eigenvalues();
  atl::Matrix3 axes = solver.eigenvectors();
  if (axes.determinant() < 0) axes.col(2) *= -1;
  return atl::Quaternion(axes);
}

std::vector<Part> parts_of(const atl::Shape& shape) {
  const auto* compound = std::get_if<atl::Compound>(&shape);
  if (compound == nullptr) return {{shape, {}}};
  std::vector<Part> parts;
  for (const atl::CompoundChild& child : compound->children) {
    const atl::Shape solid = std::visit([](const auto& convex) -> atl::Shape { return convex; }, child.shape);
    parts.push_back({solid, {child.position, child.orientation.normalized()}});
  }
  return parts;
}

}  // namespace

atl::Pose operator*(const atl::Pose& a, const atl::Pose& b) {
  return {a.position + a.orientation * b.position, (a.orientation * b.orientation).normalized()};
}

Solid make_solid(const atl::BodyDef& def) {
  Solid solid;
  solid.parts = parts_of(def.shape);
  if (def.type == atl::BodyType::Dynamic) {
    const atl::MassProperties properties = atl::body_mass(def);
    solid.mass = properties.mass;
    solid.frame.orientation = principal_axes(properties.inertia, solid.moments);
    // A centre that differs from the origin by rounding alone counts as zero; otherwise every hull would become a
    // compound.
    if (properties.centre.norm() > 1e-12 * std::cbrt(properties.volume)) solid.frame.position = properties.centre;
  }
  if (!is_identity(solid.frame)) {
    for (Part& part : solid.parts) part.pose = inverse(solid.frame) * part.pose;
  }
  solid.pose = atl::Pose{def.position, def.orientation.normalized()} * solid.frame;
  return solid;
}

atl::Pose body_pose(const Solid& solid, const atl::Pose& pose) {
  return is_identity(solid.frame) ? pose : pose * inverse(solid.frame);
}

bool is_identity(const atl::Pose& pose) {
  return pose.position.isZero(0) && pose.orientation.vec().isZero(0) && pose.orientation.w() > 0;
}

double combined_friction(double a, double b) { return std::sqrt(a * b); }
double combined_restitution(double a, double b) { return std::max(a, b); }

bool is_moving_kinematic(const atl::BodyDef& def) {
  return def.type == atl::BodyType::Kinematic && !(def.velocity.isZero(0) && def.angular_velocity.isZero(0));
}

std::string shape_name(const atl::Shape& shape) {
  constexpr std::array names = {"box",  "sphere",      "half-space",    "capsule",      "cylinder",
                                "cone", "convex hull", "triangle mesh", "height field", "compound"};
  static_assert(names.size() == std::variant_size_v<atl::Shape>);
  return names.at(shape.index());
}

void LoadSum::add(std::size_t a, std::size_t b, const atl::Vector3& force) {
  const auto place = forces_.try_emplace(std::minmax(a, b), atl::Vector3::Zero()).first;
  place->second += a < b ? force : atl::Vector3(-force);
}

std::vector<atl::ContactLoad> LoadSum::loads() const {
  std::vector<atl::ContactLoad> loads;
  for (const auto& [pair, force] : forces_) loads.push_back({.a = pair.first, .b = pair.second, .force = force});
  return loads;
}

}  // namespace peer
