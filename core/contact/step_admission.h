// Which part of the full step of a linearisation may be committed: as far as the pairs known reach,
// and halved until the exact gaps along the path of tool and strings are not negative and the
// energy does not climb. RT: yes; about 50 ns per pair the step could close.
#pragma once

#include "core/contact/row_program.h"

namespace hapticd {

/// Upper bound of the travel of any point of the tool relative to any of a string in `step`, m.
[[nodiscard]] HD_REALTIME double step_bound(const Configuration& at,
                                            const ConfigurationStep& step) noexcept;

/// The step that is to be admitted.
struct WantedStep {
  const RowProgram& program;
  const PoseError& error_GH;
  double room_left;  ///< how far points may go before they come to what was not looked at, m
  bool last;         ///< of its tick, within the tolerance: worth one try
};

/// What of it may be committed.
struct Admission {
  bool admitted = false;  ///< false: nothing is, the configuration stays
  double fraction = 0.0;
  bool centred = true;        ///< strings go to the centres of their contacts too
  ConfigurationStep step;     ///< that part of the step
  Pose X_WG;                  ///< where it leads
  Vector3 phi_GH_W{0, 0, 0};  ///< rotation error there
};

/// How much of a step keeps path, energy and other tools; commits nothing, and counts what it looks
/// at in `result`, that of the view.
HD_REALTIME void admissible_fraction(const ContactView& view, const WantedStep& wanted,
                                     Admission& admission, ContactResult& result) noexcept;

}  // namespace hapticd
