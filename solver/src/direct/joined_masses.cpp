#include "direct/joined_masses.h"

#include <solver/tuning.h>

#include <algorithm>
#include <utility>

#include "direct/island_joints.h"
#include "integrate/matrix3.h"

namespace atl::solver {
namespace {

// Tells if a damper slows the two bodies down so fast that it matters what else it moves.
bool decays_notably(const Law& law, const DirectJoint& joint, std::size_t row, double h) {
  const double moved = joint.mass[row] + law.armature;
  return law.spring_hertz == 0 && joint.mass[row] > 0 && h * law.damping > tuning::notable_decay * moved;
}

// kg or kg m^2: the mass that the springs, servos and dampers of a row would move by its distance in a substep.
double strength_of(const Law& law, const DirectJoint& joint, std::size_t row, double h) {
  if (!(joint.mass[row] > 0) || law.locked() || !law.looks_back()) return 0;
  const LinearForce force = force_on(law, joint.at[row], joint.mass[row], joint.motor_bound[row] != 0);
  return (joint.mass[row] + law.armature) * h * (h * force.square_of_omega + force.decay);
}

// Calls visit(row, law) for the rows that may have springs, servos or dampers.
template <typename Visit>
void for_each_law(const Joint* joints, const DirectJoint& joint, const Visit& visit) {
  for (std::size_t r = joint.point_rows(); r < joint.rows; ++r) {
    const Law& law = law_of(joints[joint.joint], r);
    if (!law.locked() && joint.mass[r] > 0) visit(r, law);
  }
}

// Calls visit(body) for the bodies of a joint that respond.
template <typename Visit>
void for_each_body(const DirectJoint& joint, const Visit& visit) {
  if (joint.is_tendon()) {
    for (const PulledBody& body : joint.pulled()) {
      if (body.body != no_body) visit(body.body);
    }
    return;
  }
  if (joint.first != no_body) visit(joint.first);
  if (joint.second != no_body) visit(joint.second);
}

// The largest part of the way to rest by which springs would move a body in a substep, if all of a body pulled one way
// and no joint held it. `moves` is room for six numbers a body.
double most_moved(const Joint* joints, double h, const IslandProblem& problem, std::vector<double>& moves) {
  std::fill(moves.begin(), moves.end(), 0.0);
  double most = 0;
  for (const DirectJoint& joint : problem.joints) {
    double own = 0;
    for_each_law(joints, joint, [&](std::size_t r, const Law& law) {
      own += strength_of(law, joint, r, h) / (joint.mass[r] + law.armature);
    });
    for_each_body(joint, [&](std::uint32_t body) { most = std::max(most, moves[6 * body] += own); });
  }
  return most;
}

void reset(const Joint* joints, IslandProblem& problem) {
  for (DirectJoint& joint : problem.joints) {
    joint.joined = {};
    joint.share.fill(1);
    for_each_law(joints, joint, [&](std::size_t r, const Law& law) { joint.law[r].spring_slope = law.armature; });
  }
}

// The part of the way to rest by which springs move the coordinate of a row in a substep, with its own of `strength`.
// Stronger ones count no more than its own, or a soft one would be damped with a stiff. `answer` is what an impulse
// along the row makes of velocities, and `response` of its own rate; it moves joints that are `near(joint)`.
// `part(joint, row, law)` is the part of its motion that a row's own inertia leaves.
template <typename Near, typename Part>
double moves_along(const Joint* joints, double h, const IslandProblem& problem, const std::vector<double>& answer,
                   double strength, double response, const Near& near, const Part& part) {
  const double own = strength * response;
  double sum = 0;
  for (const DirectJoint& joint : problem.joints) {
    if (!near(joint)) continue;
    for_each_law(joints, joint, [&](std::size_t r, const Law& law) {
      const double other = strength_of(law, joint, r, h);
      if (other == 0) return;
      const double rate = joint.rate_by(answer, r);
      sum += std::min(part(joint, r, law) * other * rate * rate / response, own);
    });
  }
  return sum;
}

bool share_a_body(const DirectJoint& a, const DirectJoint& b) {
  bool shared = false;
  for_each_body(
      a, [&](std::uint32_t first) { for_each_body(b, [&](std::uint32_t second) { shared |= first == second; }); });
  return shared;
}

// How springs move a coordinate in a substep, as parts of the way to rest: its own, and all.
struct Moves {
  double own = 0, all = 0;
};

// The moves along a row if no joint held its bodies.
Moves moves_alone(const Joint* joints, double h, std::size_t row, const Law& law, const DirectJoint& joint,
                  const IslandProblem& problem, std::vector<double>& answer) {
  const auto part = [](const DirectJoint& of, std::size_t r, const Law& along) {
    return of.mass[r] / (of.mass[r] + along.armature);
  };
  joint.set_momenta(row, answer);
  for_each_body(joint, [&](std::uint32_t body) {
    const DirectBody& of = problem.bodies[body];
    linear_part(answer, body) = of.inverse_mass.cwiseProduct(linear_part(std::as_const(answer), body)).eval();
    angular_part(answer, body) = product(of.inverse_inertia, Vector3(angular_part(std::as_const(answer), body)));
  });
  const double own = part(joint, row, law), strength = strength_of(law, joint, row, h);
  const double response = own / joint.mass[row];
  const auto moves = [&](const DirectJoint& of, std::size_t r, const Law& along) {
    return own * own * part(of, r, along);
  };
  const auto near = [&](const DirectJoint& of) { return share_a_body(of, joint); };
  return {strength * response, moves_along(joints, h, problem, answer, strength, response, near, moves)};
}

// The share of a coordinate's mass that is left to springs which are `own` of all.
double share_of(double own, double all) { return all > 1 ? own / all : 1; }

// Weighs a row by a solve of its own.
void weigh_row(const Joint* joints, double h, std::size_t row, const Law& law, DirectJoint& joint,
               const IslandProblem& problem, BalanceSearch& search) {
  std::vector<double>& answer = search.direction;
  joint.set_momenta(row, answer);
  search.matrix.solve(problem, answer);
  const auto near = [](const DirectJoint&) { return true; };
  const auto all = [](const DirectJoint&, std::size_t, const Law&) { return 1.0; };
  const double response = joint.rate_by(answer, row), strength = strength_of(law, joint, row, h);
  joint.joined[row] = 1 / response - law.armature;
  const double moves = moves_along(joints, h, problem, answer, strength, response, near, all);
  joint.share[row] = share_of(strength * response, moves);
}

// Weighs all rows of a tree together, by the inverse of the matrix: a robot of 28 servos takes 7 us a substep more by
// it, and 34 by a solve for each. Rows get a little inertia of their own, without which one that nothing acts along
// would not be in the matrix.
void weigh_tree(const Joint* joints, double h, JointResponse& response, IslandProblem& problem) {
  constexpr double little = 1e-6;  // of a coordinate's mass
  std::vector<DirectJoint>& all = problem.joints;
  for (DirectJoint& joint : all) {
    for_each_law(joints, joint,
                 [&](std::size_t r, const Law&) { joint.law[r].spring_slope += little * joint.mass[r]; });
  }
  if (!response.factor(problem)) return;
  response.invert();
  const auto strength = [&](const DirectJoint& joint, std::size_t r) {
    return strength_of(law_of(joints[joint.joint], r), joint, r, h);
  };
  const auto response_of = [](const DirectJoint& joint, std::size_t r) {
    return 1 / (joint.joined[r] + joint.law[r].spring_slope);
  };
  // Until the last pass a share is the sum of what springs do.
  response.for_each_response(problem, [&](std::size_t a, std::size_t r, std::size_t b, std::size_t s, double value) {
    if (a != b || r != s) return;
    all[a].joined[r] = 1 / value - all[a].law[r].spring_slope;
    all[a].share[r] = strength(all[a], r) * value;
  });
  response.for_each_response(problem, [&](std::size_t a, std::size_t r, std::size_t b, std::size_t s, double value) {
    if (a == b && r == s) return;
    const double of_first = response_of(all[a], r), of_second = response_of(all[b], s);
    const double first = strength(all[a], r), second = strength(all[b], s);
    all[a].share[r] += std::min(second * value * value / of_first, first * of_first);
    all[b].share[s] += std::min(first * value * value / of_second, second * of_second);
  });
  for (DirectJoint& joint : all) {
    for_each_law(joints, joint, [&](std::size_t r, const Law&) {
      if (joint.joined[r] == 0) return;  // it is held at an end of its range
      joint.share[r] = share_of(strength(joint, r) * response_of(joint, r), joint.share[r]);
    });
  }
}

// Weighs rows one by one where springs would move them farther than to rest if no joint held anything. Among many
// joints, where a solve for each would take longer than a substep, they are shared as if none did.
void weigh_rows(const Joint* joints, double h, IslandProblem& problem, BalanceSearch& search) {
  constexpr std::size_t max_joints = 64;
  const bool solves = problem.joints.size() <= max_joints;
  for (DirectJoint& joint : problem.joints) {
    for_each_law(joints, joint, [&](std::size_t r, const Law& law) {
      if (strength_of(law, joint, r, h) == 0) return;
      const Moves moves = moves_alone(joints, h, r, law, joint, problem, search.direction);
      if (moves.all <= 1) return;
      joint.share[r] = share_of(moves.own, moves.all);
      if (!solves || (!is_factored(problem) && !search.matrix.factor(problem))) return;
      weigh_row(joints, h, r, law, joint, problem, search);
    });
  }
}

// True if `holds(joint, row, law)` for some row.
template <typename Holds>
bool any_row(const Joint* joints, const IslandProblem& problem, const Holds& holds) {
  return std::any_of(problem.joints.begin(), problem.joints.end(), [&](const DirectJoint& joint) {
    bool any = false;
    for_each_law(joints, joint, [&](std::size_t r, const Law& law) { any = any || holds(joint, r, law); });
    return any;
  });
}

bool any_notable_damper(const Joint* joints, double h, const IslandProblem& problem) {
  return any_row(joints, problem, [h](const DirectJoint& joint, std::size_t r, const Law& law) {
    return decays_notably(law, joint, r, h);
  });
}

void weigh(const Joint* joints, double h, IslandProblem& problem, BalanceSearch& search) {
  forget_factor(problem);
  if (JointResponse* const tree = search.matrix.joints()) {
    weigh_tree(joints, h, *tree, problem);
  } else {
    weigh_rows(joints, h, problem, search);
  }
  forget_factor(problem);
}

}  // namespace

void weigh_joined(const Joint* joints, double h, IslandProblem& problem, BalanceSearch& search) {
  reset(joints, problem);
  const bool matters = most_moved(joints, h, problem, search.gradient) > 1 || any_stiff_spring(joints, h, problem) ||
                       any_notable_damper(joints, h, problem);
  if (matters) weigh(joints, h, problem, search);
}

void weigh_crowded(const Joint* joints, double h, IslandProblem& problem, BalanceSearch& search) {
  reset(joints, problem);
  if (most_moved(joints, h, problem, search.gradient) > 1) weigh(joints, h, problem, search);
}

bool any_stiff_spring(const Joint* joints, double h, const IslandProblem& problem) {
  return any_row(joints, problem, [h](const DirectJoint& joint, std::size_t r, const Law& law) {
    return joint.share[r] < 1 || has_stiff_spring(law, joint.at[r], joint.mass[r], h);
  });
}

}  // namespace atl::solver
