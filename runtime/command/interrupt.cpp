#include "interrupt.h"

#include <signal.h>

#include <array>
#include <atomic>

namespace atl::command {
namespace {

constexpr std::array<int, 3> ending = {SIGINT, SIGTERM, SIGHUP};

std::atomic<int> first_signal = 0;
static_assert(std::atomic<int>::is_always_lock_free, "a handler may use no lock");

extern "C" void record_signal(int number) {
  first_signal.store(number, std::memory_order_relaxed);
  for (const int each : ending) ::signal(each, SIG_DFL);
}

}  // namespace

void catch_interrupts() {
  struct sigaction action = {};
  action.sa_handler = record_signal;
  action.sa_flags = SA_RESTART;
  ::sigemptyset(&action.sa_mask);
  for (const int each : ending) ::sigaddset(&action.sa_mask, each);
  for (const int each : ending) {
    struct sigaction before = {};
    ::sigaction(each, nullptr, &before);
    if (before.sa_handler != SIG_IGN) ::sigaction(each, &action, nullptr);
  }
}

bool interrupted() { return first_signal.load(std::memory_order_relaxed) != 0; }

const char* interrupt_name() {
  const int number = first_signal.load(std::memory_order_relaxed);
  return number == SIGINT ? "SIGINT" : number == SIGTERM ? "SIGTERM" : "SIGHUP";
}

Failure interruption(const std::string& name, const std::string& where) {
  constexpr int ended_by_signal = 128;  // as shells tell it
  const int number = first_signal.load(std::memory_order_relaxed);
  return {static_cast<Status>(ended_by_signal + number), name + ": interrupted by " + interrupt_name() + " " + where};
}

Failure interruption(const std::string& name, std::int64_t step, std::int64_t all) {
  return interruption(name, "after step " + std::to_string(step) + " of " + std::to_string(all));
}

void stop_if_interrupted() {
  if (interrupted()) throw Interrupted{};
}

}  // namespace atl::command
