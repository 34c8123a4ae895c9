// The quadratic model of one linearisation. Eq. 5 alone sees flat obstacles: its steps then
// converge like (depth / radius)^k, slowly where a press is deep and hardly at all while a tip
// slips off. The model adds what Newton's method asks for: the curvature of the touched obstacles
// weighted with their multipliers, the rotation energy's, the stiffness of the strings that yield
// and of their friction, and of soft parts. With y = [step of the tool; displacements of the soft
// parts; deflections of the held strings]
//   H = G_phi + K + friction - sum mu_i hess(gap_i),   y = basis z  with  basis' H basis = 1,
// so that the program stays the projection of a point. During a slip H is indefinite; then the
// magnitudes of its eigenvalues count (saddle-free Newton, Dauphin et al., NIPS 2014). Frames: W;
// steps [dp; dtheta] about the origin of G. RT: yes, about 0.3 us with contacts.
#pragma once

#include "core/contact/contact_problem.h"

namespace hapticd {

/// Least eigenvalue of H relative to G and K. Smaller: longer leaps during a slip, more of them
/// refused.
inline constexpr double kMinStiffnessShare = 0.02;

/// Model at `state` with error `e`, the pairs in state.active and their multipliers, and the
/// strings held as `models` of `unknowns` say, the soft parts as `parts`. The contacts of the
/// workspace must be up to date.
HD_REALTIME void build_local_model(const ContactInput& input, const ContactState& state,
                                   const PoseError& error_GH, const StringBlocks& models,
                                   const PartBlocks& parts, int unknowns,
                                   LocalModel& model) noexcept;

}  // namespace hapticd
