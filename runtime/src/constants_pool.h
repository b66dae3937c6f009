#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>

#include "body_definition.h"

namespace atl {

/// Lets bodies that are the same share what never changes of them.
class ConstantsPool {
 public:
  /// `kind` is their fingerprint().
  std::shared_ptr<const BodyConstants> share(const BodyConstants& constants, std::uint64_t kind);

 private:
  std::map<std::uint64_t, std::weak_ptr<const BodyConstants>> known_;  // by fingerprint
  std::size_t most_ = 64;                                              // at which those that are gone are dropped
};

}  // namespace atl
