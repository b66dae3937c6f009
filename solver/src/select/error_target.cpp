#include <jobs/assert.h>
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

int rung_at(std::size_t place) { return place < substep_rungs.size() ? substep_rungs[place] : max_needed_substeps; }

// Place of the lowest rung that no more than `beyond` lie above.
template <typename ByRung>
std::size_t place_exceeded_by(std::uint32_t beyond, const ByRung& by_rung, std::size_t highest) {
  std::size_t place = highest;
  for (std::uint32_t above = by_rung[place]; place > 0 && above <= beyond; above += by_rung[place]) --place;
  return place;
}

}  // namespace

int rung_of(double square) { return rung_at(place_of_rung(square)); }

void ErrorCounts::add(double error, double substeps, double target) {
  ATL_ASSERT(substeps >= 1 && target > 0 && !(error < 0), error, substeps, target);
  ++counted_;
  const std::size_t place = place_of_rung(error * substeps * substeps / (tuning::target_margin * target));
  ++by_rung_[place];
  highest_ = std::max(highest_, place);
}

void ErrorCounts::add_missed(double error, double following, double substeps, double target) {
  add(following, substeps, target);
  ++left_[place_of_rung((error - following) / target)];
  ++missed_;
  follow_ += following > target;
}

void ErrorCounts::operator+=(const ErrorCounts& other) {
  for (std::size_t i = 0; i < by_rung_.size(); ++i) {
    by_rung_[i] += other.by_rung_[i];
    left_[i] += other.left_[i];
  }
  highest_ = std::max(highest_, other.highest_);
  small_ = std::max(small_, other.small_);
  counted_ += other.counted_;
  missed_ += other.missed_;
  follow_ += other.follow_;
}

ErrorNeed ErrorCounts::need(double target) const {
  ATL_ASSERT(missed_ <= counted_ && follow_ <= missed_, counted_, missed_, follow_);
  constexpr std::uint32_t one_in = 100;
  const std::uint32_t beyond = counted_ / one_in;
  int substeps = rung_at(place_exceeded_by(beyond, by_rung_, highest_));
  const std::size_t left = missed_ > beyond ? place_exceeded_by(beyond, left_, left_.size() - 1) : 0;
  if (left > 1) {
    const double share = static_cast<double>(substeps) / rung_at(left - 1);
    substeps = rung_of(share * share);
  }
  substeps = std::max(substeps, rung_of(small_ / (tuning::target_margin * target)));
  return {substeps, missed_ > beyond, follow_ > beyond};
}

}  // namespace atl::solver
