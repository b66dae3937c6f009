#pragma once

#include <atoll/scene.h>

#include <string>

namespace atl::command {

/// What a measure of error means, in a few words; empty if they say no more than its name.
std::string describe_measure(const std::string& name, const Scene& scene);

}  // namespace atl::command
