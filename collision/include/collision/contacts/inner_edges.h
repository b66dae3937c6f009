#pragma once

#include <collision/contacts/contact_cache.h>
#include <collision/contacts/touching_pair.h>
#include <collision/shapes/collider_table.h>
#include <jobs/arrays.h>

#include <cstdint>
#include <span>
#include <vector>

namespace atl::collision {

/// Finds contacts at edges that are none: where solids that stand still meet flush, as the tiles of a floor do, the
/// edges and sides between them are inside of what they make together, and no body is to stop at one.
///
/// Where a shape that moves touches one solid, the plane of the contact has the shape on one side. A solid that reaches
/// just to that plane from the other side can't be touched but in the plane: a contact with it whose normal leans is
/// one with an inner edge. (Its normal is none that the union of both has there, as a vertex's region in Voronoi's
/// diagram of the union says.) What reaches beyond the plane, as a wall or a step does, is left. Memory is reused.
class InnerEdges {
 public:
  /// Lists the slots of these contacts among those that touch, which are in order. `mobility` by body: 0 if it stands
  /// still. The cost is linear in what touches, and beyond that in pairs of solids that one shape touches.
  std::span<const std::uint32_t> find(const ContactCache& cache, const ColliderTable& colliders, const PoseView& poses,
                                      std::span<const std::uint8_t> mobility, std::span<const TouchingPair> touching);

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(last_, on_fixed_, inner_); }

 private:
  // A contact of a collider that moves with one that stands still.
  struct OnFixed {
    std::uint32_t mover;
    std::uint32_t collider;
    std::uint32_t slot;
    Vector3 normal = Vector3::UnitZ();  // from what stands still
    Vector3 plane = Vector3::UnitZ();   // normal of the face there, or the same
    double least_lean = 0;              // sine of the angle from which the normal leans
    double offset = 0;                  // m, of what is in that plane, along its normal
  };

  void list(const ContactCache& cache, const ColliderTable& colliders, const PoseView& poses,
            std::span<const std::uint8_t> mobility, std::span<const TouchingPair> touching);
  static bool ends_at(const ContactCache& cache, const ColliderTable& colliders, const PoseView& poses,
                      const OnFixed& contact, const OnFixed& other);
  void find_of_mover(const ContactCache& cache, const ColliderTable& colliders, const PoseView& poses,
                     std::span<const OnFixed> contacts);

  std::vector<std::uint32_t> last_;  // by collider: 1 + which it touched last in the list; all 0 between calls
  std::vector<OnFixed> on_fixed_;    // of colliders that touch several
  std::vector<std::uint32_t> inner_;
};

}  // namespace atl::collision
