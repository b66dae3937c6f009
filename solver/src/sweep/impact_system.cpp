#include <jobs/assert.h>
#include <solver/direct/direct_joints.h>
#include <solver/sweep/impact_system.h>
#include <solver/tuning.h>

#include <algorithm>
#include <cmath>

namespace atl::solver {
namespace {

// How a body has moved since the substep began.
BodyPose motion_of(const ImpactBody& body, double time) { return {body.shift + time * body.velocity, body.turned}; }

double rate_of(const ImpactEnd& end, const IslandProblem& problem, const std::vector<double>& velocities, bool given) {
  const DirectJoint& joint = problem.joints[end.joint];
  return end.side * joint.rate_by(velocities, end.row, given ? joint.given[end.row] : 0);
}

std::array<double, 6> numbers_of(const ImpactMomentum& momentum) {
  const auto& [linear, angular] = momentum;
  return {linear[0], linear[1], linear[2], angular[0], angular[1], angular[2]};
}

}  // namespace

bool ImpactSystem::begin(const SolveInput& input, DirectJoints& joints, double start, double time,
                         std::span<ImpactBody> bodies) {
  joints_ = &joints;
  start_ = start;
  time_ = time;
  hit_.clear();
  motions_.clear();
  answer_.resize(6 * places_.size());
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const ImpactBody& body = bodies[places_[i]];
    motions_.push_back(motion_of(body, time));
    linear_part(answer_, i) = body.velocity;
    angular_part(answer_, i) = body.spin;
  }
  if (!joints.begin_impacts(input, start + time, motions_, answer_)) {
    std::fill(motions_.begin(), motions_.end(), BodyPose{Vector3::Zero(), Quaternion::Identity()});
    joints.end_impacts(input, start, motions_, answer_);
    return false;
  }
  for (std::size_t i = 0; i < places_.size(); ++i) {
    ImpactBody& body = bodies[places_[i]];
    body.shift -= time * (linear_part(answer_, i) - body.velocity);
    body.turn -= time * (angular_part(answer_, i) - body.spin);
    body.velocity = linear_part(answer_, i);
    body.spin = angular_part(answer_, i);
  }
  find_ends(input);
  return true;
}

void ImpactSystem::find_ends(const SolveInput& input) {
  ends_.clear();
  const std::vector<DirectJoint>& joints = joints_->problem().joints;
  for (std::size_t j = 0; j < joints.size(); ++j) {
    for (std::size_t r = joints[j].point_rows(); r < joints[j].rows; ++r) {
      if (const int end = joints_->end_at(input, j, r); end != 0) ends_.push_back({j, r, end < 0 ? 1.0 : -1.0});
    }
  }
}

void ImpactSystem::begin_round(std::vector<std::uint32_t>& hit, std::span<ImpactBody> bodies) {
  if (!std::includes(hit_.begin(), hit_.end(), hit.begin(), hit.end())) {
    if (hit.size() + hit_.size() <= tuning::max_hit) hit.insert(hit.end(), hit_.begin(), hit_.end());
    std::sort(hit.begin(), hit.end());
    hit.erase(std::unique(hit.begin(), hit.end()), hit.end());
    hit_.assign(hit.begin(), hit.end());
    find_response();
  }
  impulses_.assign(size(), 0.0);
  put_back_.assign(size(), 0.0);
  for (std::size_t i = 0; i < places_.size(); ++i) {
    linear_part(answer_, i) = bodies[places_[i]].velocity;
    angular_part(answer_, i) = bodies[places_[i]].spin;
  }
  for (ImpactEnd& end : ends_) {
    end.before = end.rate = rate_of(end, joints_->problem(), answer_, true);
    end.impulse = 0;
  }
  for (std::uint32_t i = 0; i < hit_.size(); ++i) bodies[places_[hit_[i]]].place = i;
}

void ImpactSystem::find_response() {
  const std::size_t count = size();
  const IslandProblem& problem = joints_->problem();
  response_.resize(count * count);
  impulses_.assign(count, 0.0);
  double* column = response_.data();
  for (std::size_t c = 0; c < count; ++c) {
    impulses_[c] = 1;
    momenta_of(impulses_);
    impulses_[c] = 0;
    joints_->respond(answer_);
    for (const std::uint32_t body : hit_) column = std::copy_n(&answer_[6 * body], 6, column);
    for (const ImpactEnd& end : ends_) *column++ = rate_of(end, problem, answer_, false);
  }
}

// Makes `answer_` the momenta of all bodies by these.
void ImpactSystem::momenta_of(const std::vector<double>& impulses) {
  std::fill(answer_.begin(), answer_.end(), 0.0);
  for (std::size_t i = 0; i < hit_.size(); ++i) std::copy_n(&impulses[6 * i], 6, &answer_[6 * hit_[i]]);
  const double* along = &impulses[6 * hit_.size()];
  for (const ImpactEnd& end : ends_) {
    DirectJoint::Rows<double> rows = {};
    rows[end.row] = end.side * *along++;
    joints_->problem().joints[end.joint].add_impulses(rows.data(), answer_.data());
  }
}

void ImpactSystem::end_round(std::span<ImpactBody> bodies) {
  if (std::all_of(impulses_.begin(), impulses_.end(), [](double impulse) { return impulse == 0; })) return;
  momenta_of(impulses_);
  joints_->respond(answer_);
  auto next_hit = hit_.begin();
  for (std::uint32_t i = 0; i < places_.size(); ++i) {
    ImpactBody& body = bodies[places_[i]];
    body.changed = true;
    if (next_hit != hit_.end() && *next_hit == i) {
      ++next_hit;
      continue;
    }
    body.velocity += linear_part(answer_, i);
    body.spin += angular_part(answer_, i);
  }
  for (std::size_t i = 6 * hit_.size(); i < size(); ++i) put_back_[i] = -time_ * impulses_[i];
  momenta_of(put_back_);
  joints_->respond(answer_);
  for (std::size_t i = 0; i < places_.size(); ++i) {
    bodies[places_[i]].shift += linear_part(answer_, i);
    bodies[places_[i]].turn += angular_part(answer_, i);
  }
  std::fill(impulses_.begin(), impulses_.end(), 0.0);
  std::fill(put_back_.begin(), put_back_.end(), 0.0);
}

void ImpactSystem::end(const SolveInput& input, std::span<const ImpactBody> bodies) {
  motions_.clear();
  for (std::size_t i = 0; i < places_.size(); ++i) {
    const ImpactBody& body = bodies[places_[i]];
    motions_.push_back(motion_of(body, 0));
    linear_part(answer_, i) = body.velocity;
    angular_part(answer_, i) = body.spin;
  }
  joints_->end_impacts(input, start_, motions_, answer_);
}

void ImpactSystem::add(std::size_t first, std::span<const double> impulse, std::span<ImpactBody> bodies) {
  const double* column = &response_[size() * first];
  for (std::size_t c = 0; c < impulse.size(); ++c) {
    const double by = impulse[c];
    impulses_[first + c] += by;
    if (by == 0) {
      column += size();
      continue;
    }
    for (const std::uint32_t body : hit_) {
      bodies[places_[body]].velocity += by * Eigen::Map<const Vector3>(column);
      bodies[places_[body]].spin += by * Eigen::Map<const Vector3>(column + 3);
      column += 6;
    }
    for (ImpactEnd& end : ends_) end.rate += by * *column++;
  }
}

void ImpactSystem::push(std::uint32_t place, const ImpactMomentum& impulse, std::span<ImpactBody> bodies) {
  add(6 * place, numbers_of(impulse), bodies);
}

double ImpactSystem::push(ImpactEnd& end, std::span<ImpactBody> bodies) {
  const auto number = 6 * hit_.size() + static_cast<std::size_t>(&end - ends_.data());
  const double response = response_[(size() + 1) * number];
  if (!(response > 0)) return 0;
  const double impulse = std::max(-end.rate / response, -end.impulse);
  add_impulse(end, impulse, bodies);
  return std::abs(impulse) * response;
}

void ImpactSystem::add_impulse(ImpactEnd& end, double impulse, std::span<ImpactBody> bodies) {
  end.impulse += impulse;
  add(6 * hit_.size() + static_cast<std::size_t>(&end - ends_.data()), std::span(&impulse, 1), bodies);
}

void ImpactSystem::put_back(std::uint32_t place, double back, const ImpactMomentum& impulse) {
  const std::array<double, 6> numbers = numbers_of(impulse);
  for (std::size_t i = 0; i < 6; ++i) put_back_[6 * place + i] += back * numbers[i];
}

double ImpactSystem::response(std::uint32_t of, const ImpactMomentum& along, std::uint32_t by,
                              const ImpactMomentum& impulse) const {
  const std::array<double, 6> rows = numbers_of(along), columns = numbers_of(impulse);
  double sum = 0;
  for (std::size_t c = 0; c < 6; ++c) {
    const double* column = &response_[size() * (6 * by + c) + 6 * of];
    for (std::size_t r = 0; r < 6; ++r) sum += rows[r] * column[r] * columns[c];
  }
  return sum;
}

}  // namespace atl::solver
