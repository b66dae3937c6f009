#pragma once
/// How the materials of two shapes that touch act together.

#include <atoll/material.h>

#include "world/stores.h"

namespace atl {

/// Throws Error naming the field, the value and what was expected.
void check(const MaterialPair& pair);

/// Sets what holds between two materials, and wakes who touches by it.
void set_material_pair(Stores& world, const MaterialPair& pair);
/// Takes the table of a state that is read. Throws Error on one that no world has.
void restore_material_pairs(Stores& world, std::vector<MaterialPair> pairs);
/// Null where nothing was said of the two.
const MaterialPair* find_pair(const Stores& world, const Material& a, const Material& b);

/// Coulomb coefficient of two bodies that touch, in the direction in which it is largest.
double friction_of(const Stores& world, const Material& a, const Material& b);
/// Says how the friction of two that touch depends on its direction. They are where they will be half way through the
/// step.
void record_grip(const Stores& world, const collision::Contact& contact, const Material& first, const Material& second,
                 const collision::ContactManifold& manifold, solver::SurfaceContact& surface);
double restitution_of(const Stores& world, const Material& a, const Material& b);

}  // namespace atl
