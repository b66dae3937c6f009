#pragma once

#include <collision/contacts/meeting.h>
#include <collision/contacts/update_contacts.h>

#include <optional>

namespace atl::collision {

/// The contact with which two solids will meet. Empty for solids that miss each other, that joints hold, of which one
/// stands still for good, that bounce and turn on their way, or that turn so far on it that their places tell nothing
/// yet. `margin`: m, see collide(). Only where input.ahead is given.
std::optional<Meeting> find_meeting(const Contact& contact, bool bounces, const ContactUpdateInput& input,
                                    double margin);

}  // namespace atl::collision
