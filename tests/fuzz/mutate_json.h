#pragma once

#include <string>
#include <string_view>

namespace atl::fuzz {

/// A JSON text of which one value is another, a member is gone, or is there under another key: what changes of bytes
/// hardly ever come to. Empty if the text is no JSON, or in one of eight cases, which are for changes of bytes.
std::string mutate_json(std::string_view text, unsigned int seed);

}  // namespace atl::fuzz
