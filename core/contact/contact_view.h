// A tool's contact problem at one configuration, to look at: the pairs near it, what strings and
// soft parts are modelled as, and what the tick has done so far. RT: yes, views its parts.
#pragma once

#include <array>
#include <cstddef>

#include "core/contact/contact_result.h"
#include "core/contact/rigid_friction.h"
#include "core/contact/soft_parts.h"
#include "core/contact/yielding_strings.h"

namespace hapticd {

/// Views of the parts of a contact problem; valid while the problem, its input and state stand.
struct ContactView {
  const ContactInput& input;
  const ContactState& state;
  const ContactSet& contacts;
  const YieldingStrings& strings;
  const SoftParts& parts;
  const RigidFriction& friction;
  const ContactResult& result;

  [[nodiscard]] Configuration at() const noexcept { return {input, state}; }
  /// The contact that a pair which carries force belongs to.
  [[nodiscard]] const Contact& contact_of(const ActiveContact& active) const noexcept {
    return contacts.contacts[static_cast<std::size_t>(active.contact)];
  }
};

/// Coefficients of a soft part in a row.
struct PartTerm {
  std::size_t unknown;  ///< first of its three
  Vector3 linear;
};

/// Left-hand coefficients of one contact for the tool, the string it presses and its soft parts,
/// and the right-hand side.
struct ContactRow {
  Vector3 linear;
  Vector3 angular;
  int unknown = -1;  ///< of the string's radial deflection; the tangential one follows; -1: none
  double radial = 0.0;
  double tangential = 0.0;
  std::array<PartTerm, kMaxSoftParts> part;
  std::size_t parts = 0;
  double bound;  ///< what the gap lacks of the exact surface, m
};

/// The row of `contact`, whose strings and soft parts are modelled.
[[nodiscard]] HD_REALTIME ContactRow contact_row(const ContactView& view,
                                                 const Contact& contact) noexcept;

}  // namespace hapticd
