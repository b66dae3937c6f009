// How a step is solved.

#include <atoll/settings.h>

#include "fields.h"
#include "parts.h"

namespace atl::python {

void bind_settings(nb::module_& module) {
  nb::enum_<FrictionModel>(module, "FrictionModel")
      .value("CONE", FrictionModel::Cone, "Isotropic.")
      .value("PYRAMID", FrictionModel::Pyramid, "Each of two components clamped alone.");
  nb::enum_<Stabilisation>(module, "Stabilisation", "How contacts get bodies out of each other.")
      .value("SOFT", Stabilisation::Soft)
      .value("BAUMGARTE", Stabilisation::Baumgarte)
      .value("SPLIT_IMPULSE", Stabilisation::SplitImpulse);
  nb::enum_<ContactSolver>(module, "ContactSolver")
      .value("AUTO", ContactSolver::Auto, "By sweeps, and at once where these don't hold.")
      .value("ITERATIVE", ContactSolver::Iterative)
      .value("DIRECT", ContactSolver::Direct, "At once, in islands of up to 400 bodies.");
  nb::enum_<JointSolver>(module, "JointSolver")
      .value("AUTO", JointSolver::Auto)
      .value("ITERATIVE", JointSolver::Iterative)
      .value("DIRECT", JointSolver::Direct);
  nb::enum_<Simd>(module, "Simd", "The instruction set of the kernels. The result is the same on each, bit for bit.")
      .value("AUTO", Simd::Auto)
      .value("PORTABLE", Simd::Portable)
      .value("SSE4", Simd::Sse4)
      .value("AVX2", Simd::Avx2)
      .value("AVX512", Simd::Avx512)
      .value("NEON", Simd::Neon);

  nb::class_<ErrorTarget> target(
      module, "ErrorTarget",
      "Errors that islands are held below: each gets the fewest substeps that do it, as the last steps measured. With "
      "Stabilisation.SOFT. What could not be held is told: World.missed_targets().");
  bind_definition(
      target,
      Field{"penetration", &ErrorTarget::penetration, "m, > 0: overlap after a step; not with Settings.contact_hertz"},
      Field{"joint_gap", &ErrorTarget::joint_gap,
            "m, > 0: what locked offsets of joints are open by after a step; not with Settings.joint_hertz"},
      Field{"residual", &ErrorTarget::residual, "> 0, relative: how far contacts are from solved"},
      Field{"motion", &ErrorTarget::motion,
            "m/s, > 0: how far bodies get from their paths in a second, by an estimate"},
      Field{"min_substeps", &ErrorTarget::min_substeps, "in [1, 1024]"},
      Field{"max_substeps", &ErrorTarget::max_substeps,
            "the most that a step of an island may cost, in [min_substeps, 1024]"});
  target.def("is_set", &ErrorTarget::is_set, "Whether it asks for anything.");

  nb::class_<Settings> settings(module, "Settings",
                                "How a step is solved. The defaults suit 60 Hz and metre-sized bodies.");
  bind_definition(
      settings, Field{"substeps", &Settings::substeps, "in [1, 1024]; overlap falls with its square"},
      Field{"target", &Settings::target, "in place of substeps, from which islands then start"},
      Field{"iterations", &Settings::iterations, "sweeps with the position bias, a substep; in [1, 1024]"},
      Field{"relax_iterations", &Settings::relax_iterations, "sweeps without it; in [0, 1024]"},
      Field{"tolerance", &Settings::tolerance, "m/s, >= 0: ends an island's sweeps; 0 never"},
      Field{"friction", &Settings::friction, ""}, Field{"warm_starting", &Settings::warm_starting, ""},
      Field{"stabilisation", &Settings::stabilisation, ""},
      Field{"correction", &Settings::correction, "of the overlap that is removed a substep, in (0, 1]; not with SOFT"},
      Field{"slop", &Settings::slop, "m, >= 0: overlap that is left alone; not with SOFT"},
      Field{"contact_hertz", &Settings::contact_hertz, "Hz, > 0; by the substeps if None"},
      Field{"contact_damping_ratio", &Settings::contact_damping_ratio, ">= 0"},
      Field{"contact_push_speed", &Settings::contact_push_speed, "m/s, > 0"},
      Field{"restitution_threshold", &Settings::restitution_threshold, "m/s, >= 0; by gravity if None"},
      Field{"contact_solver", &Settings::contact_solver, ""}, Field{"joint_solver", &Settings::joint_solver, ""},
      Field{"joint_hertz", &Settings::joint_hertz, "Hz, > 0; by the substeps if None"},
      Field{"joint_damping_ratio", &Settings::joint_damping_ratio, ">= 0"},
      Field{"sleeping", &Settings::sleeping, "islands at rest fall asleep"},
      Field{"sleep_speed", &Settings::sleep_speed, "m/s"}, Field{"time_to_sleep", &Settings::time_to_sleep, "s"},
      Field{"contact_events", &Settings::contact_events, "World.contact_events() has something to tell"},
      Field{"contact_event_force", &Settings::contact_event_force,
            "N, >= 0: contact events tell of contacts that go on, too, while they carry at least this"},
      Field{"accelerations", &Settings::accelerations, "World.accelerations has something to tell"},
      Field{"keep_contact_problem", &Settings::keep_contact_problem, "what the solver had to solve is kept"},
      Field{"run_everything", &Settings::run_everything, "leaves nothing out; no bit of the result changes"},
      Field{"profile", &Settings::profile, "StepReport.solver_ms has something to tell"},
      Field{"simd", &Settings::simd, ""});
}

}  // namespace atl::python
