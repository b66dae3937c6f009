#pragma once

#include "contact_rows.h"

namespace atl::reference {

/// Sweeps over all patches in order, each solved row by row with the others' impulses held: projected Gauss-Seidel, in
/// double, without the softness of the engine's. A fixed point is an exact solution; the way there is linear, and long
/// where contacts are stacked. Impulses in and out.
void sweep_gauss_seidel(const ContactRows& rows, Eigen::VectorXd& impulses, int sweeps);

}  // namespace atl::reference
