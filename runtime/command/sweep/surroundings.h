#pragma once

#include <string>

namespace atl::command {

/// The machine and build on which times were measured, as far as a reader has to know.
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
