// Scenes as text: what schema.h reads.

#include <atoll/scene.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>
#include <string>
#include <utility>

namespace atl {
namespace scene {
namespace {

using Json = nlohmann::ordered_json;

Json json(const Vector3& v) { return {v.x(), v.y(), v.z()}; }
Json json(const Quaternion& q) { return {q.x(), q.y(), q.z(), q.w()}; }

// More than a double holds go as text.
Json json(std::uint64_t value) {
  if (value <= std::uint64_t{1} << 53) return value;
  return std::to_string(value);
}

// Zero to the bit, so that what is read again is the same: -0 is another number.
bool is_nothing(const Vector3& v) {
  return std::none_of(v.begin(), v.end(), [](double x) { return x != 0 || std::signbit(x); });
}

void put(Json& out, const char* key, const std::optional<double>& value) {
  if (value) out[key] = *value;
}
void put_unless_zero(Json& out, const char* key, const Vector3& value) {
  if (!is_nothing(value)) out[key] = json(value);
}

template <typename Enum, std::size_t count>
const char* name(Enum value, const std::array<const char*, count>& names) {
  return names[static_cast<std::size_t>(value)];
}

Json json(const ErrorTarget& target) {
  Json out = Json::object();
  put(out, "penetration", target.penetration);
  put(out, "joint_gap", target.joint_gap);
  put(out, "residual", target.residual);
  put(out, "motion", target.motion);
  out["min_substeps"] = target.min_substeps;
  out["max_substeps"] = target.max_substeps;
  return out;
}

Json json(const Settings& settings) {
  constexpr std::array solvers = {"auto", "iterative", "direct"};
  Json out = {{"substeps", settings.substeps},
              {"iterations", settings.iterations},
              {"relax_iterations", settings.relax_iterations},
              {"tolerance", settings.tolerance},
              {"friction", name(settings.friction, std::array{"cone", "pyramid"})},
              {"warm_starting", settings.warm_starting},
              {"stabilisation", name(settings.stabilisation, std::array{"soft", "baumgarte", "split_impulse"})},
              {"correction", settings.correction},
              {"slop", settings.slop}};
  if (settings.target.is_set()) out["target"] = json(settings.target);
  put(out, "contact_hertz", settings.contact_hertz);
  out["contact_damping_ratio"] = settings.contact_damping_ratio;
  out["contact_push_speed"] = settings.contact_push_speed;
  put(out, "restitution_threshold", settings.restitution_threshold);
  out["contact_solver"] = name(settings.contact_solver, solvers);
  out["joint_solver"] = name(settings.joint_solver, solvers);
  put(out, "joint_hertz", settings.joint_hertz);
  out["joint_damping_ratio"] = settings.joint_damping_ratio;
  out["sleeping"] = settings.sleeping;
  out["sleep_speed"] = settings.sleep_speed;
  out["time_to_sleep"] = settings.time_to_sleep;
  return out;
}

Json json(const Material& material) {
  constexpr std::array rules = {"default", "average", "geometric_mean", "min", "multiply", "max"};
  Json out = {{"friction", material.friction},
              {"restitution", material.restitution},
              {"rolling_friction", material.rolling_friction},
              {"torsional_friction", material.torsional_friction}};
  if (material.friction_rule != CombineRule::Default) out["friction_rule"] = name(material.friction_rule, rules);
  if (material.restitution_rule != CombineRule::Default)
    out["restitution_rule"] = name(material.restitution_rule, rules);
  if (material.is_directed()) {
    out["friction_direction"] = Json(material.friction_direction);
    out["friction_across"] = material.friction_across;
  }
  if (material.id != 0) out["id"] = json(material.id);
  return out;
}

Json json(const MaterialPair& pair) {
  Json out = {{"first", json(pair.first)}, {"second", json(pair.second)}};
  if (pair.friction) out["friction"] = *pair.friction;
  if (pair.friction_across) out["friction_across"] = *pair.friction_across;
  if (pair.restitution) out["restitution"] = *pair.restitution;
  return out;
}

Json json(const CollisionFilter& filter) {
  return {{"category", filter.category}, {"mask", filter.mask}, {"group", filter.group}};
}

template <typename Round>
Json round(const char* type, const Round& shape) {
  return {{"type", type}, {"radius", shape.radius}, {"half_height", shape.half_height}};
}

// Numbers of the materials of triangles or cells.
void put_numbers(Json& out, std::span<const std::uint8_t> numbers) {
  if (!numbers.empty()) out["materials"] = std::vector<int>(numbers.begin(), numbers.end());
}

Json points(std::span<const Vector3> all) {
  Json out = Json::array();
  for (const Vector3& point : all) out.push_back(json(point));
  return out;
}

struct ShapeWriter {
  Json operator()(const Box& box) const { return {{"type", "box"}, {"half_extents", json(box.half_extents)}}; }
  Json operator()(const Sphere& sphere) const { return {{"type", "sphere"}, {"radius", sphere.radius}}; }
  Json operator()(const Capsule& shape) const { return round("capsule", shape); }
  Json operator()(const Cylinder& shape) const { return round("cylinder", shape); }
  Json operator()(const Cone& shape) const { return round("cone", shape); }
  Json operator()(const Ellipsoid& shape) const {
    return {{"type", "ellipsoid"}, {"half_axes", json(shape.half_axes)}};
  }
  Json operator()(const TaperedCapsule& shape) const {
    return {{"type", "tapered_capsule"}, {"radii", shape.radii}, {"half_height", shape.half_height}};
  }
  Json operator()(const HalfSpace& half_space) const {
    return {{"type", "half_space"}, {"normal", json(half_space.normal)}, {"offset", half_space.offset}};
  }
  Json operator()(const ConvexHull& hull) const { return {{"type", "hull"}, {"points", points(hull.vertices())}}; }
  Json operator()(const TriangleMesh& mesh) const {
    Json out = {{"type", "mesh"}, {"vertices", points(mesh.vertices())}, {"triangles", Json::array()}};
    for (const TriangleMesh::Indices& corners : mesh.triangles()) out["triangles"].push_back(corners);
    out["smooth_angle"] = mesh.smooth_angle();
    put_numbers(out, mesh.materials());
    return out;
  }
  Json operator()(const HeightField& field) const {
    Json rows = Json::array();
    for (std::size_t row = 0; row < field.rows(); ++row) {
      Json& heights = rows.emplace_back(Json::array());
      for (const double height : field.heights().subspan(row * field.columns(), field.columns())) {
        heights.push_back(std::isnan(height) ? Json() : Json(height));  // null for a hole
      }
    }
    Json out = {{"type", "height_field"},
                {"heights", std::move(rows)},
                {"spacing", {field.spacing_x(), field.spacing_y()}},
                {"smooth", field.smooth()}};
    put_numbers(out, field.materials());
    return out;
  }
  Json operator()(const Compound& compound) const {
    Json children = Json::array();
    for (const CompoundChild& child : compound.children) {
      Json out = {{"shape", std::visit(*this, child.shape)},
                  {"position", json(child.position)},
                  {"orientation", json(child.orientation)},
                  {"density_factor", child.density_factor}};
      if (child.material) out["material"] = json(*child.material);
      if (child.filter) out["filter"] = json(*child.filter);
      children.push_back(std::move(out));
    }
    return {{"type", "compound"}, {"children", std::move(children)}};
  }
};

Json json(const MotionLocks& locks) {
  constexpr std::array names = {"x", "y", "z"};
  Json linear = Json::array(), angular = Json::array();
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (locks.linear[axis]) linear.push_back(names[axis]);
    if (locks.angular[axis]) angular.push_back(names[axis]);
  }
  return {{"linear", std::move(linear)}, {"angular", std::move(angular)}};
}

// Writes the properties that only dynamic bodies may have.
void put_dynamics(Json& out, const SceneBody& body) {
  const BodyDef& def = body.def;
  if (def.mass) {
    out["mass"] = *def.mass;
  } else {
    out["density"] = def.density;
  }
  if (def.inertia) {
    const Matrix3& m = *def.inertia;
    out["inertia"] = {m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(0, 2), m(1, 2)};
  }
  if (def.centre_of_mass) out["centre_of_mass"] = json(*def.centre_of_mass);
  if (def.gravity_scale != 1) out["gravity_scale"] = def.gravity_scale;
  if (def.linear_damping != 0) out["linear_damping"] = def.linear_damping;
  if (def.angular_damping != 0) out["angular_damping"] = def.angular_damping;
  if (def.locks != MotionLocks{}) out["locks"] = json(def.locks);
  put(out, "max_speed", def.max_speed);
  put(out, "max_angular_speed", def.max_angular_speed);
  if (!def.awake) out["awake"] = false;
  if (!def.may_sleep) out["may_sleep"] = false;
  put_unless_zero(out, "force", body.force);
}

Json json(const SceneBody& body) {
  const BodyDef& def = body.def;
  Json out = Json::object();
  if (!body.name.empty()) out["name"] = body.name;
  if (def.type != BodyType::Dynamic) out["type"] = def.type == BodyType::Static ? "static" : "kinematic";
  out["shape"] = std::visit(ShapeWriter{}, def.shape);
  if (def.material != Material{}) out["material"] = json(def.material);
  for (const Material& material : def.materials) out["materials"].push_back(json(material));
  out["position"] = json(def.position);
  if (!is_nothing(def.orientation.vec()) || def.orientation.w() < 0) out["orientation"] = json(def.orientation);
  put_unless_zero(out, "velocity", def.velocity);
  put_unless_zero(out, "angular_velocity", def.angular_velocity);
  put_unless_zero(out, "surface_velocity", def.surface_velocity);
  put_unless_zero(out, "surface_angular_velocity", def.surface_angular_velocity);
  if (def.type == BodyType::Dynamic) put_dynamics(out, body);
  if (def.filter != CollisionFilter{}) out["filter"] = json(def.filter);
  if (def.continuous) out["continuous"] = true;
  if (def.sensor) out["sensor"] = true;
  if (def.notices_static) out["notices_static"] = true;
  if (def.notices_sensors) out["notices_sensors"] = true;
  put(out, "contact_event_force", def.contact_event_force);
  if (def.user_data != 0) out["user_data"] = json(def.user_data);
  return out;
}

Json json(const JointAxis& axis) {
  Json out = Json::object();
  const bool from = axis.range.lower != -unlimited, to = axis.range.upper != unlimited;
  if (from && to) {
    out["range"] = {axis.range.lower, axis.range.upper};
  } else if (from) {
    out["lower"] = axis.range.lower;
  } else if (to) {
    out["upper"] = axis.range.upper;
  }
  if (axis.range.restitution != 0) out["restitution"] = axis.range.restitution;
  if (axis.spring) {
    Json& spring = out["spring"] = {{"rest", axis.spring->rest}};
    put(spring, "stiffness", axis.spring->stiffness);
    put(spring, "damping", axis.spring->damping);
    if (!axis.spring->is_linear()) {
      spring["hertz"] = axis.spring->hertz;
      spring["damping_ratio"] = axis.spring->damping_ratio;
    }
  }
  if (axis.motor) {
    Json& motor = out["motor"] = {{"speed", axis.motor->speed}};
    const double force = axis.motor->max_force.value_or(0);
    motor["max_force"] = force == unlimited ? Json("unlimited") : Json(force);
    if (const auto& servo = axis.motor->servo) {
      motor["servo"] = {{"target", servo->target}, {"stiffness", servo->stiffness}, {"damping", servo->damping}};
    }
  }
  if (axis.armature != 0) out["armature"] = axis.armature;
  if (axis.friction != 0) out["friction"] = axis.friction;
  return out;
}

Json json(const std::array<JointAxis, 3>& axes) { return {json(axes[0]), json(axes[1]), json(axes[2])}; }

// The keys that a kind of joint has of its own.
struct KindWriter {
  Json operator()(const BallJoint& ball) const {
    Json out = {{"kind", "ball"}, {"friction", ball.friction}};
    if (!ball.servo) return out;
    Json& servo = out["servo"] = {{"stiffness", ball.servo->stiffness}, {"damping", ball.servo->damping}};
    servo["target"] = json(ball.servo->target);
    servo["angular_velocity"] = json(ball.servo->angular_velocity);
    if (ball.servo->max_torque != unlimited) servo["max_torque"] = ball.servo->max_torque;
    return out;
  }
  Json operator()(const HingeJoint& hinge) const { return {{"kind", "hinge"}, {"angle", json(hinge.angle)}}; }
  Json operator()(const SliderJoint& slider) const { return {{"kind", "slider"}, {"offset", json(slider.offset)}}; }
  Json operator()(const FixedJoint&) const { return {{"kind", "fixed"}}; }
  Json operator()(const DistanceJoint& rod) const { return {{"kind", "distance"}, {"distance", json(rod.distance)}}; }
  Json operator()(const UniversalJoint& cross) const {
    return {{"kind", "universal"}, {"angle_first", json(cross.first)}, {"angle_second", json(cross.second)}};
  }
  Json operator()(const ConeTwistJoint& cone) const {
    Json out = {{"kind", "cone_twist"}, {"twist", json(cone.twist)}, {"swing_friction", cone.swing_friction}};
    if (cone.swing_limit != unlimited) out["swing_limit"] = cone.swing_limit;
    return out;
  }
  Json operator()(const SixDofJoint& six) const {
    Json out = {{"kind", "six_dof"}, {"offset", json(six.offset)}, {"turn", json(six.turn)}};
    out["turns"] = std::array{"vector", "angles_xyz", "angles_xzy"}.at(static_cast<std::size_t>(six.turns));
    return out;
  }
  Json operator()(const GearJoint& gear) const {
    return {{"kind", "gear"}, {"ratio", gear.ratio}, {"rack", gear.rack}};
  }
  Json operator()(const WheelJoint& wheel) const {
    return {{"kind", "wheel"},
            {"suspension", json(wheel.suspension)},
            {"steering", json(wheel.steering)},
            {"spin", json(wheel.spin)}};
  }
  Json operator()(const TendonJoint& tendon) const { return {{"kind", "tendon"}, {"length", json(tendon.length)}}; }
};

Json terms_of(const SceneJoint& joint, const TendonJoint& tendon) {
  Json terms = Json::array();
  for (std::size_t i = 0; i < tendon.terms.size(); ++i) {
    const TendonTerm& term = tendon.terms[i];
    terms.push_back(
        {{"joint", joint.terms.at(i)}, {"coordinate", term.coordinate}, {"polynomial", Json(term.polynomial)}});
  }
  return terms;
}

Json json(const Pose& frame) { return {{"position", json(frame.position)}, {"orientation", json(frame.orientation)}}; }

Json json(const SceneJoint& joint) {
  const JointDef& def = joint.def;
  Json out = std::visit(KindWriter{}, def.kind);
  if (!joint.name.empty()) out["name"] = joint.name;
  if (const auto* tendon = std::get_if<TendonJoint>(&def.kind)) {
    out["terms"] = terms_of(joint, *tendon);
  } else {
    out["first"] = joint.first;
    out["second"] = joint.second;
    out["frame_first"] = json(def.frame_first);
    out["frame_second"] = json(def.frame_second);
    if (def.collide) out["collide"] = true;
  }
  if (def.break_force != unlimited) out["break_force"] = def.break_force;
  if (def.break_torque != unlimited) out["break_torque"] = def.break_torque;
  if (def.user_data != 0) out["user_data"] = json(def.user_data);
  return out;
}

// Names of bodies, or joints, in files are each one's own: those that come again are left out.
template <typename Part>
Json parts(const std::vector<Part>& all) {
  Json out = Json::array();
  std::set<std::string> names;
  for (const Part& part : all) {
    out.push_back(json(part));
    if (!part.name.empty() && !names.insert(part.name).second) out.back().erase("name");
  }
  return out;
}

// Finds the first number that JSON can't express: its pointer, and its value.
std::optional<std::pair<std::string, double>> find_non_finite(const Json& value) {
  if (value.is_number_float() && !std::isfinite(value.get<double>())) return std::pair("", value.get<double>());
  if (!value.is_structured()) return std::nullopt;
  for (auto part = value.begin(); part != value.end(); ++part) {
    const auto found = find_non_finite(*part);
    if (!found) continue;
    const std::string key = value.is_array() ? std::to_string(part - value.begin()) : part.key();
    return std::pair("/" + key + found->first, found->second);
  }
  return std::nullopt;
}

void check_finite(const Json& value, const std::string& pointer) {
  const auto found = find_non_finite(value);
  if (!found) return;
  throw SceneError("scene_text: " + pointer + found->first + " is " + std::to_string(found->second) +
                   "; expected a finite number, as scene files hold no others");
}

}  // namespace
}  // namespace scene

std::string settings_text(const Settings& settings) {
  const scene::Json out = scene::json(settings);
  scene::check_finite(out, "/settings");
  return out.dump(2);
}

std::string scene_text(const Scene& scene) {
  using namespace scene;
  Json out = {{"format", "atoll-scene"}, {"version", 1}};
  if (!scene.name.empty()) out["name"] = scene.name;
  out["gravity"] = json(scene.gravity);
  out["dt"] = scene.dt;
  out["steps"] = scene.steps;
  if (scene.starts_at_rest) out["starts_at_rest"] = true;
  out["settings"] = json(scene.settings);
  for (const MaterialPair& pair : scene.material_pairs) out["material_pairs"].push_back(json(pair));
  // A line each for bodies and joints: files of thousands of them are still read by people, and compared line by line.
  check_finite(out, "");
  std::string text = out.dump(2);
  text.resize(text.size() - 2);
  const auto add = [&text](const char* key, const Json& all) {
    if (all.empty()) return;
    check_finite(all, std::string("/") + key);
    text += std::string(",\n  \"") + key + "\": [";
    const char* separator = "\n    ";
    for (const Json& part : all) {
      text += separator + part.dump();
      separator = ",\n    ";
    }
    text += "\n  ]";
  };
  add("bodies", parts(scene.bodies));
  add("joints", parts(scene.joints));
  return text + "\n}\n";
}

void write_scene(const Scene& scene, const std::string& path) {
  const std::string text = scene_text(scene);
  const std::string beside = path + ".partial";
  std::ofstream out(beside, std::ios::binary);
  out << text;
  out.close();
  std::error_code error;
  if (out) std::filesystem::rename(beside, path, error);
  if (out && !error) return;
  std::filesystem::remove(beside, error);
  throw SceneError(path + ": the scene can't be written there, expected a place for a file");
}

}  // namespace atl
