#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <unordered_map>

#include "world/body_definition.h"

namespace atl {

/// Lets bodies that are the same share what never changes of them.
class ConstantsPool {
 public:
  std::shared_ptr<const BodyConstants> share(const BodyConstants& constants);

 private:
  // By fingerprint. Nothing depends on their order.
  std::unordered_map<std::uint64_t, std::weak_ptr<const BodyConstants>> known_;
  std::weak_ptr<const BodyConstants> last_;  // that was shared: what comes next is often the same
  std::size_t max_ = 64;                     // at which those that are gone are dropped
};

}  // namespace atl
