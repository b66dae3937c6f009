// Worlds of one scene side by side: a world is a task.

#include <atoll/batch.h>
#include <atoll/error.h>
#include <atoll/snapshot.h>
#include <jobs/arena.h>
#include <jobs/assert.h>

#include <algorithm>
#include <array>
#include <exception>
#include <string>
#include <thread>
#include <utility>

#include "columns.h"
#include "memory_need.h"

namespace atl {
namespace {

int thread_count(int asked) {
  if (asked < 0 || asked > 1024) {
    throw Error("Batch: threads is " + std::to_string(asked) + "; expected a number from 0 to 1024");
  }
  return asked > 0 ? asked : std::clamp(static_cast<int>(std::thread::hardware_concurrency()), 1, 1024);
}

[[noreturn]] void fail(const char* call, const std::string& found, const std::string& expected) {
  throw Error(std::string("Batch::") + call + ": found " + found + "; expected " + expected);
}

// Ahead of making them, since a process that has no memory left is ended without a word.
void check_memory(const World& first, std::size_t worlds) {
  std::size_t bytes = sizeof(World) + sizeof(Snapshot);
  for (const MemoryUse& use : first.memory()) bytes += use.bytes;
  const std::string words = scene::memory_words(static_cast<double>(worlds) * static_cast<double>(bytes));
  if (words.empty()) return;
  throw Error("Batch: " + std::to_string(worlds) + " worlds need " + words + "; expected as many as there is room for");
}

void check_size(const char* call, const char* what, std::size_t found, std::size_t expected) {
  if (found != expected) {
    fail(call, std::to_string(found) + " numbers of " + what, std::to_string(expected) + " of them");
  }
}

}  // namespace

struct Batch::Impl {
  Scene scene;
  mutable jobs::Arena arena;
  std::vector<World> worlds;
  std::vector<Snapshot> starts;
  std::vector<BodyId> bodies;
  std::vector<JointId> joints;
  bool pushed = false;  // the scene has constant forces

  Impl(const Scene& of, int threads) : scene(of), arena(threads) {
    for (std::size_t i = 0; i < of.bodies.size(); ++i) {
      pushed |= !of.bodies[i].force.isZero(0);
    }
  }

  std::size_t count_of(std::span<const std::size_t> places) const {
    return places.empty() ? worlds.size() : places.size();
  }

  void check_place(const char* call, std::size_t place) const {
    if (place >= worlds.size()) {
      fail(call, "place " + std::to_string(place), "one below " + std::to_string(worlds.size()));
    }
  }
  // Worlds that are visited at the same time must not be the same.
  void check_places(const char* call, std::span<const std::size_t> places) const {
    if (places.empty()) return;
    std::vector<std::uint8_t> seen(worlds.size(), 0);
    for (const std::size_t place : places) {
      check_place(call, place);
      if (seen[place]++ != 0) fail(call, "place " + std::to_string(place) + " twice", "each once");
    }
  }

  // Tells if a visit looks at a part of a world or at all of it.
  enum class Sees { Part, All };

  // visit(world, its place, its number among `places`), several at a time. What the first of them throws goes through
  // once all are done.
  template <typename Worlds, typename Visit>
  void for_each(Worlds& all, const char* call, std::span<const std::size_t> places, const Visit& visit,
                Sees sees = Sees::Part) const {
    check_places(call, places);
    const std::size_t count = count_of(places);
    std::vector<std::exception_ptr> thrown(count);
    // Some for each worker to begin with, and then more for those that are through.
    const std::size_t grain = std::max<std::size_t>(1, count / (8 * static_cast<std::size_t>(arena.threads())));
    const auto place_of = [&](std::size_t i) { return places.empty() ? i : places[i]; };
    arena.parallel_for(count, grain, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i) {
        const std::size_t place = place_of(i);
        if (sees == Sees::All && i + 2 < end) all[place_of(i + 2)].prefetch_places();
        if (sees == Sees::All && i + 1 < end) all[place_of(i + 1)].prefetch();
        try {
          visit(all[place], place, i);
        } catch (...) {
          thrown[i] = std::current_exception();
        }
      }
    });
    for (const std::exception_ptr& exception : thrown) {
      if (exception) std::rethrow_exception(exception);
    }
  }

  JointId joint(const char* call, std::size_t number) const {
    if (number >= joints.size()) {
      fail(call, "joint " + std::to_string(number), "one below " + std::to_string(joints.size()));
    }
    return joints[number];
  }

  // A bulk call of each world for those of its bodies that take it, from two arrays with a column for each of them all.
  template <typename Bulk>
  void hand_on(const char* call, const std::array<const char*, 2>& what, std::span<const std::size_t> places,
               BodyType min, std::span<const double> first, std::span<const double> second, const Bulk& bulk) {
    const std::size_t a_world = 3 * bodies.size();
    check_size(call, what[0], first.size(), a_world * count_of(places));
    check_size(call, what[1], second.size(), a_world * count_of(places));
    for_each(worlds, call, places, [&](World& world, std::size_t, std::size_t number) {
      std::vector<BodyId> ids;
      Eigen::Matrix3Xd a(3, bodies.size()), b(3, bodies.size());
      for (std::size_t body = 0; body < bodies.size(); ++body) {
        if (world.contains(bodies[body]) && world.type(bodies[body]) < min) continue;
        const std::size_t from = number * a_world + 3 * body;
        const auto column = static_cast<Eigen::Index>(ids.size());
        a.col(column) = Vector3(first.data() + from);
        b.col(column) = Vector3(second.data() + from);
        ids.push_back(bodies[body]);
      }
      const auto columns = static_cast<Eigen::Index>(ids.size());
      a.conservativeResize(3, columns);
      b.conservativeResize(3, columns);
      bulk(world, ids, a, b);
    });
  }

  // Gives a joint of each world a number.
  void drive(const char* call, std::span<const std::size_t> places, std::size_t number, const char* what,
             std::span<const double> numbers, std::size_t coordinate,
             void (World::*set)(JointId, double, std::size_t)) {
    const JointId id = joint(call, number);
    check_size(call, what, numbers.size(), count_of(places));
    for_each(worlds, call, places,
             [&](World& world, std::size_t, std::size_t i) { (world.*set)(id, numbers[i], coordinate); });
  }
};

Batch::Batch(const Scene& scene, std::size_t worlds, int threads)
    : impl_(std::make_unique<Impl>(scene, thread_count(threads))) {
  if (worlds == 0) throw Error("Batch: worlds is 0; expected 1 or more");
  const WorldDef def = {.gravity = scene.gravity, .settings = scene.settings};
  World first(def);
  impl_->bodies = build_scene(scene, first, impl_->joints);
  ATL_ASSERT(impl_->bodies.size() == scene.bodies.size(), impl_->bodies.size(), scene.bodies.size());
  check_memory(first, worlds);
  impl_->worlds.reserve(worlds);
  impl_->worlds.push_back(std::move(first));
  while (impl_->worlds.size() < worlds) impl_->worlds.emplace_back(def);
  for (World& world : impl_->worlds) world.stay_in_batch();
  impl_->starts.resize(worlds);
  Snapshot start;
  impl_->worlds.front().save(start);
  impl_->starts.front() = start;
  // A restored world takes no more memory than its bodies need, and shares what is alike. Its start is its own all the
  // same: another world's would be refused once masses or shapes are changed.
  impl_->for_each(impl_->worlds, "Batch", {}, [&](World& world, std::size_t place, std::size_t) {
    if (place == 0) return;
    world.restore(start);
    world.save(impl_->starts[place]);
    impl_->starts[place].fit(start);
    world.share_definitions(impl_->worlds.front());
  });
}

Batch::~Batch() = default;
Batch::Batch(Batch&&) noexcept = default;
Batch& Batch::operator=(Batch&&) noexcept = default;

std::size_t Batch::size() const { return impl_->worlds.size(); }
int Batch::threads() const { return impl_->arena.threads(); }
const Scene& Batch::scene() const { return impl_->scene; }
const std::vector<BodyId>& Batch::bodies() const { return impl_->bodies; }
const std::vector<JointId>& Batch::joints() const { return impl_->joints; }

World& Batch::world(std::size_t place) {
  impl_->check_place("world", place);
  return impl_->worlds[place];
}
const World& Batch::world(std::size_t place) const {
  impl_->check_place("world", place);
  return impl_->worlds[place];
}

void Batch::for_each(const std::function<void(World&, std::size_t)>& function, std::span<const std::size_t> places) {
  impl_->for_each(impl_->worlds, "for_each", places,
                  [&](World& world, std::size_t place, std::size_t) { function(world, place); });
}

void Batch::step(double dt, int count, std::span<const std::size_t> places) {
  if (!(dt >= 1e-12 && dt <= 1)) fail("step", "dt of " + std::to_string(dt) + " s", "one in [1e-12, 1]");
  if (count < 0) fail("step", std::to_string(count) + " steps", "0 or more");
  const auto step = [&](World& world, std::size_t, std::size_t) {
    for (int i = 0; i < count; ++i) {
      if (impl_->pushed) atl::apply_forces(impl_->scene, world, impl_->bodies);
      world.step(dt);
    }
  };
  impl_->for_each(impl_->worlds, "step", places, step, Impl::Sees::All);
}

void Batch::reset(std::span<const std::size_t> places) {
  impl_->for_each(impl_->worlds, "reset", places,
                  [&](World& world, std::size_t place, std::size_t) { world.restore(impl_->starts[place]); });
}

void Batch::save_start(std::span<const std::size_t> places) {
  impl_->for_each(impl_->worlds, "save_start", places, [&](World& world, std::size_t place, std::size_t) {
    world.save(impl_->starts[place]);
    impl_->starts[place].fit({});
  });
}

void Batch::read(Column column, std::span<double> numbers) const {
  read_columns(*this, std::span(&column, 1), std::span(&numbers, 1));
}

void read_columns(const Batch& batch, std::span<const Batch::Column> columns,
                  std::span<const std::span<double>> numbers, std::span<const std::size_t> places) {
  check_size("read", "arrays", numbers.size(), columns.size());
  std::vector<std::size_t> a_world;
  for (std::size_t c = 0; c < columns.size(); ++c) {
    a_world.push_back(Batch::rows_of(columns[c]) * count_in(columns[c], batch));
    check_size("read", "a column", numbers[c].size(), a_world[c] * batch.impl_->count_of(places));
  }
  batch.impl_->for_each(batch.impl_->worlds, "read", places, [&](const World& world, std::size_t, std::size_t i) {
    std::vector<double*> to;
    for (std::size_t c = 0; c < columns.size(); ++c) to.push_back(numbers[c].data() + i * a_world[c]);
    read_columns(world, batch, columns, to);
  });
}

void Batch::set_poses(std::span<const double> origins, std::span<const double> orientations,
                      std::span<const std::size_t> places) {
  const auto bodies = static_cast<Eigen::Index>(impl_->bodies.size());
  check_size("set_poses", "origins", origins.size(), 3 * impl_->bodies.size() * impl_->count_of(places));
  check_size("set_poses", "orientations", orientations.size(), 4 * impl_->bodies.size() * impl_->count_of(places));
  impl_->for_each(impl_->worlds, "set_poses", places, [&](World& world, std::size_t, std::size_t i) {
    const auto first = static_cast<std::size_t>(bodies) * i;
    world.set_poses(impl_->bodies, Eigen::Map<const Eigen::Matrix3Xd>(origins.data() + 3 * first, 3, bodies),
                    Eigen::Map<const Eigen::Matrix4Xd>(orientations.data() + 4 * first, 4, bodies));
  });
}

void Batch::set_velocities(std::span<const double> linear, std::span<const double> angular,
                           std::span<const std::size_t> places) {
  impl_->hand_on("set_velocities", {"velocities", "spins"}, places, BodyType::Kinematic, linear, angular,
                 [](World& world, const auto& ids, const auto& v, const auto& w) { world.set_velocities(ids, v, w); });
}

void Batch::apply_forces(std::span<const double> forces, std::span<const double> torques,
                         std::span<const std::size_t> places) {
  impl_->hand_on("apply_forces", {"forces", "torques"}, places, BodyType::Dynamic, forces, torques,
                 [](World& world, const auto& ids, const auto& f, const auto& t) { world.apply_forces(ids, f, t); });
}

void Batch::set_motor_speeds(std::size_t joint, std::span<const double> speeds, std::size_t coordinate,
                             std::span<const std::size_t> places) {
  impl_->drive("set_motor_speeds", places, joint, "speeds", speeds, coordinate, &World::set_motor_speed);
}

void Batch::set_servo_targets(std::size_t joint, std::span<const double> targets, std::size_t coordinate,
                              std::span<const std::size_t> places) {
  impl_->drive("set_servo_targets", places, joint, "targets", targets, coordinate, &World::set_servo_target);
}

void Batch::read_joint(std::size_t joint, std::span<double> positions, std::span<double> speeds,
                       std::size_t coordinate) const {
  const JointId id = impl_->joint("read_joint", joint);
  check_size("read_joint", "positions", positions.size(), size());
  check_size("read_joint", "speeds", speeds.size(), size());
  if (coordinate >= 6) fail("read_joint", "coordinate " + std::to_string(coordinate), "one below 6");
  impl_->for_each(impl_->worlds, "read_joint", {}, [&](const World& world, std::size_t place, std::size_t) {
    const JointState state = world.joint_state(id);
    positions[place] = state.position[coordinate];
    speeds[place] = state.speed[coordinate];
  });
}

std::vector<std::uint64_t> Batch::hashes() const {
  std::vector<std::uint64_t> all(size());
  impl_->for_each(impl_->worlds, "hashes", {},
                  [&](const World& world, std::size_t place, std::size_t) { all[place] = world.state_hash(); });
  return all;
}

std::vector<std::size_t> Batch::quarantined() const {
  std::vector<std::size_t> all(size());
  for (std::size_t i = 0; i < size(); ++i) all[i] = impl_->worlds[i].quarantined().size();
  return all;
}

}  // namespace atl
