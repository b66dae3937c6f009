#include "world/body_records.h"

#include <collision/narrowphase/surface_contacts.h>
#include <jobs/append.h>
#include <jobs/bytes.h>

#include <algorithm>

namespace atl {

solver::Mobility mobility_of(BodyType type) {
  switch (type) {
    case BodyType::Static:
      return solver::Mobility::Fixed;
    case BodyType::Kinematic:
      return solver::Mobility::Kinematic;
    case BodyType::Dynamic:
      break;
  }
  return solver::Mobility::Dynamic;
}

void BodyRecords::resize(std::size_t bodies) {
  jobs::append(generation, bodies, std::uint32_t{0});
  jobs::append(alive, bodies, std::uint8_t{0});
  jobs::append(type, bodies, BodyType::Static);
  jobs::append(dynamic, bodies, std::uint8_t{0});
  material.resize(bodies);
  centre.resize(bodies);
  jobs::append(continuous, bodies, std::uint8_t{0});
  jobs::append(user_data, bodies, std::uint64_t{0});
  jobs::append(constants, bodies);
}

std::size_t BodyRecords::bytes() const {
  return jobs::bytes_of(generation, alive, type, continuous, user_data, constants, dynamic, free) + material.bytes() +
         centre.bytes();
}

void Contents::count(const solver::BodyTable& bodies, const BodyRecords& records, std::uint32_t body, int sign) {
  const auto add = [sign](std::size_t& counter, bool has) {
    if (has) counter += static_cast<std::size_t>(sign);
  };
  add(kinematic, bodies.mobility[body] == solver::Mobility::Kinematic);
  add(with_friction, records.material[body].friction > 0);
  add(with_restitution, records.material[body].restitution > 0);
  add(gyroscopic, bodies.gyroscopic[body] != 0);
  const auto smooth = [](const CheckedCollider& collider) { return collision::is_smooth(collider.shape); };
  const std::vector<CheckedCollider>& colliders = records.constants[body]->colliders;
  add(smooth_surfaces, std::any_of(colliders.begin(), colliders.end(), smooth));
}

}  // namespace atl
