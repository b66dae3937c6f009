#pragma once

#include <atoll/scene.h>

#include <string>
#include <vector>

namespace atl::tradeoff {

/// True if all bodies share one group whose members don't collide, so that there are joints alone.
bool nothing_touches(const Scene& scene);

/// Solvers of joints that do different things in this scene, its own first; none where there are no joints. `direct`,
/// if it is given, gets how many joints each takes at once.
std::vector<std::string> different_joint_solvers(const Scene& scene, std::vector<std::int64_t>* direct = nullptr);

}  // namespace atl::tradeoff
