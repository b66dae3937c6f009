#pragma once

#include <collision/contacts/touching_pair.h>
#include <solver/constraints/load_check.h>
#include <solver/integrate/body_table.h>

namespace atl::solver {

/// `manifolds` by slot.
inline LoadedContact loaded_contact(const BodyTable& bodies, const collision::ContactManifold* manifolds,
                                    const collision::TouchingPair& pair) {
  return {.manifold = manifolds[pair.slot],
          .first = pair.first,
          .second = pair.second,
          .inverse_first = bodies.inverse_mass[pair.first],
          .inverse_second = bodies.inverse_mass[pair.second]};
}

}  // namespace atl::solver
