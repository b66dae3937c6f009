#include "world/joint_table.h"

#include <algorithm>

namespace atl {

void JointTable::resize(std::size_t count_of_all) {
  joints.resize(count_of_all);
  def.resize(count_of_all);
  generation.resize(count_of_all, 0);
  for (std::vector<std::uint8_t>* flags : {&alive, &enabled, &broken, &suspended, &acts, &watched, &driven}) {
    flags->resize(count_of_all, 0);
  }
  limit_before.resize(count_of_all);
  of_body_.resize(count_of_all);
}

void JointTable::reset(std::size_t count_of_all) {
  *this = {};
  resize(count_of_all);
}

void JointTable::rebuild() {
  count = 0;
  of_body_.clear();
  apart_.clear();
  for (std::uint32_t joint = 0; joint < size(); ++joint) {
    update_flags(joint);
    if (!alive[joint]) continue;
    ++count;
    link(joint);
    if (enabled[joint] && !def[joint].collide) keep_apart(joints[joint].first, joints[joint].second);
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
  def[index] = definition;
  alive[index] = enabled[index] = 1;
  broken[index] = suspended[index] = 0;
  limit_before[index] = {};
  ++count;
  link(index);
  update_flags(index);
  return index;
}

void JointTable::remove(std::uint32_t joint) {
  of_body_.remove(joint, joints[joint].first, joints[joint].second);
  alive[joint] = enabled[joint] = broken[joint] = suspended[joint] = 0;
  joints[joint] = {};
  def[joint] = {};
  ++generation[joint];
  free.push_back(joint);
  --count;
  update_flags(joint);
}

void JointTable::update_flags(std::uint32_t joint) {
  const solver::Joint& j = joints[joint];
  acts[joint] = enabled[joint] && suspended[joint] == 0 && j.row_count() > 0;
  bool may_tell = def[joint].break_force < unlimited || def[joint].break_torque < unlimited;
  bool is_driven = false;
  for (std::size_t row = 0; row < j.rows; ++row) {
    may_tell |= j.law[row].limited() && !j.law[row].locked();
    is_driven |= j.law[row].motor_force > 0 && j.law[row].motor_speed != 0;
  }
  watched[joint] = acts[joint] && may_tell;
  driven[joint] = acts[joint] && is_driven;
}

bool JointTable::keep_apart(std::uint32_t a, std::uint32_t b) { return ++apart_[std::minmax(a, b)] == 1; }

bool JointTable::let_touch(std::uint32_t a, std::uint32_t b) {
  const auto found = apart_.find(std::minmax(a, b));
  if (--found->second > 0) return false;
  apart_.erase(found);
  return true;
}

}  // namespace atl
