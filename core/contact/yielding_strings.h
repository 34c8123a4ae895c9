// The touched strings as unknowns of the program of a tick. A string that yields adds two, the
// deflection u of its vertex along two directions normal to the axis,
//   U(u, lambda) = string law in series with the compliance 1/kc - 1/kt,
// so that tool and string together press on each other with kc where kt is stiffer. The vertex
// slides along the string with the spheres that touch it, and what that changes of U is work of the
// tool: the string pulls it along the axis by -dU/dx, x = lambda L, where halves are unequal. So
// all that a string does to the tool is the gradient of what it stores. Friction is a spring of
// stiffness ka between the material points of tool and string, that yields at mu N (Coulomb, by
// return mapping: J. C. Simo and T. J. R. Hughes, "Computational Inelasticity", 1.2). Frames: W.
// RT: yes, about 0.2 us per string and linearisation.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "core/contact/string_law.h"
#include "core/contact/unknowns.h"

namespace hapticd {

/// A touched string around its present deflection: what the program of a linearisation needs.
struct StringBlock {
  int unknown = -1;      ///< of the radial deflection; the tangential one follows; -1: none
  bool touched = false;  ///< the vertex slides with the contact
  StringBend bend;       ///< of the vertex
  Vector3 axis_W;        ///< unit, A to B
  double length = 0.0;   ///< m
  Vector3 radial_W;      ///< unit, along u, or where the contact pushes
  Vector3 tangential_W;  ///< unit, axis x radial
  double radial_stiffness = 1.0;      ///< N/m
  double tangential_stiffness = 1.0;  ///< N/m
  double force = 0.0;                 ///< the string pulls its vertex back by this along -radial, N
  double energy = 0.0;                ///< U, J
  double lateral_force = 0.0;         ///< on the tool along the axis, -dU/dx, N
  double axial_stiffness = 0.0;       ///< d2U/dx2, N/m
  double mixed_stiffness = 0.0;       ///< d2U/dx du, radially, N/m
  Vector3 p_GS_W;               ///< what the vertex goes with, mean centre of spheres, from G, m
  Vector3 p_GC_W;               ///< centre of the contact from G, m
  Vector3 nhat_W;               ///< normal of the contact, across both legs alike, unit
  double steepness = 1.0;       ///< what bears along nhat over what bears across the axis
  double lambda = 0.0;          ///< of the centre of the contact
  double place = 0.0;           ///< of p_GS_W along the axis, beyond the ends too, 1
  Vector3 slip_W;               ///< of the anchor, tangential to this contact, m
  double slip_stiffness = 0.0;  ///< of friction around the present slip, N/m; 0: none,
  Vector3 slipping_W;           ///< but for this unit direction, in which it slips; zero: it sticks
  /// Share of each soft part in the contact; where there is none of them nothing is set.
  std::array<double, kMaxSoftParts> part_share;
  std::size_t parts = 0;  ///< soft parts that there are
};

/// Derivative of a contact's gap with respect to the step of the tool, and equally the wrench of a
/// unit multiplier on it, about the origin of G: the normal at the contact, without what the
/// vertex's sliding along with the centre of the contact cancels of it.
struct GapGradient {
  Vector3 linear;
  Vector3 angular;
  int string = -1;    ///< index of the touched string, or -1
  double slid = 0.0;  ///< linear = normal - slid * axis of the string
};

/// What the pairs of a touched string bear together, summed over their multipliers.
struct StringSum {
  Vector3 f_W;        ///< on the tool, N
  double lambda;      ///< weighted with the multipliers
  double multiplier;  ///< N
  double beside;  ///< N, of pairs with its parts that do not yield, which are no part of the sums
};

/// The string's motion in `step` when its vertex moves by `du_W` across the axis: along it goes
/// with the contact, and to its centre as far as the step's room for that allows.
[[nodiscard]] HD_REALTIME StringMotion string_motion(const StringBlock& block,
                                                     const StringBend& bend, const Vector3& du_W,
                                                     const ConfigurationStep& step) noexcept;

/// The touched strings of one tool; what they are between ticks stands in ContactState::touched.
class YieldingStrings {
 public:
  /// Takes up strings that contacts have come near and lets go of those that are far and at rest,
  /// which moves nothing. Returns true when a string that yields was taken up or let go: the
  /// contacts are then to be queried afresh. Strings beyond the capacity stay rigid and are counted
  /// in `refused`.
  [[nodiscard]] HD_REALTIME static bool touch(const ContactInput& input, const ContactSet& contacts,
                                              TouchedStrings& strings, int& refused) noexcept;

  /// Lets all go to rest, or as far towards it as other tools let them; those stay touched.
  HD_REALTIME static void relax(const ContactInput& input, TouchedStrings& strings) noexcept;

  /// Ends a tick: where friction slips its anchor follows, and what its spring exceeds mu N by is
  /// lost as heat.
  HD_REALTIME static void finish(const ContactInput& input, TouchedStrings& strings) noexcept;

  /// True when `step` moves no string into another tool.
  [[nodiscard]] HD_REALTIME static bool clear_of_others(const Configuration& at,
                                                        const ConfigurationStep& step) noexcept;

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
  HD_REALTIME void commit(const ContactInput& input, const ConfigurationStep& step,
                          ContactState& state) const noexcept;

  /// Gradient of a contact's gap.
  [[nodiscard]] HD_REALTIME GapGradient gradient(const ContactState& state,
                                                 const Contact& contact) const noexcept;
  /// The same with respect to soft part number `part` of the state, which the contact's sphere
  /// belongs to if it is its `own`.
  [[nodiscard]] HD_REALTIME Vector3 part_gradient(const Contact& contact,
                                                  const GapGradient& gradient, std::size_t part,
                                                  bool own) const noexcept;

  /// Adds to state.F_H_W what friction and strings that pull along their axis do to the tool at the
  /// end of the full `step`, friction within mu N; `sums` are of the touched strings, in order.
  HD_REALTIME void settle(const ContactInput& input, std::span<const StringSum> sums,
                          const ConfigurationStep& step, ContactState& state) const noexcept;

  /// Of touched string number `k`, as the last build left it.
  [[nodiscard]] const StringBlock& block(std::size_t k) const noexcept { return blocks_[k]; }

 private:
  std::array<StringBlock, kMaxDeflectingStrings> blocks_;
};

static_assert(UnknownGroup<YieldingStrings>);

}  // namespace hapticd
