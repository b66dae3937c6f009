#include "view/film.h"

#include <atoll/world.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <limits>
#include <numeric>
#include <type_traits>
#include <utility>

#include "view/json_numbers.h"

namespace atl::view {
namespace {

constexpr std::uint32_t no_number = ~0u;

const char* kind_name(const JointKind& kind) {
  constexpr const char* names[] = {"ball",       "hinge",   "slider", "fixed", "distance", "universal",
                                   "cone-twist", "six-dof", "gear",   "wheel", "tendon"};
  static_assert(std::size(names) == std::variant_size_v<JointKind>);
  return names[kind.index()];
}

bool holds_a_point(const JointKind& kind) {
  return std::visit(
      []<typename Kind>(const Kind&) {
        return std::is_same_v<Kind, BallJoint> || std::is_same_v<Kind, HingeJoint> ||
               std::is_same_v<Kind, FixedJoint> || std::is_same_v<Kind, UniversalJoint> ||
               std::is_same_v<Kind, ConeTwistJoint>;
      },
      kind);
}

const char* type_name(BodyType type) {
  return type == BodyType::Static ? "static" : type == BodyType::Kinematic ? "kinematic" : "dynamic";
}

// Sets of numbers that are joined to each other, each named by its lowest.
class Joined {
 public:
  explicit Joined(std::size_t count) : lowest_(count) { std::iota(lowest_.begin(), lowest_.end(), 0u); }

  std::uint32_t lowest(std::uint32_t number) {
    while (lowest_[number] != number) number = lowest_[number] = lowest_[lowest_[number]];
    return number;
  }
  void join(std::uint32_t a, std::uint32_t b) {
    a = lowest(a);
    b = lowest(b);
    lowest_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<std::uint32_t> lowest_;
};

double default_precision(const World& world) {
  std::vector<double> reaches;
  for (const BodyId id : world.bodies()) {
    if (world.type(id) == BodyType::Dynamic) reaches.push_back(reach_of(world.definition(id).shape));
  }
  if (reaches.empty()) return std::exp2(-10);
  const auto middle = reaches.begin() + static_cast<std::ptrdiff_t>(reaches.size() / 2);
  std::nth_element(reaches.begin(), middle, reaches.end());
  return std::exp2(std::floor(std::log2(1e-3 * *middle)));
}

template <typename Of>
Json column(const std::vector<FilmFrame>& frames, const Of& of) {
  Json values = Json::array();
  for (const FilmFrame& frame : frames) values.push_back(of(frame));
  return values;
}

// Rounds a time or an error to the four digits that a page shows.
double short_number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", std::isfinite(value) ? value : 0);
  return std::strtod(text, nullptr);
}

Json frames_object(const std::vector<FilmFrame>& frames) {
  Json phases = Json::object();
  for (int phase = 0; phase < phase_count; ++phase) {
    phases[phase_name(static_cast<Phase>(phase))] =
        column(frames, [phase](const FilmFrame& frame) { return short_number(frame.phase_ms[phase]); });
  }
  return {{"step", column(frames, [](const FilmFrame& frame) { return frame.step; })},
          {"time", column(frames, [](const FilmFrame& frame) { return frame.time; })},
          {"ms", column(frames, [](const FilmFrame& frame) { return short_number(frame.ms); })},
          {"phase_ms", phases},
          {"overlap", column(frames, [](const FilmFrame& frame) { return short_number(frame.overlap); })},
          {"joint_gap", column(frames, [](const FilmFrame& frame) { return short_number(frame.joint_gap); })},
          {"contacts", column(frames, [](const FilmFrame& frame) { return frame.contacts; })},
          {"islands", column(frames, [](const FilmFrame& frame) { return frame.islands; })},
          {"asleep", column(frames, [](const FilmFrame& frame) { return frame.asleep; })}};
}

Json body_object(const FilmBody& body) {
  Json object = {{"id", {body.id.index, body.id.generation}}, {"shape", body.shape}, {"type", type_name(body.type)}};
  if (!body.name.empty()) object["name"] = body.name;
  if (body.type == BodyType::Dynamic) object["mass"] = number(body.mass);
  object["friction"] = body.material.friction;
  object["restitution"] = body.material.restitution;
  if (body.sensor) object["sensor"] = true;
  return object;
}

Json joint_object(const FilmJoint& joint) {
  return {{"id", {joint.id.index, joint.id.generation}},
          {"kind", joint.kind},
          {"first", joint.first},
          {"second", joint.second},
          {"anchor_first", numbers(joint.anchor_first)},
          {"anchor_second", numbers(joint.anchor_second)},
          {"from", joint.from},
          {"to", joint.to}};
}

void add_list(std::string& object, const char* name, const std::vector<std::string>& texts, const char* quote) {
  object += std::string(",\"") + name + "\":[";
  for (const std::string& text : texts) {
    if (&text != &texts.front()) object += ",";
    object += quote;
    object += text;
    object += quote;
  }
  object += "]";
}

}  // namespace

Film::Film(FilmOptions options)
    : options_(std::move(options)), clock_(options_.first_step, options_.stride), contacts_(options_.max_contacts) {}

void Film::add(const World& world, const StepReport& report, double dt) {
  if (clock_.tick(dt)) add_frame(world, &report);
}

void Film::add_frame(const World& world, const StepReport* report) {
  if (frames_.empty()) precision_ = options_.precision.value_or(default_precision(world));
  FilmFrame frame{.step = clock_.step(), .time = clock_.time()};
  if (report != nullptr) {
    frame.ms = report->ms;
    frame.phase_ms = report->phase_ms;
    frame.contacts = report->counts.contacts;
    frame.islands = report->counts.islands;
    frame.asleep = report->counts.asleep;
  }
  contacts_.begin_frame(precision_);
  const std::vector<BodyId> ids = world.bodies();
  number_bodies(world, ids);
  sights_.assign(bodies_.size(), {});
  record_bodies(world, ids);
  record_joints(world, frame);
  record_forces(world, frame);
  if (!contacts_.end()) record_contacts(world);
  chunks_.add_frame(sights_, precision_);
  contacts_.end_frame(FilmChunks::max_frames);
  frames_.push_back(frame);
}

// Numbers the bodies that are new. Each is shown in the shape that it had when it came.
void Film::number_bodies(const World& world, const std::vector<BodyId>& ids) {
  for (const BodyId id : ids) {
    if (numbers_.size() <= id.index) numbers_.resize(id.index + 1, no_number);
    std::uint32_t& number = numbers_[id.index];
    if (number != no_number && bodies_[number].id == id) continue;
    number = static_cast<std::uint32_t>(bodies_.size());
    const BodyDef def = world.definition(id);
    bodies_.push_back({.id = id,
                       .name = def.name,
                       .shape = shapes_.number_of(def.shape),
                       .type = def.type,
                       .mass = world.mass(id),
                       .material = def.material,
                       .sensor = def.sensor});
  }
}

void Film::record_bodies(const World& world, const std::vector<BodyId>& ids) {
  const Eigen::Matrix3Xd origins = world.origins();
  const Eigen::Map<const Eigen::Matrix4Xd> turns = world.orientations();
  for (const BodyId id : ids) {
    BodySight& sight = sights_[numbers_[id.index]];
    sight.pose.position = origins.col(id.index);
    sight.pose.orientation.coeffs() = turns.col(id.index);
    sight.flags = body_present;
    if (world.is_asleep(id)) sight.flags |= body_asleep;
  }
  for (const Quarantined& out : world.quarantined()) sights_[numbers_[out.id.index]].flags |= body_quarantined;
}

void Film::record_joints(const World& world, FilmFrame& frame) {
  std::map<JointId, std::size_t> present;
  for (const JointId id : world.joints()) {
    const JointState state = world.joint_state(id);
    if (!state.enabled) continue;
    const JointDef& def = world.joint(id);
    if (std::holds_alternative<TendonJoint>(def.kind)) continue;  // which is nowhere
    const auto known = present_joints_.find(id);
    if (known != present_joints_.end()) {
      present.insert(*known);
    } else {
      present.emplace(id, joints_.size());
      joints_.push_back({.id = id,
                         .kind = kind_name(def.kind),
                         .first = numbers_[def.first.index],
                         .second = numbers_[def.second.index],
                         .anchor_first = def.frame_first.position,
                         .anchor_second = def.frame_second.position,
                         .from = frames_.size()});
    }
    joints_[present[id]].to = frames_.size() + 1;
    if (!holds_a_point(def.kind)) continue;
    const auto place = [&](BodyId body, const Pose& at) {
      const Pose& pose = sights_[numbers_[body.index]].pose;
      return Vector3(pose.position + pose.orientation * at.position);
    };
    const double gap = (place(def.second, def.frame_second) - place(def.first, def.frame_first)).norm();
    frame.joint_gap = std::max(frame.joint_gap, gap);
  }
  present_joints_ = std::move(present);
}

// Records the forces on bodies, and the islands that follow: bodies that press on each other or are joined.
void Film::record_forces(const World& world, FilmFrame& frame) {
  Joined joined(bodies_.size());
  const auto moves = [&](std::uint32_t number) { return bodies_[number].type == BodyType::Dynamic; };
  std::vector<std::uint8_t> in_island(bodies_.size(), 0);
  const auto link = [&](std::uint32_t a, std::uint32_t b) {
    in_island[a] = moves(a);
    in_island[b] = moves(b);
    if (moves(a) && moves(b)) joined.join(a, b);
  };
  for (const PairForce& pair : world.pair_forces()) {
    const std::uint32_t a = numbers_[pair.a.index], b = numbers_[pair.b.index];
    sights_[a].force += pair.normal_force;
    sights_[b].force += pair.normal_force;
    frame.overlap = std::max(frame.overlap, -pair.separation);
    link(a, b);
  }
  for (const auto& [id, place] : present_joints_) link(joints_[place].first, joints_[place].second);
  std::map<std::uint32_t, std::uint8_t> solves;
  for (const SolverChoice& island : world.solver_choices()) {
    if (!world.contains(island.lowest) || *island.why_not != 0) continue;
    solves[numbers_[island.lowest.index]] = island.direct ? body_direct : body_refined;
  }
  for (std::uint32_t number = 0; number < bodies_.size(); ++number) {
    if (in_island[number] == 0) continue;
    const std::uint32_t lowest = joined.lowest(number);
    sights_[number].island = lowest + 1;
    if (const auto solve = solves.find(lowest); solve != solves.end()) sights_[number].flags |= solve->second;
  }
}

void Film::record_contacts(const World& world) {
  const std::span<const ContactForce> points = world.contact_forces();
  if (!contacts_.takes(points.size())) return;
  for (const ContactForce& point : points) {
    contacts_.add(numbers_[point.a.index], numbers_[point.b.index], point.position, point.normal, point.normal_force);
  }
}

std::string Film::text() {
  Json bodies = Json::array(), joints = Json::array();
  for (const FilmBody& body : bodies_) bodies.push_back(body_object(body));
  for (const FilmJoint& joint : joints_) joints.push_back(joint_object(joint));
  Json film = {{"name", options_.name},
               {"place", options_.place},
               {"related", {{"text", options_.related.text}, {"address", options_.related.address}}},
               {"precision", precision_},
               {"turn_units", FilmChunks::turn_units},
               {"chunk_frames", FilmChunks::max_frames},
               {"bodies", std::move(bodies)},
               {"joints", std::move(joints)},
               {"frames", frames_object(frames_)}};
  if (contacts_.end()) film["contacts_end"] = *contacts_.end();
  std::string text = film.dump(-1, ' ', true, Json::error_handler_t::replace);
  text.pop_back();
  // These texts are JSON already, or have nothing in them that JSON would escape.
  add_list(text, "shapes", shapes_.texts(), "");
  add_list(text, "chunks", chunks_.finish(), "\"");
  add_list(text, "contact_chunks", contacts_.finish(), "\"");
  return text += "}";
}

}  // namespace atl::view
