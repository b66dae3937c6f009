#pragma once

#include <collision/contacts/contact.h>
#include <collision/contacts/contact_order.h>
#include <jobs/arrays.h>
#include <jobs/compact_array.h>

#include <cstddef>
#include <cstdint>
#include <span>

namespace atl::collision {

/// The state of a ContactCache's slot: no contact, a contact with an active body, or one whose bodies all are inactive.
enum class ContactState : std::uint8_t { Free, Active, Idle };

/// The idle contacts in order, and with the active ones all contacts in order. Both are brought up to date only when
/// somebody asks: until then it takes notes of what became idle, and whether any contact came or went.
class IdleContacts {
 public:
  void reserve(std::size_t slots) { is_new_.reserve(slots); }
  /// One slot more than before.
  void add_slot() { is_new_.push_back(0); }
  /// A contact became idle.
  void note(std::uint32_t slot) {
    if (is_new_[slot]) return;
    is_new_[slot] = 1;
    new_.push_back(slot);
  }
  /// A contact came or went, idle or not.
  void mark_all_stale() { all_stale_ = true; }

  /// All slots in use, in order. The cost is linear in their number if any came or went since the last call, and that
  /// of sorting in the number that became idle. Valid until the next change.
  std::span<const std::uint32_t> with_active(const ContactOrder& active, std::span<const Contact> contacts,
                                             std::span<const ContactState> states);

  /// See jobs/arrays.h.
  auto arrays() const { return std::tie(entries_, new_, is_new_, all_); }

 private:
  struct Entry {
    std::uint64_t key;  // of the pair
    std::uint32_t part;
    std::uint32_t slot;
  };

  void update(std::span<const Contact> contacts, std::span<const ContactState> states);

  jobs::CompactArray<Entry> entries_;        // in order, as of the last call of with_active()
  jobs::CompactArray<std::uint32_t> new_;    // slots that became idle since
  jobs::CompactArray<std::uint8_t> is_new_;  // by slot
  jobs::CompactArray<std::uint32_t> all_;    // in order, as of that call
  bool all_stale_ = false;
};

}  // namespace atl::collision
