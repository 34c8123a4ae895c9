// What each string does to the tool after the contact problem is done: its force, where it acts,
// how far the string yields (string_law.h); its torque shrinks as its force does. Frames: W. RT:
// yes, about 0.1 us per string.
#pragma once

#include <cstdint>
#include <optional>

#include "core/contact/contact_view.h"
#include "core/math/fixed_vector.h"

namespace hapticd {

/// Strings that one tool can press at once and each get their own law; more push like rigid lines
/// and are counted.
inline constexpr int kMaxPressedStrings = 64;

/// One string that presses the tool.
struct PressedString {
  std::int32_t string = 0;
  Vector3 F_W;          ///< on the tool, friction and lateral force included, N
  Vector3 nhat_W;       ///< direction of the contact force alone, from string to tool, unit
  Vector3 p_WC;         ///< mean place of the contact, m
  double radius = 0.0;  ///< mean radius of the spheres that touch it, m
  double force = 0.0;   ///< |F_r|: of the contact, N, > 0
  double lambda = 0.0;
  double deflection = 0.0;  ///< delta, m
  double displacement =
      0.0;  ///< D: of the hand into the string: deflection and what coupling and part yield, m
  double part_compliance = 0.0;  ///< of the soft parts that touch it, m/N; 0: rigid
  std::int32_t part = 0;         ///< of the tool: that of the pair which bears most
  double part_force = 0.0;       ///< what that pair bears, N
};

using PressedStrings = FixedVector<PressedString, kMaxPressedStrings>;

/// The strings that press the tool after the tick of `view`, in ascending order. `F_H_W` becomes
/// the wrench of the tick with the forces of strings that do not yield replaced by their law.
HD_REALTIME void find_string_contacts(const ContactView& view, PressedStrings& contacts,
                                      Wrench& F_H_W) noexcept;

/// The pair of a tool and a string that are near each other.
struct NearestPair {
  double gap;  ///< m
  double lambda = 0.5;
  Vector3 nhat_W;
  Vector3 p_WC;
  std::int32_t part = -1;  ///< of the tool
  double radius = 0.0;     ///< of its sphere, m
};

/// The nearest of the pairs `contacts` between the tool, as it stands now, and string number
/// `string`; none when there is no such pair.
[[nodiscard]] HD_REALTIME std::optional<NearestPair> nearest_to_string(
    const Configuration& at, const ContactSet& contacts, std::int32_t string) noexcept;

}  // namespace hapticd
