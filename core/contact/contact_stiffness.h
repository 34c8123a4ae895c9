// Stiffness of what a tool touches as the hand feels it, for devices that close that loop by
// themselves: how the wrench of the tick changes while the same contacts hold,
//   dF_H_W = -K dX_WH,   K = J' (J G^-1 J' + C)^-1 J,
// J the rows of the pairs that bear force, G the coupling, C what strings and soft parts yield; so
// a rigid wall has kt along its normal and 0 along its surface. Obstacles count as flat and
// friction is left out. Frames: W; about the origin of G. RT: yes, about 0.1 us per pair.
#pragma once

#include "core/contact/contact_view.h"

namespace hapticd {

/// The blocks of K for translation and for rotation; what couples them is left out. Symmetric,
/// positive semidefinite, no eigenvalue above that of the coupling.
struct ContactStiffness {
  Matrix3 K_W = Matrix3::Zero();   ///< N/m
  Matrix3 Kr_W = Matrix3::Zero();  ///< N m/rad
};

/// K of the tick just done, whose last program had so many `unknowns`; zero where nothing bears
/// force.
[[nodiscard]] HD_REALTIME ContactStiffness contact_stiffness(const ContactView& view,
                                                             std::size_t unknowns) noexcept;

}  // namespace hapticd
