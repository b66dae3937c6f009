#pragma once

#include <collision/contacts/update_contacts.h>
#include <jobs/arrays.h>

#include <cstdint>
#include <span>
#include <vector>

namespace atl::collision {

/// Finds contacts with inner edges: edges and sides between solids that stand still and meet flush, as the tiles of a
/// floor do. They are inside of the one body that the solids make together, so nothing is to stop at them.
///
/// A contact's plane has the shape that moves on one side. A solid that reaches just to that plane from the other side
/// can only be touched in the plane, so a contact with it whose normal leans is one with an inner edge. (The union of
/// both solids has no such normal there: it is outside of the vertex's region in the union's Voronoi diagram.) Solids
/// that reach beyond the plane, as walls and steps do, keep their contacts. Memory is reused.
class InnerEdges {
 public:
  /// Lists the slots of these contacts among those that touch, which are in order. The cost is linear in what touches,
  /// and beyond that in pairs of solids that one shape touches.
  std::span<const std::uint32_t> find(const ContactCache& cache, const ContactUpdateInput& input,
                                      std::span<const TouchingPair> touching);

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

  void list(const ContactCache& cache, const ContactUpdateInput& input, std::span<const TouchingPair> touching);
  static bool ends_at(const ContactCache& cache, const ContactUpdateInput& input, const OnFixed& contact,
                      const OnFixed& other);
  void find_of_mover(const ContactCache& cache, const ContactUpdateInput& input, std::span<const OnFixed> contacts);

  std::vector<std::uint32_t> last_;  // by collider: 1 + which it touched last in the list; all 0 between calls
  std::vector<OnFixed> on_fixed_;    // of colliders that touch several
  std::vector<std::uint32_t> inner_;
};

}  // namespace atl::collision
