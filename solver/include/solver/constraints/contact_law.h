#pragma once

#include <collision/contacts/contact.h>

#include <array>
#include <cstdint>

namespace atl::solver {

/// Six numbers of a contact, in its own frame: along the normal, about the first and second tangent, along these, and
/// about the normal. As a motion that of the second body against the first at the contact's centre, m/s and rad/s; as
/// an impulse that on the second body, N s and N m s.
using Six = std::array<double, 6>;

/// The pieces of its law that a contact is on.
struct ContactPieces {
  std::uint8_t points = 0;  ///< a bit for each that pushes
  std::uint8_t slides = 0;  ///< both bits where the disc of friction binds; of the pyramid a bit for each tangent
  bool spins = false;
  bool rolls = false;

  bool operator==(const ContactPieces&) const = default;
};

/// The impulses of a contact.
struct ContactAnswer {
  std::array<double, collision::max_points> normal = {};  ///< N s
  std::array<double, 2> friction = {};                    ///< N s, along the tangents
  double torsional = 0;                                   ///< N m s
  std::array<double, 2> rolling = {};                     ///< N m s, about the tangents
  ContactPieces pieces;

  double load() const { return normal[0] + normal[1] + normal[2] + normal[3]; }
};

/// A contact of up to four points that is at least very slightly soft: impulses as functions of the motion. Points push
/// by what they close faster than they may; friction holds back what slides, spins and rolls, up to a bound. Each is
/// the derivative of a convex function, as long as the bounds are given.
struct ContactLaw {
  int points = 0;
  std::array<double, collision::max_points> x = {};          ///< m, from the centre along the tangents
  std::array<double, collision::max_points> y = {};          ///< m
  std::array<double, collision::max_points> stiffness = {};  ///< N s by m/s
  std::array<double, collision::max_points> bias = {};       ///< m/s: closing speed allowed, or less than 0: to part at
  Six surfaces = {};                                         ///< how surfaces run beside the motion, for friction alone
  bool pyramid = false;                                      ///< friction is bounded along each tangent by itself
  double friction_stiffness = 0;
  double torsional_stiffness = 0;
  double rolling_stiffness = 0;
  double friction_ratio = 1;   ///< of friction's bound along the second tangent, to that along the first
  double friction_bound = 0;   ///< N s, along the first tangent
  double torsional_bound = 0;  ///< N m s
  double rolling_bound = 0;    ///< N m s

  /// m/s, at which a point parts.
  double speed(int point, const Six& motion) const { return motion[0] + y[point] * motion[1] - x[point] * motion[2]; }

  ContactAnswer answer(const Six& motion) const;

  /// The answer with all pieces that `pieces` names, and no others: a point among them pulls where it parts. Pieces
  /// that slide, spin or roll answer as in `before`.
  ContactAnswer linear_answer(const Six& motion, const ContactPieces& pieces, const ContactAnswer& before) const;

  /// Impulses by motions, negative: the derivative of answer() where it is on these pieces. Symmetric, with no
  /// negative eigenvalue; rows as in Six.
  std::array<Six, 6> derivative(const Six& motion, const ContactPieces& pieces) const;

  /// Impulses in the contact's frame.
  Six total(const ContactAnswer& answer) const;

 private:
  /// The motion of the surfaces against each other.
  Six rubbing(const Six& motion) const;
  void add_sliding(std::array<Six, 6>& k, const Six& rubs) const;
};

}  // namespace atl::solver
