// A tower of boxes at rest: each carries the weight of those above it.

#include "../analytic.h"
#include "largest_errors.h"
#include "setting.h"

namespace atl::scene {
namespace stack_forces {

constexpr double duration = 5;   // s
constexpr double settled = 2.5;  // s, from when on forces count

class StackForces : public ClosedFormMeasure {
 public:
  /// weights[i], N: what body i, the ground first, has to carry.
  explicit StackForces(std::vector<double> weights)
      : weights_(std::move(weights)), sums_(weights_.size(), Vector3::Zero()), swing_(weights_.size(), 0.0) {}

  void observe(double time, std::span<const BodyState>, std::span<const ContactLoad> loads) override {
    if (time < settled) return;
    std::vector<Vector3> carried(weights_.size(), Vector3::Zero());
    for (const ContactLoad& load : loads) {
      const std::size_t lower = std::min(load.a, load.b), upper = std::max(load.a, load.b);
      if (upper == lower + 1) carried[lower] += load.a == lower ? load.force : Vector3(-load.force);
    }
    for (std::size_t i = 0; i < weights_.size(); ++i) {
      sums_[i] += carried[i];
      swing_[i] = std::max(swing_[i], error(carried[i], i));
    }
    ++count_;
  }

  std::vector<ErrorMeasure> errors() const override {
    LargestErrors errors({{"swing"}});
    for (std::size_t i = 0; i < weights_.size(); ++i) {
      errors.raise("analytic_error", error(count_ > 0 ? Vector3(sums_[i] / count_) : Vector3::Zero(), i));
      errors.raise("swing", swing_[i]);
    }
    return errors.all();
  }

 private:
  double error(const Vector3& force, std::size_t place) const {
    return (force - Vector3(0, 0, weights_[place])).norm() / weights_[place];
  }

  std::vector<double> weights_;
  std::vector<Vector3> sums_;
  std::vector<double> swing_;
  int count_ = 0;
};

}  // namespace stack_forces

Scene build_stack_forces(const ParameterValues& values, std::uint64_t) {
  using namespace stack_forces;
  Scene scene = scene_on_ground(steps_for(duration), true);
  const int height = values.integer("height");
  add_unit_boxes(scene, {.count = {1, 1, height}});
  scene.bodies.back().def.density *= values["ratio"];

  std::vector<double> weights(scene.bodies.size() - 1);
  double above = 0;
  for (std::size_t i = weights.size(); i-- > 0;) {
    above += body_mass(scene.bodies[i + 1].def).mass * standard_gravity;
    weights[i] = above;
  }
  ClosedForm form;
  form.metric =
      "over the contacts of the tower: largest difference of the force, averaged from 2.5 s on, from the weight "
      "above, relative to that weight; swing is that of a single step";
  form.source = "balance of forces";
  form.needs_loads = true;
  form.measure = [weights] { return std::make_unique<StackForces>(weights); };
  scene.closed_form = form;
  return scene;
}

}  // namespace atl::scene
