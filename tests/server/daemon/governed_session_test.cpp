// Automatic quality over whole contact sessions, by work counts at the nominal price, as the daemon
// goes under the virtual clock: against every fixed level that meets the same budget. Truth: the
// same sessions with 400 linearisations per tick; and the hand's own motion for what a force may
// change by when the level is switched.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "core/contact/tick_work.h"
#include "core/scene/quality.h"
#include "server/daemon/quality_governor.h"
#include "server/daemon/work_cost.h"
#include "tests/core/contact/rendering_fixture.h"
#include "tests/core/contact/session_run.h"
#include "tests/support/random.h"

namespace hapticd::test {
namespace {

constexpr double kRate = 1000.0;
constexpr std::int64_t kTick_ns = 1'000'000;
/// Automatic quality may have so many times the error of the best fixed level.
constexpr double kWorse = 1.5;
/// An error of so little is none, percent: a hand tells 7.
constexpr double kNoError = 0.1;
/// A session is played so often before it is judged: a climb takes calm seconds.
constexpr int kRehearsals = 6;
/// Change of force per tick that a contact switch may always make, N, and its share of kt |v| dt.
constexpr double kFreeChange = 0.15;
constexpr double kExcess = 1.1;

double nominal_ns(std::int64_t work) { return kNominalWork_ns * static_cast<double>(work); }

double dearest_tick(const std::vector<double>& costs_ns) {
  return *std::max_element(costs_ns.begin(), costs_ns.end());
}

/// That one in a thousand exceeds.
double dear_tick(std::vector<double> costs_ns) {
  const auto at = static_cast<std::ptrdiff_t>(0.999 * static_cast<double>(costs_ns.size()));
  std::nth_element(costs_ns.begin(), costs_ns.begin() + at, costs_ns.end());
  return costs_ns[static_cast<std::size_t>(at)];
}

/// What a session cost and felt like.
struct Played {
  std::vector<Vector3> f_H_W;
  std::vector<double> costs_ns;
  int cut_ticks = 0;
  int level = 0;  ///< at the end
};

RenderingScene scene_of(const ContactSession& session) {
  RenderingScene scene(session.tool_G);
  scene.capsules_W = session.capsules_W;
  for (const SessionBody& body : session.bodies) scene.add_body(body.spheres_B, pose_at(body.p_WB));
  return scene;
}

Pose hand(const ContactSession& session, int tick) {
  const SessionPose at = session.X_WH(tick / kRate);
  return pose_at(at.p_WH, at.phi_WH);
}

/// Plays once at the levels and budgets that `next` chooses from each tick.
template <typename Next>
Played play_once(const ContactSession& session, int level, Next next) {
  const RenderingScene scene = scene_of(session);
  ToolRun tool(scene, hand(session, 0));
  Played played;
  for (int tick = 0; tick < static_cast<int>(session.seconds * kRate); ++tick) {
    tool.options = quality_of(level).options;
    tool.tick(hand(session, tick));
    played.f_H_W.push_back(tool.result.F_H_W.f);
    played.costs_ns.push_back(nominal_ns(tick_work(tool.result)));
    if (tool.result.cut_short) ++played.cut_ticks;
    level = next(tool, level);
  }
  played.level = level;
  return played;
}

Played play_fixed(const ContactSession& session, int level) {
  return play_once(session, level, [](const ToolRun&, int same) { return same; });
}

Played play_governed(const ContactSession& session, double budget_ns) {
  QualityGovernor governor;
  std::int64_t t_ns = 0;
  Played played;
  played.level = kDefaultQuality;
  for (int k = 0; k <= kRehearsals; ++k) {
    played = play_once(session, played.level, [&](ToolRun& tool, int level) {
      tool.work_budget = nominal_work(budget_ns);
      const std::int64_t cost_ns = std::llround(nominal_ns(tick_work(tool.result)));
      return govern({t_ns += kTick_ns, cost_ns, level, tool.result.cut_short},
                    std::llround(budget_ns), governor);
    });
  }
  return played;
}

double error_of(const Played& played, const SessionRun& reference) {
  return std::max(force_error(played.f_H_W, reference.f_H_W).rms_percent, kNoError);
}

}  // namespace

TEST_CASE("automatic quality is within 1.5 of the error of the best fixed level at its budget") {
  for (const ContactSession& session : contact_sessions()) {
    CAPTURE(std::string(session.name));
    const SessionRun reference = play(session, reference_options(), kRate);
    std::vector<Played> fixed;
    fixed.reserve(kQualityLevels);
    for (int level = 0; level < kQualityLevels; ++level) {
      fixed.push_back(play_fixed(session, level));
    }
    for (const Played& of_budget : fixed) {
      for (const double share : {1.0, 1.4}) {
        const double budget_ns = share * dearest_tick(of_budget.costs_ns);
        double best = 1e9;
        for (const Played& other : fixed) {
          if (dearest_tick(other.costs_ns) > budget_ns) continue;
          best = std::min(best, error_of(other, reference));
        }
        const Played governed = play_governed(session, budget_ns);
        const double error = error_of(governed, reference);
        MESSAGE(std::string(session.name)
                << ": " << 1e-3 * budget_ns << " us: fixed " << best << " %, auto " << error
                << " % at level " << governed.level << ", " << governed.cut_ticks << " ticks cut");
        CHECK(error <= kWorse * best);
        CHECK(dear_tick(governed.costs_ns) <= 1.1 * budget_ns);
      }
    }
  }
}

TEST_CASE(
    "levels and budgets that are switched while a tool presses and slides make no force step") {
  double worst = 0.0;
  int judged = 0;
  int ticks = 0;
  for (const ContactSession& session : contact_sessions()) {
    SplitMix64 random(3);
    const Played steady = play_fixed(session, kDefaultQuality);
    const RenderingScene scene = scene_of(session);
    std::vector<Vector3> f_H_W;
    const Played switched = play_once(session, 0, [&](ToolRun& tool, int level) {
      f_H_W.push_back(tool.result.F_H_W.f);
      if (f_H_W.size() % 5 != 0) return level;
      tool.work_budget = random.chance(0.5) ? 0 : 1;
      return static_cast<int>(random.below(kQualityLevels));
    });
    int slip = 0;
    for (std::size_t tick = 1; tick < f_H_W.size(); ++tick) {
      const int now = static_cast<int>(tick);
      const ToolMotion moved_by = motion_between(hand(session, now - 1), hand(session, now));
      const double allowed =
          std::max(kFreeChange, kExcess * CouplingStiffness{}.kt *
                                    displacement_bound(moved_by, reach(scene.tool())));
      // Where the tool slips, or is about to, the force turns by itself.
      const double own = (steady.f_H_W[tick] - steady.f_H_W[tick - 1]).norm();
      slip = 2.0 * own > allowed ? 20 : slip - 1;
      ++ticks;
      if (slip > 0) continue;
      ++judged;
      worst = std::max(worst, (f_H_W[tick] - f_H_W[tick - 1]).norm() / allowed);
    }
    CHECK(switched.f_H_W.size() == f_H_W.size());
  }
  MESSAGE("greatest change of force over what a contact may make: " << worst << ", in " << judged
                                                                    << " of " << ticks);
  CHECK(worst <= 1.0);
  CHECK(judged > 0.7 * ticks);
}

}  // namespace hapticd::test
