#pragma once
/// A driver program of another engine, as `atoll sweep --peer` runs it, made up for tests.

#include <string>

#include "cli/command.h"

namespace atl::test {

/// A shell script that answers as a driver does. Its settings: the default, with a penetration_mean of 1 mm, at 2 s a
/// simulated second; --better, with none and at 4 s; --fell; --broken, that becomes non-finite; --slow, that never
/// ends;
/// --odd, that prints no report. An engine named Swift has no error at all, in 1 ns. A scene named stack:height=3 is
/// refused. In a chain, joints open by 0.9 m with --better and
/// by 2 m with the others.
std::string write_driver(const ScratchDirectory& scratch, const std::string& engine);

}  // namespace atl::test
