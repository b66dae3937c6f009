#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>
#include <limits>

#include "schema.h"
#include "words.h"

namespace atl::scene {
namespace {

// A string names an entry of the library, anything else is read as a definition.
template <class Part>
Part named_or_inline(const Reader& in, const std::map<std::string, Part, std::less<>>& library, const char* kind,
                     Part (*read)(const Reader&)) {
  if (!in.is<std::string>()) return read(in);
  const std::string& name = in.string();
  if (const auto found = library.find(name); found != library.end()) return found->second;
  std::vector<std::string_view> names;
  names.reserve(library.size());
  for (const auto& [known, part] : library) names.push_back(known);
  in.expected("the name of a " + std::string(kind) + " in /" + kind + "s, " +
              (names.empty() ? "which has none" : "which has " + listed(names)) + suggestion(name, names));
}

// The name of a shape that only static and kinematic bodies may have; null for a solid.
const char* name_of_unbounded(const Shape& shape) {
  if (std::holds_alternative<HalfSpace>(shape)) return "a half-space";
  if (std::holds_alternative<TriangleMesh>(shape)) return "a mesh";
  if (std::holds_alternative<HeightField>(shape)) return "a height field";
  return nullptr;
}

BodyType read_type(const Reader& in) {
  constexpr std::array types = {BodyType::Dynamic, BodyType::Static, BodyType::Kinematic};
  return types[in.choice({"dynamic", "static", "kinematic"})];
}

// Three principal moments, or all six of a symmetric matrix.
Matrix3 read_inertia(const Reader& in) {
  constexpr const char* what = "an array of three numbers, [Ixx, Iyy, Izz], or of six with Ixy, Ixz, Iyz";
  Matrix3 inertia = Matrix3::Zero();
  if (in.size(what) == 3) {
    const auto [xx, yy, zz] = in.numbers<3>(what);
    inertia.diagonal() = Vector3(xx, yy, zz);
  } else {
    const auto [xx, yy, zz, xy, xz, yz] = in.numbers<6>(what);
    inertia << xx, xy, xz, xy, yy, yz, xz, yz, zz;
  }
  const Vector3 moments = Eigen::SelfAdjointEigenSolver<Matrix3>(inertia, Eigen::EigenvaluesOnly).eigenvalues();
  const std::string found =
      "principal moments " + number_text(moments[0]) + ", " + number_text(moments[1]) + ", " + number_text(moments[2]);
  // World tests a factor too: it keeps a needle's least moment, which eigenvalues lose in the rounding of the largest.
  const double scale = inertia.cwiseAbs().maxCoeff();
  if (Eigen::LLT<Matrix3>(inertia / scale).info() != Eigen::Success) in.fail(found, "all of them > 0");
  // A flat plate meets the bound exactly, so rounding must not refuse it.
  constexpr double tolerance = 1e-9;
  if (moments[2] > (moments[0] + moments[1]) * (1 + tolerance)) {
    in.fail(found, "none larger than the sum of the others, which no rigid body can exceed");
  }
  return inertia;
}

std::array<bool, 3> read_axes(const Reader& in) {
  std::array<bool, 3> axes = {};
  const std::size_t count = in.size("an array of axes, as [\"x\", \"z\"]");
  for (std::size_t i = 0; i < count; ++i) {
    const Reader element = in.element(i);
    bool& axis = axes[element.choice({"x", "y", "z"})];
    if (axis) element.fail("an axis that is there already", "each of them once");
    axis = true;
  }
  return axes;
}

MotionLocks read_locks(const Reader& in) {
  in.only_keys({"linear", "angular", "plane"});
  if (const auto across = in.find("plane")) {
    for (const char* key : {"linear", "angular"}) {
      if (in.has(key)) in.fail_at(key, "both it and a plane", "a plane, or else what is locked");
    }
    constexpr std::array axes = {Axis::X, Axis::Y, Axis::Z};
    return MotionLocks::plane(axes[across->choice({"x", "y", "z"})]);
  }
  MotionLocks locks;
  if (const auto linear = in.find("linear")) locks.linear = read_axes(*linear);
  if (const auto angular = in.find("angular")) locks.angular = read_axes(*angular);
  return locks;
}

void read_mass(const Reader& in, BodyDef& def) {
  for (const char* key : {"density", "mass", "inertia", "centre_of_mass", "gravity_scale", "linear_damping",
                          "angular_damping", "locks", "force"}) {
    if (def.type != BodyType::Dynamic && in.has(key)) {
      in.fail_at(key, "it on a body that is not dynamic", "it on dynamic bodies only: others do not move under forces");
    }
  }
  if (in.has("density") && in.has("mass")) in.fail_at("mass", "both a mass and a density", "one of them");
  if (in.has("inertia") && !in.has("mass")) in.fail_at("mass", "an inertia without a mass", "both");
  if (in.has("centre_of_mass") && !in.has("inertia")) {
    in.fail_at("inertia", "a centre of mass without an inertia", "both");
  }
  get(in, "density", def.density, above(0));
  if (const auto mass = in.find("mass")) def.mass = mass->number(above(0));
  if (const auto inertia = in.find("inertia")) def.inertia = read_inertia(*inertia);
  if (const auto centre = in.find("centre_of_mass")) def.centre_of_mass = read_vector(*centre);
}

}  // namespace

Quaternion read_orientation(const Reader& in) {
  const auto [x, y, z, w] = in.numbers<4>("a quaternion of four numbers, [x, y, z, w]");
  constexpr double min_norm = 1e-6;
  const double norm = Quaternion(w, x, y, z).norm();
  if (!(norm > min_norm) || !std::isfinite(norm)) {
    in.fail("a quaternion of norm " + number_text(norm), "a norm that can be scaled to 1");
  }
  return {w, x, y, z};
}

CombineRule read_rule(const Reader& in) {
  return static_cast<CombineRule>(in.choice({"default", "average", "geometric_mean", "min", "multiply", "max"}));
}

Material read_material(const Reader& in) {
  in.only_keys({"friction", "friction_across", "friction_direction", "restitution", "rolling_friction",
                "torsional_friction", "friction_rule", "restitution_rule", "id"});
  Material material;
  get(in, "friction", material.friction, at_least(0));
  get(in, "friction_across", material.friction_across, at_least(0));
  if (const auto direction = in.find("friction_direction")) {
    Eigen::Map<Vector3>(material.friction_direction.data()) = read_vector(*direction);
  }
  get(in, "restitution", material.restitution, between(0, 1));
  get(in, "rolling_friction", material.rolling_friction, at_least(0));
  get(in, "torsional_friction", material.torsional_friction, at_least(0));
  if (const auto rule = in.find("friction_rule")) material.friction_rule = read_rule(*rule);
  if (const auto rule = in.find("restitution_rule")) material.restitution_rule = read_rule(*rule);
  get(in, "id", material.id);
  return material;
}

MaterialPair read_material_pair(const Reader& in) {
  in.only_keys({"first", "second", "friction", "friction_across", "restitution"});
  MaterialPair pair;
  for (auto [key, id] : {std::pair("first", &pair.first), std::pair("second", &pair.second)}) {
    get(in, key, *id);
    if (*id == 0) in.fail_at(key, "no material", "the id of one, above 0");
  }
  get(in, "friction", pair.friction, at_least(0));
  get(in, "friction_across", pair.friction_across, at_least(0));
  get(in, "restitution", pair.restitution, between(0, 1));
  return pair;
}

CollisionFilter read_filter(const Reader& in) {
  in.only_keys({"category", "mask", "group"});
  CollisionFilter filter;
  constexpr double all = std::numeric_limits<std::uint32_t>::max();
  const auto read_bits = [&](const char* key, std::uint32_t& bits) {
    double number = bits;
    get(in, key, number, between(0, all));
    if (std::trunc(number) != number) in.at(key, "").expected("an integer in [0, 2^32)");
    bits = static_cast<std::uint32_t>(number);
  };
  read_bits("category", filter.category);
  read_bits("mask", filter.mask);
  get(in, "group", filter.group, std::numeric_limits<int>::min(), std::numeric_limits<int>::max());
  return filter;
}

SceneBody read_body(const Reader& in, const Library& library) {
  in.only_keys({"name",
                "type",
                "shape",
                "material",
                "materials",
                "position",
                "orientation",
                "velocity",
                "angular_velocity",
                "surface_velocity",
                "surface_angular_velocity",
                "density",
                "mass",
                "inertia",
                "centre_of_mass",
                "gravity_scale",
                "linear_damping",
                "angular_damping",
                "locks",
                "max_speed",
                "max_angular_speed",
                "awake",
                "may_sleep",
                "force",
                "filter",
                "continuous",
                "sensor",
                "notices_static",
                "notices_sensors",
                "contact_event_force",
                "user_data"});
  SceneBody body;
  BodyDef& def = body.def;
  read_name(in, body.name);
  if (const auto type = in.find("type")) def.type = read_type(*type);

  const Reader shape = in.at("shape", "a shape or the name of one");
  def.shape = named_or_inline(shape, library.shapes, "shape", &read_shape);
  if (const char* unbounded = name_of_unbounded(def.shape); def.type == BodyType::Dynamic && unbounded != nullptr) {
    shape.fail(std::string(unbounded) + " on a dynamic body", "a solid there: this has no mass");
  }
  if (const auto material = in.find("material")) {
    def.material = named_or_inline(*material, library.materials, "material", &read_material);
  }
  const auto materials = in.find("materials");
  const std::size_t count = materials ? materials->size("an array of materials or names of them") : 0;
  for (std::size_t i = 0; i < count; ++i) {
    def.materials.push_back(named_or_inline(materials->element(i), library.materials, "material", &read_material));
  }

  get(in, "position", def.position);
  if (const auto orientation = in.find("orientation")) def.orientation = read_orientation(*orientation);
  for (const char* key : {"velocity", "angular_velocity"}) {
    if (def.type == BodyType::Static && in.has(key)) {
      in.fail_at(key, "it on a static body", "it on dynamic and kinematic bodies only");
    }
  }
  get(in, "velocity", def.velocity);
  get(in, "angular_velocity", def.angular_velocity);
  get(in, "surface_velocity", def.surface_velocity);
  get(in, "surface_angular_velocity", def.surface_angular_velocity);

  read_mass(in, def);
  get(in, "gravity_scale", def.gravity_scale);
  get(in, "linear_damping", def.linear_damping, at_least(0));
  get(in, "angular_damping", def.angular_damping, at_least(0));
  if (const auto locks = in.find("locks")) def.locks = read_locks(*locks);
  get(in, "max_speed", def.max_speed, above(0));
  get(in, "max_angular_speed", def.max_angular_speed, above(0));
  get(in, "awake", def.awake);
  get(in, "may_sleep", def.may_sleep);
  get(in, "force", body.force);
  if (const auto filter = in.find("filter")) def.filter = read_filter(*filter);
  get(in, "continuous", def.continuous);
  get(in, "sensor", def.sensor);
  get(in, "notices_static", def.notices_static);
  get(in, "notices_sensors", def.notices_sensors);
  if (const char* unbounded = name_of_unbounded(def.shape); def.sensor && unbounded != nullptr) {
    shape.fail(std::string(unbounded) + " on a sensor", "a solid there: bodies are in it or not");
  }
  get(in, "contact_event_force", def.contact_event_force, at_least(0));
  get(in, "user_data", def.user_data);
  return body;
}

}  // namespace atl::scene
