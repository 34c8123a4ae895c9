// What each string does to the tool after the optimiser is done: its force, where it acts, how far
// the string yields. Strings that do not yield get their force here (Eq. 10-13): with F the net
// contact force of the string, the hand has pressed D = |F| / kt into it, the string counts as
// deflected by delta = D / k_s, and |F_r| = F(delta), no more than kc D; its torque shrinks alike.
// Deviation: the bound by kc; without it the ends are stiffer than any loop can render. Frames: W.
// RT: yes, about 0.1 us per string.
#pragma once

#include <cstdint>

#include "core/contact/contact_problem.h"
#include "core/math/fixed_vector.h"

namespace hapticd {

/// Strings that one tool can press at once and each get their own law; more push like rigid lines
/// and are counted.
inline constexpr int kMaxPressedStrings = 64;

/// One string that presses the tool.
struct PressedString {
  std::int32_t string = 0;
  Vector3 F_W;         ///< on the tool, friction and lateral force included, N
  Vector3 nhat_W;      ///< direction of the contact force alone, from string to tool, unit
  Vector3 p_WC;        ///< mean place of the contact, m
  double force = 0.0;  ///< |F_r|: of the contact, N, > 0
  double lambda = 0.0;
  double deflection = 0.0;  ///< delta, m
  double displacement =
      0.0;  ///< D: of the hand into the string: deflection and what coupling and part yield, m
  double part_compliance = 0.0;  ///< of the soft parts that touch it, m/N; 0: rigid
  std::int32_t part = 0;         ///< of the tool: that of the pair which bears most
  double part_force = 0.0;       ///< what that pair bears, N
};

/// What a string gives the hand for what the program presses on it.
struct StringLoad {
  double force;         ///< |F_r|, N
  double deflection;    ///< delta, m
  double displacement;  ///< D, m
  double lateral;       ///< along the axis, of one that does not yield, N; 0 unless asked for
};

/// The law of string `number`, pressed at lambda with `F_W` (the program's contact force on the
/// tool, N) and held as `hold` says (null: not held). A string that yields has its law in the
/// program; it gives no more than kc D either.
[[nodiscard]] HD_REALTIME StringLoad string_load(const ContactInput& input,
                                                 const TouchedString* hold, std::int32_t number,
                                                 double lambda, const Vector3& F_W) noexcept;

using PressedStrings = FixedVector<PressedString, kMaxPressedStrings>;

/// The strings that press the tool after the tick `result`, in ascending order. `F_H_W` becomes the
/// wrench of the tick with the forces of strings that do not yield replaced by their law.
HD_REALTIME void find_string_contacts(const ContactInput& input, const ContactState& state,
                                      const OptimiserWorkspace& workspace,
                                      const ContactResult& result, PressedStrings& contacts,
                                      Wrench& F_H_W) noexcept;

/// The tool near a string that does not press it.
struct NearestPair {
  double gap;  ///< m; `nothing` when no pair is in the contact set
  double lambda = 0.5;
  Vector3 nhat_W;
  Vector3 p_WC;
  std::int32_t part = -1;  ///< of the tool; -1: no pair
};

/// The nearest pair of `contacts` between the tool, as it stands now, and string number `string`.
[[nodiscard]] HD_REALTIME NearestPair nearest_to_string(const ContactInput& input,
                                                        const ContactState& state,
                                                        const ContactSet& contacts,
                                                        std::int32_t string,
                                                        double nothing) noexcept;

}  // namespace hapticd
