#include "contact_rows.h"

#include <algorithm>

namespace atl::reference {
namespace {

using Row = Eigen::Matrix<double, 1, 6>;

Row row(const Vector3& linear, const Vector3& angular) {
  Row row;
  row << linear.transpose(), angular.transpose();
  return row;
}

Vector6 free_velocity(const ContactProblem::Body& body) {
  Vector6 v;
  v << body.free_velocity, body.free_angular_velocity;
  return v;
}

Matrix6 inverse_mass(const ContactProblem::Body& body) {
  Matrix6 inverse = Matrix6::Zero();
  inverse.topLeftCorner<3, 3>() = (body.inverse_mass * body.free_axes).asDiagonal();
  inverse.bottomRightCorner<3, 3>() = body.inverse_inertia;
  return inverse;
}

// J of one side, for a velocity at the patch that counts by `sign`.
Eigen::Matrix<double, 7, 6> jacobian(const ContactProblem::Patch& patch, const Vector3& anchor, double sign,
                                     const PatchRows& shape) {
  Eigen::Matrix<double, 7, 6> j = Eigen::Matrix<double, 7, 6>::Zero();
  const Vector3 across = patch.normal.cross(patch.tangent);
  int next = 0;
  for (const ContactProblem::Point& point : patch.points) {
    const Vector3 at = anchor + point.x * patch.tangent + point.y * across;
    j.row(next++) = sign * row(patch.normal, at.cross(patch.normal));
  }
  if (shape.slides) {
    for (const Vector3& t : {patch.tangent, across}) j.row(next++) = sign * row(t, anchor.cross(t));
  }
  if (shape.twists) j.row(next) = sign * patch.radius * row(Vector3::Zero(), patch.normal);
  return j;
}

}  // namespace

ContactRows::ContactRows(const ContactProblem& problem) {
  std::vector<int> place(problem.bodies.size(), PatchRows::none);
  std::vector<Matrix6> inverse_masses;
  std::vector<Vector6> free_velocities;
  for (std::size_t i = 0; i < problem.bodies.size(); ++i) {
    const ContactProblem::Body& body = problem.bodies[i];
    if (body.inverse_mass == 0) continue;
    place[i] = static_cast<int>(inverse_masses.size());
    inverse_masses.push_back(inverse_mass(body));
    free_velocities.push_back(free_velocity(body));
  }
  free.resize(6 * static_cast<Eigen::Index>(free_velocities.size()));
  for (std::size_t i = 0; i < free_velocities.size(); ++i)
    free.segment<6>(6 * static_cast<Eigen::Index>(i)) = free_velocities[i];

  std::vector<double> offsets;
  for (const ContactProblem::Patch& patch : problem.patches) {
    PatchRows shape;
    shape.patch = static_cast<std::size_t>(&patch - problem.patches.data());
    shape.first_row = rows;
    shape.points = static_cast<int>(patch.points.size());
    shape.friction = patch.friction;
    shape.slides = patch.friction > 0;
    shape.twists = patch.friction > 0 && patch.radius > 0;
    Eigen::Matrix<double, 7, 1> offset_of_rows = Eigen::Matrix<double, 7, 1>::Zero();
    for (int i = 0; i < shape.points; ++i) {
      offset_of_rows[i] = std::max(0.0, patch.points[static_cast<std::size_t>(i)].gap) /
                          (patch.step > 0 ? patch.step : problem.substep);
    }
    double response = 0;
    for (std::size_t side = 0; side < 2; ++side) {
      shape.j[side].setZero();
      shape.apply[side].setZero();
      const std::size_t body = side == 0 ? patch.first : patch.second;
      if (body == ContactProblem::fixed) continue;
      shape.j[side] = jacobian(patch, side == 0 ? patch.anchor_first : patch.anchor_second, side == 0 ? -1 : 1, shape);
      shape.body[side] = place[body];
      if (place[body] == PatchRows::none) {
        offset_of_rows += shape.j[side] * free_velocity(problem.bodies[body]);
        shape.j[side].setZero();
        continue;
      }
      shape.apply[side] = inverse_masses[static_cast<std::size_t>(place[body])] * shape.j[side].transpose();
      response += (shape.j[side] * shape.apply[side]).trace();
    }
    if (response == 0) continue;  // nothing that impulses move
    shape.mass = shape.rows() / response;
    rows += shape.rows();
    offsets.insert(offsets.end(), offset_of_rows.data(), offset_of_rows.data() + shape.rows());
    patches.push_back(shape);
  }
  offset = Eigen::Map<Eigen::VectorXd>(offsets.data(), rows);
}

Eigen::VectorXd ContactRows::velocities(const Eigen::VectorXd& impulses) const {
  Eigen::VectorXd v = free;
  for (const PatchRows& patch : patches) {
    for (std::size_t side = 0; side < 2; ++side) {
      if (patch.body[side] == PatchRows::none) continue;
      v.segment<6>(6 * patch.body[side]) +=
          patch.apply[side].leftCols(patch.rows()) * impulses.segment(patch.first_row, patch.rows());
    }
  }
  return v;
}

Eigen::VectorXd ContactRows::relative_velocities(const Eigen::VectorXd& velocities) const {
  Eigen::VectorXd u = offset;
  for (const PatchRows& patch : patches) {
    for (std::size_t side = 0; side < 2; ++side) {
      if (patch.body[side] == PatchRows::none) continue;
      u.segment(patch.first_row, patch.rows()) +=
          patch.j[side].topRows(patch.rows()) * velocities.segment<6>(6 * patch.body[side]);
    }
  }
  return u;
}

Eigen::VectorXd ContactRows::impulses_of(const ContactProblem& problem) const {
  Eigen::VectorXd r(rows);
  for (const PatchRows& rows_of : patches) {
    const ContactProblem::Patch& patch = problem.patches[rows_of.patch];
    int next = rows_of.first_row;
    for (const ContactProblem::Point& point : patch.points) r[next++] = point.impulse;
    if (rows_of.slides) {
      r[next++] = patch.tangent.dot(patch.friction_impulse);
      r[next++] = patch.normal.cross(patch.tangent).dot(patch.friction_impulse);
    }
    if (rows_of.twists) r[next] = patch.torsional_impulse / patch.radius;
  }
  return r;
}

void ContactRows::write(const Eigen::VectorXd& impulses, ContactProblem& problem) const {
  for (const PatchRows& rows_of : patches) {
    ContactProblem::Patch& patch = problem.patches[rows_of.patch];
    patch.friction_impulse.setZero();
    patch.torsional_impulse = 0;
    int next = rows_of.first_row;
    for (ContactProblem::Point& point : patch.points) point.impulse = impulses[next++];
    if (rows_of.slides) {
      patch.friction_impulse = impulses[next] * patch.tangent + impulses[next + 1] * patch.normal.cross(patch.tangent);
      next += 2;
    }
    if (rows_of.twists) patch.torsional_impulse = impulses[next] * patch.radius;
  }
}

}  // namespace atl::reference
