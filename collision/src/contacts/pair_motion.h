#pragma once

// The relative pose and motion of the two shapes of a contact in a step.

#include <collision/contacts/meeting.h>
#include <collision/contacts/update_contacts.h>

namespace atl::collision {

// m, of the second body against the first in this step.
inline Vector3 shift_between(const Contact& contact, const ContactUpdateInput& input) {
  const float(&first)[3] = input.reaches[contact.body_first].shift;
  const float(&second)[3] = input.reaches[contact.body_second].shift;
  return {second[0] - first[0], second[1] - first[1], second[2] - first[2]};
}

// m, world: origin of the second shape from the first's.
inline Vector3 origins_apart(const Contact& contact, const ContactUpdateInput& input) {
  if (!contact.has_local_offset) {
    return input.poses.position(contact.body_second) - input.poses.position(contact.body_first);
  }
  return input.colliders.position(contact.pair.second, input.poses) -
         input.colliders.position(contact.pair.first, input.poses);
}

// The sum of how far both bodies have turned, see ContactUpdateInput::turned.
inline double turned_by_both(const Contact& contact, const ContactUpdateInput& input) {
  return input.turned[contact.body_first] + input.turned[contact.body_second];
}

// m: how much nearer the two get in this step at most.
inline double approach_of(const Contact& contact, const ContactUpdateInput& input) {
  const float turn = input.reaches[contact.body_first].turn + input.reaches[contact.body_second].turn;
  return shift_between(contact, input).norm() + static_cast<double>(turn);
}

// m, the speculative margin.
inline double margin_of(const Contact& contact, const ContactUpdateInput& input) {
  return speculative_margin(static_cast<double>(contact.size), approach_of(contact, input));
}

// m: how far apart two solids may be to be looked at for points. Beyond the speculative margin these are of where the
// two will meet.
inline double range_of(const Contact& contact, const ContactUpdateInput& input) {
  const double size = contact.size;
  const double approach = approach_of(contact, input);
  return input.ahead != nullptr && approach > approach_share * size ? margin_share * size + steps_ahead * approach
                                                                    : speculative_margin(size, approach);
}

}  // namespace atl::collision
