#pragma once

#include <solver/constraints/joint.h>
#include <solver/integrate/motion.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

namespace atl::solver {

// A tendon couples coordinates of several joints: its length is the sum of a polynomial of each, and obeys a law as any
// coordinate does (MuJoCo's fixed tendons and joint equalities; Todorov, Erez and Tassa, "MuJoCo: a physics engine for
// model-based control", IROS 2012). It is a Joint of one row, whose Jacobian is the sum of those of the coordinates
// times the slopes of the polynomials, over all bodies of these joints.

/// The coordinate of a term where the two bodies of its joint are, and what it adds to the tendon.
struct TermRow {
  JointRow at = {};     ///< of the coordinate: its value and rate
  double position = 0;  ///< of the coordinate, continued: see law_row()
  double value = 0;     ///< of the polynomial
  double slope = 0;     ///< of the polynomial, by the coordinate
};

/// `before`: the coordinate's position before. `joint` is that of the term.
TermRow term_row(const TendonTerm& term, const Joint& joint, const BodyPose& first, const BodyPose& second,
                 double before);

/// A body that a tendon pulls on: the rate of the length by its velocity, m/s or rad/s.
struct PulledBody {
  std::uint32_t body;
  Vector3 linear;
  Vector3 angular;

  double rate(const Vector3& velocity, const Vector3& spin) const { return linear.dot(velocity) + angular.dot(spin); }
};

/// The bodies that a tendon pulls on, each once.
struct PulledBodies {
  std::array<PulledBody, 2 * max_tendon_terms> of;
  std::size_t count = 0;

  /// A term's row, between bodies of these numbers.
  void add(std::uint32_t first, std::uint32_t second, const TermRow& row) {
    add(first, -row.slope * row.at.linear, -row.slope * row.at.angular_first);
    add(second, row.slope * row.at.linear, row.slope * row.at.angular_second);
  }
  const PulledBody* begin() const { return of.data(); }
  const PulledBody* end() const { return of.data() + count; }

 private:
  void add(std::uint32_t body, const Vector3& linear, const Vector3& angular) {
    PulledBody* const last = of.data() + count;
    PulledBody* const known = std::find_if(of.data(), last, [&](const PulledBody& b) { return b.body == body; });
    if (known == last) {
      *known = {body, linear, angular};
      ++count;
    } else {
      known->linear += linear;
      known->angular += angular;
    }
  }
};

/// Calls visit(joint) with the joints of the terms of one of all joints, if it is a tendon.
template <typename Visit>
void for_each_term(const Joint* joints, std::uint32_t tendon, const Visit& visit) {
  for (std::size_t i = 0; i < joints[tendon].terms; ++i) visit(joints[joints[tendon].term[i].joint]);
}

/// A tendon where the bodies of the world are.
struct TendonNow {
  double length = 0;
  double rate = 0;                                     ///< 1/s of that
  std::array<double, max_tendon_terms> position = {};  ///< of the coordinates of its terms, continued
};

/// `joints` are all.
TendonNow tendon_now(const Joint& tendon, const Joint* joints, const BodyTable& bodies);

}  // namespace atl::solver
