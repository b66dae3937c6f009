#pragma once

#include <collision/narrowphase/surface_contacts.h>

#include "narrowphase/triangle_contact.h"

namespace atl::collision {

/// Cosine of the angle within which a ball's normals are one: it touches each facet at a point, so that the normal of
/// another, even a degree off, leads it into the facet or off it.
inline constexpr double same_facet_cosine = 1 - 1e-9;

/// The contacts of a solid's triangles, gathered by normal while they are found one after another.
class SurfaceClusters {
 public:
  explicit SurfaceClusters(const SurfaceSolid& solid);

  void add(const TriangleContact& contact);
  /// The manifolds of all that was added.
  void finish(SurfaceManifolds& result);

 private:
  static constexpr int max_clusters = 8;
  static constexpr int max_candidates = 32;
  static constexpr int max_inner = 8;

  struct Cluster {
    Vector3 normal;
    double height;   // m, of the solid along the normal, from the surface's origin
    double deepest;  // m
    std::uint8_t material;
    int count = 0;
    int inner_count = 0;
    std::array<Manifold::Point, max_candidates> points;
    std::array<Manifold::Point, max_inner> inner;  // used only if there are no others

    void add(const Manifold::Point& point, double same_place);
    void add_inner(const Manifold::Point& point);
    void drop(int i) { points[static_cast<std::size_t>(i)] = points[static_cast<std::size_t>(--count)]; }
    void update_deepest();
  };

  Cluster* cluster_for(const TriangleContact& contact, double separation);
  void drop_redundant(Cluster& cluster);
  bool is_freed_by(const Manifold::Point& point, const Cluster& cluster, const Cluster& other) const;
  void merge_to_fit();
  Cluster& at(int i) { return clusters_[static_cast<std::size_t>(i)]; }

  const SurfaceSolid& solid_;
  double size_;         // m
  double same_normal_;  // cosine
  int count_ = 0;
  std::array<Cluster, max_clusters> clusters_;
};

}  // namespace atl::collision
