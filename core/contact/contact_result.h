// What the contact problem of one tool did in a tick. Frames: W. SI. RT: yes, plain data.
#pragma once

#include <array>
#include <cstdint>

#include "core/math/limits.h"
#include "core/math/wrench.h"
#include "core/tick/contact_tick.h"

namespace hapticd {

/// One pair that carries force. The pair's contact force on the tool is multiplier * nhat_OG_W at
/// p_WC.
struct ActiveContact {
  std::int32_t contact = 0;  ///< index in the contacts of the problem
  double multiplier = 0.0;   ///< N, >= 0
};

/// What the tick did, in numbers.
struct ContactSummary : ContactOutcome {
  /// On the hand, about the origin of G, before any limit: of the contacts, of friction and of
  /// strings that pull along their axis; N, N m.
  Wrench F_H_W;
  int parts_refused = 0;  ///< soft parts that stayed rigid because kMaxSoftParts yield
  int grips_refused = 0;  ///< rigid objects that stayed smooth because kMaxGrips are held
  int sub_steps = 0;      ///< linearisations used
  int qp_iterations = 0;
  int queries = 0;   ///< tree traversals
  int halvings = 0;  ///< trial steps refused by the exact re-check or the energy test
  std::int64_t tests = 0;
  std::int64_t evaluations = 0;   ///< of the tests those of single pairs, once they were found
  std::int64_t rows = 0;          ///< filled, of all programs
  std::int64_t pressed = 0;       ///< pairs that bore force before, of all linearisations
  std::int64_t string_pairs = 0;  ///< of strings that were eliminated, of all programs
  bool cut_short = false;         ///< the work budget ended the tick
};

/// The same with the pairs that carry force; those beyond active_count mean nothing.
struct ContactResult : ContactSummary {
  std::array<ActiveContact, kMaxQpUnknowns> active;
};

}  // namespace hapticd
