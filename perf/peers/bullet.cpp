/// Bullet (bulletphysics.org) with its own defaults: one thread, sequential impulses, 10 iterations.

#include <btBulletDynamicsCommon.h>

#include <algorithm>
#include <cmath>

#include "peer.h"

namespace {

btVector3 to_bullet(const atl::Vector3& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}

btTransform to_bullet(const atl::Vector3& position, const atl::Quaternion& orientation) {
  const atl::Quaternion q = orientation.normalized();
  const btQuaternion rotation(static_cast<btScalar>(q.x()), static_cast<btScalar>(q.y()), static_cast<btScalar>(q.z()),
                              static_cast<btScalar>(q.w()));
  return btTransform(rotation, to_bullet(position));
}

atl::Vector3 from_bullet(const btVector3& v) { return {v.x(), v.y(), v.z()}; }

std::unique_ptr<btCollisionShape> to_bullet(const atl::Shape& shape) {
  // A Bullet box keeps the size it is given, its collision margin lies inside.
  if (const auto* box = std::get_if<atl::Box>(&shape)) {
    return std::make_unique<btBoxShape>(to_bullet(box->half_extents));
  }
  if (const auto* sphere = std::get_if<atl::Sphere>(&shape)) {
    return std::make_unique<btSphereShape>(static_cast<btScalar>(sphere->radius));
  }
  const auto& half_space = std::get<atl::HalfSpace>(shape);
  const double length = half_space.normal.norm();
  return std::make_unique<btStaticPlaneShape>(to_bullet(half_space.normal / length),
                                              static_cast<btScalar>(half_space.offset));
}

// Bullet multiplies both coefficients unless told otherwise; these are Atoll's rules.
btScalar combined_friction(const btCollisionObject* a, const btCollisionObject* b) {
  return std::sqrt(a->getFriction() * b->getFriction());
}
btScalar combined_restitution(const btCollisionObject* a, const btCollisionObject* b) {
  return std::max(a->getRestitution(), b->getRestitution());
}

// Atoll's v' = -c v as the fraction of speed lost in a second, which Bullet is told.
btScalar to_bullet_damping(double c) { return static_cast<btScalar>(-std::expm1(-c)); }

class BulletSimulation : public peer::Simulation {
 public:
  BulletSimulation(const atl::Scene& scene, std::span<const double> masses) {
    gCalculateCombinedFrictionCallback = combined_friction;
    gCalculateCombinedRestitutionCallback = combined_restitution;
    world_.setGravity(to_bullet(scene.gravity));
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) add_body(scene.bodies[i].def, masses[i], scene.gravity);
  }

  // No substeps: Bullet takes dt as it is.
  void step(double dt) override { world_.stepSimulation(static_cast<btScalar>(dt), 0); }

  std::vector<peer::BodyState> state() const override {
    std::vector<peer::BodyState> state;
    for (const auto& body : bodies_) {
      const btTransform& pose = body->getWorldTransform();
      const btQuaternion q = pose.getRotation();
      state.push_back({.pose = {.position = from_bullet(pose.getOrigin()),
                                .orientation = atl::Quaternion(q.w(), q.x(), q.y(), q.z()).normalized()},
                       .velocity = from_bullet(body->getLinearVelocity()),
                       .angular_velocity = from_bullet(body->getAngularVelocity())});
    }
    return state;
  }

 private:
  void add_body(const atl::BodyDef& def, double kg, const atl::Vector3& gravity) {
    if (def.type == atl::BodyType::Kinematic) throw atl::Error("the Bullet driver has no kinematic bodies");
    const bool dynamic = def.type == atl::BodyType::Dynamic;
    shapes_.push_back(to_bullet(def.shape));
    btCollisionShape* shape = shapes_.back().get();

    const auto mass = static_cast<btScalar>(dynamic ? kg : 0);
    btVector3 inertia(0, 0, 0);
    if (dynamic) shape->calculateLocalInertia(mass, inertia);
    if (dynamic && def.inertia) {
      if (!def.inertia->isDiagonal()) throw atl::Error("the Bullet driver has no inertia off the body's axes");
      inertia = to_bullet(def.inertia->diagonal());
    }

    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shape, inertia);
    info.m_startWorldTransform = to_bullet(def.position, def.orientation);
    info.m_friction = static_cast<btScalar>(def.material.friction);
    info.m_restitution = static_cast<btScalar>(def.material.restitution);
    info.m_linearDamping = to_bullet_damping(def.linear_damping);
    info.m_angularDamping = to_bullet_damping(def.angular_damping);
    bodies_.push_back(std::make_unique<btRigidBody>(info));
    btRigidBody* body = bodies_.back().get();
    world_.addRigidBody(body);
    if (dynamic) {
      body->setLinearVelocity(to_bullet(def.velocity));
      body->setAngularVelocity(to_bullet(def.angular_velocity));
      body->setGravity(to_bullet(gravity * def.gravity_scale));
      body->setActivationState(DISABLE_DEACTIVATION);  // never sleeps
    }
  }

  // Bullet owns none of what it is given, so all of it outlives the world.
  std::vector<std::unique_ptr<btCollisionShape>> shapes_;
  std::vector<std::unique_ptr<btRigidBody>> bodies_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btDbvtBroadphase broadphase_;
  btSequentialImpulseConstraintSolver solver_;
  btDiscreteDynamicsWorld world_{&dispatcher_, &broadphase_, &solver_, &configuration_};
};

}  // namespace

int main(int argc, char** argv) {
  const int version = btGetVersion();
  const peer::Engine engine = {
      .name = "bullet",
      .version = std::to_string(version / 100) + "." + std::to_string(version % 100),
      .setting = sizeof(btScalar) == sizeof(float) ? "defaults, single precision" : "defaults, double precision",
      .load = [](const atl::Scene& scene,
                 std::span<const double> masses) { return std::make_unique<BulletSimulation>(scene, masses); },
  };
  return peer::run(engine, argc, argv);
}
