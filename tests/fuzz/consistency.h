#pragma once
/// Invariants of a world, whatever was done to it, and of the answers to queries.

#include <atoll/atoll.h>
#include <atoll/queries.h>

#include "definitions.h"

namespace atl::fuzz {

/// Everything that a world tells is finite, and what it says in two places agrees. Throws Finding.
void check_world(const World& world);
/// A shape that could be made has a volume or is refused one, and closes where it says so. Throws Finding.
void check_shape(const Shape& shape);
/// Compares the reports of two worlds to which the same was done, beside their states.
void check_same_results(const World& a, const World& b);
void check_same_reports(const StepReport& a, const StepReport& b);

/// Takes from a definition the shapes that no query without a filter finds. False if that is all.
bool keep_what_is_seen(BodyDef& def);

/// Asks all worlds the same, chosen from bytes, and holds the answers to each other; and where numbers are usual, to
/// those of worlds of one body each, and overlaps to the audit. Throws Finding.
void check_queries(std::span<const World> worlds, Definitions& definitions, Bytes& bytes);
/// Asks for some bodies alone, and holds the answers to those among all that the filter lets through; and asks much at
/// once, which is answered as one by one. Throws Finding.
void check_filtered_queries(std::span<const World> worlds, Definitions& definitions, Bytes& bytes);

}  // namespace atl::fuzz
