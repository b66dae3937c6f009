#pragma once
/// The state of a contact that lasts from step to step, for archives (state_archive.h).

#include <collision/contacts/contact.h>
#include <collision/contacts/refresh.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>

#include "world/refuse.h"

namespace atl {

namespace contact_flags {
// Beside the number of points, in the lowest three bits.
inline constexpr unsigned reference_is_second = 1u << 3;
inline constexpr unsigned apart = 1u << 4;      // of two solids that were found apart: little else counts
inline constexpr unsigned near_ids = 1u << 5;   // of points: they differ from the first in their 24 lowest bits only
inline constexpr unsigned wide_axis = 1u << 6;  // it needs more than 8 bits
inline constexpr unsigned rolling = 1u << 7;    // there is an impulse against rolling
}  // namespace contact_flags

/// The values that a contact's tolerance can have.
inline constexpr std::array<float, 3> contact_tolerances = {0, collision::flat_tolerance, collision::round_tolerance};

/// Which of six directions a normal is exactly: x, y, z, -x, -y, -z as 1 to 6. 0 for any other.
inline std::array<float, 3> normal_of_code(unsigned code) {
  std::array<float, 3> normal = {};
  normal[(code - 1) % 3] = code > 3 ? -1.0f : 1.0f;
  return normal;
}
inline unsigned code_of_normal(const std::array<float, 3>& normal) {
  for (unsigned code = 1; code <= 6; ++code) {
    const std::array<float, 3> axis = normal_of_code(code);
    if (std::memcmp(&axis, &normal, sizeof axis) == 0) return code;
  }
  return 0;
}

/// Tolerance and normal are one of a few values most of the time, whether that is a face's is a bit, and the material
/// has no number. Returns whether the normal was told by that.
template <typename Archive, typename Contact>
bool visit_tolerance_and_normal(Archive& archive, Contact& contact) {
  std::uint8_t kind = 0;
  if constexpr (!Archive::reads) {
    const auto tolerance = std::find(contact_tolerances.begin(), contact_tolerances.end(), contact.tolerance);
    kind = static_cast<std::uint8_t>((tolerance - contact_tolerances.begin()) | code_of_normal(contact.normal) << 2 |
                                     (contact.material != 0) << 5 | contact.on_face << 6);
  }
  archive.value(kind);
  const unsigned tolerance = kind & 3;
  const unsigned normal = kind >> 2 & 7;
  if ((kind >> 5 & 1) != 0) archive.value(contact.material);
  archive.check(tolerance < contact_tolerances.size() && normal <= 6 && kind >> 7 == 0,
                "a contact of no kind that there is");
  if constexpr (Archive::reads) {
    contact.set_tolerance(contact_tolerances[tolerance]);
    contact.on_face = (kind >> 6 & 1) != 0;
    if (normal != 0) contact.normal = normal_of_code(normal);
  }
  return normal != 0;
}

template <typename Archive, typename Contact>
void visit_ids(Archive& archive, Contact& contact, std::size_t count, bool near) {
  if (!near) return archive.values(contact.ids.data(), count);
  archive.value(contact.ids[0]);
  std::array<std::uint8_t, 3 * (collision::max_points - 1)> low;
  const std::size_t bytes = 3 * (count - 1);
  if constexpr (!Archive::reads) {
    for (std::size_t i = 0; i < bytes; ++i) {
      low[i] = static_cast<std::uint8_t>(contact.ids[1 + i / 3] >> (8 * (i % 3)));
    }
  }
  archive.values(low.data(), bytes);
  if constexpr (Archive::reads) {
    constexpr collision::FeatureId low_bits = (1u << 24) - 1;
    for (std::size_t i = 1; i < count; ++i) contact.ids[i] = contact.ids[0] & ~low_bits;
    for (std::size_t i = 0; i < bytes; ++i) contact.ids[1 + i / 3] |= collision::FeatureId{low[i]} << (8 * (i % 3));
  }
}

/// Returns true if all numbers of a contact with points are finite, and places in bounds.
template <typename Contact, typename Manifold>
bool is_sound_contact(const Contact& contact, const Manifold& manifold) {
  // Two shapes as large as they may be overlap by twice that, and by what their bodies are off.
  constexpr double max = 4 * numbers.max;
  const auto sound = [](const auto& values) {
    return std::ranges::all_of(values, [](auto x) { return std::abs(x) <= max; });
  };
  // Impulses are as large as masses and speeds make them.
  const auto finite = [](const auto& values) {
    return std::ranges::all_of(values, [](auto x) { return std::isfinite(x); });
  };
  return sound(std::array{contact.margin}) && sound(contact.orientation) && sound(contact.normal) &&
         sound(contact.centre_incident) && sound(contact.centre_reference) &&
         std::all_of(contact.points.begin(), contact.points.begin() + contact.count, sound) &&
         finite(std::array{manifold.torsional_impulse}) && finite(manifold.normal_impulse) &&
         finite(manifold.friction_impulse);
}

/// A contact but for its pair and what follows from that, and where its points are: of bodies that move the next step
/// finds out about that before it asks, and of others it follows from their poses. `rolling` is what SurfaceContact
/// has of it, or null if it has none that counts.
template <typename Archive, typename Contact, typename Manifold, typename Rolling>
void visit_contact(Archive& archive, Contact& contact, Manifold& manifold, Rolling* rolling) {
  namespace is = contact_flags;
  std::uint8_t flags = 0;
  if constexpr (!Archive::reads) {
    bool near = contact.count > 1;
    for (std::size_t i = 1; i < contact.count; ++i) near &= (contact.ids[0] ^ contact.ids[i]) >> 24 == 0;
    flags =
        static_cast<std::uint8_t>(contact.count | (contact.reference_is_second ? is::reference_is_second : 0) |
                                  (contact.gap > 0 ? is::apart : 0) | (near ? is::near_ids : 0) |
                                  (contact.axis > 0xff ? is::wide_axis : 0) | (rolling != nullptr ? is::rolling : 0));
  }
  archive.value(flags);
  if constexpr (Archive::reads) {
    contact.count = flags & 7;
    archive.check(contact.count <= collision::max_points, "a contact of too many points");
    contact.reference_is_second = (flags & is::reference_is_second) != 0;
    archive.check(!(flags & is::apart) || contact.count == 0, "a contact of shapes apart that has points");
    archive.check(!(flags & is::near_ids) || contact.count > 1, "a contact with ids of points that it hasn't");
    archive.check(!(flags & is::rolling) || rolling != nullptr, "an impulse against rolling where nothing rolls");
    contact.axis = 0;
    contact.material = 0;
    contact.set_tolerance(0);
    contact.on_face = false;
    contact.gap = 0;
    collision::forget_impulses(manifold);
    if (rolling != nullptr) std::fill_n(rolling, 3, 0.0f);
  }
  if ((flags & is::apart) != 0) {
    archive.value(contact.gap);
    archive.check(contact.gap > 0, "a contact of shapes apart without a gap");
    archive.value(contact.radius);
    archive.values(contact.apart_from.data(), 3);
    archive.value(contact.turned);
    return;
  }
  archive.value(contact.margin);
  bool normal_stored = false;
  if constexpr (Archive::hashes) {
    archive.value(contact.tolerance);
    archive.value(static_cast<std::uint8_t>(contact.on_face));
    if (contact.material != 0) archive.value(contact.material);
  } else {
    normal_stored = visit_tolerance_and_normal(archive, contact);
  }
  if ((flags & is::wide_axis) != 0) {
    archive.value(contact.axis);
  } else {
    auto axis = static_cast<std::uint8_t>(contact.axis);
    archive.value(axis);
    if constexpr (Archive::reads) contact.axis = axis;
  }
  archive.values(contact.orientation.data(), 4);
  if (!normal_stored) archive.values(contact.normal.data(), 3);
  archive.values(contact.centre_incident.data(), 3);
  archive.values(contact.centre_reference.data(), 3);
  const std::size_t count = contact.count;
  if constexpr (Archive::reads) {
    for (std::size_t i = count; i < collision::max_points; ++i) contact.points[i] = {0, 0, 0, collision::no_point};
  }
  if (count == 0) return;
  visit_ids(archive, contact, count, (flags & is::near_ids) != 0);
  archive.values(contact.points[0].data(), 4 * count);
  archive.values(manifold.normal_impulse, count);
  archive.values(manifold.friction_impulse, 3);
  archive.value(manifold.torsional_impulse);
  if ((flags & is::rolling) != 0) archive.values(rolling, 3);
  if constexpr (Archive::reads) {
    archive.check_number(is_sound_contact(contact, manifold), "a contact whose state is not finite, or out of bounds");
  }
}

}  // namespace atl
