#pragma once

#include <atoll/scene.h>

#include <string>

namespace atl::command {

/// Explains a measure of error in a few words; empty if they would say no more than its name.
std::string describe_measure(const std::string& name, const Scene& scene);

}  // namespace atl::command
