#include "world/sleeping.h"

#include <jobs/append.h>

namespace atl {

void Sleeping::resize(std::size_t count) {
  jobs::append(awake, count, std::uint8_t{0});
  jobs::append(rest_time, count, 0.0);
  jobs::append(ring, count, none);
}

void Sleeping::wake(std::uint32_t body) {
  rest_time[body] = 0;
  if (!is_asleep(body)) return;
  std::uint32_t member = body;
  do {
    const std::uint32_t next = ring[member];
    ring[member] = none;
    awake[member] = 1;
    rest_time[member] = 0;
    --asleep;
    changed.push_back(member);
    member = next;
  } while (member != body);
}

}  // namespace atl
