// The knobs of the contact problem as a scene may set them: which field of Solver is which member
// of ContactOptions, and what decides the ones left open. Offline.
#pragma once

#include <cstdint>

#include "core/contact/contact_options.h"
#include "hapticd/v1/scene.pb.h"

namespace hapticd {

/// What decides a knob that a scene leaves open.
enum class OpenKnob : std::uint8_t {
  kByQuality,  ///< its level
  kUsual,      ///< nothing: it has its default
  kAbsent,     ///< likewise, but the default is no number of the wire
};

/// The knobs of `solver`; those it leaves open have their defaults.
[[nodiscard]] ContactOptions contact_options_of(const v1::Solver& solver);

/// Gives `solver` the numbers of `options` for the knobs of this kind that it leaves open.
void fill_open(OpenKnob kind, const ContactOptions& options, v1::Solver& solver);

/// Takes out of `solver` the knobs that quality decides, but those that `given` has.
void leave_to_quality(const v1::Solver& given, v1::Solver& solver);

/// Puts the knobs that `given` has, though quality decides them otherwise, into `options`.
void keep_from_quality(const v1::Solver& given, ContactOptions& options);

}  // namespace hapticd
