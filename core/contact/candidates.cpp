// See candidates.h. RT: yes.
#include "core/contact/candidates.h"

#include <algorithm>
#include <array>

#include "core/contact/clearance.h"
#include "core/contact/tick_work.h"

namespace hapticd {
namespace {

/// A new traversal is due when less than this share of the margin is left to move in. Less: steps
/// that end where the look did, and more force error where a tool slips off something.
constexpr double kRefreshShare = 0.5;
/// A query looks as far as hand or tool travel in a tick times this, at least this share of the
/// margin, at most all of it. Less: more queries where a tool begins to move. More: pairs that come
/// to nothing: a finger slid along the Guqin takes twice the time where all of it is looked at.
constexpr double kMarginTravels = 2.0;
constexpr double kMinMarginShare = 0.125;

/// Pairs that a short budget always leaves, and the gap up to which it leaves all, in skins. Fewer
/// and nearer: a tool among many obstacles moves by less in a tick.
constexpr std::int64_t kMinPairs = 32;
constexpr double kNearSkins = 8.0;

}  // namespace

// Where the work that is left would not do for a linearisation with all pairs, leaves out the
// farthest, as a query does that finds more than its capacity: the step gets shorter, no force
// changes.
void Candidates::leave_out_far(const Configuration& at, const ContactResult& result) noexcept {
  auto& contacts = contacts_.contacts;
  const auto count = static_cast<std::int64_t>(contacts.size());
  const std::int64_t left = at.input.work_budget - tick_work(result) - kSubStepWork -
                            kPressedWork * std::int64_t{at.state.active_count};
  const std::int64_t room = std::max(left / kPairWork, kMinPairs);
  if (at.input.work_budget <= 0 || count <= room) return;
  std::array<double, kMaxCandidates> gaps;
  for (std::size_t c = 0; c < contacts.size(); ++c) gaps[c] = contacts[c].gap;
  const auto first = gaps.begin();
  std::nth_element(first, first + room, first + count);
  const double margin =
      std::max(gaps[static_cast<std::size_t>(room)], kNearSkins * skin_of(at.input.options));
  if (margin >= contacts_.covered_margin) return;
  std::size_t kept = 0;
  for (const Contact& contact : contacts) {
    if (contact.gap < margin) contacts[kept++] = contact;
  }
  contacts.truncate(kept);
  contacts_.covered_margin = margin;
}

// At first in a tick as far as the tool may soon come; one that comes to the edge of that slips,
// and looks at all. What is farther bears no force yet, and no step goes there before it has been
// looked at.
double Candidates::margin_for(const Configuration& at) const noexcept {
  const double most = at.input.options.margin;
  if (at.state.travel > 0.0) return most;
  const double least = std::max(kMinMarginShare * most, kNearSkins * skin_of(at.input.options));
  return std::min(std::max(kMarginTravels * pace_, least), most);
}

bool Candidates::must_look_anew() const noexcept {
  return contacts_.contacts.empty() || room_left() < kRefreshShare * contacts_.covered_margin;
}

void Candidates::query(const Configuration& at, double wanted, ContactResult& result) noexcept {
  const auto& [input, state] = at;
  lap(input.clock, Stage::kOptimisation);
  const QueryOptions options{.margin = margin_for(at),
                             .horizon = input.options.margin + wanted,
                             .tool_level = leaves_ ? kLeafLevel : state.tool_level,
                             .body_level = leaves_ ? kLeafLevel : state.body_level};
  const BentObstacles bent(input.obstacles, state.touched);
  const ToolShape shape(input.parts, state.parts);
  find_contacts({input.tool, state.X_WG, shape.view()}, bent.view(), options, contacts_);
  ++result.queries;
  result.tests += contacts_.tests;
  result.minimum_gap = contacts_.minimum_gap;
  leave_out_far(at, result);
  travelled_ = 0.0;
  stale_ = false;
  lap(input.clock, Stage::kCollision);
}

void Candidates::refresh(const Configuration& at, double wanted, ContactResult& result) noexcept {
  if (!stale_) return;
  if (must_look_anew()) {
    query(at, wanted, result);
    return;
  }
  const auto& [input, state] = at;
  const BentObstacles bent(input.obstacles, state.touched);
  const ToolShape shape(input.parts, state.parts);
  evaluate_contacts({input.tool, state.X_WG, shape.view()}, bent.view(), contacts_);
  contacts_.minimum_gap = std::min(contacts_.minimum_gap, room_left());
  result.tests += static_cast<std::int64_t>(contacts_.contacts.size());
  result.evaluations += static_cast<std::int64_t>(contacts_.contacts.size());
  result.minimum_gap = contacts_.minimum_gap;
  stale_ = false;
}

std::int64_t Candidates::tests_of_next_look() const noexcept {
  return stale_ && must_look_anew() ? contacts_.tests : 0;
}

}  // namespace hapticd
