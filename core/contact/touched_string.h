// What a tool holds of a string while it touches it: the deflection the string yields by, and the
// stick anchor of its friction. A string that yields adds two unknowns to the program of the tick,
// the deflection u of its vertex along two directions normal to the axis,
//   U(u) = string law in series with the compliance 1/kc - 1/kt,
// so that tool and string together press on each other with kc where kt is stiffer. The vertex
// slides along the string with the contact. Friction is a spring of stiffness ka between the
// material points of tool and string, that yields at mu N (Coulomb, by return mapping: J. C. Simo
// and T. J. R. Hughes, "Computational Inelasticity", 1.2). Frames: W. RT: yes.
#pragma once

#include <array>
#include <cstddef>
#include <new>

#include "core/collision/contact.h"
#include "core/collision/obstacles.h"
#include "core/contact/soft_part.h"
#include "core/contact/virtual_coupling.h"
#include "core/instrument/deflection.h"
#include "core/instrument/instrument_options.h"
#include "core/math/fixed_vector.h"

namespace hapticd {

/// A touched string, from tick to tick.
struct TouchedString {
  StringBend bend;      ///< u = 0 for a string that does not yield
  bool yields = false;  ///< StringContact::kYielding: u is an unknown
  /// Of the string on the tool after the last program, N; 0 without friction.
  double normal_force = 0.0;
  Vector3 tangential_W{0.0, 0.0, 0.0};  ///< friction and lateral force on the tool, N
  Vector3 slip_W{0.0, 0.0, 0.0};        ///< of the stick anchor's spring, tangential, m
};

/// Ordered by capsule.
using TouchedStrings = FixedVector<TouchedString, kMaxDeflectingStrings>;

/// A string within this many skins may be held; it is let go beyond twice as many. Fewer: a touch
/// begins a linearisation later; more: unknowns for strings that are not touched.
inline constexpr double kTouchSkins = 2.0;
/// Stiffnesses of a string in the program stay within these shares of kt: a slack string keeps the
/// program solvable, one touched at its end is as good as rigid.
inline constexpr double kMinStringStiffness = 1e-6;
inline constexpr double kMaxStringStiffness = 1e5;

/// A held string around its present deflection: what the program of a linearisation needs.
struct StringBlock {
  int unknown = -1;      ///< of the radial deflection; the tangential one follows; -1: none
  bool touched = false;  ///< the vertex slides with the contact
  Vector3 axis_W;        ///< unit, A to B
  double length = 0.0;   ///< m
  Vector3 radial_W;      ///< unit, along u, or where the contact pushes
  Vector3 tangential_W;  ///< unit, axis x radial
  double radial_stiffness = 1.0;      ///< N/m
  double tangential_stiffness = 1.0;  ///< N/m
  double force = 0.0;                 ///< the string pulls its vertex back by this along -radial, N
  double lateral_force = 0.0;         ///< on the tool along the axis, N; 0 unless asked for
  Vector3 p_GC_W;                     ///< centre of the contact from G, m
  Vector3 nhat_W;                     ///< mean normal of the contact, unit
  double lambda = 0.0;                ///< of the centre of the contact
  Vector3 slip_W;                     ///< of the anchor, tangential to this contact, m
  double slip_stiffness = 0.0;        ///< of friction around the present slip, N/m; 0: none
  /// Share of each soft part in the contact; where there is none of them nothing is set.
  std::array<double, kMaxSoftParts> part_share;
  std::size_t parts = 0;  ///< soft parts that there are
};

using StringBlocks = std::array<StringBlock, kMaxDeflectingStrings>;

/// Parts of a string's motion in a step: of its vertex across the axis (m) and along it.
struct StringMotion {
  Vector3 du_W;
  double dlambda;   ///< with the contact and towards its centre
  double centring;  ///< what of dlambda is towards the centre: a step without it is as good
};

/// A step of the whole configuration. Strings in the order of the holds, parts in that of the soft
/// ones; entries beyond them mean nothing.
struct ConfigurationStep {
  ToolMotion tool;
  std::array<StringMotion, kMaxDeflectingStrings> strings;
  PartMotions parts;
};

/// `motion` times `factor`.
[[nodiscard]] inline StringMotion scaled(const StringMotion& motion, double factor) noexcept {
  return {motion.du_W * factor, motion.dlambda * factor, motion.centring * factor};
}

/// The bend after `motion`.
[[nodiscard]] HD_REALTIME StringBend moved(const StringBend& bend,
                                           const StringMotion& motion) noexcept;

/// What the string law needs to know of the tool and the scene.
struct StringContext {
  ObstaclesView obstacles;                   ///< without bends
  std::span<const StringConstants> strings;  ///< of the first capsules; the rest are rigid lines
  const InstrumentOptions& options;
  double kt;  ///< N/m
};

/// The string law at deflection |u| = `deflection`, in series with what kt is stiffer than kc, and
/// next to an end with kMaxStringStiffness kt.
[[nodiscard]] HD_REALTIME Deflection string_law(const StringContext& context,
                                                const StringBend& bend, double deflection) noexcept;

/// Takes up strings that contacts have come near and lets go of those that are far and at rest.
/// Returns true when a string that yields was taken up or let go: the contacts are then to be
/// queried afresh. Strings beyond the capacity stay rigid and are counted in `refused`.
[[nodiscard]] HD_REALTIME bool update_touched_strings(const StringContext& context,
                                                      const ContactSet& contacts, double skin,
                                                      TouchedStrings& holds, int& refused) noexcept;

/// The obstacles with the strings bent as they are held, after `fraction` of `step` where one is
/// given. Views the obstacles it is made from.
class BentObstacles {
 public:
  BentObstacles(const ObstaclesView& straight, const TouchedStrings& holds) noexcept
      : straight_(straight) {
    for (const TouchedString& hold : holds) {
      if (hold.yields) add(hold.bend);
    }
  }
  BentObstacles(const ObstaclesView& straight, const TouchedStrings& holds,
                const ConfigurationStep& step, double fraction) noexcept
      : straight_(straight) {
    for (std::size_t k = 0; k < holds.size(); ++k) {
      if (holds[k].yields) {
        add(moved(holds[k].bend, scaled(step.strings[k], fraction)));
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

/// Index of the hold of a capsule, or -1.
[[nodiscard]] inline int find_touched(const TouchedStrings& holds, const ContactKey& key) noexcept {
  if (key.kind != ObstacleKind::kCapsule) return -1;
  for (std::size_t k = 0; k < holds.size(); ++k) {
    if (holds[k].bend.capsule == key.obstacle) return static_cast<int>(k);
  }
  return -1;
}

/// Greatest distance any string moves when all go back to rest, m.
[[nodiscard]] inline double greatest_deflection(const TouchedStrings& holds) noexcept {
  double greatest = 0.0;
  for (const TouchedString& hold : holds) greatest = std::max(greatest, hold.bend.u_W.norm());
  return greatest;
}

/// Upper bound of the way of any point of a leg of a string `length` long in `motion`, m: that of
/// the vertex, along the axis included, for what slides past it changes legs.
[[nodiscard]] inline double displacement_bound(const StringMotion& motion, double length) noexcept {
  return motion.du_W.norm() + std::abs(motion.dlambda) * length;
}

/// Energy of the friction spring at slip `slip` while it yields at mu N, J: quadratic below, linear
/// beyond (Huber's function).
[[nodiscard]] HD_REALTIME double slip_energy(double stiffness, double limit, double slip) noexcept;

}  // namespace hapticd
