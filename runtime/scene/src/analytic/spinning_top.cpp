// Three boxes in free rotation, each near one of its principal axes.

#include "../analytic.h"
#include "free_top.h"
#include "largest_errors.h"
#include "setting.h"

namespace atl::scene {
namespace spinning_top {

constexpr double duration = 10;             // s
const Vector3 half_extents(0.5, 0.3, 0.2);  // m

struct Start {
  Vector3 moments;
  Vector3 spin;  // the body's axes are those of the world
};

class SpinningTops : public ClosedFormMeasure {
 public:
  explicit SpinningTops(const std::vector<Start>& starts)
      : starts_(starts), errors_({{"momentum_error"}, {"energy_error"}}) {
    for (const Start& start : starts) tops_.emplace_back(start.moments, start.spin, Quaternion::Identity());
  }

  void observe(double time, std::span<const BodyState> states, std::span<const ContactLoad>) override {
    for (std::size_t i = 0; i < tops_.size(); ++i) {
      const Quaternion& orientation = states[i].pose.orientation;
      errors_.raise("analytic_error", orientation.angularDistance(tops_[i].orientation(time)));

      const Vector3 start = starts_[i].moments.cwiseProduct(starts_[i].spin);
      const Vector3& spin = states[i].angular_velocity;
      const Vector3 momentum = orientation * starts_[i].moments.cwiseProduct(orientation.conjugate() * spin);
      errors_.raise("momentum_error", (momentum - start).norm() / start.norm());
      errors_.raise("energy_error", std::abs(momentum.dot(spin) / start.dot(starts_[i].spin) - 1));
    }
  }
  std::vector<ErrorMeasure> errors() const override { return errors_.all(); }

 private:
  std::vector<Start> starts_;
  std::vector<FreeTop> tops_;
  LargestErrors errors_;
};

}  // namespace spinning_top

Scene build_spinning_top(const ParameterValues& values, std::uint64_t) {
  using namespace spinning_top;
  Scene scene;
  scene.gravity = Vector3::Zero();
  scene.steps = steps_for(duration);
  std::vector<Start> starts;
  for (int axis = 0; axis < 3; ++axis) {
    const auto [sine, cosine] = sine_cosine(values["tilt"]);
    Vector3 spin = Vector3::Constant(sine / std::sqrt(2.0));
    spin[axis] = cosine;
    spin *= values["spin"];
    SceneBody top = solid(numbered("top", axis), Box{half_extents}, {2.0 * axis, 0, 0}, {});
    top.def.angular_velocity = spin;
    starts.push_back({body_mass(top.def).inertia.diagonal(), spin});
    scene.bodies.push_back(top);
  }
  ClosedForm form;
  form.metric = "largest angle in rad between a top's orientation and the closed form's";
  form.source = "Landau and Lifshitz, Mechanics, section 37";
  form.measure = [starts] { return std::make_unique<SpinningTops>(starts); };
  scene.closed_form = form;
  return scene;
}

}  // namespace atl::scene
