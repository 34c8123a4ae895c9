// What a tool knows of a string while it touches it: the deflection the string yields by, and the
// stick anchor of its friction. Frames: W. SI. RT: yes.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <new>

#include "core/collision/contact.h"
#include "core/collision/obstacles.h"
#include "core/math/fixed_vector.h"
#include "core/math/limits.h"
#include "core/math/realtime.h"

namespace hapticd {

/// A touched string, from tick to tick.
struct TouchedString {
  StringBend bend;  ///< u = 0 for a string that does not yield
  /// u as the hand feels it: bend is that of the tool that keeps its clearance, m.
  Vector3 u_felt_W{0.0, 0.0, 0.0};
  bool yields = false;  ///< StringContact::kYielding: u is an unknown
  /// Of the string on the tool after the last program, N; 0 without friction.
  double normal_force = 0.0;
  Vector3 tangential_W{0.0, 0.0, 0.0};  ///< friction and lateral force on the tool, N
  Vector3 slip_W{0.0, 0.0, 0.0};        ///< of the stick anchor's spring, tangential, m
};

/// Ordered by capsule.
using TouchedStrings = FixedVector<TouchedString, kMaxDeflectingStrings>;

/// A string within this many skins is touched; it is let go beyond twice as many. Fewer: a touch
/// begins a linearisation later; more: unknowns for strings that are not touched.
inline constexpr double kTouchSkins = 2.0;

/// Parts of a string's motion in a step: of its vertex across the axis (m) and along it.
struct StringMotion {
  Vector3 du_W;
  double dlambda;   ///< with the contact and towards its centre
  double centring;  ///< what of dlambda is towards the centre: a step without it is as good
};

/// In the order of the touched strings; entries beyond them mean nothing.
using StringMotions = std::array<StringMotion, kMaxDeflectingStrings>;

/// `motion` times `factor`.
[[nodiscard]] inline StringMotion scaled(const StringMotion& motion, double factor) noexcept {
  return {motion.du_W * factor, motion.dlambda * factor, motion.centring * factor};
}

/// The bend after `motion`.
[[nodiscard]] HD_REALTIME StringBend moved(const StringBend& bend,
                                           const StringMotion& motion) noexcept;

/// The obstacles with the touched strings bent as they are, after `fraction` of their motions where
/// those are given. Views the obstacles it is made from.
class BentObstacles {
 public:
  BentObstacles(const ObstaclesView& straight, const TouchedStrings& strings) noexcept
      : straight_(straight) {
    for (const TouchedString& string : strings) {
      if (string.yields) add(string.bend);
    }
  }
  BentObstacles(const ObstaclesView& straight, const TouchedStrings& strings,
                const StringMotions& motions, double fraction) noexcept
      : straight_(straight) {
    for (std::size_t k = 0; k < strings.size(); ++k) {
      if (strings[k].yields) {
        add(moved(strings[k].bend, scaled(motions[k], fraction)));
      }
    }
  }
  /// Valid as long as this.
  [[nodiscard]] ObstaclesView view() const noexcept {
    ObstaclesView bent = straight_;
    bent.bends = {std::launder(reinterpret_cast<const StringBend*>(bends_.data())), count_};
    return bent;
  }

 private:
  void add(const StringBend& bend) noexcept {
    new (bends_.data() + count_++ * sizeof(StringBend)) StringBend(bend);
  }

  const ObstaclesView& straight_;
  /// Bends, of which no more are made than there are: this is built several times in a tick.
  alignas(StringBend) std::array<std::byte, kMaxDeflectingStrings * sizeof(StringBend)> bends_;
  std::size_t count_ = 0;
};

/// Index of the touched string that is capsule number `capsule`, or -1.
[[nodiscard]] inline int find_touched(const TouchedStrings& strings,
                                      std::int32_t capsule) noexcept {
  for (std::size_t k = 0; k < strings.size(); ++k) {
    if (strings[k].bend.capsule == capsule) return static_cast<int>(k);
  }
  return -1;
}

/// Index of the touched string that a pair is with, or -1.
[[nodiscard]] inline int find_touched(const TouchedStrings& strings,
                                      const ContactKey& key) noexcept {
  return is_string(key) ? find_touched(strings, key.obstacle) : -1;
}

/// Greatest distance any string moves when all go back to rest, m.
[[nodiscard]] inline double greatest_deflection(const TouchedStrings& strings) noexcept {
  double greatest = 0.0;
  for (const TouchedString& string : strings) greatest = std::max(greatest, string.bend.u_W.norm());
  return greatest;
}

/// Upper bound of the travel of any point of a leg of a string `length` long in `motion`, m: that
/// of the vertex, along the axis included, for what slides past it changes legs.
[[nodiscard]] inline double displacement_bound(const StringMotion& motion, double length) noexcept {
  return motion.du_W.norm() + std::abs(motion.dlambda) * length;
}

}  // namespace hapticd
