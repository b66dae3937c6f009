#pragma once
/// Filters, of users and of the broadphase, for archives (state_archive.h).

#include <cstdint>

#include "state/state_archive.h"
#include "world/utf8.h"

namespace atl {

template <typename Archive, typename Text>
void visit_text(Archive& archive, Text& text) {
  if constexpr (Archive::reads) {
    text.resize(archive.count_of(1));
  } else {
    archive.value(static_cast<std::uint32_t>(text.size()));
  }
  archive.values(text.data(), text.size());
  if constexpr (Archive::reads) archive.check(is_name(text), "a name that is not UTF-8 without control characters");
}

template <typename Archive, typename Filter>
void visit_filter(Archive& archive, Filter& filter) {
  visit_all(archive, filter.category, filter.mask, filter.group);
}

}  // namespace atl
