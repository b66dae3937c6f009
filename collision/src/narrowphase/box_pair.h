#pragma once

#include <collision/narrowphase/manifold.h>

namespace atl::collision {

// The two boxes in the frame of the reference box.
struct BoxPair {
  Vector3 half_reference;
  Vector3 half_incident;
  Vector3 position;  // of the incident box
  Matrix3 rotation;  // its axes, as columns

  BoxPair swapped() const {
    return {half_incident, half_reference, -(rotation.transpose() * position), rotation.transpose()};
  }
};

// The edge of a box that lies farthest along a direction, of the four along one of its axes.
struct SupportEdge {
  Vector3 middle;  // in the box's frame
  int sides;       // bit i: on the negative side of axis i
};
inline SupportEdge support_edge(const Vector3& half_extents, const Vector3& direction, Eigen::Index axis) {
  SupportEdge edge{Vector3::Zero(), 0};
  for (Eigen::Index i = 0; i < 3; ++i) {
    if (i == axis) continue;
    edge.middle[i] = direction[i] < 0 ? -half_extents[i] : half_extents[i];
    if (direction[i] < 0) edge.sides |= 1 << i;
  }
  return edge;
}

// Adds to a manifold of crossing edges, whose reference is the first box, what else of the two may meet within the
// margin (m): corners that would meet the other box along the normal, and edges that would cross.
void add_other_features(const BoxPair& pair, double margin, Manifold& manifold);

}  // namespace atl::collision
