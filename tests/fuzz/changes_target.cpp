// Changes of all kinds to bodies and joints of one heap, steps between them, and another heap far from it to which
// nothing is done: that one comes to the same bits as without the first. What a world says of itself, said to it again,
// changes nothing, and a world restored in another place goes on as this one.

#include <atoll/snapshot.h>

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "consistency.h"
#include "finding.h"
#include "target.h"

namespace {

using namespace atl;

constexpr double dt = 1.0 / 60;

// Boxes in a row, and a pendulum beside them, which touch nothing else: half-spaces reach as far.
std::vector<BodyId> add_far_heap(World& world) {
  const Vector3 far(3000, 0, 0);
  const CollisionFilter own = {.category = 1u << 20, .mask = 1u << 20};
  std::vector<BodyId> ids = {world.add_body(
      {.type = BodyType::Static, .shape = Box{{2, 2, 0.5}}, .position = far + Vector3(0, 0, -0.5), .filter = own})};
  for (int i = 0; i < 3; ++i) {
    ids.push_back(world.add_body({.position = far + Vector3(1.2 * i - 1.2, 0, 0.52 + 0.05 * i), .filter = own}));
  }
  ids.push_back(world.add_body({.shape = Sphere{0.2}, .position = far + Vector3(0, 3, 2), .filter = own}));
  world.add_joint(joint_at(world, HingeJoint{}, ids[0], ids.back(), far + Vector3(0, 3.5, 2.5)));
  return ids;
}

class Changes {
 public:
  Changes(fuzz::Bytes& bytes, fuzz::Definitions& definitions)
      : bytes_(bytes),
        definitions_(definitions),
        world_({.settings = definitions.settings({.sleeping = bytes.flag()})}),
        still_({.settings = world_.settings()}),
        far_(add_far_heap(world_)) {
    add_far_heap(still_);
    bodies_.push_back(world_.add_body({.type = BodyType::Static, .shape = HalfSpace{{0, 0, 1}, -1}}));
    still_.add_body({.type = BodyType::Static, .shape = HalfSpace{{0, 0, 1}, -1}});
    for (int left = 4; left > 0; --left) try_to([&] { bodies_.push_back(world_.add_body(definitions_.body())); });
  }

  void act() {
    const BodyId id = bodies_[bytes_.below(bodies_.size())];
    if (bytes_.one_in(3)) {
      change_joint();
    } else {
      try_to([&] { change_body(id); });
    }
    fuzz::check_world(world_);
    say_again(id);
    if (bytes_.one_in(6)) restore_elsewhere();
    if (!bytes_.flag()) return;
    const bool is_whole = world_.step(dt).quarantined == 0;
    still_.step(dt);
    fuzz::check_world(world_);
    for (const BodyId far : far_) {
      fuzz::require(!is_whole || world_.body_hash(far) == still_.body_hash(far),
                    "body " + std::to_string(far.index) + " feels what is done to others far from it");
    }
  }

 private:
  template <typename Call>
  static void try_to(const Call& call) {
    try {
      call();
    } catch (const Error&) {
    }
  }

  void change_body(BodyId id) {
    switch (bytes_.below(14)) {
      case 0:
        return bodies_.push_back(world_.add_body(definitions_.body()));
      case 1:
        return world_.remove_body(id);
      case 2:
        return world_.set_definition(id, definitions_.body());
      case 3:
        return world_.set_shape(id, definitions_.shape(BodyType::Dynamic));
      case 4:
        return world_.set_filter(id, definitions_.filter());
      case 5:
        return world_.set_mass(id, definitions_.number(0.1, 1000));
      case 6:
        return world_.set_enabled(id, bytes_.flag());
      case 7:
        return world_.sleep(id);
      case 8:
        return world_.wake(id);
      case 9:
        return world_.set_pose(id, {definitions_.vector(2), Quaternion::Identity()});
      case 10:
        return world_.set_collision_enabled(id, bodies_.back(), bytes_.flag());
      case 11: {
        BodyDef def = world_.definition(id);
        def.type = static_cast<BodyType>(bytes_.below(3));
        if (def.type != BodyType::Dynamic) def.mass.reset(), def.inertia.reset(), def.centre_of_mass.reset();
        return world_.set_definition(id, def);
      }
      case 12: {
        BodyDef def = world_.definition(id);
        def.locks = MotionLocks::plane(static_cast<Axis>(bytes_.below(3)));
        return world_.set_definition(id, def);
      }
      default:
        return world_.apply_impulse(id, definitions_.vector(100), world_.centre_of_mass(id) + Vector3(0.1, 0, 0));
    }
  }

  // All joints but the far heap's.
  void change_joint() {
    const BodyId first = bodies_[bytes_.below(bodies_.size())], second = bodies_[bytes_.below(bodies_.size())];
    const std::vector<JointId> joints = world_.joints();
    const JointId id = joints[bytes_.below(joints.size())];
    const std::uint32_t choice = bytes_.below(5);
    if (joints.size() == 1 || choice == 0) {
      const JointKind kind = definitions_.joint_kind();
      return try_to([&] { world_.add_joint({.kind = kind, .first = first, .second = second}); });
    }
    if (id == joints.front()) return;
    try_to([&] {
      switch (choice) {
        case 1:
          return world_.remove_joint(id);
        case 2:
          return world_.set_joint(id, definitions_.joint_kind());
        case 3:
          return world_.set_joint_axis(id, definitions_.axis(true));
        default:
          return world_.set_joint_enabled(id, bytes_.flag());
      }
    });
  }

  void say_again(BodyId id) {
    const std::uint64_t before = world_.state_hash();
    if (world_.contains(id) && none_asleep()) {
      world_.set_definition(id, world_.definition(id));
      fuzz::require(world_.state_hash() == before, "a body's own definition changes the world");
    }
    for (const JointId joint : world_.joints()) {
      const JointDef same = world_.joint(joint);
      // A suspension's frequency is that of the masses as it is set.
      if (!std::holds_alternative<WheelJoint>(same.kind)) world_.set_joint(joint, same);
    }
    fuzz::require(!none_asleep() || world_.state_hash() == before, "a joint's own definition changes the world");
  }

  bool none_asleep() const {
    for (const BodyId id : world_.bodies()) {
      if (world_.is_asleep(id)) return false;
    }
    return true;
  }

  void restore_elsewhere() {
    Snapshot snapshot;
    world_.save(snapshot);
    World other({.settings = world_.settings()}), third;
    other.restore(snapshot);
    third.restore(snapshot);
    fuzz::require(other.state_hash() == world_.state_hash(), "a restored world has another hash");
    other.step(dt);
    third.step(dt);
    fuzz::check_world(other);
    fuzz::require(other.state_hash() == third.state_hash(), "two worlds restored from one snapshot part");
    world_.step(dt);
    fuzz::require(other.state_hash() == world_.state_hash(), "a restored world parts from the one that was saved");
    world_.restore(snapshot);
  }

  fuzz::Bytes& bytes_;
  fuzz::Definitions& definitions_;
  World world_, still_;
  std::vector<BodyId> far_;
  std::vector<BodyId> bodies_;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  atl::fuzz::Bytes bytes({data, size});
  atl::fuzz::Definitions definitions(bytes, atl::fuzz::Numbers::Usual);
  Changes changes(bytes, definitions);
  for (int left = 12; left > 0 && !bytes.empty(); --left) changes.act();
  return 0;
}
