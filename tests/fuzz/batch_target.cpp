// Programs of calls on a batch of three worlds, and on three worlds by themselves: all come to the same bits.

#include <atoll/batch.h>
#include <atoll/scene.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <vector>

#include "consistency.h"
#include "finding.h"
#include "target.h"

namespace {

using namespace atl;

constexpr std::size_t count = 3;

Scene scene_from(fuzz::Bytes& bytes, fuzz::Definitions& definitions) {
  World world({.settings = definitions.settings({})});
  std::vector<BodyId> bodies;
  for (std::uint32_t left = 1 + bytes.below(6); left > 0; --left) {
    try {
      bodies.push_back(world.add_body(definitions.body()));
      if (bodies.size() < 2 || bytes.flag()) continue;
      world.add_joint(definitions.joint(world, bodies[bodies.size() - 2], bodies.back()));
    } catch (const Error&) {
    }
  }
  return scene_of(world);
}

class Run {
 public:
  Run(fuzz::Bytes& bytes, fuzz::Definitions& definitions)
      : bytes_(bytes), definitions_(definitions), scene_(scene_from(bytes, definitions)), batch_(scene_, count, 2) {
    for (std::size_t i = 0; i < count; ++i) {
      alone_.emplace_back(WorldDef{.gravity = scene_.gravity, .settings = scene_.settings});
      ids_ = build_scene(scene_, alone_[i]);
      alone_[i].save(starts_[i]);
    }
    compare("the start");
  }

  void act() {
    choose_places();
    switch (bytes_.below(6)) {
      case 0:
        return set_velocities();
      case 1:
        return change();
      case 2:
        return both(
            "reset", [&] { batch_.reset(places_); }, [&](std::size_t i) { alone_[i].restore(starts_[i]); });
      case 3:
        return both(
            "save_start", [&] { batch_.save_start(places_); }, [&](std::size_t i) { alone_[i].save(starts_[i]); });
      default:
        return step();
    }
  }

 private:
  void choose_places() {
    places_.clear();
    const std::uint32_t chosen = 1 + bytes_.below(7);
    for (std::size_t i = 0; i < count; ++i) {
      if ((chosen >> i & 1) != 0) places_.push_back(i);
    }
  }

  // Where one throws, so does the other.
  template <typename Together, typename OneByOne>
  void both(const char* what, const Together& together, const OneByOne& one_by_one) {
    std::string thrown, thrown_alone;
    try {
      together();
    } catch (const Error& error) {
      thrown = error.what();
    }
    for (const std::size_t i : places_) {
      try {
        one_by_one(i);
      } catch (const Error& error) {
        if (thrown_alone.empty()) thrown_alone = error.what();
      }
    }
    fuzz::require(thrown.empty() == thrown_alone.empty(), std::string(what) + ": " + thrown + thrown_alone);
    compare(what);
  }

  void step() {
    const double dt = definitions_.number(1e-3, 0.05);
    const int steps = 1 + static_cast<int>(bytes_.below(4));
    both(
        "step", [&] { batch_.step(dt, steps, places_); },
        [&](std::size_t i) {
          for (int left = steps; left > 0; --left) {
            apply_forces(scene_, alone_[i], ids_);
            alone_[i].step(dt);
          }
        });
  }

  void set_velocities() {
    std::vector<double> linear, angular;
    for (std::size_t i = 0; i < 3 * ids_.size() * places_.size(); ++i) {
      linear.push_back(definitions_.number(-5, 5));
      angular.push_back(definitions_.number(-5, 5));
    }
    both(
        "set_velocities", [&] { batch_.set_velocities(linear, angular, places_); },
        [&](std::size_t i) {
          const auto number = static_cast<std::size_t>(std::find(places_.begin(), places_.end(), i) - places_.begin());
          std::vector<BodyId> moving;
          std::vector<double> v, w;
          for (std::size_t body = 0; body < ids_.size(); ++body) {
            if (alone_[i].contains(ids_[body]) && alone_[i].type(ids_[body]) == BodyType::Static) continue;
            moving.push_back(ids_[body]);
            const auto from = static_cast<std::ptrdiff_t>(3 * (number * ids_.size() + body));
            v.insert(v.end(), linear.begin() + from, linear.begin() + from + 3);
            w.insert(w.end(), angular.begin() + from, angular.begin() + from + 3);
          }
          const auto columns = static_cast<Eigen::Index>(moving.size());
          alone_[i].set_velocities(moving, Eigen::Map<const Eigen::Matrix3Xd>(v.data(), 3, columns),
                                   Eigen::Map<const Eigen::Matrix3Xd>(w.data(), 3, columns));
        });
  }

  // By calls of the world's, on the batch's threads.
  void change() {
    if (ids_.empty()) return;
    const BodyId id = ids_[bytes_.below(ids_.size())];
    const BodyDef other = definitions_.body();
    const std::uint32_t choice = bytes_.below(5);
    const Vector3 gravity = definitions_.vector(20);
    const auto call = [&](World& world) {
      switch (choice) {
        case 0:
          return world.set_gravity(gravity);
        case 1:
          return world.set_definition(id, other);
        case 2:
          return world.set_enabled(id, !world.is_enabled(id));
        case 3:
          return world.remove_body(id);
        default:
          world.add_body(other);
      }
    };
    both(
        "a change", [&] { batch_.for_each([&](World& world, std::size_t) { call(world); }, places_); },
        [&](std::size_t i) { call(alone_[i]); });
  }

  void compare(const char* what) {
    const std::vector<std::uint64_t> hashes = batch_.hashes();
    for (std::size_t i = 0; i < count; ++i) {
      fuzz::require(hashes[i] == alone_[i].state_hash(), std::string("a batch differs after ") + what);
      fuzz::check_world(batch_.world(i));
    }
  }

  fuzz::Bytes& bytes_;
  fuzz::Definitions& definitions_;
  Scene scene_;
  Batch batch_;
  std::vector<World> alone_;
  std::vector<BodyId> ids_;
  std::array<Snapshot, count> starts_;
  std::vector<std::size_t> places_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  atl::fuzz::Bytes bytes({data, size});
  const atl::fuzz::Numbers numbers = bytes.flag() ? atl::fuzz::Numbers::Any : atl::fuzz::Numbers::Usual;
  atl::fuzz::Definitions definitions(bytes, numbers);
  try {
    Run run(bytes, definitions);
    for (int left = 40; left > 0 && !bytes.empty(); --left) run.act();
  } catch (const atl::Error&) {
  }
  return 0;
}
