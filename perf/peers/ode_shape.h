#pragma once
/// ODE's geoms, vectors and quaternions for Atoll's.

#include <ode/ode.h>

#include <deque>
#include <vector>

#include "solid.h"

namespace peer {

/// A quaternion in ODE's order: w first.
struct OdeQuaternion {
  explicit OdeQuaternion(const atl::Quaternion& q) : w_x_y_z{q.w(), q.x(), q.y(), q.z()} {}
  dQuaternion w_x_y_z;
};

atl::Vector3 from_ode(const dReal* v);

/// Makes geoms, and owns what they point to.
class OdeShapes {
 public:
  explicit OdeShapes(dSpaceID space) : space_(space) {}
  OdeShapes(const OdeShapes&) = delete;
  OdeShapes& operator=(const OdeShapes&) = delete;
  ~OdeShapes();

  /// One geom a part, each on the body or, where that is null, at its place in the world. Throws atl::Error on a
  /// shape that ODE hasn't got.
  std::vector<dGeomID> add(const Solid& solid, dBodyID body);

 private:
  struct Maker;
  struct Hull {
    std::vector<dReal> planes;
    std::vector<dReal> points;
    std::vector<unsigned> polygons;
  };
  struct Surface {
    std::vector<double> numbers;
    std::vector<dTriIndex> corners;
  };

  dSpaceID space_;
  std::deque<Hull> hulls_;
  std::deque<Surface> surfaces_;
  std::vector<dTriMeshDataID> meshes_;
  std::vector<dHeightfieldDataID> fields_;
};

}  // namespace peer
