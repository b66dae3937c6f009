#include <atoll/error.h>
#include <atoll/errors.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <string>

namespace atl {
namespace {

/// Angle of the rotation that takes one orientation to the other, in [0, pi]; their lengths do not matter.
double angle_between(const Quaternion& from, const Quaternion& to) {
  const Quaternion turn = from.conjugate() * to;
  return 2 * std::atan2(turn.vec().norm(), std::abs(turn.w()));
}

}  // namespace

RestReport measure_rest(std::span<const PlacedShape> ideal, std::span<const PlacedShape> actual, const Vector3& up) {
  if (ideal.size() != actual.size()) {
    throw Error("measure_rest: actual has " + std::to_string(actual.size()) + " bodies, expected as many as ideal, " +
                std::to_string(ideal.size()));
  }
  if (!(std::abs(up.norm() - 1) <= 1e-6)) {
    throw Error("measure_rest: up has length " + std::to_string(up.norm()) + ", expected a unit vector");
  }

  RestReport report;
  std::size_t bodies = 0;
  for (std::size_t i = 0; i < ideal.size(); ++i) {
    if (ideal[i].type != BodyType::Dynamic) continue;
    const Vector3 moved = actual[i].pose.position - ideal[i].pose.position;
    const double sink = -moved.dot(up);
    report.sink_max = std::max(report.sink_max, sink);
    report.sink_mean += sink;
    report.drift_max = std::max(report.drift_max, (moved + sink * up).norm());
    report.tilt_max = std::max(report.tilt_max, angle_between(ideal[i].pose.orientation, actual[i].pose.orientation));
    ++bodies;
  }
  if (bodies > 0) report.sink_mean /= static_cast<double>(bodies);
  return report;
}

}  // namespace atl
