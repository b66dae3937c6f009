#include "sweep/group_results.h"

#include <features/with_joints.h>

#include "integrate/rows3.h"

namespace atl::solver {

void write_back(const SolveInput& input, const GroupParts& parts, std::span<const std::uint32_t> bodies, bool joined,
                std::size_t begin, std::size_t end) {
  BodyTable& table = input.bodies;
  const SolverBodies& rows = parts.bodies;
  const JoinedMotion& joined_motion = parts.joined_motion;
  const std::uint32_t first_dynamic = parts.numbers.first_dynamic();
  const double substep = input.dt / input.settings.substeps;
  MovedBodies& notes = input.fast.local();
  for (std::size_t i = begin; i < end; ++i) {
    const std::uint32_t body = bodies[i];
    const std::size_t local = first_dynamic + i;
    const BodyPose start{table.position(body), table.orientation(body)};
    const bool is_joined = with_joints && joined && joined_motion.is_joined(i);
    const Vector3 gained = get3(rows.velocity[local].linear);
    const Vector3 gained_spin = get3(rows.velocity[local].angular);
    // Half the gain of the step is the sum of half the gains of its substeps, so one shift covers them all.
    const Vector3 acceleration = get3(rows.acceleration[local].linear);
    const BlowRows blow = rows.blow.empty() ? BlowRows{} : rows.blow[local];
    const Vector3 pulled = gained - get3(blow.linear), pulled_spin = gained_spin - get3(blow.angular);
    const bool shifts =
        !is_joined && changes_steadily(pulled, pulled_spin, acceleration.norm(), input.dt, table.radius[body]);
    // In free flight spin changes by tumbling, which has its own integrator: only the position is shifted.
    const bool flies = (pulled - input.dt * acceleration).squaredNorm() <= 1e-6 * pulled.squaredNorm();
    table.velocity(body) += gained;
    table.angular_velocity(body) += gained_spin;
    table.position(body) += get3(rows.displacement[local].linear);
    Quaternion orientation = rotation_of(rows.displacement[local]) * table.orientation(body);
    if (is_joined) {
      // Joints would part if bodies were shifted each by its own.
      if (joined_motion.falls(i)) table.position(body) -= 0.5 * substep * input.dt * joined_motion.acceleration(i);
    } else if (flies || shifts) {
      table.position(body) -= 0.5 * substep * pulled;
    }
    if (shifts && !flies) {
      const Vector3 back = -0.25 * substep * pulled_spin;  // half a small rotation
      orientation = Quaternion(1, back.x(), back.y(), back.z()) * orientation;
    }
    table.set_orientation(body, orientation.normalized());
    if (is_joined && joined_motion.is_direct(i)) continue;  // joints have a last word
    record_motion(table, input.bounds, body, start, input.dt, notes);
  }
}

void capture_answers(const SolveInput& input, const GroupParts& parts, const GroupReport& report,
                     std::span<const std::uint32_t> bodies) {
  const SolverBodies& rows = parts.bodies;
  const std::uint32_t first_dynamic = parts.numbers.first_dynamic();
  const std::span<const ContactBlock> blocks = parts.contacts.blocks();
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    const ContactBlock& block = blocks[b];
    for (std::size_t lane = 0; lane < block_lanes; ++lane) {
      if (block.slot[lane] < 0) continue;
      ContactCapture::Answer& answer = input.capture->answers[static_cast<std::size_t>(block.slot[lane])];
      answer.step = input.dt / input.settings.substeps;
      for (std::size_t i = 0; i < max_points; ++i) {
        answer.separation[i] = block.separation[i][lane];
        answer.normal_impulse[i] = block.normal_impulse[i][lane];
      }
      for (std::size_t i = 0; i < 3; ++i) {
        answer.anchor_first[i] = block.anchor_first[i][lane];
        answer.anchor_second[i] = block.anchor_second[i][lane];
      }
      answer.planar = !rows.locks.empty() && parts.contacts.planar_blocks()[b].planar[lane] > 0;
      const std::array<float, 3>& normal = answer.normal;
      const std::array<float, 3>& tangent = answer.tangent;
      for (std::size_t i = 0; i < 3; ++i) {
        answer.normal[i] = block.normal[i][lane];
        answer.tangent[i] = block.tangent[i][lane];
      }
      for (std::size_t i = 0; i < 2; ++i) answer.x[i] = block.x[i][lane];
      const auto along_tangents = [&](float first, float second) {
        std::array<float, 3> sum;
        for (std::size_t i = 0; i < 3; ++i) {
          const std::size_t j = (i + 1) % 3, k = (i + 2) % 3;
          sum[i] = first * tangent[i] + second * (normal[j] * tangent[k] - normal[k] * tangent[j]);
        }
        return sum;
      };
      answer.friction_impulse = along_tangents(block.friction_impulse[0][lane], block.friction_impulse[1][lane]);
      answer.torsional_impulse = block.torsional_impulse[lane];
      answer.rolling_impulse = {0, 0, 0};
      if (!report.surfaces) continue;
      const auto& rolling = parts.contacts.surface_blocks()[b].rolling_impulse;
      answer.rolling_impulse = along_tangents(rolling[0][lane], rolling[1][lane]);
    }
  }
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const std::size_t local = first_dynamic + i;
    ContactCapture::Motion& motion = input.capture->motions[bodies[i]];
    motion.free_velocity = input.bodies.velocity(bodies[i]) + get3(rows.free_velocity[local].linear);
    motion.free_angular_velocity = input.bodies.angular_velocity(bodies[i]) + get3(rows.free_velocity[local].angular);
    motion.inverse_inertia = inverse_inertia_of(rows, local);
  }
}

}  // namespace atl::solver
