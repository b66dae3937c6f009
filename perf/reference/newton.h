#pragma once

#include <Eigen/Sparse>
#include <Eigen/SparseLU>
#include <vector>

#include "contact_rows.h"

namespace atl::reference {

/// Semismooth Newton on the function of Alart and Curnier ("A mixed formulation for frictional contact problems prone
/// to Newton like solution methods", 1991), in m/s, which is zero exactly at the solutions:
///   normal   (r - max(0, r - m u)) / m           friction   (r_T - P(r_T - m u_T)) / m
/// with m the patch's mass and P the projection on the disc of radius mu R, R as r has it; the twist likewise on an
/// interval. Bodies' velocities stay unknowns, so that the matrix is sparse. Contacts at four points leave shares of
/// the weight open: a proximal term, u + (r' - r) e / m, picks those near to where the step starts, and does not move
/// the zeros.
class NewtonSolver {
 public:
  explicit NewtonSolver(const ContactRows& rows);

  /// |F|, m/s.
  double error(const Eigen::VectorXd& impulses) const;

  /// The Newton step from the impulses, with the proximal term's weight e > 0. False where the matrix is singular.
  bool step(const Eigen::VectorXd& impulses, double proximal, Eigen::VectorXd& change);

 private:
  struct Linearisation;
  Linearisation linearise(const PatchRows& patch, const Eigen::VectorXd& impulses, const Eigen::VectorXd& u) const;

  const ContactRows& rows_;
  Eigen::SparseLU<Eigen::SparseMatrix<double>, Eigen::COLAMDOrdering<int>> factors_;
  std::vector<Eigen::Triplet<double>> entries_;
  bool analysed_ = false;
};

}  // namespace atl::reference
