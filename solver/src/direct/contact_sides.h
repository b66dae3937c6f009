#pragma once
/// How the places where contacts act on their bodies move through a step that is solved at once.
///
/// Velocities obey contacts as these are at the end of the step, and impulses act half way through it. Then bodies that
/// go on turning as they do neither lose energy nor gain any: the midpoint rule of Hairer, Lubich and Wanner,
/// "Geometric Numerical Integration", 2006, section II.1, for velocities that change by impulses. Rows are those of
/// half the way, and what they still come to be off is given.

#include <solver/direct/direct_rows.h>
#include <solver/direct/solve_input.h>

#include <vector>

namespace atl::solver {

/// Places a contact on its bodies: its arms, with `half_way` as they will be in the middle of the step, what moves it
/// that doesn't respond, and what its arms come to make of its motion until the step's end. Its axes are set.
void place_sides(const SolveInput& input, const std::vector<DirectBody>& bodies, bool half_way, DirectContact& contact);

/// True if a point comes to lie in the other body, from where it is on, at the speed at which it closes: the body is
/// stopped on its way, by however much.
bool lands(const DirectContact& contact, const std::vector<double>& velocity, double dt);

/// Gives a contact what its arms and, of what touches along a line, the turn of that make of its motion until the end
/// of the step.
void go_ahead(DirectContact& contact);

}  // namespace atl::solver
