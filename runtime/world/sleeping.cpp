#include "world/sleeping.h"

#include <jobs/append.h>
#include <jobs/assert.h>

#include <algorithm>
#include <iterator>
#include <limits>

namespace atl {

void Sleeping::resize(std::size_t count) {
  ATL_ASSERT(count >= awake.size(), count, awake.size());
  jobs::append(awake, count, std::uint8_t{0});
  jobs::append(rest_time, count, 0.0);
  jobs::append(ring, count, none);
  jobs::append(reported_asleep, count, std::uint8_t{0});
  if (!wakeful.empty()) jobs::append(wakeful, count, std::uint8_t{0});
}

void Sleeping::keep_awake(std::uint32_t body, bool always) {
  ATL_ASSERT(body < awake.size(), body, awake.size());
  if (wakeful.empty() && !always) return;
  if (wakeful.empty()) wakeful.resize(awake.size(), std::uint8_t{0});
  wakeful[body] = always;
}

void Sleeping::record_change(std::uint32_t body) {
  changed.push_back(body);
  unreported.push_back(body);
}

std::vector<std::uint32_t> Sleeping::news() const {
  std::vector<std::uint32_t> bodies;
  std::ranges::copy_if(unreported, std::back_inserter(bodies),
                       [&](std::uint32_t body) { return is_asleep(body) != (reported_asleep[body] != 0); });
  std::ranges::sort(bodies);
  bodies.erase(std::unique(bodies.begin(), bodies.end()), bodies.end());
  return bodies;
}

void Sleeping::mark_all_reported() {
  for (const std::uint32_t body : unreported) mark_reported(body);
  unreported.clear();
}

void Sleeping::wake(std::uint32_t body) {
  ATL_ASSERT(body < ring.size(), body, ring.size());
  rest_time[body] = 0;
  if (!is_asleep(body)) return;
  std::uint32_t member = body;
  do {
    const std::uint32_t next = ring[member];
    ATL_ASSERT(next < ring.size(), member, next, ring.size());
    ATL_ASSERT(asleep > 0 && awake[member] == 0, member, asleep);
    ring[member] = none;
    awake[member] = 1;
    rest_time[member] = 0;
    --asleep;
    record_change(member);
    member = next;
  } while (member != body);
}

double Sleeping::update_rest_time(const solver::BodyTable& bodies, std::uint32_t body, double speed_limit, double dt) {
  const double speed =
      std::max(bodies.velocity(body).norm(), bodies.angular_velocity(body).norm() * bodies.radius[body]);
  rest_time[body] = speed < speed_limit ? rest_time[body] + dt : 0;
  ATL_ASSERT(rest_time[body] >= 0, body, rest_time[body], dt);
  return rest_time[body];
}

void Sleeping::put_to_sleep(std::span<const std::uint32_t> island, solver::BodyTable& bodies) {
  for (std::size_t i = 0; i < island.size(); ++i) {
    const std::uint32_t body = island[i];
    ATL_ASSERT(!is_asleep(body), body);
    ATL_ASSERT(bodies.mobility[body] == solver::Mobility::Dynamic, body, static_cast<int>(bodies.mobility[body]));
    ring[body] = island[(i + 1) % island.size()];
    awake[body] = 0;
    record_change(body);
    bodies.velocity(body).setZero();
    bodies.angular_velocity(body).setZero();
  }
  asleep += static_cast<std::int64_t>(island.size());
}

void Sleeping::update(const solver::Islands& islands, solver::BodyTable& bodies, const Settings& settings, double dt) {
  const auto settle = [&](std::span<const std::uint32_t> island) {
    ATL_ASSERT(!island.empty(), islands.count());
    double rested = std::numeric_limits<double>::infinity();
    for (const std::uint32_t body : island) {
      rested = std::min(rested, update_rest_time(bodies, body, settings.sleep_speed, dt));
      if (stays_awake(body)) rested = -1;
    }
    if (rested >= settings.time_to_sleep) put_to_sleep(island, bodies);
  };
  for (std::size_t island = 0; island < islands.count(); ++island) settle(islands.bodies(island, island + 1));
  for (const std::uint32_t& body : islands.free_bodies()) settle(std::span(&body, 1));
}

}  // namespace atl
