#pragma once

#include <atoll/settings.h>
#include <jobs/arrays.h>
#include <jobs/compact_array.h>
#include <solver/integrate/body_table.h>
#include <solver/islands/islands.h>

#include <cstdint>
#include <span>
#include <vector>

namespace atl {

/// Which bodies are awake. An island falls asleep as a whole when all its bodies have been at rest for long
/// enough, and its bodies are linked in a ring, so that waking one wakes them all.
struct Sleeping {
  static constexpr std::uint32_t none = ~0u;

  jobs::CompactArray<std::uint8_t> awake;        ///< by body; 1 for every dynamic body that is not asleep
  jobs::CompactArray<double> rest_time;          ///< s, by body
  jobs::CompactArray<std::uint32_t> ring;        ///< by body: the next body of its sleeping island
  std::int64_t asleep = 0;                       ///< bodies
  jobs::CompactArray<std::uint32_t> changed;     ///< bodies that fell asleep or woke, in the order in which they did
  jobs::CompactArray<std::uint32_t> unreported;  ///< the same since events were reported; some more than once
  jobs::CompactArray<std::uint8_t> reported_asleep;  ///< by body: 1 for one that slept when events were last reported
  jobs::CompactArray<std::uint8_t> wakeful;          ///< by body: one that may not sleep; empty where all may

  void resize(std::size_t count);
  bool is_asleep(std::uint32_t body) const { return ring[body] != none; }
  /// Wakes a body and what sleeps with it; resets the rest time of one that is awake.
  void wake(std::uint32_t body);
  /// After a step: rest times, and islands (and lone bodies) that fall asleep; their velocities become zero.
  void update(const solver::Islands& islands, solver::BodyTable& bodies, const Settings& settings, double dt);
  /// Has awake bodies sleep as one island, at zero velocity.
  void put_to_sleep(std::span<const std::uint32_t> island, solver::BodyTable& bodies);
  /// Whether the body may not sleep.
  void keep_awake(std::uint32_t body, bool always);
  bool stays_awake(std::uint32_t body) const { return !wakeful.empty() && wakeful[body] != 0; }
  /// Bodies that sleep now and didn't, or the reverse, when events were last reported; in order.
  std::vector<std::uint32_t> news() const;
  /// Takes what the body does now, sleep or not, as reported: news() leaves it out until that changes.
  void mark_reported(std::uint32_t body) { reported_asleep[body] = is_asleep(body); }
  void mark_all_reported();
  auto arrays() const { return std::tie(awake, rest_time, ring, changed, unreported, reported_asleep, wakeful); }

 private:
  void record_change(std::uint32_t body);
  double update_rest_time(const solver::BodyTable& bodies, std::uint32_t body, double speed_limit, double dt);
};

}  // namespace atl
