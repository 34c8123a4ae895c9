// What the contact problem of one tool did in a tick. Frames: W. SI. RT: yes, plain data.
#pragma once

#include <array>
#include <cstdint>

#include "core/math/limits.h"
#include "core/math/wrench.h"

namespace hapticd {

/// One pair that carries force. The pair's contact force on the tool is multiplier * nhat_OG_W at
/// p_WC.
struct ActiveContact {
  std::int32_t contact = 0;  ///< index in the contacts of the problem
  double multiplier = 0.0;   ///< N, >= 0
};

enum class ContactStatus : std::uint8_t {
  kFree,        ///< nothing in the way: G coincides with H
  kConverged,   ///< the wanted step fell below stop_tolerance
  kLagging,     ///< sub-steps or work used up before convergence
  kRefused,     ///< no admissible step found: G kept
  kQpFailed,    ///< solver gave up: G kept, force not larger than before
  kRecovering,  ///< a gap was negative at the start: being pushed out
};

/// What the tick did, in numbers.
struct ContactSummary {
  ContactStatus status = ContactStatus::kFree;
  /// On the hand, about the origin of G, before any limit: of the contacts, of friction and of
  /// strings that pull along their axis; N, N m.
  Wrench F_H_W;
  int active_count = 0;     ///< pairs that carry force
  int strings_refused = 0;  ///< strings that stayed rigid because kMaxDeflectingStrings are touched
  int parts_refused = 0;    ///< soft parts that stayed rigid because kMaxSoftParts yield
  int sub_steps = 0;        ///< linearisations used
  int qp_iterations = 0;
  int queries = 0;         ///< tree traversals
  int rows_exchanged = 0;  ///< rows brought in because more pairs than rows mattered
  int halvings = 0;        ///< trial steps refused by the exact re-check or the energy test
  std::int64_t tests = 0;
  std::int64_t evaluations = 0;   ///< of the tests those of single pairs, once they were found
  std::int64_t rows = 0;          ///< filled, of all programs
  std::int64_t pressed = 0;       ///< pairs that bore force before, of all linearisations
  std::int64_t string_pairs = 0;  ///< of strings that were eliminated, of all programs
  bool cut_short = false;         ///< the work budget ended the tick
  double minimum_gap = 0.0;       ///< at the last evaluated pose, m
};

/// The same with the pairs that carry force; those beyond active_count mean nothing.
struct ContactResult : ContactSummary {
  std::array<ActiveContact, kMaxQpUnknowns> active;
};

}  // namespace hapticd
