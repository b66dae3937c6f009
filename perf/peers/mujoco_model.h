#pragma once
/// A scene as a MuJoCo model, by way of the XML (MJCF) that MuJoCo reads.

#include <atoll/scene.h>
#include <mujoco/mujoco.h>

#include <string>
#include <vector>

#include "ball.h"
#include "peer.h"
#include "solid.h"

namespace peer {

/// The MuJoCo options that a setting's variant selects.
struct MujocoOptions {
  std::string name;
  std::string cone = "pyramidal";
  std::string solver = "Newton";
  std::string integrator = "Euler";
  /// Contacts as stiff as the step allows: a time constant of two steps, and a hundredth to a thousandth of the force
  /// for the regularisation, instead of 20 ms and a tenth to a twentieth. Joints alike, with the least regularisation
  /// that there is, a ten-thousandth.
  bool stiff = false;
  double impratio = 1;    ///< how much harder friction is than the normal direction
  bool multiccd = false;  ///< more than one point where a hull, or a cylinder not on a plane, touches
};
const std::vector<MujocoOptions>& mujoco_variants();

/// Built once, compiled again with more room where a scene turns out to have more contacts.
class MujocoScene {
 public:
  /// Throws atl::Error on what MuJoCo or this driver has no equal for.
  MujocoScene(const atl::Scene& scene, const Setting& setting);

  /// A new model with room for that many contacts; the caller deletes it. Throws atl::Error, with MuJoCo's own words.
  mjModel* compile(int contacts) const;

  /// The most contacts there can be room for: MuJoCo stores dense matrices of all constraint rows by all degrees of
  /// freedom and by all rows, sparse or not, in one buffer of less than 2 GiB.
  int max_contacts() const;

  const std::vector<Solid>& solids() const { return solids_; }
  /// Scene bodies that move, in the order of the model's bodies 1, 2, ...
  const std::vector<std::size_t>& moving() const { return moving_; }
  /// Scene body of each of the model's geoms.
  const std::vector<std::size_t>& owners() const { return owners_; }

 private:
  bool moves(std::size_t body) const;
  void find_pairs_apart();
  void add_geoms(std::size_t body, std::string& xml);
  void add_joints();
  double constraint_rows(int contacts) const;
  /// Doubles for the solvers' factors and products; MuJoCo's own guess is five times the square of rows and freedoms.
  /// Throws atl::Error if that is too many.
  double stack_size(int contacts) const;
  /// Converts a point of a solid to the frame of its body in the model.
  atl::Vector3 in_model(std::size_t body, const atl::Vector3& point) const;
  void set_dynamics(mjModel& model) const;

  const atl::Scene& scene_;
  std::string options_;
  std::string assets_;
  std::string world_;
  std::string joints_;
  std::vector<Solid> solids_;
  std::vector<Ball> balls_;
  std::vector<std::size_t> moving_;
  std::vector<std::size_t> owners_;
  std::vector<bool> touches_;                               // by body: whether it may touch any other
  std::vector<std::pair<std::size_t, std::size_t>> apart_;  // pairs of those that may that don't
  std::vector<std::vector<float>> heights_;                 // of the model's height fields, in [0, 1]
};

}  // namespace peer
