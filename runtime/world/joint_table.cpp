#include "world/joint_table.h"

#include <jobs/assert.h>

#include <algorithm>
#include <numbers>

namespace atl {
namespace {

// The definition of joints that aren't there.
const std::shared_ptr<const JointDef>& no_definition() {
  static const auto none = std::make_shared<const JointDef>();
  return none;
}

}  // namespace

double creep_time(const solver::Law& law) {
  const double stiffness = law.stiffness + (law.drives() ? law.servo_stiffness : 0);
  const double damping = law.damping + (law.drives() ? law.servo_damping : 0);
  const double by_force = stiffness > 0 ? damping / stiffness : 0;
  const double by_hertz = law.spring_hertz > 0 ? law.damping_ratio / (std::numbers::pi * law.spring_hertz) : 0;
  return std::max(by_force, by_hertz);
}

void JointTable::resize(std::size_t count_of_all) {
  ATL_ASSERT(count_of_all >= size(), count_of_all, size());
  joints.resize(count_of_all);
  def.resize(count_of_all, no_definition());
  generation.resize(count_of_all, 0);
  for (jobs::CompactArray<std::uint8_t>* flags : {&alive, &enabled, &broken, &suspended, &acts, &watched, &driven}) {
    flags->resize(count_of_all, 0);
  }
  limit_before.resize(count_of_all);
  by_.body.resize(count_of_all);
}

void JointTable::reset(std::size_t count_of_all) {
  *this = {};
  resize(count_of_all);
}

void JointTable::rebuild() {
  count = 0;
  by_.body.clear();
  apart_.clear();
  by_.tendons.clear();
  for (std::uint32_t joint = 0; joint < size(); ++joint) {
    update_flags(joint);
    if (!alive[joint]) continue;
    ++count;
    link(joint);
    if (enabled[joint] && !def[joint]->collide) keep_apart(joints[joint].first, joints[joint].second);
  }
}

std::uint32_t JointTable::add(const JointDef& definition, const solver::Joint& joint) {
  std::uint32_t index;
  if (free.empty()) {
    index = static_cast<std::uint32_t>(size());
    resize(size() + 1);
  } else {
    index = free.back();
    free.pop_back();
  }
  joints[index] = joint;
  ATL_ASSERT(index < size() && !alive[index], index, size());
  def[index] = std::make_shared<const JointDef>(definition);
  alive[index] = enabled[index] = 1;
  broken[index] = suspended[index] = 0;
  limit_before[index] = {};
  ++count;
  link(index);
  update_flags(index);
  return index;
}

void JointTable::remove(std::uint32_t joint) {
  ATL_ASSERT(joint < size() && alive[joint], joint, size());
  ATL_ASSERT(count > 0, count);
  unlink(joint);
  alive[joint] = 0;
  clear(joint);
  ++generation[joint];
  free.push_back(joint);
  --count;
  update_flags(joint);
}

void JointTable::clear(std::uint32_t joint) {
  joints[joint] = {};
  def[joint] = no_definition();
  enabled[joint] = broken[joint] = suspended[joint] = 0;
}

void JointTable::link(std::uint32_t joint) {
  ATL_ASSERT(joints[joint].is_tendon() || joints[joint].first != joints[joint].second, joint, joints[joint].first);
  if (joints[joint].is_tendon()) {
    by_.tendons.insert(std::lower_bound(by_.tendons.begin(), by_.tendons.end(), joint), joint);
  } else {
    by_.body.add(joint, joints[joint].first, joints[joint].second);
  }
}

void JointTable::unlink(std::uint32_t joint) {
  if (joints[joint].is_tendon()) {
    jobs::erase(by_.tendons, joint);
  } else {
    by_.body.remove(joint, joints[joint].first, joints[joint].second);
  }
}

std::vector<std::uint32_t> JointTable::tendons_over(std::uint32_t joint) const {
  ATL_ASSERT(joint < size(), joint, size());
  std::vector<std::uint32_t> over;
  for (const std::uint32_t tendon : by_.tendons) {
    const solver::Joint& of = joints[tendon];
    const auto end = of.term.begin() + of.terms;
    if (std::any_of(of.term.begin(), end, [&](const solver::TendonTerm& term) { return term.joint == joint; })) {
      over.push_back(tendon);
    }
  }
  return over;
}

bool JointTable::takes_part(std::uint32_t joint) const { return enabled[joint] && suspended[joint] == 0; }

void JointTable::update_flags(std::uint32_t joint) {
  const solver::Joint& j = joints[joint];
  ATL_ASSERT(joint < size(), joint, size());
  ATL_ASSERT(j.rows <= solver::max_joint_rows && j.terms <= j.term.size(), joint, j.rows, j.terms);
  ATL_ASSERT(def[joint] != nullptr, joint);
  // A tendon's joints need no rows of their own: what is free may hang on a rope.
  acts[joint] = takes_part(joint) && j.row_count() > 0 &&
                std::all_of(j.term.begin(), j.term.begin() + j.terms,
                            [&](const solver::TendonTerm& term) { return takes_part(term.joint); });
  bool may_tell = def[joint]->break_force < unlimited || def[joint]->break_torque < unlimited;
  bool is_driven = false;
  for (std::size_t row = 0; row < j.rows; ++row) {
    may_tell |= j.law[row].limited() && !j.law[row].locked();
    is_driven |= (j.law[row].drives() && j.law[row].motor_speed != 0) || creep_time(j.law[row]) > 0;
  }
  watched[joint] = acts[joint] && may_tell;
  driven[joint] = acts[joint] && is_driven;
  if (j.is_tendon()) return;
  for (const std::uint32_t tendon : tendons_over(joint)) update_flags(tendon);
}

bool JointTable::keep_apart(std::uint32_t a, std::uint32_t b) { return ++apart_[std::minmax(a, b)] == 1; }

bool JointTable::let_touch(std::uint32_t a, std::uint32_t b) {
  const auto found = apart_.find(std::minmax(a, b));
  ATL_ASSERT(found != apart_.end(), a, b);
  ATL_ASSERT(found->second > 0, a, b, found->second);
  if (--found->second > 0) return false;
  apart_.erase(found);
  return true;
}

}  // namespace atl
