#include "command_line.h"

int main(int argc, char** argv) { return atl::command::run_command_line(argc, argv); }
