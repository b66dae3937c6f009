#pragma once

namespace atl::command {

/// Whether main() got `atoll ensemble ...`, of which Python reads the words that follow.
bool is_ensemble(int argc, char** argv);

/// `atoll ensemble`: becomes `python3 -m atoll ensemble` with the same words, so signals and exit status are Python's.
/// The environment's ATOLL_PYTHON names another interpreter. A package beside the executable, as a build has it, is
/// taken before those that are installed. Returns only by throwing Failure: where there is no Python or no package.
[[noreturn]] void run_ensemble(char** argv);

}  // namespace atl::command
