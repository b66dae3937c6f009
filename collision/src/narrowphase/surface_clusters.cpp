#include "narrowphase/surface_clusters.h"

#include <collision/narrowphase/feature_id.h>
#include <jobs/assert.h>

#include <algorithm>
#include <cmath>

namespace atl::collision {
namespace {

// Triangles that look the same way within 1 degree are one face.
constexpr double same_normal = 0.99984769515639123;
// Cosine of 15 degrees: normals this close share a manifold if a solid touches in more directions than there are
// manifolds, as on fine terrain.
constexpr double similar_normal = 0.96592582628906831;
// Part of the solid's size: points closer to each other are the same, found by two triangles.
constexpr double same_place = 1e-5;
// Part of the solid's size by which another normal must be better for a point to count as freed along it.
constexpr double freed_slack = 1e-3;

// Value in an id that stands for no particular triangle.
constexpr std::uint32_t any_triangle = (1u << 28) - 1;

}  // namespace

SurfaceClusters::SurfaceClusters(const SurfaceSolid& solid)
    : solid_(solid),
      size_(solid.shape.inner_radius),
      same_normal_(solid.shape.kind == ShapeKind::Sphere ? same_facet_cosine : same_normal) {}

void SurfaceClusters::Cluster::add(const Manifold::Point& point, double radius) {
  for (int i = 0; i < count; ++i) {
    Manifold::Point& known = points[static_cast<std::size_t>(i)];
    const bool is_near = (known.position - point.position).squaredNorm() <= radius * radius;
    if (!is_near && known.id != point.id) continue;
    // A place on a rim may differ between triangles that look different ways.
    if (!is_near && point.separation < known.separation) known = point;
    deepest = std::min(deepest, known.separation);
    return;
  }
  if (count == max_candidates) {
    Manifold few;
    few.normal = normal;
    reduce_points(points.data(), count, few);
    count = few.count;
    std::copy_n(few.points.begin(), few.count, points.begin());
  }
  points[static_cast<std::size_t>(count++)] = point;
  deepest = std::min(deepest, point.separation);
}

void SurfaceClusters::Cluster::add_inner(const Manifold::Point& point) {
  if (inner_count < max_inner) {
    inner[static_cast<std::size_t>(inner_count++)] = point;
    return;
  }
  const auto shallowest = std::max_element(inner.begin(), inner.end(),
                                           [](const auto& a, const auto& b) { return a.separation < b.separation; });
  if (point.separation < shallowest->separation) *shallowest = point;
}

void SurfaceClusters::Cluster::update_deepest() {
  deepest = INFINITY;
  for (int i = 0; i < count; ++i) deepest = std::min(deepest, points[static_cast<std::size_t>(i)].separation);
}

SurfaceClusters::Cluster* SurfaceClusters::cluster_for(const TriangleContact& contact, double separation) {
  Cluster* cluster = nullptr;
  double best = same_normal_;
  for (int i = 0; i < count_; ++i) {
    const double cosine = at(i).normal.dot(contact.normal);
    if (cosine <= best || at(i).material != contact.material) continue;
    best = cosine;
    cluster = &at(i);
  }
  if (cluster != nullptr) return cluster;
  if (count_ < max_clusters) {
    cluster = &at(count_++);
  } else {
    cluster = std::max_element(clusters_.begin(), clusters_.end(),
                               [](const Cluster& a, const Cluster& b) { return a.deepest < b.deepest; });
    if (separation >= cluster->deepest) return nullptr;
  }
  cluster->normal = contact.normal;
  cluster->height = solid_.height(contact.normal, Vector3::Zero());
  cluster->material = contact.material;
  cluster->deepest = INFINITY;
  cluster->count = 0;
  cluster->inner_count = 0;
  return cluster;
}

void SurfaceClusters::add(const TriangleContact& contact) {
  if (contact.count == 0) return;
  double deepest = INFINITY;
  for (int i = 0; i < contact.count; ++i) {
    deepest = std::min(deepest, contact.points[static_cast<std::size_t>(i)].separation);
  }
  Cluster* cluster = cluster_for(contact, deepest);
  if (cluster == nullptr) return;
  for (int i = 0; i < contact.count; ++i) {
    Manifold::Point point = contact.points[static_cast<std::size_t>(i)];
    // A point on the solid's own feature keeps its id from one triangle to the next.
    if ((contact.own >> i & 1) != 0) {
      point.id = solid_.shape.kind == ShapeKind::Sphere ? single_point_id() : with_triangle(point.id, any_triangle);
    }
    if ((contact.inner >> i & 1) != 0) {
      cluster->add_inner(point);
    } else {
      cluster->add(point, same_place * size_);
    }
  }
}

// A solid that covers a place on the surface leaves it soonest along the normal that it reaches least far behind, if
// that one's points push it as far: what reaches behind it may lie beside its triangles. That counts only between
// faces that bend away from each other, where all of the one is behind the other: of those that make a hollow, both
// push.
bool SurfaceClusters::is_freed_by(const Manifold::Point& point, const Cluster& cluster, const Cluster& other) const {
  const double slack = freed_slack * size_;
  const Vector3& normal = cluster.normal;
  const Vector3 place = point.position - point.separation * normal;
  const double behind_other = other.height - other.normal.dot(place);
  if (behind_other <= cluster.height - normal.dot(place) + slack || other.deepest > behind_other + slack) return false;
  for (int i = 0; i < other.count; ++i) {
    const Manifold::Point& beyond = other.points[static_cast<std::size_t>(i)];
    const Vector3 other_place = beyond.position - beyond.separation * other.normal;
    if (normal.dot(other_place - place) > slack || other.normal.dot(place - other_place) > slack) return false;
  }
  return other.count > 0;
}

void SurfaceClusters::drop_redundant(Cluster& cluster) {
  for (int i = cluster.count - 1; i >= 0; --i) {
    for (int k = 0; k < count_; ++k) {
      if (&at(k) == &cluster) continue;
      if (!is_freed_by(cluster.points[static_cast<std::size_t>(i)], cluster, at(k))) continue;
      cluster.drop(i);
      break;
    }
  }
  cluster.update_deepest();
}

void SurfaceClusters::merge_to_fit() {
  const auto remove = [&](int i) {
    for (int k = i; k + 1 < count_; ++k) at(k) = at(k + 1);
    --count_;
  };
  while (count_ > max_surface_manifolds) {
    int first = 0;
    int second = 0;
    double best = similar_normal;
    for (int i = 0; i < count_; ++i) {
      for (int k = i + 1; k < count_; ++k) {
        const double cosine = at(i).normal.dot(at(k).normal);
        if (cosine <= best) continue;
        best = cosine;
        first = i;
        second = k;
      }
    }
    if (second > 0) {
      if (at(second).deepest < at(first).deepest) std::swap(at(first), at(second));
      for (int i = 0; i < at(second).count; ++i) {
        at(first).add(at(second).points[static_cast<std::size_t>(i)], same_place * size_);
      }
      remove(second);
      continue;
    }
    int shallowest = 0;
    for (int i = 1; i < count_; ++i) {
      if (at(i).deepest >= at(shallowest).deepest) shallowest = i;
    }
    remove(shallowest);
  }
}

void SurfaceClusters::finish(SurfaceManifolds& result) {
  for (int i = 0; i < count_; ++i) {
    Cluster& cluster = at(i);
    if (cluster.count > 0) continue;
    cluster.count = cluster.inner_count;
    std::copy_n(cluster.inner.begin(), cluster.inner_count, cluster.points.begin());
    cluster.update_deepest();
  }
  if (count_ > 1) {
    // Shallow ones are what frees: the deepest go first.
    std::array<bool, max_clusters> done = {};
    for (int round = 0; round < count_; ++round) {
      int next = -1;
      for (int i = 0; i < count_; ++i) {
        if (!done[static_cast<std::size_t>(i)] && (next < 0 || at(i).deepest < at(next).deepest)) next = i;
      }
      done[static_cast<std::size_t>(next)] = true;
      drop_redundant(at(next));
    }
    int kept = 0;
    for (int i = 0; i < count_; ++i) {
      if (at(i).count == 0) continue;
      if (kept != i) at(kept) = at(i);
      ++kept;
    }
    count_ = kept;
    merge_to_fit();
  }
  ATL_ASSERT(count_ <= max_surface_manifolds, count_);
  result.count = 0;
  for (int i = 0; i < count_; ++i) {
    Manifold& manifold = result.manifolds[static_cast<std::size_t>(result.count++)];
    ATL_ASSERT(at(i).count > 0 && at(i).count <= max_candidates, i, at(i).count);
    manifold.reference_is_second = true;
    manifold.normal = at(i).normal;
    manifold.material = at(i).material;
    manifold.axis = 0;
    reduce_points(at(i).points.data(), at(i).count, manifold);
  }
}

}  // namespace atl::collision
