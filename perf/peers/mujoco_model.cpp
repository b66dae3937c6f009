#include "mujoco_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <initializer_list>
#include <memory>
#include <span>

namespace peer {
namespace {

constexpr int rows_per_contact = 4;  // of a pyramid with two tangents; a cone has three
// A moving kinematic body is one of this many times the mass of the heaviest dynamic one.
constexpr double kinematic_mass_ratio = 1e9;

std::string numbers(std::initializer_list<double> values) {
  std::string text;
  for (const double value : values) {
    std::array<char, 32> digits;
    std::snprintf(digits.data(), digits.size(), "%.17g ", value);
    text += digits.data();
  }
  return text;
}

std::string attribute(const char* name, std::initializer_list<double> values) {
  return std::string(" ") + name + "=\"" + numbers(values) + "\"";
}

std::string place(const atl::Pose& pose) {
  const atl::Vector3& p = pose.position;
  const atl::Quaternion& q = pose.orientation;
  return attribute("pos", {p.x(), p.y(), p.z()}) + attribute("quat", {q.w(), q.x(), q.y(), q.z()});
}

// The attributes of a geom: its type, size and asset. The asset is appended.
struct GeomText {
  std::string& assets;
  std::vector<std::vector<float>>& heights;
  std::string name;  // for an asset
  atl::Pose pose;    // of the part; a shape may change it to that of MuJoCo's frame

  std::string operator()(const atl::Box& box) {
    const atl::Vector3& h = box.half_extents;
    return " type=\"box\"" + attribute("size", {h.x(), h.y(), h.z()});
  }
  std::string operator()(const atl::Sphere& sphere) { return " type=\"sphere\"" + attribute("size", {sphere.radius}); }
  std::string operator()(const atl::Capsule& capsule) {
    return " type=\"capsule\"" + attribute("size", {capsule.radius, capsule.half_height});
  }
  std::string operator()(const atl::Cylinder& cylinder) {
    return " type=\"cylinder\"" + attribute("size", {cylinder.radius, cylinder.half_height});
  }
  std::string operator()(const atl::Ellipsoid& ellipsoid) {
    const atl::Vector3& a = ellipsoid.half_axes;
    return " type=\"ellipsoid\"" + attribute("size", {a.x(), a.y(), a.z()});
  }

  std::string operator()(const atl::HalfSpace& half_space) {
    const atl::Vector3 normal = half_space.normal.normalized();
    const atl::Quaternion turn(Eigen::Quaterniond::FromTwoVectors(atl::Vector3::UnitZ(), normal));
    pose = pose * atl::Pose{half_space.offset * normal, turn};
    return " type=\"plane\" size=\"0 0 1\"";
  }

  std::string operator()(const atl::ConvexHull& hull) {
    assets += "<mesh name=\"" + name + "\" vertex=\"";
    for (const atl::Vector3& v : hull.vertices()) assets += numbers({v.x(), v.y(), v.z()});
    assets += "\"/>\n";
    return " type=\"mesh\" mesh=\"" + name + "\"";
  }

  // MuJoCo's are centred in x and y and start at the lowest sample; it takes heights as shares of the highest.
  std::string operator()(const atl::HeightField& field) {
    const auto samples = field.heights();
    const auto [low, high] = std::minmax_element(samples.begin(), samples.end());
    const double rise = std::max(*high - *low, 1e-6), thickness = 1;
    std::vector<float>& shares = heights.emplace_back();
    for (const double height : samples) shares.push_back(static_cast<float>((height - *low) / rise));
    const double half_x = (field.columns() - 1) * field.spacing_x() / 2;
    const double half_y = (field.rows() - 1) * field.spacing_y() / 2;
    assets += "<hfield name=\"" + name + "\" nrow=\"" + std::to_string(field.rows()) + "\" ncol=\"" +
              std::to_string(field.columns()) + "\"" + attribute("size", {half_x, half_y, rise, thickness}) + "/>\n";
    pose = pose * atl::Pose{.position = {half_x, half_y, *low}};
    return " type=\"hfield\" hfield=\"" + name + "\"";
  }

  std::string operator()(const atl::Cone&) { throw atl::Error("MuJoCo has no cones"); }
  std::string operator()(const atl::TaperedCapsule&) { throw atl::Error("MuJoCo has no tapered capsules"); }
  std::string operator()(const atl::TriangleMesh&) {
    throw atl::Error("MuJoCo has no triangle meshes: it takes a mesh for its convex hull");
  }
  std::string operator()(const atl::Compound&) { throw atl::Error("the MuJoCo driver found a compound in a compound"); }
};

std::string options_text(const atl::Scene& scene, const Setting& setting, const MujocoOptions& options) {
  const double dt = scene.dt / setting.substeps;
  const atl::Vector3& g = scene.gravity;
  std::string text = "<compiler angle=\"radian\" inertiafromgeom=\"false\"/>\n<option" + attribute("timestep", {dt}) +
                     attribute("gravity", {g.x(), g.y(), g.z()}) + attribute("impratio", {options.impratio}) +
                     " iterations=\"" + std::to_string(setting.iterations) + "\" cone=\"" + options.cone +
                     "\" solver=\"" + options.solver + "\" integrator=\"" + options.integrator + "\">" +
                     (options.multiccd ? "<flag multiccd=\"enable\"/>" : "") + "</option>\n";
  if (options.stiff) {
    const std::string time = attribute("solref", {2 * dt, 1});
    text += "<default><geom" + time + " solimp=\"0.99 0.999 0.001\"/><equality" + time +
            " solimp=\"0.9999 0.9999 0.001\"/></default>\n";
  }
  return text;
}

std::string body_name(std::size_t i) { return "b" + std::to_string(i); }

const MujocoOptions& find_options(const std::string& name) {
  const auto& variants = mujoco_variants();
  return *std::find_if(variants.begin(), variants.end(), [&](const MujocoOptions& each) { return each.name == name; });
}

void check(const atl::Scene& scene) {
  for (const atl::SceneBody& body : scene.bodies) {
    const double restitution = body.def.material.restitution;
    if (restitution > 0) {
      throw atl::Error("MuJoCo has no restitution: found " + std::to_string(restitution) + ", expected 0");
    }
  }
}

}  // namespace

const std::vector<MujocoOptions>& mujoco_variants() {
  static const std::vector<MujocoOptions> variants = {
      {.name = "pyramidal"},
      {.name = "elliptic", .cone = "elliptic"},
      {.name = "implicit", .integrator = "implicit"},
      {.name = "rk4", .integrator = "RK4"},
      {.name = "cg", .solver = "CG"},
      {.name = "pgs", .solver = "PGS"},
      {.name = "multiccd", .multiccd = true},
      {.name = "stiff", .stiff = true},
      {.name = "elliptic-stiff", .cone = "elliptic", .stiff = true, .impratio = 10},
  };
  return variants;
}

MujocoScene::MujocoScene(const atl::Scene& scene, const Setting& setting)
    : scene_(scene), options_(options_text(scene, setting, find_options(setting.variant))) {
  check(scene);
  double heaviest = 0;
  for (const atl::SceneBody& body : scene.bodies) {
    solids_.push_back(make_solid(body.def));
    heaviest = std::max({heaviest, solids_.back().mass, solids_.back().moments.maxCoeff()});
  }
  balls_ = balls_of(scene, solids_, "MuJoCo");
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (moves(i)) moving_.push_back(i);
  }
  stack_size(0);  // throws before the pairs of too many bodies are looked at
  find_pairs_apart();
  // A fixed body that an exclusion or a joint names becomes a body of the model, after the moving ones. All others
  // become geoms of the world body; MuJoCo numbers these first.
  std::vector<bool> named(scene.bodies.size());
  for (const auto& [a, b] : apart_) named[a] = named[b] = true;
  for (const Ball& ball : balls_) named[ball.first] = named[ball.second] = true;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (!moves(i) && !named[i]) add_geoms(i, world_);
  }
  for (const std::size_t i : moving_) {
    const atl::BodyDef& def = scene.bodies[i].def;
    const Solid& solid = solids_[i];
    const atl::Vector3& moments = solid.moments;
    world_ += "<body name=\"" + body_name(i) + "\"" + place(solid.pose) + ">";
    if (def.type == atl::BodyType::Dynamic) {
      world_ += "<freejoint/><inertial pos=\"0 0 0\"" + attribute("mass", {solid.mass}) +
                attribute("diaginertia", {moments.x(), moments.y(), moments.z()}) + "/>\n";
    } else {
      world_ += "<joint type=\"free\"" + attribute("armature", {kinematic_mass_ratio * std::max(heaviest, 1.0)}) +
                "/><inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/>\n";
    }
    add_geoms(i, world_);
    world_ += "</body>\n";
  }
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (moves(i) || !named[i]) continue;
    world_ += "<body name=\"" + body_name(i) + "\">";
    add_geoms(i, world_);
    world_ += "</body>\n";
  }
  add_joints();
}

bool MujocoScene::moves(std::size_t body) const {
  const atl::BodyDef& def = scene_.bodies[body].def;
  return def.type == atl::BodyType::Dynamic || is_moving_kinematic(def);
}

void MujocoScene::find_pairs_apart() {
  const std::size_t count = scene_.bodies.size();
  const atl::MayTouch may_touch = exceptions_to_touch(scene_);
  touches_.assign(count, !may_touch);
  if (!may_touch) return;
  const auto matters = [&](std::size_t a, std::size_t b) {
    return scene_.bodies[a].def.type == atl::BodyType::Dynamic || scene_.bodies[b].def.type == atl::BodyType::Dynamic;
  };
  for (std::size_t a = 0; a < count; ++a) {
    for (std::size_t b = a + 1; b < count; ++b) {
      if (matters(a, b) && may_touch(a, b)) touches_[a] = touches_[b] = true;
    }
  }
  for (std::size_t a = 0; a < count; ++a) {
    for (std::size_t b = a + 1; b < count; ++b) {
      if (matters(a, b) && touches_[a] && touches_[b] && !may_touch(a, b)) apart_.emplace_back(a, b);
    }
  }
}

void MujocoScene::add_joints() {
  joints_ += "<contact>\n";
  for (const auto& [a, b] : apart_) {
    joints_ += "<exclude body1=\"" + body_name(a) + "\" body2=\"" + body_name(b) + "\"/>\n";
  }
  joints_ += "</contact>\n<equality>\n";
  for (const Ball& ball : balls_) {
    joints_ += "<connect body1=\"" + body_name(ball.first) + "\" body2=\"" + body_name(ball.second) +
               "\" anchor=\"0 0 0\"/>\n";
  }
  joints_ += "</equality>\n";
}

void MujocoScene::add_geoms(std::size_t body, std::string& xml) {
  const atl::BodyDef& def = scene_.bodies[body].def;
  const Solid& solid = solids_[body];
  for (std::size_t k = 0; k < solid.parts.size(); ++k) {
    const Part& part = solid.parts[k];
    GeomText text{assets_, heights_, "s" + std::to_string(body) + "_" + std::to_string(k),
                  moves(body) ? part.pose : solid.pose * part.pose};
    const std::string shape = std::visit(text, part.shape);
    // Static and kinematic bodies collide with dynamic bodies only, so they get no category of their own.
    const char* category = touches_[body] && def.type == atl::BodyType::Dynamic ? "1" : "0";
    const char* others = touches_[body] ? "1" : "0";
    xml += "<geom" + shape + place(text.pose) + attribute("friction", {def.material.friction, 0, 0}) +
           " condim=\"3\" conaffinity=\"" + others + "\" contype=\"" + category + "\"/>\n";
    owners_.push_back(body);
  }
}

double MujocoScene::constraint_rows(int contacts) const {
  return rows_per_contact * static_cast<double>(contacts) + 3.0 * static_cast<double>(balls_.size());
}

int MujocoScene::max_contacts() const {
  // With n rows and v degrees of freedom: 24 n v + 12 n^2 bytes.
  constexpr double max_bytes = 1.8e9;
  const double v = 6.0 * static_cast<double>(moving_.size());
  const double rows = std::sqrt(v * v + max_bytes / 12) - v - constraint_rows(0);
  return static_cast<int>(std::max(rows, 0.0) / rows_per_contact);
}

double MujocoScene::stack_size(int contacts) const {
  const double rows = constraint_rows(contacts);
  const double freedoms = 6.0 * static_cast<double>(moving_.size());
  const double stack = 1e6 + 12 * freedoms * freedoms + 6 * rows * (freedoms + 100);
  if (stack > 2e9) throw atl::Error("MuJoCo has no room for " + std::to_string(moving_.size()) + " bodies");
  return stack;
}

mjModel* MujocoScene::compile(int contacts) const {
  const std::string xml = "<mujoco>\n" + options_ + "<size nconmax=\"" + std::to_string(contacts) + "\" njmax=\"" +
                          std::to_string(std::llround(constraint_rows(contacts))) + "\" nstack=\"" +
                          std::to_string(std::llround(stack_size(contacts))) + "\"/>\n<asset>\n" + assets_ +
                          "</asset>\n<worldbody>\n" + world_ + "</worldbody>\n" + joints_ + "</mujoco>\n";

  const auto files = std::make_unique<mjVFS>();  // megabytes
  mj_defaultVFS(files.get());
  mj_makeEmptyFileVFS(files.get(), "scene.xml", static_cast<int>(xml.size()));
  std::memcpy(files->filedata[0], xml.data(), xml.size());
  std::array<char, 1000> message = {};
  mjModel* model = mj_loadXML("scene.xml", files.get(), message.data(), message.size());
  mj_deleteVFS(files.get());
  if (model == nullptr) throw atl::Error(std::string("MuJoCo: ") + message.data());
  set_dynamics(*model);
  return model;
}

atl::Vector3 MujocoScene::in_model(std::size_t body, const atl::Vector3& point) const {
  if (moves(body)) return point;
  const atl::Pose& pose = solids_[body].pose;
  return pose.position + pose.orientation * point;
}

void MujocoScene::set_dynamics(mjModel& model) const {
  for (std::size_t i = 0; i < heights_.size(); ++i) {
    std::copy(heights_[i].begin(), heights_[i].end(), model.hfield_data + model.hfield_adr[i]);
  }
  // Both points: of the second, MuJoCo would take that where the first starts. A body that stands is one at the origin.
  for (std::size_t j = 0; j < balls_.size(); ++j) {
    const Ball& ball = balls_[j];
    mjtNum* points = model.eq_data + mjNEQDATA * j;
    const atl::Vector3 first = in_model(ball.first, ball.at_first), second = in_model(ball.second, ball.at_second);
    std::copy(first.begin(), first.end(), points);
    std::copy(second.begin(), second.end(), points + 3);
  }
  // Damping is a force per velocity, by degree of freedom.
  for (std::size_t k = 0; k < moving_.size(); ++k) {
    const atl::BodyDef& def = scene_.bodies[moving_[k]].def;
    const Solid& solid = solids_[moving_[k]];
    mjtNum* damping = model.dof_damping + 6 * k;
    for (int axis = 0; axis < 3; ++axis) {
      damping[axis] = def.linear_damping * solid.mass;
      damping[3 + axis] = def.angular_damping * solid.moments[axis];
    }
  }
}

}  // namespace peer
