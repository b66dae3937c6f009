#pragma once

#include <collision/contacts/update_contacts.h>
#include <jobs/arrays.h>
#include <jobs/compact_array.h>

#include <cstdint>
#include <optional>
#include <span>

namespace atl::collision {

/// Finds contacts with inner edges: edges and sides between solids that stand still, or are parts of one body, and meet
/// flush, as the tiles of a floor do. They are inside of the one body that the solids make together (the ground, here),
/// so nothing is to stop at them.
///
/// A contact's plane has the shape that meets the ground on one side. A solid that reaches just to that plane from the
/// other side can only be touched in the plane, so a contact with it whose normal leans is one with an inner edge. (The
/// union of both solids has no such normal there: it is outside of the vertex's region in the union's Voronoi diagram.)
/// Solids that reach beyond the plane, as walls and steps do, keep their contacts.
///
/// A solid may also stand on that plane with an edge, as a ramp does on a floor. What comes over the floor can't be
/// touched by the edge before it is touched by the face that rises from it, since it would have to be in the floor. So
/// its contact is with the plane of that face, not with the edge, whose normal leans back. Memory is reused.
class InnerEdges {
 public:
  /// Lists the slots of contacts to leave out among those that touch, which are in order; turns those with edges that
  /// stand on a plane, and counts their points. The cost is linear in what touches, and beyond that in pairs of solids
  /// that one shape touches.
  std::span<const std::uint32_t> find(ContactCache& cache, const ContactUpdateInput& input, ContactUpdate& update);

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(met_, on_ground_, inner_); }

 private:
  // A contact of a body with the ground.
  struct OnGround {
    std::uint32_t mover;     // the body
    std::uint32_t ground;    // its number, see inner_edges.cpp
    std::uint32_t own;       // collider of the body
    std::uint32_t collider;  // of the ground
    std::uint32_t slot;
    Vector3 normal = Vector3::UnitZ();  // from the ground
    Vector3 plane = Vector3::UnitZ();   // normal of the face there, or the same
    bool on_face = false;               // the normal is nearly that of a face
    double min_lean = 0;                // sine of the angle from which the normal leans
    double offset = 0;                  // m, of what is in that plane, along its normal
  };

  // A face of a solid, in its frame.
  struct Plane {
    Vector3 normal;
    double offset;  // m
  };

  void list(const ContactCache& cache, const ContactUpdateInput& input, std::span<const TouchingPair> touching);
  static void measure(const Contact& contact, const ContactManifold& manifold, const ContactUpdateInput& input,
                      bool ground_is_first, OnGround& found);
  static bool ends_at(const ContactCache& cache, const ContactUpdateInput& input, const OnGround& contact,
                      const OnGround& other);
  static std::optional<Plane> face_above(const ContactCache& cache, const ContactUpdateInput& input,
                                         const OnGround& contact, const OnGround& other);
  void find_of_mover(ContactCache& cache, const ContactUpdateInput& input, std::span<const OnGround> contacts,
                     ContactUpdate& update);

  jobs::CompactArray<std::uint8_t> met_;  // by body: pairs of shapes in which it meets the ground; all 0 between calls
  jobs::CompactArray<OnGround> on_ground_;  // of bodies that meet it in several pairs
  jobs::CompactArray<std::uint32_t> inner_;
};

}  // namespace atl::collision
