// Continuous collision of bodies that joints connect: the assembly stops as one. If one of its fast bodies meets
// something at a part of the step, all are put back to where they were then, so that no joint is torn. Static and
// kinematic bodies connect nothing.

#include <solver/constraints/joint.h>

#include <algorithm>

#include "world_impl.h"

namespace atl {

using collision::Motion;

// By number, what joints connect a body to; alone if none acts on it.
std::uint32_t World::Impl::assembly_of(std::uint32_t body) const {
  return bodies.joined[body] ? assembly_[body] : FastMove::alone;
}

// The bodies that aren't fast of assemblies that stop.
void World::Impl::list_carried() {
  carried_.clear();
  // In order of assemblies.
  const auto stops = [this](std::uint32_t assembly) {
    const auto first_of = [this](std::uint32_t place) { return fast_in_order_[place].assembly; };
    const auto found = std::ranges::lower_bound(together_, assembly, {}, first_of);
    return found != together_.end() && first_of(*found) == assembly && stops_[found - together_.begin()].stops();
  };
  fast_.for_each([&](const solver::MovedBodies& of_worker) {
    for (const solver::MovedBody& joined : of_worker.joined) {
      const std::uint32_t assembly = assembly_of(joined.body);
      if (find_fast(joined.body) || !stops(assembly)) continue;
      carried_.push_back({assembly, joined.body, {joined.start.position, joined.start.orientation}});
    }
  });
  std::sort(carried_.begin(), carried_.end(), [](const Carried& x, const Carried& y) {
    return x.assembly != y.assembly ? x.assembly < y.assembly : x.body < y.body;
  });
}

void World::Impl::list_together() {
  together_.clear();
  std::uint32_t last = FastMove::alone;
  for (std::uint32_t i = 0; i < fast_in_order_.size(); ++i) {
    const std::uint32_t assembly = fast_in_order_[i].assembly;
    if (assembly == FastMove::alone || assembly != last) together_.push_back(i);
    last = assembly;
  }
}

std::span<const FastMove> World::Impl::moves_together(std::size_t number) const {
  const std::size_t begin = together_[number];
  const std::size_t end = number + 1 < together_.size() ? together_[number + 1] : fast_in_order_.size();
  return std::span(fast_in_order_).subspan(begin, end - begin);
}

// Whether a fast body, and what is joined to it, may be put `aside` of where the step took it. An assembly that would
// go far waits where it started until its contacts have slowed it: it may hang on the world, and those of its bodies
// that aren't fast look for nothing in their way.
bool World::Impl::may_shift(const FastMove& fast, const Vector3& aside) const {
  if (fast.assembly == FastMove::alone) return bodies.locks[fast.body] == 0;
  return aside.norm() <= bodies.reach_limit[fast.body];
}

// Ends the step of a fast body, or of an assembly, where it met something. Each body is put on the straight way of its
// centre, turned evenly about it. Where bodies turned by an angle a in the step, joints open by that by up to a^2 / 8
// of how far they are from these centres, until the next step closes them.
void World::Impl::stop(std::size_t number, const FastStop& stop) {
  const auto put_back = [&](std::uint32_t body, const collision::Pose& start) {
    const collision::Pose end{bodies.position(body) + stop.aside, bodies.orientation(body)};
    const collision::Pose pose = stop.t >= 1 ? end : Motion::between(start, end, Vector3::Zero()).at(stop.t);
    bodies.position(body) = pose.position;
    bodies.set_orientation(body, pose.orientation);
    look_again(body);
    ++report_.counts.stopped;
  };
  const std::span<const FastMove> moves = moves_together(number);
  for (const FastMove& fast : moves) put_back(fast.body, fast.start_pose());
  const std::uint32_t assembly = moves.front().assembly;
  if (assembly == FastMove::alone) return;
  for (const Carried& carried : std::ranges::equal_range(carried_, assembly, {}, &Carried::assembly)) {
    put_back(carried.body, carried.start);
  }
  for (const solver::JointLink& link : joint_graph_.links_of(assembly)) follow_position(joints.joints[link.joint]);
}

// Of a joint whose bodies were put elsewhere, by less than half a turn.
void World::Impl::follow_position(solver::Joint& joint) const {
  const solver::JointFrames frames = frames_of(joint);
  for (std::size_t row = 0; row < joint.rows; ++row) {
    const double value = joint_row(joint, row, frames).value;
    joint.position[row] = solver::continued(joint.coordinate[row], value, joint.position[row]);
  }
}

}  // namespace atl
