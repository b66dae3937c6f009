#pragma once
/// Filters, of users and of the broadphase, for archives (state_archive.h).

namespace atl {

template <typename Archive, typename Filter>
void visit_filter(Archive& archive, Filter& filter) {
  archive.value(filter.category);
  archive.value(filter.mask);
  archive.value(filter.group);
}

}  // namespace atl
