#pragma once

#include <solver/constraints/joint.h>
#include <solver/integrate/body_table.h>
#include <solver/islands/islands.h>
#include <solver/solver_settings.h>

#include <span>

namespace atl::solver {

/// The longest substep, in s, that can follow all springs of joints that hang together, see SpringStep; infinite
/// without springs. Stiffer ones give energy to tumbling bodies where joints are swept: 7 of 2000 trees gain, with
/// springs of 49 Hz and more, at 240 substeps a second. `joints` are all.
double longest_substep(std::span<const JointLink> links, std::span<const Joint> joints, const BodyTable& bodies);

/// Tells whether joints that hang together are to be solved at once. `too_stiff`: the substep is longer than the
/// longest for their springs. `Auto`: where that is so, where they are joined to something fixed or kinematic, where
/// one is actuated or a tendon couples some, where a body is light, or turns easily, between others that its joints
/// hold to it, and in long chains.
bool joins_directly(std::span<const JointLink> links, std::span<const Joint> joints, const BodyTable& bodies,
                    JointMethod method, bool too_stiff);

}  // namespace atl::solver
