// See candidates.h. RT: yes.
#include "core/contact/candidates.h"

#include <algorithm>

#include "core/contact/tick_work.h"

namespace hapticd {
namespace {

/// A new traversal is due when less than this share of the margin is left to move in. Less: steps
/// that end where the look did, and more force error where a tool slips off something.
constexpr double kRefreshShare = 0.5;
/// A query looks as far as the way of hand or tool in a tick times this, at least this share of the
/// margin, at most all of it. Less: more queries where a tool begins to move. More: pairs that come
/// to nothing: a finger slid along the Guqin takes twice the time where all of it is looked at.
constexpr double kMarginWays = 2.0;
constexpr double kMinMarginShare = 0.125;

/// Pairs that a short budget always leaves, and the gap up to which it leaves all, in skins. Fewer
/// and nearer: a tool among many obstacles moves by less in a tick.
constexpr std::int64_t kMinPairs = 32;
constexpr double kNearSkins = 8.0;

/// Where the work that is left would not do for a linearisation with all pairs, leaves out the
/// farthest, as a query does that finds more than its capacity: the step gets shorter, no force
/// changes.
void leave_out_far(const ContactInput& input, const ContactState& state,
                   const ContactResult& result, OptimiserWorkspace& w) noexcept {
  auto& contacts = w.contacts.contacts;
  const auto count = static_cast<std::int64_t>(contacts.size());
  const std::int64_t left = input.work_budget - tick_work(result) - kSubStepWork -
                            kPressedWork * std::int64_t{state.active_count};
  const std::int64_t room = std::max(left / kPairWork, kMinPairs);
  if (input.work_budget <= 0 || count <= room) return;
  for (std::size_t c = 0; c < contacts.size(); ++c) w.excess[c] = contacts[c].gap;
  const auto first = w.excess.begin();
  std::nth_element(first, first + room, first + count);
  const double margin =
      std::max(w.excess[static_cast<std::size_t>(room)], kNearSkins * input.options.skin);
  if (margin >= w.contacts.covered_margin) return;
  std::size_t kept = 0;
  for (const Contact& contact : contacts) {
    if (contact.gap < margin) contacts[kept++] = contact;
  }
  contacts.truncate(kept);
  w.contacts.covered_margin = margin;
}

/// How far the next query looks: at first in a tick as far as the tool may soon come; one that
/// comes to the edge of that slips, and looks at all. What is farther bears no force yet, and no
/// step goes there before it has been looked at.
double margin_for(const ContactInput& input, const ContactState& state,
                  const OptimiserWorkspace& w) noexcept {
  const double most = input.options.margin;
  if (state.travel > 0.0) return most;
  const double least = std::max(kMinMarginShare * most, kNearSkins * input.options.skin);
  return std::min(std::max(kMarginWays * w.pace, least), most);
}

/// How far tool points may still go before they come to what was not looked at, m.
double room_left(const OptimiserWorkspace& w) noexcept {
  return w.contacts.covered_margin - w.travelled;
}

bool must_look_anew(const OptimiserWorkspace& w) noexcept {
  return w.contacts.contacts.empty() || room_left(w) < kRefreshShare * w.contacts.covered_margin;
}

}  // namespace

void find_candidates(const ContactInput& input, const ContactState& state, double reach_wanted,
                     OptimiserWorkspace& w, ContactResult& result) noexcept {
  const QueryOptions options{.margin = margin_for(input, state, w),
                             .horizon = input.options.margin + reach_wanted,
                             .tool_level = w.leaves ? kLeafLevel : state.tool_level,
                             .body_level = w.leaves ? kLeafLevel : state.body_level};
  const BentObstacles bent(input.obstacles, state.touched);
  const ToolShape shape(input.parts, state.parts);
  find_contacts(input.tool, state.X_WG, bent.view(), options, w.contacts, shape.view());
  ++result.queries;
  result.tests += w.contacts.tests;
  result.minimum_gap = w.contacts.minimum_gap;
  leave_out_far(input, state, result, w);
  w.travelled = 0.0;
  w.stale = false;
  w.full_step = false;
}

void refresh_candidates(const ContactInput& input, const ContactState& state, double reach_wanted,
                        OptimiserWorkspace& w, ContactResult& result) noexcept {
  if (!w.stale) return;
  if (must_look_anew(w)) {
    find_candidates(input, state, reach_wanted, w, result);
    return;
  }
  const BentObstacles bent(input.obstacles, state.touched);
  const ToolShape shape(input.parts, state.parts);
  evaluate_contacts(input.tool, state.X_WG, bent.view(), w.contacts, shape.view());
  w.contacts.minimum_gap = std::min(w.contacts.minimum_gap, room_left(w));
  result.tests += static_cast<std::int64_t>(w.contacts.contacts.size());
  result.evaluations += static_cast<std::int64_t>(w.contacts.contacts.size());
  result.minimum_gap = w.contacts.minimum_gap;
  w.stale = false;
}

std::int64_t tests_of_next_look(const OptimiserWorkspace& w) noexcept {
  return w.stale && must_look_anew(w) ? w.contacts.tests : 0;
}

}  // namespace hapticd
