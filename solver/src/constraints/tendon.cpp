#include <jobs/assert.h>
#include <solver/constraints/tendon.h>

namespace atl::solver {

TermRow term_row(const TendonTerm& term, const Joint& joint, const BodyPose& first, const BodyPose& second,
                 double before) {
  JointFrames frames = joint_frames(joint, first.position, first.orientation, second.position, second.orientation);
  // The joint's own rows may not be along the coordinate.
  if (asks_for_turn(term.coordinate)) {
    frames.set_turn(Eigen::Quaterniond(first.orientation * joint.axes_first),
                    Eigen::Quaterniond(second.orientation * joint.axes_second));
  }
  TermRow row;
  row.at = coordinate_row(term.coordinate, frames);
  row.at.value = row.position = continued(term.coordinate, row.at.value, before);
  fade(term.coordinate, frames, true, row.at);
  row.value = term.value_at(row.at.value);
  row.slope = term.slope_at(row.at.value);
  return row;
}

TendonNow tendon_now(const Joint& tendon, const Joint* joints, const BodyTable& bodies) {
  const auto pose_of = [&](std::uint32_t body) { return BodyPose{bodies.position(body), bodies.orientation(body)}; };
  TendonNow now;
  ATL_ASSERT(tendon.is_tendon() && tendon.terms <= tendon.term.size(), tendon.terms, tendon.term.size());
  for (std::size_t i = 0; i < tendon.terms; ++i) {
    const TendonTerm& term = tendon.term[i];
    const Joint& of = joints[term.joint];
    ATL_ASSERT(!of.is_tendon() && of.first != of.second, term.joint, of.first, of.second);
    const TermRow row = term_row(term, of, pose_of(of.first), pose_of(of.second), term.position);
    now.length += row.value;
    now.rate += row.slope * row.at.rate(bodies.velocity(of.first), bodies.angular_velocity(of.first),
                                        bodies.velocity(of.second), bodies.angular_velocity(of.second));
    now.position[i] = row.position;
  }
  return now;
}

}  // namespace atl::solver
