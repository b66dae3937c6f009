// Two or three bodies that touch nothing, on joints of any kind, with whatever acts along their coordinates: no motor
// has more force than it is given, no energy or momentum comes of nothing, what breaks was overloaded, and joints that
// are solved directly come to where swept ones do.

#include <algorithm>
#include <cmath>
#include <string>
#include <variant>
#include <vector>

#include "consistency.h"
#include "motion.h"
#include "support/motion.h"
#include "support/random_assembly.h"
#include "target.h"

namespace {

using namespace atl;

constexpr double dt = 1.0 / 60;
constexpr int steps = 8;

struct Joined {
  WorldDef world;
  std::vector<BodyDef> bodies;
  std::vector<JointDef> joints;
};

BodyDef body_of(fuzz::Bytes& bytes, fuzz::Definitions& definitions) {
  BodyDef def = {.shape = Box{{bytes.within(0.05, 0.5), bytes.within(0.05, 0.5), 0.2}},
                 .position = definitions.vector(1),
                 .orientation = definitions.orientation(),
                 .density = std::pow(10.0, 2 + bytes.within(0, 2))};
  if (bytes.one_in(3)) def.velocity = definitions.vector(3);
  if (bytes.one_in(3)) def.angular_velocity = definitions.vector(3);
  def.filter.mask = 0;
  return def;
}

Joined joined_of(fuzz::Bytes& bytes) {
  fuzz::Definitions definitions(bytes, fuzz::Numbers::Usual);
  Joined made;
  made.world.gravity = bytes.flag() ? Vector3(Vector3::Zero()) : definitions.vector(10);
  made.world.settings.substeps = definitions.integer(1, 8);
  made.world.settings.joint_solver = static_cast<JointSolver>(bytes.below(3));
  World scratch;
  std::vector<BodyId> ids;
  for (std::uint32_t left = 2 + bytes.below(2); left > 0; --left) {
    BodyDef def = body_of(bytes, definitions);
    if (ids.empty() && bytes.one_in(3)) {
      def.type = BodyType::Static;
      def.velocity = def.angular_velocity = Vector3::Zero();
    }
    made.bodies.push_back(def);
    ids.push_back(scratch.add_body(def));
    if (ids.size() == 1) continue;
    try {
      const JointDef joint = definitions.joint(scratch, ids[ids.size() - 2], ids.back());
      scratch.add_joint(joint);
      made.joints.push_back(joint);
    } catch (const Error&) {
    }
  }
  return made;
}

World world_of(const Joined& made) {
  World world(made.world);
  for (const BodyDef& def : made.bodies) world.add_body(def);
  for (const JointDef& def : made.joints) world.add_joint(def);
  return world;
}

template <typename Kind>
bool has(const Joined& made) {
  return std::ranges::any_of(made.joints, [](const JointDef& def) { return std::holds_alternative<Kind>(def.kind); });
}

// m or rad: by how much joints are open, or beyond their ranges.
double gap_of(const World& world) {
  std::vector<PlacedJoint> joints;
  std::vector<BodyState> states;
  for (const BodyId id : world.bodies()) states.push_back(world.state(id));
  for (const JointId id : world.joints()) {
    const JointDef& def = world.joint(id);
    if (std::holds_alternative<TendonJoint>(def.kind)) continue;
    joints.push_back({def.kind, def.first.index, def.second.index, def.frame_first, def.frame_second});
  }
  const JointDriftReport drift = measure_joint_drift(joints, states);
  return drift.max + drift.angle_max + drift.excess_max + drift.angle_excess_max;
}

// Null where its kind has no such coordinate.
const JointAxis* axis_of(const World& world, JointId id, std::size_t coordinate) {
  try {
    return &world.joint_axis(id, coordinate);
  } catch (const Error&) {
    return nullptr;
  }
}

void check_motors(const World& world, JointId id) {
  const JointState state = world.joint_state(id);
  for (std::size_t i = 0; i < state.motor.size(); ++i) {
    const JointAxis* const axis = axis_of(world, id, i);
    if (axis == nullptr) continue;
    const double max = axis->motor ? *axis->motor->max_force : 0;
    fuzz::require(std::abs(state.motor[i]) <= max * (1 + 1e-6),
                  "a motor of " + std::to_string(max) + " N exerts " + std::to_string(state.motor[i]));
  }
}

template <typename Has>
bool any_axis(const World& world, const Has& has) {
  for (const JointId id : world.joints()) {
    for (std::size_t i = 0; i < 6; ++i) {
      const JointAxis* const axis = axis_of(world, id, i);
      if (axis != nullptr && has(*axis)) return true;
    }
  }
  return false;
}

bool is_endless(const JointAxis& axis) { return axis.motor && axis.motor->max_force == unlimited; }
bool bounces(const JointAxis& axis) { return axis.range.restitution > 0; }

void check_breaking(const World& world, JointId id) {
  const JointState state = world.joint_state(id);
  const JointDef& def = world.joint(id);
  const double force = state.force.norm(), torque = state.torque.norm();
  const bool holds = force <= def.break_force * (1 + 1e-9) && torque <= def.break_torque * (1 + 1e-9);
  const bool overloaded = force >= def.break_force * (1 - 1e-9) || torque >= def.break_torque * (1 - 1e-9);
  fuzz::require(state.broken ? overloaded : holds, std::string("a joint ") + (state.broken ? "breaks" : "holds") +
                                                       " at " + std::to_string(force) + " N and " +
                                                       std::to_string(torque) + " N m");
}

struct Sizes {
  double momentum = 0;  // kg m/s
  double reach = 1;     // m
};

Sizes sizes_of(const World& world) {
  Sizes sizes;
  for (const BodyId id : world.bodies()) {
    if (world.type(id) != BodyType::Dynamic) continue;
    sizes.momentum += world.mass(id) * (0.1 + world.velocity(id).norm() + world.angular_velocity(id).norm());
    sizes.reach = std::max(sizes.reach, world.centre_of_mass(id).norm());
  }
  return sizes;
}

void check_run(const Joined& made) {
  World world = world_of(made);
  const std::vector<BodyId> ids = world.bodies();
  test::Assembly assembly;
  assembly.length = 6;
  assembly.gap = gap_of(world);
  const double allowed = 2 * test::energy_allowance(world, assembly, ids, steps * dt).all() + 1e-3;
  const double start = test::mechanical_energy(world, ids);
  // A gear's two wheels push against the frame that would carry them, which no body here stands for: momentum goes.
  const bool is_free =
      made.world.gravity.isZero() && made.bodies.front().type == BodyType::Dynamic && !has<GearJoint>(made);
  const bool is_direct = made.world.settings.joint_solver == JointSolver::Direct;
  // See README.md; and test::energy_allowance() doesn't know of tendons.
  const bool is_held = !has<TendonJoint>(made) && (is_direct || (assembly.gap < 0.1 && !any_axis(world, is_endless)));
  for (int i = 0; i < steps; ++i) {
    const MotionReport before = test::motion_of(world);
    const bool is_whole = world.step(dt).quarantined == 0;
    fuzz::check_world(world);
    fuzz::require(is_whole || !is_held, "a body breaks");
    if (!is_whole) return;
    for (const JointId id : world.joints()) {
      check_motors(world, id);
      check_breaking(world, id);
    }
    const Sizes sizes = sizes_of(world);
    if (is_free) {
      const double arm = is_direct ? 1e-4 * sizes.reach : unlimited;  // swept joints turn within a substep
      fuzz::require_same_momentum(before, test::motion_of(world), 1e-4 * sizes.momentum, arm * sizes.momentum);
    }
    const double gained = test::mechanical_energy(world, ids) - start;
    fuzz::require(!is_held || gained <= allowed,
                  "joints make " + std::to_string(gained) + " J, of at most " + std::to_string(allowed));
  }
}

// Both with so many substeps that what they differ by is error of neither.
void check_solvers_agree(Joined made) {
  if (has<TendonJoint>(made)) return;  // nor are its ends known
  made.world.settings.substeps = 64;
  made.world.settings.iterations = 16;
  for (JointDef& def : made.joints) def.break_force = def.break_torque = unlimited;
  for (BodyDef& def : made.bodies) def.velocity = def.angular_velocity = Vector3::Zero();
  made.world.settings.joint_solver = JointSolver::Direct;
  World direct = world_of(made);
  // How fast joints are closed is up to the solver, and so is which of several ends bounces first.
  if (gap_of(direct) > 1e-6 || any_axis(direct, is_endless) || any_axis(direct, bounces)) return;
  made.world.settings.joint_solver = JointSolver::Iterative;
  World swept = world_of(made);
  for (int i = 0; i < 3; ++i) {
    direct.step(dt);
    swept.step(dt);
  }
  for (const BodyId id : direct.bodies()) {
    const double apart = (direct.centre_of_mass(id) - swept.centre_of_mass(id)).norm();
    fuzz::require(apart < 0.1 + 0.005 * direct.velocity(id).norm(),
                  "solvers take a body to places " + std::to_string(apart) + " m apart");
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  atl::fuzz::Bytes bytes({data, size});
  const Joined made = joined_of(bytes);
  check_run(made);
  check_solvers_agree(made);
  return 0;
}
