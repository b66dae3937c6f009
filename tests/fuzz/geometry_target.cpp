// Shapes of points and triangles as they come: flat, thin, doubled, tiny, huge. What is taken has a volume or closes as
// it says, and bodies of it lie, fall, are asked for and are written as any others.

#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "consistency.h"
#include "few_steps.h"
#include "target.h"

namespace {

using namespace atl;

// Points of a grid, so that many are in one plane, line or place; some are a little off it.
class Points {
 public:
  explicit Points(fuzz::Bytes& bytes) : bytes_(bytes), size_(std::pow(10.0, int(bytes.below(13)) - 6)) {
    for (double& stretch : stretches_) stretch = bytes.one_in(4) ? std::pow(10.0, -double(bytes.below(10))) : 1;
    noise_ = bytes.one_in(3) ? std::pow(10.0, -1 - double(bytes.below(15))) : 0;
  }

  std::vector<Vector3> take(std::size_t count) {
    std::vector<Vector3> points(count);
    for (Vector3& point : points) {
      for (int i = 0; i < 3; ++i) {
        const double place =
            bytes_.one_in(40) ? bytes_.any() : int(bytes_.below(9)) - 4 + noise_ * bytes_.within(-1, 1);
        point[i] = size_ * stretches_[static_cast<std::size_t>(i)] * place / 4;
      }
    }
    return points;
  }

 private:
  fuzz::Bytes& bytes_;
  double size_;
  std::array<double, 3> stretches_ = {};
  double noise_ = 0;
};

TriangleMesh mesh_of(fuzz::Bytes& bytes) {
  Points points(bytes);
  const std::vector<Vector3> vertices = points.take(3 + bytes.below(14));
  std::vector<TriangleMesh::Indices> triangles(1 + bytes.below(20));
  for (TriangleMesh::Indices& triangle : triangles) {
    for (std::uint32_t& index : triangle) index = bytes.below(vertices.size());
  }
  const TriangleMesh mesh(vertices, triangles, bytes.one_in(3) ? bytes.within(0, 3) : 0);
  return bytes.one_in(4) ? mesh.scaled(points.take(1).front()) : mesh;
}

HeightField field_of(fuzz::Bytes& bytes) {
  Points points(bytes);
  const std::uint32_t columns = 2 + bytes.below(4), rows = 2 + bytes.below(4);
  std::vector<double> heights;
  for (const Vector3& point : points.take(std::size_t{columns} * rows)) heights.push_back(point.z());
  const Vector3 spacing = points.take(1).front();
  return HeightField(columns, rows, spacing.x(), spacing.y(), heights, bytes.flag());
}

Shape solid_of(fuzz::Bytes& bytes) {
  Points points(bytes);
  const ConvexHull hull(points.take(4 + bytes.below(30)));
  if (bytes.one_in(4)) return hull.scaled(points.take(1).front());
  if (!bytes.one_in(4)) return hull;
  Compound compound;
  for (std::uint32_t left = 1 + bytes.below(3); left > 0; --left) {
    compound.children.push_back({.shape = hull, .position = points.take(1).front()});
  }
  return compound;
}

void run(fuzz::Bytes& bytes) {
  World world;
  const auto add = [&](const BodyDef& def) {
    fuzz::check_shape(def.shape);
    world.add_body(def);
  };
  fuzz::Definitions definitions(bytes, fuzz::Numbers::Any);
  for (std::uint32_t left = 1 + bytes.below(3); left > 0; --left) {
    try {
      switch (bytes.below(4)) {
        case 0:
          add({.type = BodyType::Static, .shape = mesh_of(bytes)});
          break;
        case 1:
          add({.type = BodyType::Kinematic, .shape = field_of(bytes), .angular_velocity = {0, 0, 1}});
          break;
        default:
          add({.shape = solid_of(bytes), .position = Points(bytes).take(1).front()});
      }
    } catch (const Error&) {
    }
  }
  fuzz::few_steps(world, 4);
  fuzz::check_queries(std::span(&world, 1), definitions, bytes);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  atl::fuzz::Bytes bytes({data, size});
  run(bytes);
  return 0;
}
