// Two flat faces that meet make a manifold that holds them against turning over: three points at least, four where the
// faces' overlap has four corners or more, all as deep as the faces overlap, spread over the overlap.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <numbers>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "support/colliding.h"
#include "support/min_turn.h"
#include "support/placing.h"

namespace atl::test::manifold_faces_test {
namespace {

using std::numbers::pi;
using Vector2 = Eigen::Vector2d;
using Polygon = std::vector<Vector2>;

constexpr int pairs_wanted = 2000;
const std::array<const char*, 5> kind_names = {"Box", "Cylinder", "Cone", "Hull", "HalfSpace"};

/// A flat face in the frame of its shape.
struct Face {
  Vector3 normal;                ///< unit, outwards
  std::vector<Vector3> corners;  ///< around the normal; 96 for a disc
};

Face disc(double radius, double height, double sign) {
  Face face{sign * Vector3::UnitZ(), {}};
  for (int i = 0; i < 96; ++i) {
    const double angle = sign * 2 * pi * i / 96;
    face.corners.emplace_back(radius * std::cos(angle), radius * std::sin(angle), height);
  }
  return face;
}

struct Faced {
  Shape shape;
  Face face;
};

double spread(RandomPlaces& random) { return std::pow(10, random.between(-0.4, 0.4)); }

Faced random_faced(int kind, RandomPlaces& random) {
  const double size = spread(random);
  const double sign = random.between(-1, 1) < 0 ? -1 : 1;
  if (kind == 0) {
    const Vector3 half = size * Vector3(1, spread(random), spread(random));
    const Vector3 x(half.x(), 0, 0), y(0, sign * half.y(), 0), z(0, 0, sign * half.z());
    return {Box{half}, {sign * Vector3::UnitZ(), {z + x + y, z - x + y, z - x - y, z + x - y}}};
  }
  const double half_height = size * spread(random);
  if (kind == 1) return {Cylinder{size, half_height}, disc(size, sign * half_height, sign)};
  if (kind == 2) return {Cone{size, half_height}, disc(size, -half_height, -1)};
  if (kind == 4) return {HalfSpace{}, {Vector3::UnitZ(), {}}};
  // A frustum with a random polygon below, so that there is a face of some size.
  std::vector<Vector3> points;
  const double corners = std::floor(random.between(3, 9));
  for (double i = 0; i < corners; ++i) {
    const double angle = 2 * pi * (i + random.between(-0.3, 0.3)) / corners;
    points.emplace_back(size * std::cos(angle), size * std::sin(angle), -half_height);
    points.emplace_back(0.7 * points.back().x(), 0.7 * points.back().y(), half_height);
  }
  Face face{-Vector3::UnitZ(), {}};
  for (std::size_t i = points.size(); i >= 2; i -= 2) face.corners.push_back(points[i - 2]);
  return {ConvexHull(points), face};
}

double area(const Polygon& polygon) {
  double twice = 0;
  for (std::size_t i = 0; i < polygon.size(); ++i) {
    const Vector2& p = polygon[i];
    const Vector2& q = polygon[(i + 1) % polygon.size()];
    twice += p.x() * q.y() - p.y() * q.x();
  }
  return twice / 2;
}

/// The part of a polygon that lies in a convex one; both counter-clockwise.
Polygon clip(Polygon polygon, const Polygon& window) {
  for (std::size_t i = 0; i < window.size(); ++i) {
    const Vector2& tail = window[i];
    const Vector2 along = window[(i + 1) % window.size()] - tail;
    const auto inside = [&](const Vector2& p) { return along.x() * (p - tail).y() - along.y() * (p - tail).x(); };
    Polygon kept;
    for (std::size_t j = 0; j < polygon.size(); ++j) {
      const Vector2& p = polygon[j];
      const Vector2& q = polygon[(j + 1) % polygon.size()];
      const double at_p = inside(p);
      const double at_q = inside(q);
      if (at_p >= 0) kept.push_back(p);
      if ((at_p >= 0) != (at_q >= 0)) kept.push_back(p + at_p / (at_p - at_q) * (q - p));
    }
    polygon = std::move(kept);
  }
  return polygon;
}

/// Corners that matter: without those that add less than a hundredth to the area.
std::size_t corner_count(Polygon polygon) {
  const double min = 0.01 * area(polygon);
  for (;;) {
    std::size_t smallest = polygon.size();
    double smallest_area = min;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
      const std::size_t before = (i + polygon.size() - 1) % polygon.size();
      const double corner = area({polygon[before], polygon[i], polygon[(i + 1) % polygon.size()]});
      if (corner < smallest_area) {
        smallest_area = corner;
        smallest = i;
      }
    }
    if (smallest == polygon.size() || polygon.size() <= 3) return polygon.size();
    polygon.erase(polygon.begin() + static_cast<std::ptrdiff_t>(smallest));
  }
}

/// Area that up to four points span.
double spanned(Polygon points) {
  Vector2 middle = Vector2::Zero();
  for (const Vector2& point : points) middle += point / static_cast<double>(points.size());
  std::sort(points.begin(), points.end(), [&](const Vector2& p, const Vector2& q) {
    return std::atan2((p - middle).y(), (p - middle).x()) < std::atan2((q - middle).y(), (q - middle).x());
  });
  return area(points);
}

struct Combination {
  int first, second;
};

class ManifoldsOfFaces : public testing::TestWithParam<Combination> {};

TEST_P(ManifoldsOfFaces, HaveThreePointsOrFour) {
  const auto [first, second] = GetParam();
  RandomPlaces random(static_cast<unsigned>(first * 10 + second));
  int pairs = 0, few = 0, turned = 0, uneven = 0, narrow = 0;
  double narrowest = 1;
  std::ostringstream example;
  for (int index = 0; pairs < pairs_wanted && index < 20 * pairs_wanted; ++index) {
    const Faced on_a = random_faced(first, random);
    const Faced on_b = random_faced(second, random);
    Posed a = posed(on_a.shape);
    Posed b = posed(on_b.shape);
    const double size = std::min(a.colliding.inner_radius, b.colliding.inner_radius);
    const double depth = size * std::pow(10, random.between(-5, -2));
    a.pose = {random.vector(-1, 1), random.orientation()};
    const Vector3 normal = a.pose.orientation * on_a.face.normal;
    const Quaternion facing(min_turn(b.pose.orientation * on_b.face.normal, -normal));
    b.pose.orientation = turn(random.between(0, 2 * pi), normal) * facing;
    b.pose.position = random.vector(-1, 1);

    // The faces in the plane of the first, about its first corner.
    const Vector3 x = (a.pose.orientation * (on_a.face.corners[1] - on_a.face.corners[0])).normalized();
    const Vector3 y = normal.cross(x);
    const Vector3 origin = a.pose.position + a.pose.orientation * on_a.face.corners[0];
    const auto flat = [&](const Vector3& p) { return Vector2(x.dot(p - origin), y.dot(p - origin)); };
    const auto flat_face = [&](const Posed& shape, const Face& face) {
      Polygon polygon;
      for (const Vector3& corner : face.corners) {
        polygon.push_back(flat(shape.pose.position + shape.pose.orientation * corner));
      }
      return polygon;
    };
    const Polygon face_a = flat_face(a, on_a.face);
    Polygon meeting = face_a;
    if (second == 4) {
      b.pose.position += normal * (normal.dot(origin - b.pose.position) - depth);
    } else {
      // One random point of each face upon the other's.
      const auto point_of = [&](const Posed& shape, const Face& face) {
        Vector3 point = Vector3::Zero();
        double sum = 0;
        for (const Vector3& corner : face.corners) {
          const double weight = random.between(0, 1);
          point += weight * corner;
          sum += weight;
        }
        return Vector3(shape.pose.position + shape.pose.orientation * (point / sum));
      };
      const double aside = random.between(0, 1.2) * size;
      b.pose.position += point_of(a, on_a.face) - point_of(b, on_b.face) - depth * normal +
                         aside * (turn(random.between(0, 2 * pi), normal) * x);
      Polygon face_b = flat_face(b, on_b.face);
      std::reverse(face_b.begin(), face_b.end());
      meeting = clip(face_b, face_a);
      if (meeting.size() < 3 || area(meeting) < 0.02 * std::min(area(face_a), area(face_b))) continue;
    }
    const audit::Penetration exact = audit::penetration(a.placed(), b.placed());
    if (degrees_between(exact.normal, normal) > 1e-3) continue;  // there is a shorter way out, sideways
    ++pairs;

    const Found found = collide(a, b, 0.01 * size);
    const int wanted = corner_count(meeting) >= 4 ? 4 : 3;
    if (degrees_between(found.normal, normal) > 0.1) ++turned;
    if (std::max(std::abs(found.depth - depth), std::abs(found.shallowest - depth)) > 1e-4 * size) ++uneven;
    Polygon points;
    for (const Vector3& point : found.points) points.push_back(flat(point));
    const double share = spanned(points) / area(meeting);
    narrowest = std::min(narrowest, share);
    if (found.count < wanted && few++ == 0) {
      example << "pair " << index << ": " << found.count << " points span " << share << " of an overlap with "
              << corner_count(meeting) << " corners:";
      for (const Vector2& corner : meeting) example << " (" << corner.transpose() << ")";
      example << "; found";
      for (const Vector2& point : points) example << " (" << point.transpose() << ")";
    }
    if (share < 0.4) ++narrow;
  }
  std::cout << kind_names[static_cast<std::size_t>(first)] << "-" << kind_names[static_cast<std::size_t>(second)]
            << ": " << pairs << " pairs, " << few << " with too few points, " << turned << " normals off, " << uneven
            << " unevenly deep, " << narrow << " narrow (the narrowest spans " << narrowest << " of the overlap)\n";
  EXPECT_EQ(pairs, pairs_wanted);
  EXPECT_EQ(few, 0) << example.str();
  EXPECT_EQ(turned, 0);
  EXPECT_EQ(uneven, 0);
  EXPECT_EQ(narrow, 0);
}

std::vector<Combination> all_combinations() {
  std::vector<Combination> result;
  for (int first = 0; first < 4; ++first) {
    for (int second = first; second < 5; ++second) result.push_back({first, second});
  }
  return result;
}

INSTANTIATE_TEST_SUITE_P(All, ManifoldsOfFaces, testing::ValuesIn(all_combinations()), [](const auto& pair) {
  return std::string(kind_names[static_cast<std::size_t>(pair.param.first)]) +
         kind_names[static_cast<std::size_t>(pair.param.second)];
});

}  // namespace
}  // namespace atl::test::manifold_faces_test
