#include <jobs/assert.h>
#include <solver/direct/direct_island.h>
#include <solver/direct/moving_bodies.h>
#include <solver/tuning.h>

#include <algorithm>
#include <span>
#include <utility>

#include "direct/island_joints.h"
#include "direct/island_solves.h"

namespace atl::solver {
namespace {

void count_work(const SolveInput& input, const IslandMembers& members, const IslandProblem& problem,
                DirectIslandReport& report) {
  for (const DirectContact& contact : problem.contacts) {
    ++report.contacts;
    report.several_points += input.manifolds[contact.slot].separation[1] < collision::no_point;
    report.two_movable += contact.first != no_body && contact.second != no_body;
    report.friction += contact.friction > 0;
  }
  for (const std::uint32_t body : members.bodies) report.gyroscopic_bodies += input.bodies.gyroscopic[body];
}

}  // namespace

bool IslandMembers::take_in(const SolveInput& input, const IslandGroup& group) {
  const std::span<const std::uint32_t> bodies_now = input.islands.bodies(group.begin, group.end);
  const std::span<const TouchingPair> contacts_now = input.islands.contacts(group.begin, group.end);
  const std::span<const JointLink> joints_now = input.islands.joints(group.begin, group.end);
  const auto same_pair = [](const auto& a, const auto& b) { return a.first == b.first && a.second == b.second; };
  const auto same_pairs = [&](const auto& now, const auto& before) {
    return std::equal(now.begin(), now.end(), before.begin(), before.end(), same_pair);
  };
  const auto row_count = [&](const JointLink& link) { return input.joints[link.joint].row_count(); };
  const auto same_rows = [&](const JointLink& link, std::uint8_t before) { return row_count(link) == before; };
  island = group.begin;
  first_rank = input.islands.first_rank(group.begin);
  const auto term_ends_before = std::exchange(term_ends, {});
  for (const JointLink& link : joints_now) {
    for_each_term(input.joints, link.joint,
                  [&](const Joint& of) { term_ends.emplace_back(local(input, of.first), local(input, of.second)); });
  }
  const bool same = term_ends == term_ends_before &&
                    std::equal(joints_now.begin(), joints_now.end(), rows.begin(), rows.end(), same_rows) &&
                    std::equal(bodies_now.begin(), bodies_now.end(), bodies.begin(), bodies.end()) &&
                    same_pairs(contacts_now, contacts) && same_pairs(joints_now, joints);
  bodies.assign(bodies_now.begin(), bodies_now.end());
  contacts.assign(contacts_now.begin(), contacts_now.end());
  joints.assign(joints_now.begin(), joints_now.end());
  rows.clear();
  ends.clear();
  for (const JointLink& link : joints) {
    rows.push_back(static_cast<std::uint8_t>(row_count(link)));
    ends.emplace_back(local(input, link.first), local(input, link.second));
  }
  return same;
}

std::vector<std::pair<std::uint32_t, std::uint32_t>> IslandMembers::couplings(const SolveInput& input) const {
  std::vector<std::pair<std::uint32_t, std::uint32_t>> coupled;
  const auto couple = [&](const auto& pair) {
    const std::uint32_t first = local(input, pair.first);
    const std::uint32_t second = local(input, pair.second);
    if (first != no_body && second != no_body) coupled.emplace_back(first, second);
  };
  for (const TouchingPair& pair : contacts) couple(pair);
  auto ends_of_terms = std::span(term_ends);
  for (const JointLink& link : joints) {
    const std::size_t terms = input.joints[link.joint].terms;
    if (terms == 0) couple(link);
    couple_all(ends_of_terms.first(terms), coupled);
    ends_of_terms = ends_of_terms.subspan(terms);
  }
  ATL_ASSERT(ends_of_terms.empty(), ends_of_terms.size(), term_ends.size());
  return coupled;
}

bool DirectIsland::analyse(const SolveInput& input, const IslandGroup& group) {
  if (members_.take_in(input, group)) return fits_;
  // Else each solver would come to hold what the largest of all islands took that it has ever solved.
  motions_ = IslandMotions();
  bodies_ = std::vector<MovingBody>();
  const std::size_t count = members_.bodies.size();
  return fits_ = count <= tuning::max_bodies &&
                 motions_.search.matrix.analyse(count, members_.couplings(input), max_factor_blocks(count, true));
}

DirectIslandReport DirectIsland::solve(const SolveInput& input) {
  IslandProblem& problem = motions_.problem;
  ATL_ASSERT(fits_, members_.island, members_.bodies.size());
  motions_.resize(members_.bodies.size());
  problem.joints.resize(members_.joints.size());
  motions_.search.iterations = 0;
  DirectIslandReport report;
  if (!load_bodies(input, members_, problem, bodies_)) {
    report.why_not = "a body tumbles too fast";
  } else if (!load_contacts(input, members_, problem)) {
    report.why_not = "something bounces";
  } else {
    report.solved = members_.joints.empty() ? solve_step(input, members_, bodies_, motions_)
                                            : solve_substeps(input, members_, bodies_, motions_);
    if (!report.solved) report.why_not = "its search ended nowhere";
  }
  report.iterations = motions_.search.iterations;
  if (!report.solved) return report;
  count_work(input, members_, problem, report);
  return report;
}

}  // namespace atl::solver
