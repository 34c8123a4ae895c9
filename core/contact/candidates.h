// The pairs of tool and obstacles that a linearisation may come to: found by a traversal around the
// tool, and evaluated afresh as it moves on. A tool looks no farther than hand and tool go; what is
// farther bears no force yet, and no step goes there before it has been looked at. RT: yes.
#pragma once

#include <algorithm>
#include <cstdint>

#include "core/contact/configuration.h"
#include "core/contact/contact_result.h"
#include "core/math/realtime.h"

namespace hapticd {

/// The pairs near G, and how far they still are all. Set `begin` before the first query of a tick.
class Candidates {
 public:
  /// Begins a tick before which no point of tool or hand went further than `pace` (m) within one;
  /// `leaves`: it goes by the leaves, whatever the options say.
  void begin(double pace, bool leaves) noexcept {
    pace_ = pace;
    leaves_ = leaves;
  }

  /// Finds the pairs around the tool, with the bounds of coarse levels unless by the leaves;
  /// `wanted` (m): how far the tool would go if nothing was in its way. A short work budget leaves
  /// the farthest out.
  HD_REALTIME void query(const Configuration& at, double wanted, ContactResult& result) noexcept;

  /// Brings the pairs to where the tool is: the same afresh, or a new query once it has moved out
  /// of their range; nothing where they are of this configuration.
  HD_REALTIME void refresh(const Configuration& at, double wanted, ContactResult& result) noexcept;

  /// No point of tool or strings has moved further than `travel` (m) since the last call.
  void moved(double travel) noexcept {
    travelled_ += travel;
    stale_ = true;
  }

  /// True when every pair up to `distance` (m) is among them, wherever the tool has gone since;
  /// `travel` (m): another bound of how far.
  [[nodiscard]] bool sees(double distance, double travel = 0.0) const noexcept {
    return distance <= contacts_.covered_margin - std::max(travelled_, travel);
  }

  /// False when the gap of a listed pair is certainly above `gap` (m) now.
  [[nodiscard]] bool may_be_within(const Contact& contact, double gap) const noexcept {
    return !(contact.gap - travelled_ > gap);
  }

  /// True when certainly nothing at all is nearer than `distance` (m), wherever the tool has gone
  /// since.
  [[nodiscard]] bool clear_within(double distance) const noexcept {
    return contacts_.minimum_gap - travelled_ >= distance;
  }

  /// How far points of the tool may still go before they come to what was not looked at, m.
  [[nodiscard]] double room_left() const noexcept { return contacts_.covered_margin - travelled_; }

  /// Tests that the next linearisation begins with, as many as the last traversal took, where it
  /// has to look around anew; otherwise 0.
  [[nodiscard]] HD_REALTIME std::int64_t tests_of_next_look() const noexcept;

  /// As they were at the last query or refresh.
  [[nodiscard]] const ContactSet& contacts() const noexcept { return contacts_; }

 private:
  [[nodiscard]] double margin_for(const Configuration& at) const noexcept;
  void leave_out_far(const Configuration& at, const ContactResult& result) noexcept;
  [[nodiscard]] bool must_look_anew() const noexcept;

  ContactSet contacts_;
  double travelled_ = 0.0;  ///< how far tool points may have moved since the last traversal, m
  double pace_ = 0.0;       ///< of any point of the tool or the hand in a tick, at most, m
  bool stale_ = false;      ///< contacts describe an earlier configuration
  bool leaves_ = false;
};

}  // namespace hapticd
