#pragma once

namespace atl::command {

/// Does what the arguments of main() ask for, and returns the exit status. Help and results go to stdout, all else to
/// stderr.
int run_command_line(int argc, char** argv);

}  // namespace atl::command
