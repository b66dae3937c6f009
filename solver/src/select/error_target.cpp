#include <solver/select/error_target.h>
#include <solver/tuning.h>

#include <algorithm>

namespace atl::solver {

namespace {

std::size_t place_of_rung(double square) {
  const auto holds = [square](double rung) {
    return square <= (rung == 1 ? tuning::one_substep_share : 1) * rung * rung;
  };
  return static_cast<std::size_t>(std::find_if(substep_rungs.begin(), substep_rungs.end(), holds) -
                                  substep_rungs.begin());
}

int rung_at(std::size_t place) { return place < substep_rungs.size() ? substep_rungs[place] : most_needed; }

}  // namespace

int rung_of(double square) { return rung_at(place_of_rung(square)); }

void ErrorCounts::add(double error, double substeps, double target) {
  ++counted_;
  const std::size_t place = place_of_rung(error * substeps * substeps / (tuning::target_margin * target));
  ++by_rung_[place];
  highest_ = std::max(highest_, place);
}

void ErrorCounts::add_missed(const Missed& missed, double substeps, double target) {
  add(missed.following, substeps, target);
  ++missed_;
  follow_ += missed.following > target;
  rest_ += missed.rests;
}

void ErrorCounts::operator+=(const ErrorCounts& other) {
  for (std::size_t i = 0; i < by_rung_.size(); ++i) by_rung_[i] += other.by_rung_[i];
  highest_ = std::max(highest_, other.highest_);
  counted_ += other.counted_;
  missed_ += other.missed_;
  follow_ += other.follow_;
  rest_ += other.rest_;
}

ErrorNeed ErrorCounts::need() const {
  constexpr std::uint32_t one_in = 100;
  const std::uint32_t beyond = counted_ / one_in;
  std::size_t rung = highest_;
  for (std::uint32_t above = by_rung_[rung]; rung > 0 && above <= beyond; above += by_rung_[rung]) --rung;
  return {rung_at(rung), missed_ > beyond, follow_ > beyond, rest_ > beyond};
}

}  // namespace atl::solver
