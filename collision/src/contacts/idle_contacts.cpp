#include <collision/contacts/idle_contacts.h>
#include <jobs/assert.h>

#include <algorithm>

namespace atl::collision {

// A slot may have been given up and used again for another pair.
void IdleContacts::update(std::span<const Contact> contacts, std::span<const ContactState> states) {
  const auto is_idle = [&](std::uint32_t slot) { return states[slot] == ContactState::Idle; };
  jobs::erase_if(entries_, [&](const Entry& entry) { return !is_idle(entry.slot) || is_new_[entry.slot] != 0; });
  const auto kept = static_cast<std::ptrdiff_t>(entries_.size());
  for (const std::uint32_t slot : new_) {
    ATL_ASSERT(slot < states.size() && is_new_[slot] == 1, slot, states.size());
    is_new_[slot] = 0;
    if (is_idle(slot)) entries_.push_back({contacts[slot].pair.key(), contacts[slot].part, slot});
  }
  new_.clear();
  const auto precedes = [](const Entry& a, const Entry& b) { return a.key == b.key ? a.part < b.part : a.key < b.key; };
  std::sort(entries_.begin() + kept, entries_.end(), precedes);
  std::inplace_merge(entries_.begin(), entries_.begin() + kept, entries_.end(), precedes);
  if constexpr (jobs::with_asserts) {
    for (std::size_t i = 1; i < entries_.size(); ++i) {
      ATL_ASSERT(precedes(entries_[i - 1], entries_[i]), i, entries_[i - 1].slot, entries_[i].slot);
    }
  }
}

std::span<const std::uint32_t> IdleContacts::with_active(const ContactOrder& active, std::span<const Contact> contacts,
                                                         std::span<const ContactState> states) {
  if (!all_stale_) return all_;
  update(contacts, states);
  all_.clear();
  std::size_t next = 0;
  for (const Entry& idle : entries_) {
    while (next < active.size() && active.pair_at(next).key() < idle.key) all_.push_back(active[next++]);
    all_.push_back(idle.slot);
  }
  const std::span<const std::uint32_t> rest = active.slots().subspan(next);
  all_.insert(all_.end(), rest.begin(), rest.end());
  all_stale_ = false;
  return all_;
}

}  // namespace atl::collision
