#pragma once

#include <collision/contact.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace atl::solver {

class Islands;

/// How far soft contacts may give under what they carry, in parts of the smaller body's half thickness, before they
/// count as overloaded. A column of boxes starts to buckle from about 15 boxes on, where it is 1.6% (by Euler's load; a
/// longer one takes a while).
inline constexpr double overload_give = 0.015;
/// In islands that are little but columns, which cost little to solve at once: six boxes. From 0.2% on it would also
/// take in three, six times as dear in a crowd of such stacks for the 1 mm of a metre that they give.
inline constexpr double column_give = 0.005;
/// Hz, as whose springs contacts count when it is decided whether they carry too much: what four substeps at 60 Hz make
/// of them. Substeps make them stiffer, but to decide by that would leave a wall to eight of them, and sink by 165 mm,
/// that gets sixteen if four are asked for, and sinks by 41. Nor do sweeps settle columns any sooner: with 16 substeps
/// a tower of 50 boxes falls that gives by 0.3% only.
inline constexpr double load_hertz = 30;
/// The same over the length of the step, in longer ones.
inline constexpr double load_hertz_by_step = 0.5;
/// In parts of the arm: crushes what carries it.
inline constexpr double crushing_give = 0.12;

/// Of a contact's arm and normal: how far its body reaches along the normal, and for what is touched at a rim at least
/// this part of the arm.
inline constexpr double least_thickness = 0.1;

/// What an island is like, where it matters for how much its contacts may carry.
enum class Build : std::uint8_t {
  Any,
  /// Small and of so few contacts that it is little but columns (or arches): to solve it at once costs not much more
  /// than to sweep it.
  Columns,
  Joined,  ///< there are joints in it
};
Build build_of(const Islands& islands, std::size_t island);

/// Where there are joints, a body that is so many times as heavy as the one it presses on crushes it: by more than
/// limbs of a body differ.
inline constexpr double crushing_ratio = 64;

/// The lighter body of a contact that carries more than soft ones are made for.
struct Overload {
  std::uint32_t body;
  bool crushed;
};

/// A contact and its bodies, with inverse masses in 1/kg: 0 of what doesn't respond.
struct LoadedContact {
  const collision::ContactManifold& manifold;
  std::uint32_t first, second;
  double inverse_first, inverse_second;
};

/// N s: all that its points push with, as of the last step.
double load_of(const collision::ContactManifold& manifold);

/// Adds what a contact is, if it is overloaded. `give` in m kg: how far contacts between dynamic bodies give under the
/// load that it carries, times the mass.
void note_overload(const LoadedContact& contact, double give, Build build, std::vector<Overload>& overloads);

}  // namespace atl::solver
