#pragma once

#include <iosfwd>

namespace atl::command {

/// `atoll scenes`: the built-in scenes with their parameters.
void list_scenes(std::ostream& out);

}  // namespace atl::command
