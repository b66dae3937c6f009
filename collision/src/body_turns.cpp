#include <collision/body_turns.h>

#include <algorithm>

namespace atl::collision {

void BodyTurns::follow(std::size_t body, const PoseView& poses) {
  const double* now = poses.orientations + 4 * body;
  std::array<double, 4>& last = last_[body];
  const Eigen::Map<const Vector3> from(last.data());
  const Eigen::Map<const Vector3> to(now);
  const double sine = (last[3] * to - now[3] * from - from.cross(to)).norm();
  // What isn't finite may have turned by any angle.
  turned_[body] += sine <= 1 ? 2 * sine : 2;
  std::copy_n(now, 4, last.begin());
}

void BodyTurns::follow(std::span<const std::uint32_t> bodies, std::size_t count, const PoseView& poses,
                       jobs::Arena& arena) {
  constexpr std::size_t grain = 1024;
  turned_.resize(count);
  last_.resize(count);
  arena.parallel_for(bodies.size(), grain, [&](std::size_t begin, std::size_t end) {
    for (const std::uint32_t body : bodies.subspan(begin, end - begin)) follow(body, poses);
  });
}

}  // namespace atl::collision
