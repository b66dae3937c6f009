#pragma once
/// Ctrl-C, while C++ runs for long without Python's lock.

#include <nanobind/nanobind.h>

#include <chrono>

namespace atl::python {

/// Asked between pieces of work: throws what Python's handlers of signals raise. Looks every 50 ms, as it takes the
/// lock.
class SignalCheck {
 public:
  void operator()() {
    const Clock::time_point now = Clock::now();
    if (now - last_ < std::chrono::milliseconds(50)) return;
    last_ = now;
    const nanobind::gil_scoped_acquire lock;
    if (PyErr_CheckSignals() != 0) throw nanobind::python_error();
  }

 private:
  using Clock = std::chrono::steady_clock;
  Clock::time_point last_ = Clock::now();
};

}  // namespace atl::python
