#include "ode_shape.h"

#include <algorithm>
#include <cmath>

namespace peer {

atl::Vector3 from_ode(const dReal* v) { return {v[0], v[1], v[2]}; }

OdeShapes::~OdeShapes() {
  for (const dTriMeshDataID mesh : meshes_) dGeomTriMeshDataDestroy(mesh);
  for (const dHeightfieldDataID field : fields_) dGeomHeightfieldDataDestroy(field);
}

struct OdeShapes::Maker {
  // A geom, and its frame in that of Atoll's shape.
  struct Made {
    dGeomID geom;
    atl::Pose place = {};
  };

  OdeShapes& store;
  const atl::Pose& pose;  // of the part in the world, as the scene starts

  Made operator()(const atl::Box& box) const {
    const atl::Vector3 size = 2 * box.half_extents;
    return {dCreateBox(store.space_, size.x(), size.y(), size.z())};
  }
  Made operator()(const atl::Sphere& sphere) const { return {dCreateSphere(store.space_, sphere.radius)}; }
  Made operator()(const atl::Capsule& capsule) const {
    return {dCreateCapsule(store.space_, capsule.radius, 2 * capsule.half_height)};
  }
  Made operator()(const atl::Cylinder& cylinder) const {
    return {dCreateCylinder(store.space_, cylinder.radius, 2 * cylinder.half_height)};
  }

  // A plane of ODE's can't be placed: it is given in the world's frame.
  Made operator()(const atl::HalfSpace& half_space) const {
    const atl::Vector3 local = half_space.normal.normalized();
    const atl::Vector3 normal = pose.orientation * local;
    const double offset = half_space.offset + normal.dot(pose.position);
    return {dCreatePlane(store.space_, normal.x(), normal.y(), normal.z(), offset)};
  }

  Made operator()(const atl::ConvexHull& hull) const {
    store.hulls_.emplace_back();
    Hull& copy = store.hulls_.back();
    const auto vertices = hull.vertices();
    for (const atl::Vector3& vertex : vertices) copy.points.insert(copy.points.end(), vertex.begin(), vertex.end());
    for (std::size_t i = 0; i < hull.face_count(); ++i) {
      const auto face = hull.face(i);
      copy.polygons.push_back(static_cast<unsigned>(face.size()));
      copy.polygons.insert(copy.polygons.end(), face.begin(), face.end());
      // Newell's normal: any three corners of a face may be nearly in a line.
      atl::Vector3 normal = atl::Vector3::Zero(), middle = atl::Vector3::Zero();
      for (std::size_t k = 0; k < face.size(); ++k) {
        const atl::Vector3& corner = vertices[face[k]];
        normal += (corner - vertices[face[0]]).cross(vertices[face[(k + 1) % face.size()]] - vertices[face[0]]);
        middle += corner / static_cast<double>(face.size());
      }
      normal.normalize();
      copy.planes.insert(copy.planes.end(), {normal.x(), normal.y(), normal.z(), normal.dot(middle)});
    }
    return {dCreateConvex(store.space_, copy.planes.data(), static_cast<unsigned>(hull.face_count()),
                          copy.points.data(), static_cast<unsigned>(vertices.size()), copy.polygons.data())};
  }

  Made operator()(const atl::TriangleMesh& mesh) const {
    if (dCheckConfiguration("ODE_EXT_trimesh") == 0) throw atl::Error("this build of ODE has no triangle meshes");
    store.surfaces_.emplace_back();
    Surface& copy = store.surfaces_.back();
    for (const atl::Vector3& vertex : mesh.vertices()) {
      copy.numbers.insert(copy.numbers.end(), vertex.begin(), vertex.end());
    }
    for (const atl::TriangleMesh::Indices& corners : mesh.triangles()) {
      copy.corners.insert(copy.corners.end(), corners.begin(), corners.end());
    }
    const dTriMeshDataID data = dGeomTriMeshDataCreate();
    store.meshes_.push_back(data);
    dGeomTriMeshDataBuildDouble(data, copy.numbers.data(), 3 * sizeof(double),
                                static_cast<int>(copy.numbers.size() / 3), copy.corners.data(),
                                static_cast<int>(copy.corners.size()), 3 * sizeof(dTriIndex));
    dGeomTriMeshDataPreprocess2(data, 1U << dTRIDATAPREPROCESS_BUILD_FACE_ANGLES, nullptr);  // hulls need them
    return {dCreateTriMesh(store.space_, data, nullptr, nullptr, nullptr)};
  }

  // ODE's fields have y up and their middle at the origin. Turned upright by a quarter turn about x, their rows run
  // against Atoll's y, and so in reverse order; diagonals are then Atoll's.
  Made operator()(const atl::HeightField& field) const {
    store.surfaces_.emplace_back();
    std::vector<double>& heights = store.surfaces_.back().numbers;
    const std::size_t columns = field.columns(), rows = field.rows();
    const auto samples = field.heights();
    for (std::size_t row = rows; row-- > 0;) {
      const auto first = samples.begin() + static_cast<std::ptrdiff_t>(row * columns);
      heights.insert(heights.end(), first, first + static_cast<std::ptrdiff_t>(columns));
    }
    const double width = static_cast<double>(columns - 1) * field.spacing_x();
    const double depth = static_cast<double>(rows - 1) * field.spacing_y();
    const auto [low, high] = std::minmax_element(heights.begin(), heights.end());
    const dHeightfieldDataID data = dGeomHeightfieldDataCreate();
    store.fields_.push_back(data);
    constexpr double thickness = 1;  // m, of solid below the lowest sample
    dGeomHeightfieldDataBuildDouble(data, heights.data(), 0, width, depth, static_cast<int>(columns),
                                    static_cast<int>(rows), 1, 0, thickness, 0);
    dGeomHeightfieldDataSetBounds(data, *low, *high);
    const atl::Quaternion upright(std::sqrt(0.5), std::sqrt(0.5), 0, 0);
    return {dCreateHeightfield(store.space_, data, 1), {{width / 2, depth / 2, 0}, upright}};
  }

  Made operator()(const atl::Cone&) const {
    throw atl::Error("ODE has no cones; expected boxes, spheres, capsules, cylinders, convex hulls or surfaces");
  }
  Made operator()(const atl::Ellipsoid&) const { throw atl::Error("ODE has no ellipsoids"); }
  Made operator()(const atl::TaperedCapsule&) const { throw atl::Error("ODE has no tapered capsules"); }
  Made operator()(const atl::Compound&) const { throw atl::Error("the ODE driver found a compound in a compound"); }
};

std::vector<dGeomID> OdeShapes::add(const Solid& solid, dBodyID body) {
  std::vector<dGeomID> geoms;
  for (const Part& part : solid.parts) {
    const atl::Pose world = solid.pose * part.pose;
    const auto [geom, place] = std::visit(Maker{*this, world}, part.shape);
    geoms.push_back(geom);
    if (std::holds_alternative<atl::HalfSpace>(part.shape)) {
      if (body != nullptr) throw atl::Error("ODE has no half-spaces that move");
      continue;
    }
    const atl::Pose local = part.pose * place;
    const atl::Pose pose = body != nullptr ? local : solid.pose * local;
    const atl::Vector3& at = pose.position;
    const OdeQuaternion turn(pose.orientation);
    if (body == nullptr) {
      dGeomSetPosition(geom, at.x(), at.y(), at.z());
      dGeomSetQuaternion(geom, turn.w_x_y_z);
      continue;
    }
    dGeomSetBody(geom, body);
    if (is_identity(pose)) continue;
    dGeomSetOffsetPosition(geom, at.x(), at.y(), at.z());
    dGeomSetOffsetQuaternion(geom, turn.w_x_y_z);
  }
  return geoms;
}

}  // namespace peer
