#pragma once
/// Surface properties of a body, and the filter of bodies that it may touch.

#include <array>
#include <cstdint>
#include <optional>

namespace atl {

/// How a coefficient of two touching bodies follows from that of each. Where their materials ask for different rules,
/// the one that stands later here counts.
enum class CombineRule : std::uint32_t {
  Default,  ///< GeometricMean of friction, Max of restitution
  Average,
  GeometricMean,
  Min,
  Multiply,
  Max,
};

/// Surface properties. Of two touching bodies friction and restitution follow by CombineRule, and everything else is
/// the larger of the two. Restitution is along the normal alone: no spin comes back from it.
struct Material {
  double friction = 0.6;  ///< Coulomb coefficient, >= 0
  /// Coulomb coefficient across `friction_direction`, where there is one, >= 0.
  double friction_across = 0.6;
  /// Body frame, of any length: `friction` acts along it, as along a skate, a rail or a wheel's rim. Zero: friction is
  /// alike in all directions. In the plane of a contact its bound is the shadow of the ellipsoid with these half axes,
  /// and what slips is held back as takes the most energy (Michalowski and Mroz, Archives of Mechanics 30, 1978). Where
  /// both bodies have a direction, the axes are those of the one whose two coefficients differ more.
  std::array<double, 3> friction_direction = {};
  double restitution = 0.0;  ///< Newton coefficient, in [0, 1]
  /// m, >= 0: the torque that holds back rolling is at most this times the normal force, as if that acted so far ahead
  /// of the contact (Johnson, "Contact Mechanics", 9.2).
  double rolling_friction = 0;
  /// m, >= 0: the torque that holds back spinning about the normal is at most this times the normal force, on top of
  /// what the friction of a contact's points comes to.
  double torsional_friction = 0;
  CombineRule friction_rule = CombineRule::Default;
  CombineRule restitution_rule = CombineRule::Default;
  std::uint64_t id = 0;  ///< a number of yours for World::set_material_pair(), or 0

  bool is_directed() const { return friction_direction != std::array<double, 3>(); }
  bool operator==(const Material&) const = default;
};

/// Numbers of two materials that touch, whatever would follow from each. Those left out still follow from them.
struct MaterialPair {
  std::uint64_t first = 0;  ///< Material::id of the two, in either order; not 0
  std::uint64_t second = 0;
  std::optional<double> friction = {};  ///< Coulomb coefficient, >= 0
  /// The same across a material's `friction_direction`; `friction` if left out.
  std::optional<double> friction_across = {};
  std::optional<double> restitution = {};  ///< Newton coefficient, in [0, 1]

  bool operator==(const MaterialPair&) const = default;
};

/// Which bodies may touch. Two do if the mask of each has a bit of the other's category, unless they share a
/// group other than 0: then they do if it is positive, and don't if it is negative.
struct CollisionFilter {
  std::uint32_t category = 1;
  std::uint32_t mask = ~0u;
  std::int32_t group = 0;

  bool operator==(const CollisionFilter&) const = default;
};

}  // namespace atl
