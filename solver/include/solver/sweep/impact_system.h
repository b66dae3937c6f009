#pragma once

#include <solver/integrate/body_table.h>
#include <solver/integrate/motion.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tuple>
#include <vector>

namespace atl::solver {

class DirectJoints;
struct SolveInput;

/// A body that something may hit in a substep.
struct ImpactBody {
  static constexpr std::uint32_t none = ~0u;

  std::uint32_t local = 0;  ///< index into SolverBodies
  Vector3 velocity = Vector3::Zero();
  Vector3 spin = Vector3::Zero();
  Vector3 acceleration = Vector3::Zero();  ///< m/s^2, by forces
  Vector3 inverse_mass = Vector3::Zero();  ///< along the world's axes, of which some may be locked
  Matrix3 inverse_inertia = Matrix3::Zero();
  Quaternion rotation = Quaternion::Identity();  ///< of contacts' arms on it, from how blocks have them
  bool turns = false;                            ///< they turn with it
  bool is_locked = false;                        ///< about some axis
  bool tumbles = false;                          ///< its moments of inertia differ
  bool is_hit = false;
  double time = 0;                             ///< s into the substep, at which it first is, and as of which it is here
  Vector3 shift = Vector3::Zero();             ///< m: by which it has to begin elsewhere, to be where it is hit on time
  Vector3 turn = Vector3::Zero();              ///< rad, likewise
  Quaternion turned = Quaternion::Identity();  ///< since the substep began
  bool changed = false;                        ///< by the last round
  bool bounces = false;                        ///< some round has
  std::uint32_t system = none;                 ///< number of the ImpactSystem that it answers with, if joints hold it
  std::uint32_t member = none;                 ///< among all bodies of that
  std::uint32_t place = none;                  ///< among those of them that are hit
  bool waits = false;                          ///< to be hit in a later round

  bool moves() const { return !inverse_mass.isZero(0) || !inverse_inertia.isZero(0); }
  bool is_joined() const { return system != none; }
};

/// An impulse on a body, about its centre.
struct ImpactMomentum {
  Vector3 linear;   ///< N s
  Vector3 angular;  ///< N m s
};

/// A coordinate that is at an end of its range, beyond which impacts may not drive it.
struct ImpactEnd {
  std::size_t joint, row;  ///< in the problem of the joints
  double side;             ///< 1 at the lower end, -1 at the upper one
  double before = 0;       ///< m/s or rad/s, away from the end
  double rate = 0;         ///< likewise, now
  double impulse = 0;      ///< N s or N m s
};

/// Bodies that hang together by joints, and how they answer to impulses at an instant: locks hold, ends of ranges only
/// push, and rotors turn along; springs, motors and friction have no time to act.
class ImpactSystem {
 public:
  /// Takes the bodies, `places` among all, on to the instant of their first impact, at velocities which keep the
  /// joints. `start`: s into the step, of the substep. Returns false, with nothing changed, if there are none.
  bool begin(const SolveInput& input, DirectJoints& joints, double start, double time, std::span<ImpactBody> bodies);
  /// Starts a round of impacts that hit these bodies of it (at most tuning::max_hit), in rising order, and maybe others
  /// before.
  void begin_round(std::vector<std::uint32_t>& hit, std::span<ImpactBody> bodies);
  /// Hands on to all its bodies what the hit ones have got in a round.
  void end_round(std::span<ImpactBody> bodies);
  /// Goes back to the start of the substep, once its bodies have.
  void end(const SolveInput& input, std::span<const ImpactBody> bodies);

  /// Gives an impulse to a body that is hit.
  void push(std::uint32_t place, const ImpactMomentum& impulse, std::span<ImpactBody> bodies);
  /// Keeps a coordinate from leaving its range. Returns the change of its rate.
  double push(ImpactEnd& end, std::span<ImpactBody> bodies);
  void add_impulse(ImpactEnd& end, double impulse, std::span<ImpactBody> bodies);
  /// Has all its bodies begin elsewhere: `back` seconds of what an impulse on a hit one makes of their velocities.
  void put_back(std::uint32_t place, double back, const ImpactMomentum& impulse);
  /// 1/kg: what an impulse on one hit body makes of the motion of another along a direction.
  double response(std::uint32_t of, const ImpactMomentum& along, std::uint32_t by, const ImpactMomentum& impulse) const;

  std::span<ImpactEnd> ends() { return ends_; }
  /// Its bodies among all.
  std::vector<std::uint32_t>& places() { return places_; }

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(places_, hit_, ends_, response_, impulses_, put_back_, answer_, motions_); }

 private:
  std::size_t size() const { return 6 * hit_.size() + ends_.size(); }
  void find_ends(const SolveInput& input);
  void find_response();
  void add(std::size_t first, std::span<const double> impulse, std::span<ImpactBody> bodies);
  void momenta_of(const std::vector<double>& impulses);

  DirectJoints* joints_ = nullptr;
  double start_ = 0;                   // s into the step, of the substep
  double time_ = 0;                    // s into the substep
  std::vector<std::uint32_t> places_;  // of its bodies among those of Impacts
  std::vector<std::uint32_t> hit_;     // numbers of those that are hit among these
  std::vector<ImpactEnd> ends_;
  std::vector<double> response_;   // by columns: of six numbers of each hit body, and of ends, to impulses on the same
  std::vector<double> impulses_;   // on these, in this round
  std::vector<double> put_back_;   // times s, by which bodies are put back
  std::vector<double> answer_;     // of all bodies, six numbers each
  std::vector<BodyPose> motions_;  // of all, since the substep began
};

}  // namespace atl::solver
