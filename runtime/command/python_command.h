#pragma once

namespace atl::command {

/// Tells if main() got `atoll ensemble ...` or `atoll import ...`, of which Python reads the words that follow.
bool is_python_command(int argc, char** argv);

/// Becomes `python3 -m atoll` with the same words, so signals and exit status are Python's. The environment's
/// ATOLL_PYTHON names another interpreter. A package beside the executable, as a build has it, is taken before those
/// that are installed. Returns only by throwing Failure: where there is no Python or no package.
[[noreturn]] void run_python_command(char** argv);

}  // namespace atl::command
