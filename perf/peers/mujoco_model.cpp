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
    text += "<default><geom" + attribute("solref", {2 * dt, 1}) + " solimp=\"0.99 0.999 0.001\"/></default>\n";
  }
  return text;
}

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
  // The model numbers the world's geoms first.
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const atl::BodyDef& def = scene.bodies[i].def;
    if (def.type == atl::BodyType::Dynamic || is_moving_kinematic(def)) {
      moving_.push_back(i);
    } else {
      add_geoms(def, i, world_);
    }
  }
  for (const std::size_t i : moving_) {
    const atl::BodyDef& def = scene.bodies[i].def;
    const Solid& solid = solids_[i];
    const atl::Vector3& moments = solid.moments;
    world_ += "<body" + place(solid.pose) + ">";
    if (def.type == atl::BodyType::Dynamic) {
      world_ += "<freejoint/><inertial pos=\"0 0 0\"" + attribute("mass", {solid.mass}) +
                attribute("diaginertia", {moments.x(), moments.y(), moments.z()}) + "/>\n";
    } else {
      world_ += "<joint type=\"free\"" + attribute("armature", {kinematic_mass_ratio * std::max(heaviest, 1.0)}) +
                "/><inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"1 1 1\"/>\n";
    }
    add_geoms(def, i, world_);
    world_ += "</body>\n";
  }
}

void MujocoScene::add_geoms(const atl::BodyDef& def, std::size_t body, std::string& xml) {
  const Solid& solid = solids_[body];
  const bool fixed = def.type != atl::BodyType::Dynamic && !is_moving_kinematic(def);
  for (std::size_t k = 0; k < solid.parts.size(); ++k) {
    const Part& part = solid.parts[k];
    GeomText text{assets_, heights_, "s" + std::to_string(body) + "_" + std::to_string(k),
                  fixed ? solid.pose * part.pose : part.pose};
    const std::string shape = std::visit(text, part.shape);
    // What forces don't move touches nothing of its kind.
    const char* category = def.type == atl::BodyType::Dynamic ? "1" : "0";
    xml += "<geom" + shape + place(text.pose) + attribute("friction", {def.material.friction, 0, 0}) +
           " condim=\"3\" conaffinity=\"1\" contype=\"" + category + "\"/>\n";
    owners_.push_back(body);
  }
}

int MujocoScene::most_contacts() const {
  // With n rows and v degrees of freedom: 24 n v + 12 n^2 bytes.
  constexpr double most_bytes = 1.8e9;
  const double v = 6.0 * static_cast<double>(moving_.size());
  return static_cast<int>((std::sqrt(v * v + most_bytes / 12) - v) / rows_per_contact);
}

mjModel* MujocoScene::compile(int contacts) const {
  const double rows = rows_per_contact * static_cast<double>(contacts);
  const double freedoms = 6.0 * static_cast<double>(moving_.size());
  // Doubles for the solvers' factors and products; MuJoCo's own guess is five times the square of rows and freedoms.
  const double stack = 1e6 + 12 * freedoms * freedoms + 6 * rows * (freedoms + 100);
  if (stack > 2e9) throw atl::Error("MuJoCo has no room for " + std::to_string(moving_.size()) + " bodies");
  const std::string xml = "<mujoco>\n" + options_ + "<size nconmax=\"" + std::to_string(contacts) + "\" njmax=\"" +
                          std::to_string(std::llround(rows)) + "\" nstack=\"" + std::to_string(std::llround(stack)) +
                          "\"/>\n<asset>\n" + assets_ + "</asset>\n<worldbody>\n" + world_ +
                          "</worldbody>\n</mujoco>\n";

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

void MujocoScene::set_dynamics(mjModel& model) const {
  for (std::size_t i = 0; i < heights_.size(); ++i) {
    std::copy(heights_[i].begin(), heights_[i].end(), model.hfield_data + model.hfield_adr[i]);
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
