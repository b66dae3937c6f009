#pragma once
/// A body of a scene as other engines want it: its frame at the centre of mass, along the principal axes.

#include <atoll/body.h>
#include <atoll/closed_form.h>
#include <atoll/error.h>

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace peer {

/// b within a.
atl::Pose operator*(const atl::Pose& a, const atl::Pose& b);

/// One shape of a body. Never a compound.
struct Part {
  atl::Shape shape = atl::Box{};
  atl::Pose pose = {};  ///< in the solid's frame
};

struct Solid {
  double mass = 0;                              ///< kg; 0 for what forces don't move
  atl::Vector3 moments = atl::Vector3::Zero();  ///< kg m^2, principal
  atl::Pose frame = {};  ///< in the body's frame; the body's own where that will do, and for what has no mass
  atl::Pose pose = {};   ///< in the world, as the scene starts
  std::vector<Part> parts;
};

/// Mass, centre and inertia are those of atl::body_mass. Throws atl::Error on an unusable definition.
Solid make_solid(const atl::BodyDef& def);

/// The pose of the body's frame, from the pose that its solid's frame has in the world.
atl::Pose body_pose(const Solid& solid, const atl::Pose& pose);

bool is_identity(const atl::Pose& pose);

/// Friction and restitution of a pair, combined by Atoll's rule.
double combined_friction(double a, double b);
double combined_restitution(double a, double b);

/// True for a kinematic body that moves, false for one that stands still.
bool is_moving_kinematic(const atl::BodyDef& def);

/// "sphere", "convex hull", ...
std::string shape_name(const atl::Shape& shape);

/// Sums up forces between bodies by pair.
class LoadSum {
 public:
  /// `force` of body a on body b, in either order.
  void add(std::size_t a, std::size_t b, const atl::Vector3& force);
  std::vector<atl::ContactLoad> loads() const;

 private:
  std::map<std::pair<std::size_t, std::size_t>, atl::Vector3> forces_;
};

}  // namespace peer
