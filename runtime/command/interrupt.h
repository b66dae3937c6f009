#pragma once

#include <cstdint>
#include <string>

#include "failure.h"

namespace atl::command {

/// From here on the first SIGINT (Ctrl-C), SIGTERM or SIGHUP is noted only, so that what is under way can end in order.
/// The next one ends the process at once, as all do that were ignored when it started, which stay ignored.
void catch_interrupts();

/// True once such a signal came. Loops ask between steps.
bool interrupted();

/// The failure that ends the command then, with status 128 + signal: "NAME: interrupted by SIGINT WHERE".
Failure interruption(const std::string& name, const std::string& where);
/// The same, "after step STEP of ALL".
Failure interruption(const std::string& name, std::int64_t step, std::int64_t all);

/// Thrown by loops that a signal interrupts and that can't return early; the catcher knows which results exist by then.
struct Interrupted {};

/// Throws Interrupted once there was a signal.
void stop_if_interrupted();

/// "SIGINT", "SIGTERM" or "SIGHUP": of the signal that came.
const char* interrupt_name();

}  // namespace atl::command
