#include <solver/constraints/row_law.h>
#include <solver/constraints/spring_step.h>
#include <solver/select/joint_selection.h>
#include <solver/tuning.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

namespace atl::solver {
namespace {

// Bodies joined to each body, of a component.
class Neighbours {
 public:
  explicit Neighbours(std::span<const JointLink> links, const BodyTable& bodies) {
    for (const JointLink& link : links) {
      for (const std::uint32_t body : {link.first, link.second}) {
        if (bodies.mobility[body] == Mobility::Dynamic) bodies_.push_back(body);
      }
    }
    std::sort(bodies_.begin(), bodies_.end());
    bodies_.erase(std::unique(bodies_.begin(), bodies_.end()), bodies_.end());
    of_.resize(bodies_.size());
    for (const JointLink& link : links) {
      if (bodies.mobility[link.first] != Mobility::Dynamic || bodies.mobility[link.second] != Mobility::Dynamic)
        continue;
      const std::size_t a = place(link.first), b = place(link.second);
      of_[a].push_back(b);
      of_[b].push_back(a);
    }
  }

  // The body that is farthest from a given one, and by how many joints.
  std::pair<std::size_t, std::size_t> farthest(std::size_t from) const {
    std::vector<std::size_t> distance(of_.size(), ~std::size_t{0});
    std::vector<std::size_t> reached = {from};
    distance[from] = 0;
    for (std::size_t i = 0; i < reached.size(); ++i) {
      for (const std::size_t other : of_[reached[i]]) {
        if (distance[other] != ~std::size_t{0}) continue;
        distance[other] = distance[reached[i]] + 1;
        reached.push_back(other);
      }
    }
    return {reached.back(), distance[reached.back()]};
  }

 private:
  std::size_t place(std::uint32_t body) const {
    return static_cast<std::size_t>(std::lower_bound(bodies_.begin(), bodies_.end(), body) - bodies_.begin());
  }

  std::vector<std::uint32_t> bodies_;
  std::vector<std::vector<std::size_t>> of_;
};

using Rows6 = Eigen::Matrix<double, Eigen::Dynamic, 6, 0, 6, 6>;
using Square = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6>;

// A body and one of its joints: what the joint takes of the body's answer to impulses.
struct Hold {
  std::uint32_t body;
  std::uint32_t other;
  Rows6 share;  // L^-1 J M^-1/2 with L L^T = J M^-1 J^T of both bodies: of norm up to 1, where the body is light

  bool operator<(const Hold& b) const { return body < b.body; }
};

// True if all eigenvalues of a a^T are below a limit.
template <typename Matrix>
bool is_below(double limit, const Matrix& a) {
  const Square rest = limit * Square::Identity(a.rows(), a.rows()) - a * a.transpose();
  return Eigen::LLT<Square>(rest).info() == Eigen::Success;
}

// A joint where its frames coincide, in the first body's axes: what is chosen must not depend on where bodies are when
// that is asked.
struct AssembledJoint {
  Quaternion turn;  // of the second body
  JointFrames frames;

  explicit AssembledJoint(const Joint& joint)
      : turn(joint.axes_first * joint.axes_second.conjugate()),
        frames(joint_frames(joint, Vector3::Zero(), Quaternion::Identity(),
                            joint.anchor_first - turn * joint.anchor_second, turn)) {}
};

// Joints of bodies that are light for them.
class Holds {
 public:
  Holds(std::span<const JointLink> links, std::span<const Joint> joints, const BodyTable& bodies) {
    for (const JointLink& link : links) {
      if (!joints[link.joint].is_tendon()) add(joints[link.joint], bodies);
    }
    std::stable_sort(holds_.begin(), holds_.end());
  }

  // True if two joints pull a light body to and fro between two heavy ones.
  bool slow_each_other() const {
    for (auto a = holds_.begin(); a != holds_.end(); ++a) {
      for (auto b = a + 1; b != holds_.end() && b->body == a->body; ++b) {
        if (a->other != b->other && !is_below(tuning::max_error_left, Square(a->share * b->share.transpose())))
          return true;
      }
    }
    return false;
  }

 private:
  void add(const Joint& joint, const BodyTable& bodies) {
    const auto [turn, frames] = AssembledJoint(joint);
    Rows6 first(joint.row_count(), 6), second(joint.row_count(), 6);
    Eigen::Index count = 0;
    const auto add_row = [&](const JointRow& row) {
      first.row(count) << row.linear.transpose(), row.angular_first.transpose();
      second.row(count) << row.linear.transpose(), row.angular_second.transpose();
      ++count;
    };
    for (int axis = 0; joint.point && axis < 3; ++axis) add_row(offset_along(frames, axis));
    for (std::size_t row = 0; row < joint.rows; ++row) {
      // A distance is left out, since it has no direction while the origins coincide, as they do here.
      if (!joint.law[row].locked() || joint.coordinate[row] == Coordinate::Distance) continue;
      add_row(joint_row(joint, row, frames));
    }
    if (count == 0) return;
    weigh(first, count, bodies, joint.first, Matrix3::Identity());
    weigh(second, count, bodies, joint.second, turn.toRotationMatrix());
    const Eigen::LLT<Square> factor(first * first.transpose() + second * second.transpose());
    if (factor.info() != Eigen::Success) return;
    keep(joint.first, joint.second, factor.matrixL().solve(first));
    keep(joint.second, joint.first, factor.matrixL().solve(second));
  }

  // Scales rows by the root of the inverse mass matrix, in a body's own axes, so that the body's joints can be
  // compared.
  static void weigh(Rows6& rows, Eigen::Index count, const BodyTable& bodies, std::uint32_t body, const Matrix3& axes) {
    rows.conservativeResize(count, 6);
    const Matrix3 root = Eigen::LLT<Matrix3>(bodies.inverse_inertia[body]).matrixL();
    rows.leftCols<3>() *= std::sqrt(bodies.inverse_mass[body]) * axes;
    rows.rightCols<3>() *= axes * root;
  }

  void keep(std::uint32_t body, std::uint32_t other, const Rows6& share) {
    if (!is_below(tuning::max_error_left, share)) holds_.push_back({body, other, share});
  }

  std::vector<Hold> holds_;
};

// True if solving joint by joint is not accurate enough. Bodies that hang on something, or are locked along or about
// axes, swing for long, and machines stand on something or hold their pose by servos; errors add up in both. A tendon's
// impulse has to reach over several joints.
bool asks_for_direct(std::span<const JointLink> links, std::span<const Joint> joints, const BodyTable& bodies) {
  const auto asks = [&](const JointLink& link) {
    const auto holds = [&](std::uint32_t body) { return bodies.inverse_mass[body] == 0 || bodies.locks[body] != 0; };
    return holds(link.first) || holds(link.second) || joints[link.joint].is_actuated() ||
           joints[link.joint].is_tendon();
  };
  if (std::any_of(links.begin(), links.end(), asks) || Holds(links, joints, bodies).slow_each_other()) return true;
  if (links.size() <= tuning::long_chain) return false;
  const Neighbours neighbours(links, bodies);
  return neighbours.farthest(neighbours.farthest(0).first).second > tuning::long_chain;
}

}  // namespace

double longest_substep(std::span<const JointLink> links, std::span<const Joint> joints, const BodyTable& bodies) {
  double fastest = 0;  // 1/s
  for (const JointLink& link : links) {
    const Joint& joint = joints[link.joint];
    if (joint.is_tendon()) continue;
    if (std::none_of(joint.law.begin(), joint.law.begin() + joint.rows, [](const Law& law) { return law.springs(); })) {
      continue;
    }
    const auto [turn, frames] = AssembledJoint(joint);
    const Matrix3 axes = turn.toRotationMatrix();
    for (std::size_t row = 0; row < joint.rows; ++row) {
      if (!joint.law[row].springs()) continue;
      const double response = joint_row(joint, row, frames)
                                  .response(bodies.inverse_mass[joint.first] + bodies.inverse_mass[joint.second],
                                            Matrix3(bodies.inverse_inertia[joint.first]),
                                            axes * bodies.inverse_inertia[joint.second] * axes.transpose());
      fastest = std::max(fastest, LinearForce::of_spring(joint.law[row], 1 / response, 1).fastest());
    }
  }
  return SpringStep::max_phase / fastest;
}

bool joins_directly(std::span<const JointLink> links, std::span<const Joint> joints, const BodyTable& bodies,
                    JointMethod method, bool too_stiff) {
  if (method != JointMethod::Auto) return method == JointMethod::Direct;
  return too_stiff || asks_for_direct(links, joints, bodies);
}

}  // namespace atl::solver
