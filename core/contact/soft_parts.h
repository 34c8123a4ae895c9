// The touched soft parts of a tool as unknowns of the program of a tick. A part stands aside by v,
// held by a spring k and a damper c side by side (Kelvin-Voigt), and so in series with every
// contact of the part. Over a tick, by implicit Euler,
//   U(v) = 1/2 k |v|^2 + c/(2 dt) |v - v_before|^2 = 1/2 K |v - v*|^2 + const,
//   K = k + c/dt,  v* = (c/dt) v_before / K,
// which never gives more energy than it was given. A part adds three unknowns while it is touched
// or displaced. RT: yes, about 20 ns per part.
#pragma once

#include <array>

#include "core/contact/unknowns.h"

namespace hapticd {

/// Displacements up to this vanish when the way is free, m: far below the skin, so that no gap
/// closes by it. Smaller: a damped part keeps its unknowns longer.
inline constexpr double kVanishing = 1e-9;

/// A soft part in the program of one linearisation.
struct PartBlock {
  int unknown = -1;               ///< of the first of three, in the axes of W; -1: does not move
  double stiffness = 0.0;         ///< K, N/m
  Vector3 off_G{0.0, 0.0, 0.0};   ///< v - v*, m
  Vector3 pull_W{0.0, 0.0, 0.0};  ///< on the part, from spring and damper: -K (v - v*), N
};

/// The soft parts of one tool; what they are between ticks stands in ContactState::parts.
class SoftParts {
 public:
  /// Begins a tick: where the parts stand is where they stood before. Parts that are no longer soft
  /// are forgotten.
  HD_REALTIME static void begin(const ContactInput& input, TouchedParts& soft) noexcept;

  /// Takes up soft parts that contacts have come near and lets go of those at rest that none is
  /// near; neither moves anything. Returns true when any was taken up or let go: the unknowns are
  /// then others. Parts beyond the capacity stay rigid and are counted in `refused`.
  [[nodiscard]] HD_REALTIME static bool touch(const ContactInput& input, const ContactSet& contacts,
                                              TouchedParts& soft, int& refused) noexcept;

  /// Where a part goes when nothing touches it, in G, m: to v*, or to rest when that is vanishingly
  /// near.
  [[nodiscard]] HD_REALTIME static Vector3 rest_of(const ContactInput& input,
                                                   const SoftPart& soft) noexcept;
  /// How far that takes any of them, m.
  [[nodiscard]] HD_REALTIME static double free_travel(const Configuration& at) noexcept;
  /// Lets all go there.
  HD_REALTIME static void relax(const ContactInput& input, TouchedParts& soft) noexcept;

  // As UnknownGroup.
  [[nodiscard]] HD_REALTIME int build(const Configuration& at, const ContactSet& contacts,
                                      int unknowns) noexcept;
  HD_REALTIME void measure(const ContactState& state, UnknownScale& scale) const noexcept;
  HD_REALTIME void read_step(const Configuration& at, const Unknowns& y,
                             ConfigurationStep& step) const noexcept;
  [[nodiscard]] HD_REALTIME static double travel(const Configuration& at,
                                                 const ConfigurationStep& step) noexcept;
  [[nodiscard]] HD_REALTIME double energy_gain(const Configuration& at,
                                               const ConfigurationStep& step) const noexcept;
  HD_REALTIME void add_stored_energy(const Configuration& at, double& energy) const noexcept;
  HD_REALTIME static void commit(const ContactInput& input, const ConfigurationStep& step,
                                 ContactState& state) noexcept;

  /// Of touched part number `k`, as the last build left it.
  [[nodiscard]] const PartBlock& block(std::size_t k) const noexcept { return blocks_[k]; }

 private:
  std::array<PartBlock, kMaxSoftParts> blocks_;
};

static_assert(UnknownGroup<SoftParts>);

}  // namespace hapticd
