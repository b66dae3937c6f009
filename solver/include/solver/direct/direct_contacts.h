#pragma once

#include <jobs/bytes.h>
#include <solver/constraints/contact_law.h>
#include <solver/direct/block_ldlt.h>
#include <solver/solve_input.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace atl::solver {

/// What became of a direct solve.
struct DirectContactsReport {
  bool solved = false;  ///< if not, no state was changed
  int iterations = 0;   ///< of Newton's method, beyond the first solve
  ContactWork work;
  std::int64_t gyroscopic_bodies = 0;  ///< whose moments of inertia differ
  double ms = 0;                       ///< with SolverSettings::profile
};

/// The contacts of an island, solved at once and for a whole step: of islands so ill-conditioned (tall columns, heavy
/// bodies on light ones) that sweeps get nowhere.
///
/// Contacts are very slightly soft, so impulses are functions of the velocities v at the end of the step (ContactLaw),
/// and these are where a convex function is least:
///
///   |v - v*|^2_M / 2 + sum over contacts of psi(J v),
///
/// with v* the velocities without contacts and -psi' a contact's impulses. Newton's method with an exact line search
/// finds them; its matrix, M plus the stiffness of the contacts that hold, is positive definite, with a block of 6 x 6
/// for each body and each pair, and is factored directly (Todorov, "Convex and analytically-invertible dynamics with
/// contacts and constraints", ICRA 2014; Castro, Permenter and Han, "An unconstrained convex formulation of compliant
/// contact", T-RO 2022). Friction's bound is given while that is done, and follows the load from one time to the next.
///
/// As with sweeps of soft contacts, this is done twice: bodies keep velocities at which contacts just stop, and move by
/// velocities at which overlap is parted, too.
///
/// The first solve takes each contact to be on the pieces that the impulses of the last step tell of, and at rest is
/// all there is to do. Where Newton's method doesn't end soon, as after an impact, an interior point method starts
/// over, with the same matrices. No state outlives a step, but the order of elimination, which the pairs determine.
class DirectContacts {
 public:
  static constexpr std::size_t most_bodies = 400;  ///< of an island: more take longer than a step may

  /// Takes in an island. Returns false if its factor would be too large.
  bool analyse(const SolveInput& input, const IslandGroup& group);
  /// Solves the island that was taken in last. Not solved is what bounces, tumbles fast or didn't converge.
  DirectContactsReport solve(const SolveInput& input);

  /// Memory held.
  std::size_t bytes() const {
    return sizeof(*this) + system_.bytes() +
           jobs::bytes_of(members_, pairs_, bodies_, contacts_, velocity_, free_, lasting_, gradient_, direction_,
                          product_);
  }

 private:
  static constexpr std::uint32_t none = ~std::uint32_t{0};
  static constexpr double tolerance = 2e-4;  // m/s, of what the balance of a body's impulses may lack
  // Iterations in which friction's bound follows the load. With more it would go to and fro for long: each halves the
  // difference at best.
  static constexpr int following = 2;

  struct Body {
    std::uint32_t body;
    double mass;              // kg
    double radius;            // m, of gyration
    Matrix3 inertia;          // kg m^2, world frame
    Matrix3 inverse_inertia;  // likewise
    Vector3 acceleration;     // m/s^2
  };

  // Points on the interior path: see direct_contacts_interior.cpp.
  struct Interior {
    using Points = std::array<double, collision::max_points>;
    Points impulse;                 // N s, > 0
    Points gap;                     // m/s, > 0: how much faster it parts than where it pushes with this impulse
    Points missing;                 // m/s, by which the gap is not yet that
    Points held;                    // N s by m/s
    Points impulse_step, gap_step;  // along direction_
  };

  struct Contact {
    std::uint32_t slot;
    std::uint32_t first, second;                 // bodies_, or none of what doesn't respond
    std::array<Vector3, 3> axes;                 // normal, tangents
    Vector3 arm_first, arm_second;               // m, from the centres of mass
    double friction, lever, rolling, torsional;  // of what the points push with
    double bound_load;                           // N s, that the bounds of these are of
    ContactLaw law;
    std::array<double, collision::max_points> mass;        // kg, effective, of each point
    std::array<double, collision::max_points> separation;  // m
    Six given;                                             // motion by what doesn't respond
    Six motion;                                            // at velocity_
    Six change;                                            // along direction_
    ContactAnswer answer;
    ContactAnswer lasting;   // that of the velocities which bodies keep
    ContactPieces factored;  // what the factor is of
    Interior interior;

    void add_motion(double sign, const Vector3& arm, const Vector3& v, const Vector3& w, Six& to) const;
    bool fixed() const { return first == none || second == none; }  // against something of infinite mass
    void bound_friction(double load);
    Six motion_after(double t) const;  // of the way along direction_
    Vector3 in_plane(const std::array<double, 2>& along_tangents) const {
      return along_tangents[0] * axes[1] + along_tangents[1] * axes[2];
    }
  };

  // Where in a Six what is along and about an axis is.
  static constexpr int along(int axis) { return axis == 0 ? 0 : 2 + axis; }
  static constexpr int about(int axis) { return axis == 0 ? 5 : axis; }

  std::uint32_t local(const SolveInput& input, std::uint32_t body) const;
  bool load_bodies(const SolveInput& input);
  void load_velocities(const SolveInput& input);
  bool load_contacts(const SolveInput& input);
  void load_contact(const SolveInput& input, const TouchingPair& pair, Contact& contact) const;
  void place(const SolveInput& input, const TouchingPair& pair, Contact& contact) const;
  static void warm_start(const SolveInput& input, Contact& contact);
  Six motion_of(const Contact& contact, const std::vector<double>& velocities) const;
  Six motion_now(const Contact& contact) const;
  void add_impulse(const Contact& contact, const Six& impulse, double sign, std::vector<double>& to) const;
  void mass_times(const std::vector<double>& velocities, std::vector<double>& product) const;
  void add_masses();
  void add_stiffness(const Contact& contact, const std::array<Six, 6>& k);
  bool factor();
  bool is_factored() const;

  void stop_contacts(const SolveInput& input);
  void push_contacts_apart(const SolveInput& input);
  bool overlaps_notably(const SolveInput& input) const;
  bool find_velocities(const SolveInput& input, DirectContactsReport& report);
  bool settle_friction(DirectContactsReport& report);
  double friction_off() const;
  bool is_bounded() const;
  void take_back_give(const SolveInput& input);
  void keep_velocities();
  bool solve_on_last_pieces();
  bool minimise(DirectContactsReport& report, int follows);
  template <typename Answer>
  void balance(const Answer& answer);
  double unbalanced() const;
  void find_direction();
  void follow_load(double t);
  double slope(double t) const;
  double step_length() const;
  bool follow_interior(DirectContactsReport& report);
  void start_interior();
  void take_pieces();
  double note_interior();
  bool factor_interior();
  double interior_step(double target, bool corrected);
  double interior_after(double t) const;
  void take_interior_step(double t);
  void capture(const SolveInput& input) const;
  void write_back(const SolveInput& input);
  void note_work(const SolveInput& input, DirectContactsReport& report) const;
  void note_overloads(const SolveInput& input) const;

  std::vector<std::uint32_t> members_;
  std::size_t island_ = 0;
  std::vector<TouchingPair> pairs_;
  bool fits_ = false;
  std::uint32_t first_rank_ = 0;
  BlockLdlt system_;
  std::vector<Body> bodies_;
  std::vector<Contact> contacts_;
  // Six numbers a body: linear, angular.
  std::vector<double> velocity_, free_;                 // m/s, rad/s
  std::vector<double> lasting_;                         // likewise: velocity_ is what bodies move by, these they keep
  std::vector<double> gradient_, direction_, product_;  // N s, N m s; m/s, rad/s; N s, N m s
  double mass_slope_ = 0, mass_curvature_ = 0;          // of the first term, along direction_
};

// Of M (v - v*), what is left after the impulses that contacts answer with to their motion: the gradient.
template <typename Answer>
void DirectContacts::balance(const Answer& answer) {
  for (std::size_t i = 0; i < velocity_.size(); ++i) product_[i] = velocity_[i] - free_[i];
  mass_times(product_, gradient_);
  for (Contact& contact : contacts_) {
    contact.motion = motion_now(contact);
    contact.answer = answer(contact);
    add_impulse(contact, contact.law.total(contact.answer), -1, gradient_);
  }
}

}  // namespace atl::solver
