#include "narrowphase/gjk.h"

#include <jobs/assert.h>

#include <cmath>
#include <limits>

namespace atl::collision {
namespace {

// Boxes need 3, pairs of cylinders and cones 20 on average and at most 100, of 1.6 million random pairs.
constexpr int max_iterations = 100;

// Part of the distance by which it may exceed the proven bound.
constexpr double tolerance = 1e-14;

struct SimplexVertex {
  Vector3 difference;  // second - first
  Vector3 on_first;
  Vector3 on_second;
};

// The feature of a simplex that lies nearest to the origin.
struct Nearest {
  Vector3 point = Vector3::Zero();
  double square = std::numeric_limits<double>::infinity();
  int count = 0;
  int vertex[3] = {0, 0, 0};
  double weight[3] = {1, 0, 0};
};

struct Simplex {
  SimplexVertex vertices[4];
  int count = 0;

  const Vector3& at(int i) const { return vertices[i].difference; }
};

void offer_point(const Simplex& simplex, int i, Nearest& best) {
  const double square = simplex.at(i).squaredNorm();
  if (square >= best.square) return;
  best = {simplex.at(i), square, 1, {i, 0, 0}, {1, 0, 0}};
}

void offer_segment(const Simplex& simplex, int i, int j, Nearest& best) {
  const Vector3& p = simplex.at(i);
  const Vector3& q = simplex.at(j);
  const Vector3 along = q - p;
  const double square = along.squaredNorm();
  const double from_p = -p.dot(along);
  const double from_q = q.dot(along);
  if (!(from_p > 0 && square > 0)) return offer_point(simplex, i, best);
  if (!(from_q > 0)) return offer_point(simplex, j, best);
  // Measured from the nearer end, so that little precision is lost if the other end is far away.
  const double t = from_p / square;
  const double s = from_q / square;
  const Vector3 point = t < s ? Vector3(p + t * along) : Vector3(q - s * along);
  const double distance_square = point.squaredNorm();
  if (distance_square < best.square) best = {point, distance_square, 2, {i, j, 0}, {1 - t, t, 0}};
}

// The triangle's edges come only at its last vertex, k: that vertex is the newest, and the feature across from
// it was the nearest one before, which it improved on.
void offer_triangle(const Simplex& simplex, int i, int j, int k, double noise, Nearest& best) {
  const Vector3& p = simplex.at(i);
  const Vector3& q = simplex.at(j);
  const Vector3& r = simplex.at(k);
  const Vector3 edges[3] = {q - p, r - q, p - r};
  const double lengths[3] = {edges[0].squaredNorm(), edges[1].squaredNorm(), edges[2].squaredNorm()};
  // The two shorter edges, and the height at the vertex nearest to the origin: where the triangle is long and
  // thin or lies far out on one side, the others would drown the height in rounding.
  const int longest =
      lengths[0] >= lengths[1] ? (lengths[0] >= lengths[2] ? 0 : 2) : (lengths[1] >= lengths[2] ? 1 : 2);
  const int after = (longest + 1) % 3;
  const int before = (longest + 2) % 3;
  const Vector3 normal = edges[after].cross(edges[before]);
  const double square = normal.squaredNorm();
  const double weight_p = normal.dot(q.cross(edges[1]));
  const double weight_q = normal.dot(r.cross(edges[2]));
  const double weight_r = normal.dot(p.cross(edges[0]));
  const double flat = 16 * noise;  // lower than this, rounding decides where it faces: its edges are all there is
  if (weight_p > 0 && weight_q > 0 && weight_r > 0 && square > flat * flat * lengths[longest]) {
    const double to_p = p.squaredNorm();
    const double to_q = q.squaredNorm();
    const double to_r = r.squaredNorm();
    const Vector3& base = to_p <= to_q ? (to_p <= to_r ? p : r) : (to_q <= to_r ? q : r);
    const double height = normal.dot(base) / square;
    const Vector3 point = height * normal;
    const double distance_square = point.squaredNorm();
    const double sum = weight_p + weight_q + weight_r;
    if (distance_square < best.square) {
      best = {point, distance_square, 3, {i, j, k}, {weight_p / sum, weight_q / sum, weight_r / sum}};
    }
    return;
  }
  offer_segment(simplex, i, k, best);
  offer_segment(simplex, j, k, best);
}

// True if the origin lies beyond a face, seen from the vertex `across`; also if the tetrahedron is so flat that
// rounding decides.
bool beyond_face(const Simplex& simplex, int i, int j, int k, int across) {
  const Vector3& r = simplex.at(k);
  const Vector3 normal = (simplex.at(i) - r).cross(simplex.at(j) - r);
  const Vector3 to_across = simplex.at(across) - r;
  const double inside = normal.dot(to_across);
  const double origin = -normal.dot(r);
  const double noise = 1e-15 * normal.norm() * to_across.norm();
  return std::abs(inside) <= noise || (inside > 0 ? origin < 0 : origin > 0);
}

// False if the origin lies in the simplex. The last vertex is the newest.
bool find_nearest(const Simplex& simplex, double noise, Nearest& best) {
  best.square = std::numeric_limits<double>::infinity();
  switch (simplex.count) {
    case 1:
      offer_point(simplex, 0, best);
      return true;
    case 2:
      offer_segment(simplex, 0, 1, best);
      return true;
    case 3:
      offer_triangle(simplex, 0, 1, 2, noise, best);
      return true;
    default: {
      bool outside = false;
      constexpr int faces[3][3] = {{0, 1, 2}, {1, 2, 0}, {2, 0, 1}};
      for (const auto& face : faces) {
        if (!beyond_face(simplex, face[0], face[1], 3, face[2])) continue;
        outside = true;
        offer_triangle(simplex, face[0], face[1], 3, noise, best);
      }
      return outside;
    }
  }
}

// Drops the vertices that the nearest feature doesn't have.
void reduce(Simplex& simplex, Nearest& nearest) {
  SimplexVertex kept[3];
  ATL_ASSERT(nearest.count >= 1 && nearest.count <= 3, nearest.count);
  for (int i = 0; i < nearest.count; ++i) kept[i] = simplex.vertices[nearest.vertex[i]];
  simplex.count = nearest.count;
  for (int i = 0; i < nearest.count; ++i) {
    simplex.vertices[i] = kept[i];
    nearest.vertex[i] = i;
  }
}

Vector3 weighted(const Simplex& simplex, const Nearest& nearest, Vector3 SimplexVertex::*point) {
  Vector3 sum = Vector3::Zero();
  for (int i = 0; i < nearest.count; ++i) sum += nearest.weight[i] * (simplex.vertices[nearest.vertex[i]].*point);
  return sum;
}

// A thin triangle's weights may be lost to rounding, though not its plane. Its nearest edge then has a point as good;
// and where the plane is lost too, which the proven bound shows, a better one.
void mend_thin_triangle(const Simplex& simplex, double lower_bound, double noise, Nearest& nearest) {
  const double miss = (weighted(simplex, nearest, &SimplexVertex::difference) - nearest.point).norm();
  const bool plane_lost = lower_bound > noise && nearest.square < (lower_bound - noise) * (lower_bound - noise);
  if (miss <= 64 * noise && !plane_lost) return;
  Nearest edge;
  offer_segment(simplex, 0, 1, edge);
  offer_segment(simplex, 1, 2, edge);
  offer_segment(simplex, 2, 0, edge);
  if (plane_lost) {
    nearest = edge;
  } else if ((edge.point - nearest.point).norm() < miss) {
    const Vector3 point = nearest.point;
    const double square = nearest.square;
    nearest = edge;
    nearest.point = point;
    nearest.square = square;
  }
}

bool contains(const Simplex& simplex, const Vector3& difference) {
  for (int i = 0; i < simplex.count; ++i) {
    if (simplex.at(i) == difference) return true;
  }
  return false;
}

}  // namespace

GjkResult gjk_distance(const ConvexCore& first, const ConvexCore& second, const Placement& placement,
                       const Vector3& guess) {
  const auto support = [&](const Vector3& direction) {
    SimplexVertex vertex;
    vertex.on_first = first.support(direction);
    const Vector3 turned = placement.rotation.transpose() * -direction;
    vertex.on_second = placement.position + placement.rotation * second.support(turned);
    vertex.difference = vertex.on_second - vertex.on_first;
    return vertex;
  };
  // Rounding error of a difference's coordinates, and what distances below it mean: touching.
  const double scale = first.extent + second.extent + placement.position.norm();
  const double noise = 4 * std::numeric_limits<double>::epsilon() * scale;

  Simplex simplex;
  simplex.vertices[0] = support(guess.squaredNorm() > 0 ? guess : Vector3::UnitX());
  simplex.count = 1;
  Nearest nearest;
  find_nearest(simplex, noise, nearest);
  GjkResult result;
  bool overlap = false;
  for (; result.iterations < max_iterations; ++result.iterations) {
    const double distance = std::sqrt(nearest.square);
    if (!(distance > noise)) {
      overlap = true;
      break;
    }
    const SimplexVertex fresh = support(nearest.point);
    const double bound = nearest.point.dot(fresh.difference) / distance;
    if (bound > result.lower_bound) {
      result.lower_bound = bound;
      result.bound_normal = nearest.point / distance;
    }
    if (distance - result.lower_bound <= noise + tolerance * distance || contains(simplex, fresh.difference)) break;
    ATL_ASSERT(simplex.count >= 1 && simplex.count <= 3, simplex.count, result.iterations);
    Simplex grown = simplex;
    grown.vertices[grown.count++] = fresh;
    Nearest next;
    const bool outside = find_nearest(grown, noise, next);
    if (!outside) {
      // A plane that parts the two is the better witness: then the tetrahedron is flat but for rounding.
      overlap = result.lower_bound <= noise;
      break;
    }
    if (next.square >= nearest.square) break;
    simplex = grown;
    nearest = next;
    reduce(simplex, nearest);
  }
  if (overlap) {
    result.lower_bound = 0;
    result.distance = 0;
  } else {
    if (nearest.count == 3) mend_thin_triangle(simplex, result.lower_bound, noise, nearest);
    result.distance = std::sqrt(nearest.square);
    result.normal = nearest.point / result.distance;
  }
  result.on_first = weighted(simplex, nearest, &SimplexVertex::on_first);
  result.on_second = weighted(simplex, nearest, &SimplexVertex::on_second);
  return result;
}

}  // namespace atl::collision
