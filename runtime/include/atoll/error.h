#pragma once

#include <stdexcept>
#include <string>

namespace atl {

/// Thrown by every public call that is handed something unusable: a bad definition, a stale id, a
/// setting out of range, or what the build was made without (ATOLL_WITH_..., see runtime/guide/install.md). The message
/// names the field, the value found and what was expected. A call that throws has changed nothing.
/// World::step never throws.
class Error : public std::runtime_error {
 public:
  explicit Error(const std::string& message) : std::runtime_error(message) {}
};

}  // namespace atl
