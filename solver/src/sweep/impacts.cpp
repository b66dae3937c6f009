#include <jobs/assert.h>
#include <solver/direct/joint_systems.h>
#include <solver/integrate/free_flight.h>
#include <solver/sweep/impacts.h>
#include <solver/tuning.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

#include "integrate/matrix3.h"
#include "integrate/rows3.h"

namespace atl::solver {
namespace {

void turn(const Quaternion& by, ImpactBody& body) {
  if (body.turns) body.rotation = by * body.rotation;
  body.turned = by * body.turned;
  if (body.is_locked) return;
  const Matrix3 rotation = by.toRotationMatrix();
  body.inverse_inertia = symmetric_product(product(rotation, body.inverse_inertia), rotation);
}

// Turns a body freely by `time` seconds, forwards or back: at its mean spin, with constant angular momentum.
void tumble(double time, ImpactBody& body) {
  const Vector3 momentum = body.tumbles ? product(symmetric_inverse(body.inverse_inertia), body.spin) : Vector3::Zero();
  const ImpactBody start = body;
  Vector3 mean = start.spin;
  for (int i = 0; i < (body.tumbles ? 3 : 1); ++i) {
    body = start;
    turn(rotation_by(time * mean), body);
    if (body.tumbles) body.spin = product(body.inverse_inertia, momentum);
    mean = 0.5 * (start.spin + body.spin);
  }
}

// Hides a contact from the sweeps of this substep; the next one takes care of it.
void hide(const ContactKernelData& data, std::uint32_t block, std::uint32_t lane) {
  for (std::size_t i = 0; i < max_points; ++i) {
    data.blocks[block].separation[i][lane] = data.bounces[block].separation[i][lane] = collision::no_point;
  }
}

// True if swept joints hold a body, and nobody knows what they hold to it: they would part if the body were shifted.
bool is_held(const ContactKernelData& data, const ImpactBody& body) {
  return data.joined != nullptr && data.joined[body.local] == static_cast<std::uint8_t>(Joined::Swept) &&
         !body.is_joined();
}

// m, the arms of a contact on its two bodies, as these are turned now.
std::pair<Vector3, Vector3> arms_of(const ContactKernelData& data, std::uint32_t number, const ImpactBody& first,
                                    const ImpactBody& second) {
  const std::uint32_t b = number / block_lanes, lane = number % block_lanes;
  const Vector3 arm_first = get_lane(data.blocks[b].anchor_first, lane);
  const Vector3 arm_second = get_lane(data.blocks[b].anchor_second, lane);
  if (data.rim_blocks == nullptr || !data.blocks[b].traits.rims) {
    return {first.rotation * arm_first, second.rotation * arm_second};
  }
  const Vector3 rim_first = get_lane(data.rim_blocks[b].rim_first, lane);
  const Vector3 rim_second = get_lane(data.rim_blocks[b].rim_second, lane);
  return {first.rotation * (arm_first - rim_first) + rim_first,
          second.rotation * (arm_second - rim_second) + rim_second};
}

// Returns false if no point can arrive faster than the threshold: a bound from the speeds at the centre.
bool may_close(const ContactKernelData& data, std::uint32_t number, const ImpactBody& first, const ImpactBody& second) {
  const ContactBlock& block = data.blocks[number / block_lanes];
  const std::uint32_t lane = number % block_lanes;
  double extent = 0;  // m, of the points about the centre
  for (std::size_t i = 0; i < block.traits.points; ++i) {
    extent = std::max<double>(extent, std::abs(block.x[i][lane]) + std::abs(block.y[i][lane]));
  }
  const auto [arm_first, arm_second] = arms_of(data, number, first, second);
  const Vector3 velocity =
      second.velocity + second.spin.cross(arm_second) - first.velocity - first.spin.cross(arm_first);
  const double fall = data.constants.h * (first.acceleration.norm() + second.acceleration.norm());
  const double closing = get_lane(block.normal, lane).dot(velocity) - extent * (second.spin - first.spin).norm() - fall;
  return closing < -data.constants.restitution_threshold;
}

// s, from now, after which a point that closes arrives, under a steady acceleration along the normal.
double arrival(double closing, double gap, double acceleration, double h) {
  if (!(gap > 0)) return 0;
  const double square = std::max(closing * closing - 2 * acceleration * gap, 0.0);
  return std::min(2 * gap / (std::sqrt(square) - closing), h);
}

}  // namespace

void Impacts::begin_step(std::size_t body_count, std::size_t block_count) {
  block_count_ = block_count;
  number_.assign(body_count, none);
  first_.clear();
}

void Impacts::solve(const ContactKernelData& data, Friction friction, const Joints& joints) {
  bodies_.clear();
  contacts_.clear();
  hit_systems_.clear();
  if (joints.components != nullptr && systems_.size() < joints.components->component_count()) {
    systems_.resize(joints.components->component_count());
  }
  find_first(data, joints);
  for (int round = 0; round < tuning::max_impact_rounds && !contacts_.empty(); ++round) {
    if (joints.components != nullptr) begin_systems(data, joints);
    gather_sets();
    reflect_sets(friction);
    for (const std::uint32_t number : hit_systems_) systems_[number].end_round(bodies_);
    for (const ImpactContact& contact : contacts_) {
      for (std::size_t i = 0; i < max_points; ++i) {
        float& spent = data.bounces[contact.block].spent[i][contact.lane];
        spent = static_cast<float>(spent + contact.points[i].impulse);
      }
    }
    find_next(data, joints);
  }
  for (const ImpactContact& contact : contacts_) hide(data, contact.block, contact.lane);
  store(data, joints);
}

// Takes in what joints hold to bodies that are hit in this round.
void Impacts::begin_systems(const ContactKernelData& data, const Joints& joints) {
  hits_.clear();
  for (const ImpactContact& contact : contacts_) {
    for (const std::uint32_t place : {contact.first, contact.second}) {
      if (bodies_[place].is_joined()) hits_.push_back({bodies_[place].system, contact.time, bodies_[place].local});
    }
  }
  std::sort(hits_.begin(), hits_.end());
  for (std::size_t begin = 0, end = 0; begin < hits_.size(); begin = end) {
    const JoinedHit& first = hits_[begin];
    while (end < hits_.size() && hits_[end].system == first.system) ++end;
    if (!bodies_[number_[first.local]].is_hit && !begin_system(data, joints, first.system, first.time)) continue;
    // The earliest first.
    joined_.clear();
    for (std::size_t i = begin; i < end; ++i) bodies_[number_[hits_[i].local]].waits = true;
    for (std::size_t i = begin; i < end && joined_.size() < tuning::max_hit; ++i) {
      ImpactBody& body = bodies_[number_[hits_[i].local]];
      if (body.waits) joined_.push_back(body.member);
      body.waits = false;
    }
    std::sort(joined_.begin(), joined_.end());
    systems_[first.system].begin_round(joined_, bodies_);
  }
  std::erase_if(contacts_, [&](const ImpactContact& contact) {
    return bodies_[contact.first].waits || bodies_[contact.second].waits;
  });
  for (ImpactContact& contact : contacts_) {
    if (contact.is_complete) continue;
    complete(data, contact);
    if (is_joined(contact)) weigh_joined({bodies_, systems_}, contact);
  }
}

// Takes a system as a whole to where it is by its first impact.
bool Impacts::begin_system(const ContactKernelData& data, const Joints& joints, std::uint32_t number, double time) {
  const std::uint32_t of_graph = joints.components->graph_component(number);
  DirectJoints& of = *joints.input.joint_systems->for_impacts(joints.input, of_graph);
  if (!joints.input.solves_directly(of_graph)) {
    of.locate([&](std::uint32_t body) { return joints.numbers.local(joints.input, joints.group, body); });
    of.load(joints.input, data.bodies);
  }
  ImpactSystem& system = systems_[number];
  system.places().clear();
  for (const std::uint32_t local : of.places()) {
    const std::uint32_t place = body_of(data, joints, local);
    ImpactBody& body = bodies_[place];
    body.system = number;
    body.member = static_cast<std::uint32_t>(system.places().size());
    body.is_hit = body.bounces = true;
    body.time = time;
    tumble(time, body);
    system.places().push_back(place);
  }
  if (system.begin(joints.input, of, joints.start, time, bodies_)) {
    hit_systems_.push_back(number);
    return true;
  }
  for (const std::uint32_t place : system.places()) bodies_[place].system = none;
  return false;
}

void Impacts::reflect_sets(Friction friction) {
  for (std::size_t begin = 0, end = 0; begin < contacts_.size(); begin = end) {
    const std::uint32_t set = contacts_[begin].set;
    joined_.clear();
    for (; end < contacts_.size() && contacts_[end].set == set; ++end) {
      for (const std::uint32_t place : {contacts_[end].first, contacts_[end].second}) {
        if (bodies_[place].is_joined()) joined_.push_back(bodies_[place].system);
      }
    }
    std::sort(joined_.begin(), joined_.end());
    joined_.erase(std::unique(joined_.begin(), joined_.end()), joined_.end());
    reflect(std::span(contacts_).subspan(begin, end - begin), {bodies_, systems_}, joined_, friction);
  }
}

void Impacts::find_first(const ContactKernelData& data, const Joints& joints) {
  for (std::size_t b = 0; b < block_count_; ++b) {
    if (!data.blocks[b].traits.bounces) continue;
    for (unsigned lane = 0; lane < block_lanes; ++lane) {
      if (data.bounces[b].closes >> lane & 1u)
        add_if_hit(data, joints, static_cast<std::uint32_t>(b * block_lanes + lane));
    }
  }
}

// Finds the contacts for the next round, among those of bodies that the last round has changed.
void Impacts::find_next(const ContactKernelData& data, const Joints& joints) {
  if (first_.empty()) list_lanes(data);
  std::vector<std::uint32_t>& lanes = changed_;
  lanes.clear();
  for (ImpactBody& body : bodies_) {
    if (!body.changed) continue;
    body.changed = false;
    body.bounces = true;
    lanes.insert(lanes.end(), lanes_.begin() + first_[body.local], lanes_.begin() + first_[body.local + 1]);
  }
  std::sort(lanes.begin(), lanes.end());
  lanes.erase(std::unique(lanes.begin(), lanes.end()), lanes.end());
  contacts_.clear();
  for (const std::uint32_t lane : lanes) add_if_hit(data, joints, lane);
}

void Impacts::list_lanes(const ContactKernelData& data) {
  const auto each = [&](const auto& act) {
    for (std::size_t b = 0; b < block_count_; ++b) {
      const ContactBlock& block = data.blocks[b];
      for (std::size_t lane = 0; block.traits.bounces && lane < block_lanes; ++lane) {
        if (block.slot[lane] < 0) continue;
        const auto number = static_cast<std::uint32_t>(b * block_lanes + lane);
        if (block.write_first >> lane & 1u) act(block.first[lane], number);
        if (block.write_second >> lane & 1u) act(block.second[lane], number);
      }
    }
  };
  first_.assign(number_.size() + 2, 0);
  if constexpr (jobs::with_asserts) {
    each([&](std::int32_t body, std::uint32_t lane) {
      ATL_ASSERT(body >= 0 && static_cast<std::size_t>(body) < number_.size(), body, lane, number_.size());
    });
  }
  each([&](std::int32_t body, std::uint32_t) { ++first_[static_cast<std::size_t>(body) + 2]; });
  std::partial_sum(first_.begin(), first_.end(), first_.begin());
  lanes_.resize(first_.back());
  each([&](std::int32_t body, std::uint32_t lane) { lanes_[first_[static_cast<std::size_t>(body) + 1]++] = lane; });
}

std::uint32_t Impacts::body_of(const ContactKernelData& data, const Joints& joints, std::uint32_t local) {
  ATL_ASSERT(local < number_.size(), local, number_.size());
  std::uint32_t& number = number_[local];
  if (number != none) return number;
  number = static_cast<std::uint32_t>(bodies_.size());
  const SolverBodies& rows = data.bodies;
  ImpactBody& body = bodies_.emplace_back();
  body.local = local;
  if (joints.components != nullptr && local >= joints.numbers.first_dynamic()) {
    const std::uint32_t component = joints.components->component_of(local - joints.numbers.first_dynamic());
    if (component != JointGraph::none &&
        joints.input.joint_systems->for_impacts(joints.input, joints.components->graph_component(component)) != nullptr)
      body.system = component;
  }
  body.velocity = velocity_of(rows, local);
  body.spin = spin_of(rows, local);
  body.acceleration = get3(rows.acceleration[local].linear);
  body.inverse_mass = inverse_mass_of(rows, local);
  body.is_locked = !rows.locks.empty() && rows.locks[local].kind != 0 && rows.locks[local].kind != -1;
  body.inverse_inertia = inverse_inertia_of(rows, local);
  body.tumbles = !rows.gyroscopic.empty() && rows.gyroscopic[local].active != 0;
  if (rows.shape.empty() || !(rows.shape[local].kind > 0)) return number;
  // Rows have it as it was to be half way through the step.
  body.turns = true;
  turn(rotation_of(rows.displacement[local]) * rotation_by(get3(rows.shape[local].half_turn)).conjugate(), body);
  body.turned = Quaternion::Identity();
  return number;
}

void Impacts::add_if_hit(const ContactKernelData& data, const Joints& joints, std::uint32_t number) {
  const std::uint32_t b = number / block_lanes, lane = number % block_lanes;
  const ContactBlock& block = data.blocks[b];
  const BounceBlock& bounce = data.bounces[b];
  if (!(bounce.restitution[lane] > 0)) return;
  const std::uint32_t place_of_first = body_of(data, joints, static_cast<std::uint32_t>(block.first[lane]));
  const std::uint32_t place_of_second = body_of(data, joints, static_cast<std::uint32_t>(block.second[lane]));
  ImpactBody& first = bodies_[place_of_first];
  ImpactBody& second = bodies_[place_of_second];
  if (!may_close(data, number, first, second)) return;
  ImpactContact contact(b, lane, place_of_first, place_of_second);
  const Vector3 normal = get_lane(block.normal, lane), tangent = get_lane(block.tangent, lane);
  contact.axes = {normal, tangent, normal.cross(tangent)};
  std::tie(contact.arm_first, contact.arm_second) = arms_of(data, number, first, second);

  // Points bounce if they meet in this substep, faster than the threshold.
  const double h = data.constants.h;
  const double pull = normal.dot(second.acceleration - first.acceleration);
  const double max_pull = std::abs(normal.dot(first.acceleration)) + std::abs(normal.dot(second.acceleration));
  std::array<double, max_points> gap = {};
  bool bounces = false;
  contact.time = h;
  for (std::size_t i = 0; i < block.traits.points; ++i) {
    ImpactContact::Point& point = contact.points[i];
    point.x = block.x[i][lane];
    point.y = block.y[i][lane];
    point.closing = contact.parting_speed(point, first, second);
    gap[i] = bounce.separation[i][lane] + contact.shift_at(point, first, second);
    point.hits = point.closing < 0 && gap[i] + h * (point.closing - h * max_pull) < 0;
    if (!point.hits) continue;
    const double time = arrival(point.closing, gap[i], pull, h);
    if (point.closing + time * pull >= -data.constants.restitution_threshold) continue;
    bounces = point.bounces = true;
    contact.time = std::min(contact.time, time);
  }
  if (!bounces) return;
  ATL_ASSERT(!(contact.time < 0) && !(contact.time > h), b, lane, contact.time, h);
  // A body that is held is not put elsewhere, so it bounces where it is next to the surface: now, or as the
  // next substep begins.
  if (contact.time > 0.5 * h && (is_held(data, first) || is_held(data, second))) {
    hide(data, b, lane);
    return;
  }

  contact.pulled = pull * contact.time;
  contacts_.push_back(contact);
  if (!is_joined(contact)) complete(data, contacts_.back());
}

// Takes the bodies of a contact to the instant of their first impact, and finds how it is to be reflected.
void Impacts::complete(const ContactKernelData& data, ImpactContact& contact) {
  const std::uint32_t b = contact.block, lane = contact.lane;
  const ContactBlock& block = data.blocks[b];
  ImpactBody& first = bodies_[contact.first];
  ImpactBody& second = bodies_[contact.second];
  for (ImpactBody* body : {&first, &second}) {
    if (body->is_hit || !body->moves()) continue;
    body->is_hit = true;
    body->time = contact.time;
    tumble(body->time, *body);
  }
  contact.is_complete = true;
  std::tie(contact.arm_first, contact.arm_second) = arms_of(data, b * block_lanes + lane, first, second);
  const double restitution = data.bounces[b].restitution[lane];
  for (std::size_t i = 0; i < block.traits.points; ++i) {
    ImpactContact::Point& point = contact.points[i];
    if (!point.hits) continue;
    point.mass = contact.mass_of(point, first, second);
    ATL_ASSERT(!(point.mass < 0), b, lane, i, point.mass);
    point.closing = contact.parting_speed(point, first, second);
    if (!point.bounces) continue;
    point.parting = -restitution * std::min(point.closing + contact.pulled, 0.0) - contact.pulled;
  }
  ImpactContact::Friction& rubs = contact.friction;
  rubs.coefficient = block.friction[lane];
  rubs.radius = block.friction_radius[lane];
  for (std::size_t i = 0; i < 3; ++i) rubs.mass[i] = block.friction_mass[i][lane];
  rubs.twist_mass = block.twist_mass[lane];
  if (data.surface_blocks != nullptr) {
    const SurfaceBlock& surface = data.surface_blocks[b];
    rubs.runs = {surface.slip[0][lane], surface.slip[1][lane], surface.spin[2][lane]};
    rubs.torsional = surface.torsional_friction[0][lane];
    rubs.ellipse = {surface.cosine[0][lane], surface.sine[0][lane], surface.ratio[0][lane]};
  }
}

// Sorts contacts by what hangs together: bodies that can't move pass nothing on.
void Impacts::gather_sets() {
  sets_.resize(bodies_.size());
  std::iota(sets_.begin(), sets_.end(), 0u);
  const auto root = [&](std::uint32_t body) {
    while (sets_[body] != body) body = sets_[body] = sets_[sets_[body]];
    return body;
  };
  // One body stands for all that joints hold together.
  const auto one_of = [&](std::uint32_t body) {
    return bodies_[body].is_joined() ? systems_[bodies_[body].system].places().front() : body;
  };
  for (const ImpactContact& contact : contacts_) {
    if (!bodies_[contact.first].moves() || !bodies_[contact.second].moves()) continue;
    const std::uint32_t a = root(one_of(contact.first)), b = root(one_of(contact.second));
    sets_[std::max(a, b)] = std::min(a, b);
  }
  for (ImpactContact& contact : contacts_) {
    contact.set = root(one_of(bodies_[contact.first].moves() ? contact.first : contact.second));
  }
  // Then by their bodies, so that sums don't tell which blocks they are in: who shares a group must not show.
  const auto order = [&](const ImpactContact& contact) {
    return std::tuple(contact.set, bodies_[contact.first].local, bodies_[contact.second].local);
  };
  std::ranges::stable_sort(contacts_, {}, order);
}

void Impacts::store(const ContactKernelData& data, const Joints& joints) {
  for (ImpactBody& body : bodies_) {
    number_[body.local] = none;
    if (!body.bounces) continue;
    tumble(-body.time, body);
    BlowRows& blow = data.bodies.blow[body.local];
    add3(blow.linear, body.velocity - velocity_of(data.bodies, body.local));
    add3(blow.angular, body.spin - spin_of(data.bodies, body.local));
    set_uncarried(data.bodies, body.local, body.velocity, body.spin);
    if (is_held(data, body)) continue;
    add3(data.bodies.displacement[body.local].linear, body.shift);
    turn_on(data.bodies, body.local, body.turned);
  }
  for (const std::uint32_t number : hit_systems_) systems_[number].end(joints.input, bodies_);
}

}  // namespace atl::solver
