#pragma once

#include <collision/contacts/contact.h>
#include <collision/shapes/collider_table.h>
#include <jobs/compact_array.h>
#include <solver/direct/joint_systems.h>
#include <solver/integrate/body_table.h>
#include <solver/islands/islands.h>
#include <solver/solver_settings.h>

#include <cstddef>
#include <cstdint>

namespace atl::solver {

/// The input of an estimate of the loads on contacts.
struct LoadInput {
  const Islands& islands;
  const BodyTable& bodies;
  const collision::ContactManifold* manifolds;  ///< by slot
  const collision::Contact* contacts;           ///< likewise
  const collision::ColliderTable& colliders;
  Vector3 gravity;  ///< m/s^2
  double dt;        ///< s
  const SolverSettings& settings;
  const JointGraph* joint_graph = nullptr;      ///< null where there are no joints
  const JointSystems* joint_systems = nullptr;  ///< likewise
  bool refines = true;                          ///< islands that sag may be refined; else targets set their substeps
  bool estimates = true;                        ///< all loads; else those of islands that have changed
};

/// Estimates the load on each contact of an island at rest. From the top down, each body hands its weight and the load
/// on it to the bodies below it, in equal parts.
class LoadEstimate {
 public:
  /// Bodies of an island whose contacts would overlap by more than is allowed.
  struct Overload {
    std::size_t bodies = 0;
    bool deep = false;  ///< one of them is deep in what it presses on
  };
  Overload of(const LoadInput& input, std::size_t island, Build build);

 private:
  // A body of the island.
  struct Node {
    float height;  // m, above the first one
    float load;    // N: its weight, and what it carries
    float inverse_mass;
    std::uint32_t on_top;    // supports it is the lower body of, that haven't handed their load on
    std::uint32_t supports;  // number of its supports
    std::uint32_t support;   // the last of them
    bool overloaded;
  };
  // A contact, from the body above to the one below, which is none if it is fixed.
  struct Support {
    std::uint32_t above, below, next;
    float capacity;  // N: with more load the contact overlaps too far
    std::uint32_t contact;
  };
  bool is_deep(const LoadInput& input, const collision::TouchingPair& pair, double load, Build build) const;

  jobs::CompactArray<Node> nodes_;
  jobs::CompactArray<Support> supports_;
  jobs::CompactArray<std::uint32_t> free_;  // nodes whose load is known
};

}  // namespace atl::solver
