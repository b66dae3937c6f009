#pragma once
/// Definitions of bodies, joints, settings and queries, chosen from bytes.

#include <atoll/atoll.h>
#include <atoll/queries.h>

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bytes.h"

namespace atl::fuzz {

/// The range of a definition's numbers.
enum class Numbers {
  Usual,  ///< sizes of metres and all valid: nothing may be refused, and results can be held against others
  Any     ///< now and then infinite, not a number, absurd or out of range
};

class Definitions {
 public:
  Definitions(Bytes& bytes, Numbers numbers) : bytes_(bytes), numbers_(numbers) {}

  bool has_normal_numbers() const { return numbers_ == Numbers::Usual; }

  /// In [lower, upper], or any.
  double number(double lower, double upper);
  int integer(int lower, int upper);
  Vector3 vector(double reach);
  Quaternion orientation();
  std::string name();

  Shape shape(BodyType type);
  ConvexShape convex();
  Material material();
  CollisionFilter filter();
  BodyDef body();

  JointKind joint_kind();
  JointAxis axis(bool angle);
  /// Over joints of the world, of which there are some.
  JointDef tendon(const World& world);
  /// Between two of the bodies.
  JointDef joint(const World& world, BodyId first, BodyId second);

  /// Changed here and there from those given.
  Settings settings(Settings settings);
  /// The same with a target, or without one.
  Settings with_target(Settings settings);
  QueryShape query_shape();
  ShapeCast shape_cast();
  Ray ray();

 private:
  ConvexHull hull();
  TriangleMesh mesh();
  HeightField height_field();
  Compound compound();

  Bytes& bytes_;
  Numbers numbers_;
};

}  // namespace atl::fuzz
