#pragma once

namespace atl::solver {

/// What the surfaces of a touching pair do beside plain friction, by contact slot, in rows of four floats for the
/// kernels. The step fills in all but the impulse, which lasts as those of a manifold do.
struct alignas(32) SurfaceContact {
  float slip[3] = {0, 0,
                   0};  ///< m/s, world frame: of the second surface along its body, against the first along its own
  float rolling_friction = 0;            ///< m
  float rolling_impulse[3] = {0, 0, 0};  ///< N m s, in the tangent plane, on the second body
  float torsional_friction = 0;          ///< m
};

}  // namespace atl::solver
