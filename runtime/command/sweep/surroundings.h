#pragma once

#include <string>

namespace atl::command {

/// What a reader has to know of where times were measured.
struct Surroundings {
  std::string cpu;       ///< the model's name
  unsigned cores = 0;    ///< logical
  std::string compiler;  ///< that built Atoll
  std::string system;    ///< kernel and architecture
};

Surroundings surroundings();

/// Today, as "2024-02-29".
std::string today();

}  // namespace atl::command
