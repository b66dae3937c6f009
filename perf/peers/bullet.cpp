/// Bullet (bulletphysics.org), one thread. Friction and restitution of a pair combine by Atoll's rules, and restitution
/// begins at the scene's threshold; sleeping and continuous collision detection are off. All else are Bullet's
/// defaults: 10 iterations of sequential impulses, penetration corrected by Baumgarte's method down to 4 cm and by a
/// split impulse below (the variant split-impulse: always), one friction direction (along the sliding), gyroscopic
/// torque integrated implicitly in the body's frame. A ball joint is a point-to-point constraint.

#include <BulletDynamics/ConstraintSolver/btNNCGConstraintSolver.h>
#include <BulletDynamics/MLCPSolvers/btDantzigSolver.h>
#include <BulletDynamics/MLCPSolvers/btMLCPSolver.h>
#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>

#include "ball.h"
#include "bullet_shape.h"
#include "peer.h"

namespace {

using peer::from_bullet;
using peer::to_bullet;

// Bullet multiplies both coefficients unless told otherwise.
btScalar combined_friction(const btCollisionObject* a, const btCollisionObject* b) {
  return static_cast<btScalar>(peer::combined_friction(a->getFriction(), b->getFriction()));
}
btScalar combined_restitution(const btCollisionObject* a, const btCollisionObject* b) {
  return static_cast<btScalar>(peer::combined_restitution(a->getRestitution(), b->getRestitution()));
}

// Atoll's v' = -c v as the fraction of speed lost in a second, which Bullet is told.
btScalar to_bullet_damping(double c) { return static_cast<btScalar>(-std::expm1(-c)); }

std::unique_ptr<btConstraintSolver> make_solver(const std::string& variant, btMLCPSolverInterface& direct) {
  if (variant == "nncg") return std::make_unique<btNNCGConstraintSolver>();
  if (variant == "dantzig") return std::make_unique<btMLCPSolver>(&direct);
  return std::make_unique<btSequentialImpulseConstraintSolver>();
}

// Keeps pairs apart before Bullet looks at their shapes.
struct OverlapFilter : btOverlapFilterCallback {
  explicit OverlapFilter(atl::MayTouch rule) : may_touch(std::move(rule)) {}

  bool needBroadphaseCollision(btBroadphaseProxy* a, btBroadphaseProxy* b) const override {
    const bool bits = (a->m_collisionFilterGroup & b->m_collisionFilterMask) != 0 &&
                      (b->m_collisionFilterGroup & a->m_collisionFilterMask) != 0;
    return bits && may_touch(index(a), index(b));
  }
  static std::size_t index(const btBroadphaseProxy* proxy) {
    return static_cast<std::size_t>(static_cast<const btCollisionObject*>(proxy->m_clientObject)->getUserIndex());
  }

  atl::MayTouch may_touch;
};

class BulletSimulation : public peer::Simulation {
 public:
  BulletSimulation(const atl::Scene& scene, const peer::Setting& setting)
      : scene_(scene),
        substeps_(setting.substeps),
        dt_(static_cast<btScalar>(scene.dt / setting.substeps)),
        two_frictions_(setting.variant == "two-frictions"),
        filter_(peer::exceptions_to_touch(scene)),
        solver_(make_solver(setting.variant, direct_)) {
    gCalculateCombinedFrictionCallback = combined_friction;
    gCalculateCombinedRestitutionCallback = combined_restitution;
    world_.setGravity(to_bullet(scene.gravity));
    btContactSolverInfo& info = world_.getSolverInfo();
    info.m_numIterations = setting.iterations;
    info.m_restitutionVelocityThreshold = static_cast<btScalar>(peer::threshold_of(scene));
    if (setting.variant == "split-impulse") info.m_splitImpulsePenetrationThreshold = 0;
    if (two_frictions_) info.m_solverMode |= SOLVER_USE_2_FRICTION_DIRECTIONS;
    if (filter_.may_touch) broadphase_.getOverlappingPairCache()->setOverlapFilterCallback(&filter_);
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) add_body(i);
    add_joints();
  }

  void step() override {
    for (int substep = 0; substep < substeps_; ++substep) {
      for (const std::size_t i : pushed_) bodies_[i]->applyCentralForce(to_bullet(scene_.bodies[i].force));
      world_.stepSimulation(dt_, 0);  // 0: Bullet takes dt as it is
      for (const std::size_t i : moving_) {
        poses_[i] = moved(i, scene_.dt / substeps_);
        bodies_[i]->setWorldTransform(to_bullet(poses_[i]));
      }
    }
  }

  std::vector<atl::BodyState> states() const override {
    std::vector<atl::BodyState> states;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
      const atl::BodyDef& def = scene_.bodies[i].def;
      if (def.type == atl::BodyType::Dynamic) {
        states.push_back({.pose = peer::body_pose(solids_[i], from_bullet(bodies_[i]->getWorldTransform())),
                          .velocity = from_bullet(bodies_[i]->getLinearVelocity()),
                          .angular_velocity = from_bullet(bodies_[i]->getAngularVelocity())});
      } else {
        states.push_back({poses_[i], def.velocity, def.angular_velocity});
      }
    }
    return states;
  }

  // The impulses that the solver keeps at the points of its manifolds. The first body is pushed along the normal.
  std::vector<atl::ContactLoad> loads() const override {
    peer::LoadSum sum;
    for (int m = 0; m < dispatcher_.getNumManifolds(); ++m) {
      const btPersistentManifold& manifold = *dispatcher_.getManifoldByIndexInternal(m);
      btVector3 impulse(0, 0, 0);
      for (int p = 0; p < manifold.getNumContacts(); ++p) {
        const btManifoldPoint& point = manifold.getContactPoint(p);
        impulse += point.m_appliedImpulse * point.m_normalWorldOnB +
                   point.m_appliedImpulseLateral1 * point.m_lateralFrictionDir1;
        if (two_frictions_) {
          impulse += point.m_appliedImpulseLateral2 * point.m_lateralFrictionDir2;
        }
      }
      const atl::Vector3 force = from_bullet(impulse) / dt_;
      if (!force.isZero(0)) sum.add(index(manifold.getBody1()), index(manifold.getBody0()), force);
    }
    return sum.loads();
  }

 private:
  static std::size_t index(const btCollisionObject* body) { return static_cast<std::size_t>(body->getUserIndex()); }

  void add_body(std::size_t i) {
    const atl::BodyDef& def = scene_.bodies[i].def;
    solids_.push_back(peer::make_solid(def));
    const peer::Solid& solid = solids_.back();
    poses_.push_back(solid.pose);

    btRigidBody::btRigidBodyConstructionInfo info(static_cast<btScalar>(solid.mass), nullptr, shapes_.add(solid),
                                                  to_bullet(solid.moments));
    info.m_startWorldTransform = to_bullet(solid.pose);
    info.m_friction = static_cast<btScalar>(def.material.friction);
    info.m_restitution = static_cast<btScalar>(def.material.restitution);
    info.m_linearDamping = to_bullet_damping(def.linear_damping);
    info.m_angularDamping = to_bullet_damping(def.angular_damping);
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    btRigidBody& body = *bodies_.back();
    body.setUserIndex(static_cast<int>(i));
    if (peer::is_moving_kinematic(def)) {
      body.setCollisionFlags(body.getCollisionFlags() | btCollisionObject::CF_KINEMATIC_OBJECT);
      moving_.push_back(i);
      // Bullet derives its velocity from where it is and was.
      body.setInterpolationWorldTransform(to_bullet(moved(i, -scene_.dt / substeps_)));
    }
    body.setActivationState(DISABLE_DEACTIVATION);  // never sleeps
    world_.addRigidBody(&body);
    if (def.type != atl::BodyType::Dynamic) return;
    body.setLinearVelocity(to_bullet(def.velocity));
    body.setAngularVelocity(to_bullet(def.angular_velocity));
    body.setGravity(to_bullet(scene_.gravity * def.gravity_scale));
    if (!scene_.bodies[i].force.isZero(0)) pushed_.push_back(i);
  }

  void add_joints() {
    for (const peer::Ball& ball : peer::balls_of(scene_, solids_, "Bullet")) {
      joints_.push_back(std::make_unique<btPoint2PointConstraint>(*bodies_[ball.first], *bodies_[ball.second],
                                                                  to_bullet(ball.at_first), to_bullet(ball.at_second)));
      world_.addConstraint(joints_.back().get());
    }
  }

  // The pose of a kinematic body after another `dt` seconds.
  atl::Pose moved(std::size_t i, double dt) const {
    const atl::BodyDef& def = scene_.bodies[i].def;
    atl::Pose pose = poses_[i];
    pose.position += dt * def.velocity;
    const atl::Vector3 turn = dt * def.angular_velocity;
    if (turn.isZero(0)) return pose;
    const atl::Quaternion rotation(Eigen::AngleAxisd(turn.norm(), turn.normalized()));
    pose.orientation = (rotation * pose.orientation).normalized();
    return pose;
  }

  const atl::Scene& scene_;
  int substeps_;
  btScalar dt_;
  bool two_frictions_;
  std::vector<std::size_t> pushed_;  // bodies that a force acts on
  std::vector<std::size_t> moving_;  // kinematic bodies
  std::vector<peer::Solid> solids_;
  std::vector<atl::Pose> poses_;  // of what forces don't move

  // Bullet owns none of what it is given, so all of it outlives the world.
  peer::BulletShapes shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  std::vector<std::unique_ptr<btPoint2PointConstraint>> joints_;
  OverlapFilter filter_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btDantzigSolver direct_;
  std::unique_ptr<btConstraintSolver> solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, solver_.get(), &configuration_};
};

}  // namespace

int main(int argc, char** argv) {
  const int version = btGetVersion();
  const peer::Engine engine = {
      .name = "bullet",
      .version = std::to_string(version / 100) + "." + std::to_string(version % 100),
      .precision = sizeof(btScalar) == sizeof(float) ? "single" : "double",
      .iterations = 10,
      .variants = {"default", "split-impulse", "two-frictions", "nncg", "dantzig"},
      .settings =
          {
              {"default", {}, true},
              {"2 substeps", {"--substeps", "2"}, false},
              {"4 substeps", {"--substeps", "4"}, true},
              {"8 substeps", {"--substeps", "8"}, false},
              {"16 substeps", {"--substeps", "16"}, false},
              {"30 iterations", {"--iterations", "30"}, false},
              {"100 iterations", {"--iterations", "100"}, false},
              {"300 iterations", {"--iterations", "300"}, false},
              {"4 substeps, 50 iterations", {"--substeps", "4", "--iterations", "50"}, false},
              {"two friction directions", {"--variant", "two-frictions"}, false},
              {"split impulse", {"--variant", "split-impulse"}, false},
              {"conjugate gradients, 50 iterations", {"--variant", "nncg", "--iterations", "50"}, false},
          },
      .load = [](const atl::Scene& scene,
                 const peer::Setting& setting) { return std::make_unique<BulletSimulation>(scene, setting); },
  };
  return peer::run(engine, argc, argv);
}
