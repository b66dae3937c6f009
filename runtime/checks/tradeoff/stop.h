#pragma once

#include <functional>

namespace atl::tradeoff {

/// Asked between steps, and while another program runs: whether to end there. It throws nothing. None at all: never.
using Stop = std::function<bool()>;

/// Thrown by loops that were told to stop and can't return early; the catcher knows which results exist by then.
struct Stopped {};

/// Throws Stopped where it is asked to.
inline void stop_if_asked(const Stop& stop) {
  if (stop && stop()) throw Stopped{};
}

}  // namespace atl::tradeoff
