// The features that the step ran, and why: the plan as data, for reports.

#include <features/with_continuous.h>
#include <features/with_direct_contacts.h>
#include <features/with_joints.h>
#include <features/with_recording.h>
#include <features/with_restitution.h>
#include <features/with_surfaces.h>

#include "step/events.h"
#include "step/pipeline.h"

namespace atl {
namespace {

struct FeatureWords {
  const char* name;
  const char* unit;
  const char* why_run;
  const char* why_not;
};

// By Feature.
constexpr std::array<FeatureWords, feature_count> words = {{
    {"broadphase", "pairs", "bounds of bodies overlap", "no two bodies' bounds overlap"},
    {"narrowphase", "pairs", "pairs are new, or have moved since they were last looked at",
     "no pair is new or has moved"},
    {"recycled_manifolds", "pairs", "pairs have hardly moved since they were last looked at",
     "no pair was looked at before and has hardly moved since"},
    {"contact_filter", "pairs", "a filter is set, and pairs are new or asked of again", "no contact filter is set"},
    {"contact_modifier", "contacts", "a modifier is set, and bodies touch", "no contact modifier is set"},
    {"contact_solver", "contacts", "bodies touch", "nothing touches"},
    {"several_points", "contacts", "bodies touch with edges or faces", "whatever touches does so in one point"},
    {"two_movable_bodies", "contacts", "bodies that can move touch each other",
     "whatever touches, one of the two is fixed"},
    {"friction", "contacts", "touching materials have friction", "no contact has friction"},
    {"rolling_and_belts", "contacts", "surfaces run, or hold back rolling or spinning",
     "no surface runs, or holds back rolling or spinning"},
    {"restitution", "contacts", "touching materials bounce", "no contact bounces"},
    {"warm_starting", "contacts", "it is on", "it is off, or nothing touches"},
    {"relaxation", "contacts", "soft contacts push, and what they pushed is taken back",
     "it is off, contacts are not soft, or nothing touches"},
    {"split_impulses", "contacts", "overlap is removed by velocities of its own",
     "stabilisation is another, or nothing touches"},
    {"early_end", "groups", "sweeps end where they change little: a tolerance is set",
     "no tolerance is set, or nothing touches"},
    {"direct_contacts", "islands", "some islands' contacts carry more than sweeps can settle",
     "no island's contacts carry more than sweeps can settle"},
    {"refined_substeps", "islands", "some islands sag under their own weight, or a body lands",
     "no island sags, and no body lands that leans"},
    {"error_target", "islands", "errors of islands have targets, and decide on their substeps",
     "no error has a target, or nothing touches or is joined"},
    {"joint_solver", "joints", "bodies that are awake are joined: one joint after the other",
     "all joints are solved at once"},
    {"direct_joints", "joints", "some joints that hang together are solved at once",
     "no joint needs to be solved at once"},
    {"motion_locks", "bodies", "bodies in islands are locked along or about axes",
     "no body in an island is locked along or about an axis"},
    {"gyroscopic_torque", "bodies", "bodies in islands have unequal moments of inertia",
     "no body in an island has unequal moments of inertia"},
    {"free_flight", "bodies", "some bodies touch nothing", "every awake body touches something or is joined"},
    {"kinematic_bodies", "bodies", "there are some", "there are none"},
    {"continuous_collision", "bodies", "some bodies moved farther than their size allows",
     "no body moved farther than margins see"},
    {"sleeping", "bodies", "it is on", "it is off"},
    {"contact_events", "events", "they are asked for", "they are not asked for"},
    {"sensors", "sensors", "there are some", "there are none"},
    {"contact_problem", "contacts", "it is asked for", "it is not asked for"},
    {"recording", "steps", "calls are recorded", "nothing is recorded"},
}};

// False for features that this build leaves out.
bool is_built(Feature feature) {
  switch (feature) {
    case Feature::RollingAndBelts:
      return with_surfaces;
    case Feature::Restitution:
      return with_restitution;
    case Feature::DirectContacts:
    case Feature::RefinedSubsteps:
      return with_direct_contacts;
    case Feature::JointSolver:
    case Feature::DirectJoints:
      return with_joints;
    case Feature::ContinuousCollision:
      return with_continuous;
    case Feature::Recording:
      return with_recording;
    default:
      return true;
  }
}

}  // namespace

const char* feature_name(Feature feature) { return words[static_cast<std::size_t>(feature)].name; }

void report_features(const Stores& world, const StepPipeline& pipeline, const ContactRules& rules, bool records,
                     StepReport& report) {
  solver::ContactWork work;
  std::int64_t surfaces = 0, gyroscopic = 0, locked = 0, early_ends = 0;
  for (const solver::GroupReport& group : pipeline.solve().group_reports()) {
    work += group.work;
    if (group.surfaces) surfaces += group.work.contacts;
    gyroscopic += group.gyroscopic_bodies;
    locked += group.locked_bodies;
    early_ends += world.settings.tolerance > 0;
  }
  const StepCounts& counts = report.counts;
  const auto phase_ms = [&](Phase phase) { return report.phase_ms[static_cast<std::size_t>(phase)]; };
  const auto note = [&](Feature feature, bool run, std::int64_t items, double ms = 0) {
    const FeatureWords& of = words[static_cast<std::size_t>(feature)];
    report.features[static_cast<std::size_t>(feature)] = {of.name,         run,     run ? of.why_run : of.why_not,
                                                          run ? items : 0, of.unit, run ? ms : 0};
  };
  const auto report_items = [&note](Feature feature, std::int64_t items, double ms = 0) {
    note(feature, items > 0, items, ms);
  };

  const auto explain = [&report](Feature feature, const char* why) {
    report.features[static_cast<std::size_t>(feature)].why = why;
  };

  report_items(Feature::Broadphase, counts.pairs, phase_ms(Phase::FindPairs));
  report_items(Feature::Narrowphase, counts.recomputed_manifolds, phase_ms(Phase::UpdateContacts));
  report_items(Feature::RecycledManifolds, counts.recycled_manifolds);
  report_items(Feature::ContactFilter, counts.filtered_pairs);
  if (rules.filters() && counts.filtered_pairs == 0) explain(Feature::ContactFilter, "no pair is new to the filter");
  report_items(Feature::ContactModifier, counts.asked_contacts);
  if (rules.modifies() && counts.asked_contacts == 0) explain(Feature::ContactModifier, "nothing touches");
  report_items(Feature::ContactSolver, counts.contacts, phase_ms(Phase::SolveIslands));
  report_items(Feature::SeveralPoints, work.several_points);
  report_items(Feature::TwoMovableBodies, work.two_movable);
  report_items(Feature::Friction, work.friction);
  report_items(Feature::RollingAndBelts, surfaces);
  report_items(Feature::Restitution, work.bounces);
  report_items(Feature::WarmStarting, world.settings.warm_starting ? counts.contacts : 0);
  const bool soft = world.settings.stabilisation == Stabilisation::Soft;
  report_items(Feature::Relaxation, soft && world.settings.relax_iterations > 0 ? work.contacts : 0);
  report_items(Feature::SplitImpulses, world.settings.stabilisation == Stabilisation::SplitImpulse ? work.contacts : 0);
  report_items(Feature::EarlyEnd, early_ends);
  double direct_ms = 0, refined_ms = 0;
  for (const SolverChoice& island : world.results.solver_choices) (island.direct ? direct_ms : refined_ms) += island.ms;
  report_items(Feature::DirectContacts, counts.direct_islands, direct_ms);
  report_items(Feature::RefinedSubsteps, counts.refined_islands, refined_ms);
  report_items(Feature::ErrorTarget, world.settings.target.is_set() ? counts.islands : 0);
  report_items(Feature::JointSolver, counts.joints - counts.direct_joints);
  report_items(Feature::DirectJoints, counts.direct_joints);
  if (counts.joints == 0) {
    const char* why = world.joints.count == 0 ? "there are no joints" : "no joint acts on a body that is awake";
    for (const Feature feature : {Feature::JointSolver, Feature::DirectJoints}) explain(feature, why);
  }
  report_items(Feature::MotionLocks, locked);
  report_items(Feature::GyroscopicTorque, gyroscopic);
  report_items(Feature::FreeFlight, static_cast<std::int64_t>(pipeline.islands().islands().free_bodies().size()));
  report_items(Feature::KinematicBodies, static_cast<std::int64_t>(world.contents.kinematic));
  report_items(Feature::ContinuousCollision, counts.swept, phase_ms(Phase::SweepFastBodies));
  note(Feature::Sleeping, world.settings.sleeping, counts.active_bodies, phase_ms(Phase::Finish));
  const bool events = finds_contact_events(world.settings);
  const ContactEvents& events_of_step =
      world.settings.contact_events ? world.results.contact_events : world.results.unasked_events;
  note(Feature::ContactEvents, events, static_cast<std::int64_t>(events_of_step.events.size()));
  report_items(Feature::Sensors, static_cast<std::int64_t>(world.contents.sensors));
  note(Feature::ContactProblem, world.settings.keep_contact_problem || world.settings.run_everything, counts.contacts);
  note(Feature::Recording, records, 1);
  for (std::size_t i = 0; i < feature_count; ++i) {
    if (!is_built(static_cast<Feature>(i))) report.features[i].why = "this build is without it";
  }
}

}  // namespace atl
