/// MuJoCo (mujoco.org), one thread, with its own defaults: contacts with a time constant of 20 ms, pyramidal friction
/// cones, Newton's method with up to 100 iterations, semi-implicit Euler. Friction of a pair combines by Atoll's rule,
/// where MuJoCo would take the larger: each step is made of MuJoCo's own public stages, and each contact's coefficients
/// are set between collision and constraints. MuJoCo has no restitution. A ball joint is an equality constraint between
/// two free bodies.

#include <mujoco/mujoco.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "mujoco_model.h"
#include "peer.h"

namespace {

// MuJoCo's handler must not return. What it is told of is a lack of memory.
void give_up(const char* message) {
  std::fprintf(stderr, "mujoco: %s\n", message);
  std::_Exit(3);
}

struct Deleter {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
  void operator()(mjData* data) const { mj_deleteData(data); }
};

class MujocoSimulation : public peer::Simulation {
 public:
  /// `room`: for how many contacts an earlier simulation of the scene needed room, if there was one.
  MujocoSimulation(const atl::Scene& scene, const peer::Setting& setting, int& room)
      : scene_(scene),
        substeps_(setting.substeps),
        whole_(setting.variant == "rk4"),
        source_(scene, setting),
        room_(room) {
    if (whole_) check_uniform_friction();
    const int contacts = std::max(room_, 16 + 4 * static_cast<int>(source_.moving().size()));
    load(std::min(contacts, source_.max_contacts()));
    for (std::size_t k = 0; k < source_.moving().size(); ++k) set_velocity(k);
  }

  void step() override {
    for (int substep = 0; substep < substeps_; ++substep) {
      for (const std::size_t k : driven_) set_velocity(k);
      const std::vector<mjtNum> before = state();
      while (!(whole_ ? step_whole() : step_by_stages())) {
        grow();
        restore(before);
      }
      check_finite();
    }
  }

  bool started_over() const override { return started_over_; }

  std::vector<atl::BodyState> states() const override {
    std::vector<atl::BodyState> states;
    for (const peer::Solid& solid : source_.solids()) states.push_back({peer::body_pose(solid, solid.pose)});
    for (std::size_t k = 0; k < source_.moving().size(); ++k) {
      const std::size_t i = source_.moving()[k];
      const mjtNum *q = data_->qpos + 7 * k, *v = data_->qvel + 6 * k;
      const atl::Quaternion turn = atl::Quaternion(q[3], q[4], q[5], q[6]).normalized();
      states[i] = {.pose = peer::body_pose(source_.solids()[i], {{q[0], q[1], q[2]}, turn}),
                   .velocity = {v[0], v[1], v[2]},
                   .angular_velocity = turn * atl::Vector3(v[3], v[4], v[5])};
    }
    return states;
  }

  // A contact's first axis points from its first geom to its second, which is pushed that way.
  std::vector<atl::ContactLoad> loads() const override {
    peer::LoadSum sum;
    for (int c = 0; c < data_->ncon; ++c) {
      const mjContact& contact = data_->contact[c];
      mjtNum local[6];
      mj_contactForce(model_.get(), data_.get(), c, local);
      const mjtNum* axes = contact.frame;
      atl::Vector3 force = atl::Vector3::Zero();
      for (int axis = 0; axis < 3; ++axis) {
        force += local[axis] * atl::Vector3(axes[3 * axis], axes[3 * axis + 1], axes[3 * axis + 2]);
      }
      if (!force.isZero(0)) sum.add(owner(contact.geom1), owner(contact.geom2), force);
    }
    return sum.loads();
  }

 private:
  std::size_t owner(int geom) const { return source_.owners()[static_cast<std::size_t>(geom)]; }
  const atl::BodyDef& def(int geom) const { return scene_.bodies[owner(geom)].def; }

  void check_uniform_friction() const {
    const double first = scene_.bodies.front().def.material.friction;
    for (const atl::SceneBody& body : scene_.bodies) {
      if (body.def.material.friction == first) continue;
      throw atl::Error("MuJoCo's Runge-Kutta step combines friction by its own rule: found coefficients " +
                       std::to_string(first) + " and " + std::to_string(body.def.material.friction) +
                       ", expected the same on all bodies");
    }
  }

  void load(int contacts) {
    data_.reset();
    model_.reset(source_.compile(contacts));
    data_.reset(mj_makeData(model_.get()));
    if (data_ == nullptr) throw atl::Error("MuJoCo found no memory for " + std::to_string(contacts) + " contacts");
    driven_.clear();
    for (std::size_t k = 0; k < source_.moving().size(); ++k) {
      const atl::SceneBody& body = scene_.bodies[source_.moving()[k]];
      const double mass = source_.solids()[source_.moving()[k]].mass;
      if (body.def.type != atl::BodyType::Dynamic) driven_.push_back(k);
      const atl::Vector3 force = body.force + mass * (body.def.gravity_scale - 1) * scene_.gravity;
      std::copy(force.begin(), force.end(), data_->xfrc_applied + 6 * (k + 1));  // body 0 is the world
    }
  }

  // More room for contacts.
  void grow() {
    const int now = model_->nconmax, max = source_.max_contacts();
    if (now >= max) {
      throw atl::Error("MuJoCo has room for at most " + std::to_string(max) + " contacts among " +
                       std::to_string(source_.moving().size()) + " bodies; the scene has more");
    }
    room_ = std::min(now + now / 2, max);
    started_over_ = true;
    load(room_);
  }

  void set_velocity(std::size_t k) {
    const atl::BodyDef& body = scene_.bodies[source_.moving()[k]].def;
    const mjtNum* q = data_->qpos + 7 * k;
    const atl::Vector3 spin = atl::Quaternion(q[3], q[4], q[5], q[6]).conjugate() * body.angular_velocity;
    std::copy(body.velocity.begin(), body.velocity.end(), data_->qvel + 6 * k);
    std::copy(spin.begin(), spin.end(), data_->qvel + 6 * k + 3);
  }

  std::vector<mjtNum> state() const {
    std::vector<mjtNum> all(data_->qpos, data_->qpos + model_->nq);
    all.insert(all.end(), data_->qvel, data_->qvel + model_->nv);
    all.insert(all.end(), data_->qacc_warmstart, data_->qacc_warmstart + model_->nv);
    return all;
  }
  void restore(const std::vector<mjtNum>& all) {
    std::copy_n(all.data(), model_->nq, data_->qpos);
    std::copy_n(all.data() + model_->nq, model_->nv, data_->qvel);
    std::copy_n(all.data() + model_->nq + model_->nv, model_->nv, data_->qacc_warmstart);
  }

  bool is_full() const { return data_->warning[mjWARN_CONTACTFULL].number > 0; }

  // Each of these returns false where there was no room for all contacts.
  bool step_whole() {
    mj_step(model_.get(), data_.get());
    return !is_full();
  }

  // mj_step, with the contacts' friction set on the way.
  bool step_by_stages() {
    const mjModel* m = model_.get();
    mjData* d = data_.get();
    mj_checkPos(m, d);
    mj_checkVel(m, d);
    mj_kinematics(m, d);
    mj_comPos(m, d);
    mj_camlight(m, d);
    mj_tendon(m, d);
    mj_crb(m, d);
    mj_factorM(m, d);
    mj_collision(m, d);
    if (is_full()) return false;
    combine_friction();
    mj_makeConstraint(m, d);
    mj_transmission(m, d);
    mj_projectConstraint(m, d);
    mj_fwdVelocity(m, d);
    mj_step2(m, d);
    return true;
  }

  void combine_friction() {
    for (int c = 0; c < data_->ncon; ++c) {
      mjContact& contact = data_->contact[c];
      const double mu =
          peer::combined_friction(def(contact.geom1).material.friction, def(contact.geom2).material.friction);
      contact.friction[0] = contact.friction[1] = std::max(mu, mjMINMU);
      if (mu == 0) contact.dim = 1;
    }
  }

  // MuJoCo starts over from the initial state where it finds bad numbers.
  void check_finite() const {
    for (const int warning : {mjWARN_BADQPOS, mjWARN_BADQVEL, mjWARN_BADQACC}) {
      if (data_->warning[warning].number == 0) continue;
      throw peer::NonFinite("the simulation broke down: MuJoCo found bad numbers and reset it");
    }
  }

  const atl::Scene& scene_;
  int substeps_;
  bool whole_;
  peer::MujocoScene source_;
  int& room_;
  bool started_over_ = false;
  std::unique_ptr<mjModel, Deleter> model_;
  std::unique_ptr<mjData, Deleter> data_;
  std::vector<std::size_t> driven_;  // kinematic bodies, by place among those that move
};

}  // namespace

int main(int argc, char** argv) {
  mju_user_error = give_up;
  mju_user_warning = [](const char*) {};  // by default a file in the working directory
  int room = 0;                           // a driver simulates one scene
  std::vector<std::string> variants;
  for (const peer::MujocoOptions& variant : peer::mujoco_variants()) variants.push_back(variant.name);
  const peer::Engine engine = {
      .name = "mujoco",
      .version = mj_versionString(),
      .precision = sizeof(mjtNum) == sizeof(float) ? "single" : "double",
      .iterations = 100,
      .variants = variants,
      .settings =
          {
              {"default", {}, true},
              {"4 substeps", {"--substeps", "4"}, true},
              {"8 substeps", {"--substeps", "8"}, false},
              {"16 substeps", {"--substeps", "16"}, false},
              {"elliptic", {"--variant", "elliptic"}, false},
              {"elliptic, 8 substeps", {"--variant", "elliptic", "--substeps", "8"}, false},
              {"implicit", {"--variant", "implicit"}, false},
              {"Runge-Kutta", {"--variant", "rk4"}, false},
              {"multiccd", {"--variant", "multiccd"}, false},
              {"stiff", {"--variant", "stiff"}, false},
              {"stiff, 4 substeps", {"--variant", "stiff", "--substeps", "4"}, false},
              {"stiff, 16 substeps", {"--variant", "stiff", "--substeps", "16"}, false},
              {"elliptic, stiff, 4 substeps", {"--variant", "elliptic-stiff", "--substeps", "4"}, false},
              {"elliptic, stiff, 16 substeps", {"--variant", "elliptic-stiff", "--substeps", "16"}, false},
              {"conjugate gradients", {"--variant", "cg"}, true},
          },
      .load = [&room](
                  const atl::Scene& scene,
                  const peer::Setting& setting) { return std::make_unique<MujocoSimulation>(scene, setting, room); },
  };
  return peer::run(engine, argc, argv);
}
