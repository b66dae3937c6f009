#pragma once

#include <solver/tuning.h>

namespace atl::solver {

enum class Friction { None, Cone, Pyramid };
enum class JointMethod { Auto, Iterative, Direct };
enum class Stabilisation { Soft, Baumgarte, SplitImpulse };

/// Settings of the solver. Ranges and meanings as in atoll/settings.h.
struct SolverSettings {
  int substeps = 4;
  double refinement = 1;  ///< substeps for each of those that were asked for; `substeps` counts them all
  bool refined = false;   ///< it is in more of them that what sags, or lands, is held
  int iterations = 1;
  int relax_iterations = 1;
  bool pyramid = false;
  bool warm_starting = true;
  double tolerance = 0;
  Stabilisation stabilisation = Stabilisation::Soft;
  double correction = 0.2;
  double slop = 5e-4;
  bool profile = false;
  bool everything = false;   ///< leave nothing out, for no other result
  bool direct_only = false;  ///< every island that can be is solved at once, at any cost
  double contact_hertz = 0;  ///< 0: an eighth of the substep rate
  double contact_damping_ratio = 10;
  double contact_push_speed = 3;
  double restitution_threshold = 0;  ///< m/s
  JointMethod joint_method = JointMethod::Auto;
  double joint_hertz = 0;  ///< 0: 0.28 of the substep rate
  double joint_damping_ratio = 2;
};

/// A soft constraint's coefficients: the impulse of a damped spring integrated implicitly over a substep, as a
/// velocity constraint with bias (Catto, "Soft Constraints", GDC 2011; the form of "Solver2D", 2024).
struct Softness {
  float bias_rate = 0;      ///< 1/s, speed asked for per metre of overlap
  float mass_scale = 1;     ///< of the effective mass
  float impulse_scale = 0;  ///< of the accumulated impulse, which it lets leak

  /// hertz > 0, damping_ratio >= 0, h > 0 in s.
  static Softness of(double hertz, double damping_ratio, double h) {
    const double omega = 2 * 3.14159265358979323846 * hertz;
    const double a1 = 2 * damping_ratio + h * omega;
    const double a2 = h * omega * a1;
    const double a3 = 1 / (1 + a2);
    return {static_cast<float>(omega / a1), static_cast<float>(a2 * a3), static_cast<float>(a3)};
  }

  /// The softness of each of `count` parallel constraints which together are as stiff and damped as this one.
  Softness shared_by(int count) const {
    if (count == 1) return *this;
    const double left = static_cast<double>(impulse_scale) * count;
    const double sum = mass_scale + left;
    return {bias_rate, static_cast<float>(mass_scale / sum), static_cast<float>(left / sum)};
  }

  /// A rigid one that asks for a part of the overlap back within a substep (Baumgarte).
  static Softness rigid(double correction, double h) { return {static_cast<float>(correction / h), 1, 0}; }
};

/// Stiffening of soft contacts under load. A spring gives by its load over its stiffness, and the stiffness goes by the
/// masses of the two bodies, however much lies on them. A contact that would give by more than
/// tuning::stiffening_penetration gets springs and dashpots stronger by a factor: overlap is removed as fast as before,
/// but less of it stays. Contacts of jointed bodies don't stiffen, since the joints would give instead.
struct Stiffening {
  float max = 1;                  ///< how many times as stiff; 1: never
  float penetration_by_load = 0;  ///< m by N s a substep and 1/kg, as stiff as contacts are otherwise
  float response = 0;             ///< of the spring and dashpot to a change of speed, by that of the masses

  /// Contacts with a frequency of their own never stiffen. Neither do refined substeps: they are stiff already, and a
  /// stiffened tower falls in them.
  static Stiffening of(const SolverSettings& settings, double hertz, double h) {
    const double omega = 2 * 3.14159265358979323846 * hertz;
    const bool stiffens = settings.contact_hertz == 0 && !settings.refined;
    return {stiffens ? tuning::max_stiffening : 1, static_cast<float>(1 / (h * omega * omega)),
            static_cast<float>(h * omega * (2 * settings.contact_damping_ratio + h * omega))};
  }
};

/// The constants of a substep that kernels read.
struct SubstepConstants {
  float step;  ///< s, of all substeps together
  float h;     ///< s
  int substeps;
  float inverse_h;  ///< 1/s
  Softness dynamic_contact;
  Softness fixed_contact;   ///< against a body of infinite mass
  Stiffening stiffening;    ///< of contacts between bodies that move
  Softness joint;           ///< of joints that are solved one by one
  float joint_carried = 1;  ///< of their impulses, that the next substep starts with
  float push_speed;         ///< m/s, of contacts of what isn't large
  float gravity = 0;        ///< m/s^2: what is large under it is pushed apart faster
  float slop;               ///< m, overlap that is left alone
  float restitution_threshold;
  float refinement;  ///< see SolverSettings: impulses are kept as sums over so many substeps

  static SubstepConstants of(const SolverSettings& settings, double dt) {
    const double h = dt / settings.substeps;
    const double hertz = contact_hertz(settings, h);
    SubstepConstants c;
    c.step = static_cast<float>(dt);
    c.h = static_cast<float>(h);
    c.substeps = settings.substeps;
    c.inverse_h = static_cast<float>(1 / h);
    c.slop = 0;
    if (settings.stabilisation == Stabilisation::Soft) {
      c.dynamic_contact = Softness::of(hertz, settings.contact_damping_ratio, h);
      c.fixed_contact = Softness::of(2 * hertz, settings.contact_damping_ratio, h);
      c.stiffening = Stiffening::of(settings, hertz, h);
      // A net of joints that are swept once a substep rings up from 0.4 / h on.
      const double joint_limit = tuning::joint_hertz_limit / h;
      const double joint_hertz =
          settings.joint_hertz > 0 && settings.joint_hertz < joint_limit ? settings.joint_hertz : joint_limit;
      c.joint = Softness::of(joint_hertz, settings.joint_damping_ratio, h);
    } else {
      c.dynamic_contact = c.fixed_contact = c.joint = Softness::rigid(settings.correction, h);
      // Let sweeps take away a part e of an error, b of which is asked back as speed, and carry 1 - k of the impulses.
      // Errors for which e is small then go by s^3 + (2 e + k) s^2 + e (1 + b) s + e b = 0, s in 1/h, and ring up
      // unless (2 e + k) (1 + b) > b.
      if (settings.stabilisation == Stabilisation::Baumgarte) {
        c.joint_carried = static_cast<float>(1 / (1 + settings.correction));
      }
      c.slop = static_cast<float>(settings.slop);
    }
    c.refinement = static_cast<float>(settings.refinement);
    c.push_speed = static_cast<float>(settings.contact_push_speed);
    c.restitution_threshold = static_cast<float>(settings.restitution_threshold);
    return c;
  }

  /// 1/s: how fast sweeps part the overlap of soft contacts that carry nothing, on the mean of a step of dt seconds.
  static double parting_rate(const SolverSettings& settings, double dt, bool fixed) {
    const double h = dt / settings.substeps;
    const double hertz = contact_hertz(settings, h);
    const Softness soft = Softness::of(fixed ? 2 * hertz : hertz, settings.contact_damping_ratio, h);
    double left = 1;
    for (int i = 0; i < settings.substeps; ++i) left *= 1 - h * soft.bias_rate * soft.mass_scale;
    return (1 - left) / dt;
  }

  /// Hz, of soft contacts in substeps of h seconds.
  static double contact_hertz(const SolverSettings& settings, double h) {
    // A contact much stiffer than the substep can follow would be integrated badly.
    const double limit = tuning::contact_hertz_limit / h;
    const double wanted = settings.contact_hertz > 0 ? settings.contact_hertz : tuning::contact_hertz_share / h;
    return wanted < limit ? wanted : limit;
  }

  /// m by N and 1/kg: how far contacts between dynamic bodies count as giving under a load, whatever the substeps.
  static double penetration_by_load(const SolverSettings& settings, double dt) {
    double hertz = tuning::contact_hertz_share * tuning::assumed_substeps / dt;
    if (settings.contact_hertz > 0 && settings.contact_hertz < hertz) hertz = settings.contact_hertz;
    const double omega = 2 * 3.14159265358979323846 * hertz;
    return 1 / (omega * omega);
  }
};

}  // namespace atl::solver
