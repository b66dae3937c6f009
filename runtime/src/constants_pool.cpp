#include "constants_pool.h"

#include <algorithm>

namespace atl {

std::shared_ptr<const BodyConstants> ConstantsPool::share(const BodyConstants& constants, std::uint64_t kind) {
  if (known_.size() >= most_) {
    std::erase_if(known_, [](const auto& entry) { return entry.second.expired(); });
    most_ = std::max<std::size_t>(64, 2 * known_.size());
  }
  std::weak_ptr<const BodyConstants>& place = known_[kind];
  std::shared_ptr<const BodyConstants> shared = place.lock();
  if (!shared) {
    shared = std::make_shared<const BodyConstants>(constants);
    place = shared;
  }
  return shared;
}

}  // namespace atl
