/// The Open Dynamics Engine (ode.org), one thread. Friction and restitution of a pair combine by Atoll's rules, and
/// restitution begins at the scene's threshold. Friction is the pyramid that follows the normal force
/// (dContactApprox1): without it ODE takes the coefficient for a force. At most 8 contacts a pair of convex shapes, 32
/// with a surface. A ball joint is one of its own. ERP, CFM, over-relaxation and gyroscopic torque are ODE's defaults;
/// nothing is disabled automatically.

#include <ode/ode.h>
#include <ode/version.h>

#include <array>
#include <cmath>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <deque>

#include "ball.h"
#include "ode_shape.h"
#include "peer.h"

namespace {

using peer::from_ode;

// ODE ends the process at what it takes for an impossible state, which a run that blew up comes to.
[[noreturn]] void give_up(int number, const char* message, va_list arguments) {
  std::fprintf(stderr, "ode: the simulation broke down: error %d: ", number);
  std::vfprintf(stderr, message, arguments);
  std::fputc('\n', stderr);
  std::_Exit(4);
}

// Warnings, as of the direct solver's trouble with redundant contacts. Each may come thousands of times.
void warn_once(int number, const char* message, va_list arguments) {
  static bool warned = false;
  if (warned) return;
  warned = true;
  std::fprintf(stderr, "ode: message %d, shown once: ", number);
  std::vfprintf(stderr, message, arguments);
  std::fputc('\n', stderr);
}

struct Library {
  Library() {
    dInitODE2(0);
    dAllocateODEDataForThread(dAllocateMaskAll);
    dSetErrorHandler(give_up);
    dSetDebugHandler(give_up);
    dSetMessageHandler(warn_once);
  }
  ~Library() { dCloseODE(); }
};

class OdeSimulation : public peer::Simulation {
 public:
  OdeSimulation(const atl::Scene& scene, const peer::Setting& setting)
      : scene_(scene),
        substeps_(setting.substeps),
        dt_(scene.dt / setting.substeps),
        direct_(setting.variant == "worldstep"),
        world_(dWorldCreate()),
        space_(dSweepAndPruneSpaceCreate(nullptr, dSAP_AXES_XYZ)),
        contacts_(dJointGroupCreate(0)),
        shapes_(space_),
        may_touch_(peer::exceptions_to_touch(scene)) {
    dWorldSetGravity(world_, scene.gravity.x(), scene.gravity.y(), scene.gravity.z());
    dWorldSetQuickStepNumIterations(world_, setting.iterations);
    try {
      for (std::size_t i = 0; i < scene.bodies.size(); ++i) add_body(i);
      for (const peer::Ball& ball : peer::balls_of(scene, solids_, "ODE")) add_joint(ball);
    } catch (...) {
      destroy();
      throw;
    }
  }
  ~OdeSimulation() override { destroy(); }

  void step() override {
    for (int substep = 0; substep < substeps_; ++substep) {
      for (const auto& [body, force] : forces_) dBodyAddForce(body, force.x(), force.y(), force.z());
      dJointGroupEmpty(contacts_);
      touches_.clear();
      feedback_.clear();
      rows_ = joint_rows_;
      dSpaceCollide(space_, this,
                    [](void* self, dGeomID a, dGeomID b) { static_cast<OdeSimulation*>(self)->touch(a, b); });
      advance();
    }
  }

  std::vector<atl::BodyState> states() const override {
    std::vector<atl::BodyState> states;
    for (std::size_t i = 0; i < solids_.size(); ++i) {
      const peer::Solid& solid = solids_[i];
      if (bodies_[i] == nullptr) {
        states.push_back({peer::body_pose(solid, solid.pose)});
        continue;
      }
      const dReal* q = dBodyGetQuaternion(bodies_[i]);
      const atl::Quaternion turn(q[0], q[1], q[2], q[3]);
      states.push_back({.pose = peer::body_pose(solid, {from_ode(dBodyGetPosition(bodies_[i])), turn.normalized()}),
                        .velocity = from_ode(dBodyGetLinearVel(bodies_[i])),
                        .angular_velocity = from_ode(dBodyGetAngularVel(bodies_[i]))});
    }
    return states;
  }

  void keep_loads() override { keeps_loads_ = true; }

  std::vector<atl::ContactLoad> loads() const override {
    peer::LoadSum sum;
    for (std::size_t i = 0; i < touches_.size(); ++i) {
      sum.add(touches_[i].other, touches_[i].pushed, from_ode(feedback_[i].f1));
    }
    return sum.loads();
  }

 private:
  // The two bodies of a contact joint: the one that the first force of its feedback acts on, and the other one.
  struct Touch {
    std::size_t pushed;
    std::size_t other;
  };

  void add_body(std::size_t i) {
    const atl::BodyDef& def = scene_.bodies[i].def;
    solids_.push_back(peer::make_solid(def));
    const peer::Solid& solid = solids_.back();
    const bool dynamic = def.type == atl::BodyType::Dynamic;
    const bool moves = dynamic || peer::is_moving_kinematic(def);
    bodies_.push_back(moves ? make_body(def, solid) : nullptr);
    const dBodyID body = bodies_.back();
    for (const dGeomID geom : shapes_.add(solid, body)) {
      dGeomSetData(geom, reinterpret_cast<void*>(static_cast<std::uintptr_t>(i)));
    }
    if (!dynamic) return;
    atl::Vector3 force = scene_.bodies[i].force;
    if (def.gravity_scale != 1) {
      dBodySetGravityMode(body, 0);
      force += def.gravity_scale * solid.mass * scene_.gravity;
    }
    if (!force.isZero(0)) forces_.emplace_back(body, force);
  }

  dBodyID make_body(const atl::BodyDef& def, const peer::Solid& solid) {
    const dBodyID body = dBodyCreate(world_);
    if (def.type == atl::BodyType::Kinematic) {
      dBodySetKinematic(body);
    } else {
      dMass mass;
      const atl::Vector3& moments = solid.moments;
      dMassSetParameters(&mass, solid.mass, 0, 0, 0, moments.x(), moments.y(), moments.z(), 0, 0, 0);
      dBodySetMass(body, &mass);
      // ODE takes away a share of the velocity in each step, by default only above a threshold.
      dBodySetLinearDamping(body, -std::expm1(-def.linear_damping * dt_));
      dBodySetAngularDamping(body, -std::expm1(-def.angular_damping * dt_));
      dBodySetLinearDampingThreshold(body, 0);
      dBodySetAngularDampingThreshold(body, 0);
    }
    const atl::Vector3 &at = solid.pose.position, &v = def.velocity, &w = def.angular_velocity;
    dBodySetPosition(body, at.x(), at.y(), at.z());
    dBodySetQuaternion(body, peer::OdeQuaternion(solid.pose.orientation).w_x_y_z);
    dBodySetLinearVel(body, v.x(), v.y(), v.z());
    dBodySetAngularVel(body, w.x(), w.y(), w.z());
    return body;
  }

  // ODE takes the first anchor in the world's frame and the second in the body's, which is the world's where there is
  // none. The first body must be there.
  void add_joint(peer::Ball ball) {
    if (bodies_[ball.first] == nullptr) {
      std::swap(ball.first, ball.second);
      std::swap(ball.at_first, ball.at_second);
    }
    const dBodyID first = bodies_[ball.first], second = bodies_[ball.second];
    const auto in_world = [&](std::size_t i, const atl::Vector3& at) -> atl::Vector3 {
      return solids_[i].pose.position + solids_[i].pose.orientation * at;
    };
    const dJointID joint = dJointCreateBall(world_, nullptr);
    dJointAttach(joint, first, second);
    const atl::Vector3 a = in_world(ball.first, ball.at_first);
    const atl::Vector3 b = second == nullptr ? in_world(ball.second, ball.at_second) : ball.at_second;
    dJointSetBallAnchor(joint, a.x(), a.y(), a.z());
    dJointSetBallAnchor2(joint, b.x(), b.y(), b.z());
    joint_rows_ += 3;
  }

  static std::size_t index(dGeomID geom) { return reinterpret_cast<std::uintptr_t>(dGeomGetData(geom)); }
  static bool is_surface(dGeomID geom) {
    return dGeomGetClass(geom) == dTriMeshClass || dGeomGetClass(geom) == dHeightfieldClass;
  }

  // Makes the contact joints of a pair of geoms whose bounds overlap.
  void touch(dGeomID a, dGeomID b) {
    const atl::BodyDef &def_a = scene_.bodies[index(a)].def, &def_b = scene_.bodies[index(b)].def;
    if (def_a.type != atl::BodyType::Dynamic && def_b.type != atl::BodyType::Dynamic) return;
    if (index(a) == index(b)) return;  // parts of a compound
    if (may_touch_ && !may_touch_(index(a), index(b))) return;

    std::array<dContactGeom, 32> points;
    const int max = is_surface(a) || is_surface(b) ? static_cast<int>(points.size()) : 8;
    const int count = dCollide(a, b, max, points.data(), sizeof(dContactGeom));
    if (count == 0) return;
    dContact contact = {};
    contact.surface.mode = dContactApprox1;
    contact.surface.mu = peer::combined_friction(def_a.material.friction, def_b.material.friction);
    contact.surface.bounce = peer::combined_restitution(def_a.material.restitution, def_b.material.restitution);
    if (contact.surface.bounce > 0) {
      contact.surface.mode |= dContactBounce;
      contact.surface.bounce_vel = peer::threshold_of(scene_);
    }
    for (int i = 0; i < count; ++i) {
      contact.geom = points[static_cast<std::size_t>(i)];
      // With hulls, MPR now and then has no normal to give.
      if (!(from_ode(contact.geom.normal).squaredNorm() > 0.5) || !std::isfinite(contact.geom.depth)) continue;
      const dJointID joint = dJointCreateContact(world_, contacts_, &contact);
      dJointAttach(joint, dGeomGetBody(a), dGeomGetBody(b));
      rows_ += contact.surface.mu > 0 ? 3 : 1;
      if (!keeps_loads_) continue;
      feedback_.emplace_back();
      dJointSetFeedback(joint, &feedback_.back());
      // A joint's first body is never the world.
      touches_.push_back(dGeomGetBody(a) != nullptr ? Touch{index(a), index(b)} : Touch{index(b), index(a)});
    }
  }

  void advance() {
    if (!direct_) {
      if (dWorldQuickStep(world_, dt_) == 0) throw atl::Error("ODE ran out of memory");
      return;
    }
    // The matrix is that of an island; this takes the world for one.
    constexpr double max = 2e9;  // bytes
    const double bytes = 8 * rows_ * rows_;
    if (bytes > max) {
      throw atl::Error("ODE's direct solver would need up to " + std::to_string(std::llround(bytes / 1e6)) +
                       " MB for " + std::to_string(std::llround(rows_)) + " rows; expected at most " +
                       std::to_string(std::llround(max / 1e6)) + " MB: use --variant quickstep");
    }
    if (dWorldStep(world_, dt_) == 0) throw atl::Error("ODE ran out of memory");
  }

  void destroy() {
    dJointGroupDestroy(contacts_);
    dSpaceDestroy(space_);  // with its geoms
    dWorldDestroy(world_);  // with its bodies
  }

  const atl::Scene& scene_;
  int substeps_;
  double dt_;
  bool direct_;
  bool keeps_loads_ = false;
  dWorldID world_;
  dSpaceID space_;
  dJointGroupID contacts_;
  peer::OdeShapes shapes_;
  atl::MayTouch may_touch_;
  std::vector<peer::Solid> solids_;
  std::vector<dBodyID> bodies_;  // null for what doesn't move
  std::vector<std::pair<dBodyID, atl::Vector3>> forces_;
  std::vector<Touch> touches_;
  std::deque<dJointFeedback> feedback_;  // ODE keeps pointers to them
  double rows_ = 0;
  double joint_rows_ = 0;
};

}  // namespace

int main(int argc, char** argv) {
  const Library library;
  const peer::Engine engine = {
      .name = "ode",
      .version = dODE_VERSION,
      .precision = sizeof(dReal) == sizeof(float) ? "single" : "double",
      .iterations = 20,
      .variants = {"quickstep", "worldstep"},
      .settings =
          {
              {"default", {}, true},
              {"2 substeps", {"--substeps", "2"}, false},
              {"4 substeps", {"--substeps", "4"}, true},
              {"8 substeps", {"--substeps", "8"}, false},
              {"16 substeps", {"--substeps", "16"}, false},
              {"50 iterations", {"--iterations", "50"}, false},
              {"100 iterations", {"--iterations", "100"}, false},
              {"300 iterations", {"--iterations", "300"}, false},
              {"4 substeps, 50 iterations", {"--substeps", "4", "--iterations", "50"}, false},
              {"direct", {"--variant", "worldstep"}, false},
              {"direct, 4 substeps", {"--variant", "worldstep", "--substeps", "4"}, false},
              {"direct, 16 substeps", {"--variant", "worldstep", "--substeps", "16"}, false},
          },
      .load = [](const atl::Scene& scene,
                 const peer::Setting& setting) { return std::make_unique<OdeSimulation>(scene, setting); },
  };
  return peer::run(engine, argc, argv);
}
