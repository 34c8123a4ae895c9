// What touches a string, sub-step by sub-step: fingers are potentials of the distance between the
// string and their centre, planes of the depth in them, and the force of a sub-step is the discrete
// gradient of the potential. So the energy of modes and contacts changes by exactly the work of the
// paths, less damping and friction, at any stiffness, and a string rings after a pluck as the
// finger left it. Source of the method: O. Gonzalez, "Time integration and discrete Hamiltonian
// systems", J. Nonlinear Sci. 6, 1996; V. Chatziioannou and M. van Walstijn, "Energy conserving
// schemes for the simulation of musical instrument contact dynamics", J. Sound Vib. 339, 2015.
// Friction is a bristle that yields at mu N. SI; displacements and forces across the string, (y,
// z). RT: yes.
#pragma once

#include <cstdint>

#include "core/instrument/string_motion.h"
#include "core/math/fixed_vector.h"

namespace hapticd {

/// Contacts of one string that a sub-step solves together, at most.
inline constexpr int kMaxStringContacts = 9;

enum class StringContactShape : std::uint8_t {
  kRound,  ///< a finger, a plectrum: the string is pushed out of a circle about `d`
  kPlane,  ///< a fret, a board: the string is kept on the side of `d` that `normal` points to
};

/// One contact over a tick, and what it remembers.
struct StringContactPath {
  StringContactShape shape = StringContactShape::kRound;
  double lambda_from = 0.5;     ///< place along the string, [0, 1], at the start of the tick
  double lambda_to = 0.5;       ///< and at its end
  Transverse d_from, d_to;      ///< centre, or a point of the plane, m
  Transverse normal{0.0, 1.0};  ///< of a plane, unit
  double radius = 0.0;          ///< of a round contact and the string together, m, > 0
  double radius_from = 0.0;     ///< at the start; 0: the same
  double stiffness = 2e4;       ///< k, N/m, > 0; what the modes leave out comes in series
  double damping = 0.0;         ///< c, N s/m, >= 0, in touch; it never attracts
  double friction = 0.0;        ///< mu, >= 0
  double bristle = 2e4;         ///< k_a, N/m, > 0

  double slope = 0.0;      ///< b of the last sub-step, N/m: where the next one's search begins
  double stretched = 0.0;  ///< the bristle, m

  // Over the tick:
  Transverse force;     ///< mean, on the string, N
  double work = 0.0;    ///< of the path on string and contact, sliding included, J
  double stored = 0.0;  ///< in contact and bristle at the end, J
  int touched = 0;      ///< sub-steps with force
  int first = -1;       ///< of those the first, -1: none
  int last = -1;        ///< and the last
};

using StringContactPaths = FixedVector<StringContactPath, kMaxStringContacts>;

/// `steps` sub-steps under `contacts`, whose paths are straight from the start to the end of them.
/// A contact that slides carries its potential along; the work of that is the hand's. Returns the
/// sub-steps that kept the tangent plane of a round contact for want of another root: energy is
/// lost in those. 32 steps of 32 modes: 3.5 us with one contact.
HD_REALTIME int play(const StringConstants& string, const ModeTable& table, int steps,
                     StringContactPaths& contacts, ModalMotion& motion) noexcept;

}  // namespace hapticd
