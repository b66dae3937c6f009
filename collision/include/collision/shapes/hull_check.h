#pragma once

#include <collision/shapes/hull.h>

#include <cstdint>

namespace atl::collision {

/// Hash of a hull's vertices and faces: what Hull::content is.
std::uint64_t content_of(const Hull& hull);

/// Whether all else that a hull tells of its shape is what its vertices and faces make, in the same order. No number in
/// it may lead out of it.
bool is_made_of_its_faces(const Hull& hull);

}  // namespace atl::collision
