// `atoll verify`, in runs with a fault in step 7 on body 5.

#include "command/verify/verify.h"

#include <CLI/CLI.hpp>
#include <iostream>

#include "../../support/planted_fault.h"
#include "command/failure.h"

int main(int argc, char** argv) {
  CLI::App app;
  atl::command::VerifyOptions options;
  atl::command::add_verify_options(app, options);
  CLI11_PARSE(app, argc, argv);
  try {
    atl::command::verify(options, atl::test::more_speed_with_threads({.step = 7, .body = 5}));
  } catch (const atl::command::Failure& failure) {
    std::cerr << failure.what() << "\n";
    return static_cast<int>(failure.status());
  }
}
