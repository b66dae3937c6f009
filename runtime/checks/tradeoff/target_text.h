#pragma once

#include <atoll/settings.h>

#include <string>

namespace atl::tradeoff {

/// Reads an option's text for an error target: "1mm", for penetrations and gaps of joints; "off"; or a list such as
/// "penetration=1mm,joint_gap=0.1mm,residual=0.01,motion=1mm/s". Leaves substeps unchanged. Returns "", or what was
/// found and what was expected.
std::string read_target(const std::string& text, ErrorTarget& target);

/// The same in words, as "1 mm" or "penetration 1 mm, motion 5 mm/s"; "off" of one that asks for nothing.
std::string target_words(const ErrorTarget& target);

}  // namespace atl::tradeoff
