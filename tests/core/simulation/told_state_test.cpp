// What a tick tells of tools and strings, while one tool or several bend them. Truth: every sphere
// of every tool against every leg of every string and every sphere of the body, in long double.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <map>
#include <random>

#include "core/simulation/contact_report.h"
#include "tests/core/simulation/ensemble.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// Shapes of strings that several tools hold are rounded as they pass from one to another, m.
constexpr double kRounding = 1e-8;
/// A vertex of a string that nobody bends may be left out of the drawing, m.
constexpr double kDrawn = 2.0 * kMinToldBend;
constexpr double kMargin = 5e-3;

/// The string through its ends and the vertices that the tick tells.
std::vector<Vector3> told_shape(const Tick& tick, std::int32_t string) {
  const double z = 0.02 * string;
  std::vector<Vector3> points{{0.0, 0.0, z}};
  for (const StringBendTick& bend : tick.string_bends) {
    if (bend.string != string) continue;
    points.push_back(Vector3(kEnsembleLength * bend.lambda, 0.0, z) + to_vector(bend.deflection_W));
  }
  points.push_back({kEnsembleLength, 0.0, z});
  return points;
}

/// Of a place to a polygon, m.
double distance_to(const std::vector<Vector3>& points, const Vector3& p) {
  double nearest = 1.0;
  for (std::size_t k = 0; k + 1 < points.size(); ++k) {
    const Vector3 axis = points[k + 1] - points[k];
    const double share = std::clamp((p - points[k]).dot(axis) / axis.squaredNorm(), 0.0, 1.0);
    nearest = std::min(nearest, (p - points[k] - share * axis).norm());
  }
  return nearest;
}

/// Where a tool at `p` goes next: nowhere, to just where it touches the straight string, or
/// anywhere about `x`.
Vector3 next_place(const Vector3& p, double x, double touch_y, SplitMix64& random) {
  const std::uint64_t choice = random.below(4);
  if (choice == 0) return p;
  const double there = x + random.uniform(-0.05, 0.05);
  if (choice == 1) return {there, touch_y, 0.0};
  return {there, random.uniform(-6e-3, 0.014), random.uniform(-6e-3, 6e-3)};
}

/// Contacts with string 0 are told with the gap to all of it as it is bent, each sphere once.
void check_contacts(Ensemble& ensemble, std::size_t tools, double touch_y) {
  std::vector<Vector3> shape;
  for (const Vector3& point : ensemble.shape(0)) shape.push_back(point);
  const Simulation& simulation = ensemble.simulation();
  for (std::size_t k = 0; k < tools; ++k) {
    ContactReport report;
    report_contacts(simulation.memory(), simulation.strings().sharing(), k, report);
    const Vector3& p_WG = ensemble.simulation().rendered(k).X_WG.p;
    for (const ContactTick& contact : report.contacts) {
      if (!is_string(contact.key) || contact.key.obstacle != 0) continue;
      const double gap = distance_to(shape, p_WG) - touch_y;
      // A tool alone tells both legs, of which one is the nearer.
      CHECK(contact.gap > gap - kRounding);
      if (tools > 1) CHECK(contact.gap < gap + kRounding);
    }
  }
}

void wander(std::uint64_t seed, std::size_t tools) {
  CAPTURE(seed);
  SplitMix64 random(seed);
  EnsembleOptions options;
  options.body_y = -8e-3;
  Ensemble ensemble(tools, options);
  const double apart = random.below(2) == 0 ? 0.15 : 0.02;
  std::vector<Vector3> at;
  at.reserve(tools);
  for (std::size_t k = 0; k < tools; ++k)
    at.push_back({0.2 + 0.15 * static_cast<double>(k), 0.02, 0.0});
  // A tool that begins inside something is pushed out of it.
  ensemble.tick(at);
  int shared = 0;
  for (int leg = 0; leg < 8; ++leg) {
    std::vector<Vector3> to;
    to.reserve(tools);
    for (std::size_t k = 0; k < tools; ++k) {
      const double x = 0.2 + apart * static_cast<double>(k);
      to.push_back(next_place(at[k], x, kEnsembleTip + options.string.radius, random));
    }
    const int ticks = 1 + static_cast<int>(random.below(60));
    for (int k = 1; k <= ticks; ++k) {
      std::vector<Vector3> p;
      p.reserve(tools);
      for (std::size_t i = 0; i < tools; ++i) p.push_back(at[i] + (to[i] - at[i]) * k / ticks);
      const Tick& told = ensemble.tick(p).record();
      double gap = kMargin;
      for (const ToolTick& tool : told.tools) gap = std::min(gap, tool.contact.minimum_gap);
      const auto truth = static_cast<double>(ensemble.minimum_gap());
      CHECK(std::abs(gap - std::min(truth, kMargin)) < kRounding);
      check_contacts(ensemble, tools, kEnsembleTip + options.string.radius);
      const std::vector<Vector3> drawn = told_shape(told, 0);
      shared += drawn.size() > 3 ? 1 : 0;
      const StringPoints shape = ensemble.shape(0);
      for (const Vector3& point : shape) CHECK(distance_to(drawn, point) < kDrawn);
      for (const ToolTick& tool : told.tools) {
        CHECK(distance_to(drawn, to_vector(tool.X_WG.p)) - kEnsembleTip - options.string.radius >
              -2.0 * kMinToldBend);
      }
    }
    at = to;
  }
  if (tools > 2) CHECK(shared > 0);
}

}  // namespace

TEST_CASE("the gap that is told is that of the tick, and strings are told as they are bent") {
  const std::uint64_t fresh = std::random_device{}();
  std::printf("seed of this run: %llu\n", static_cast<unsigned long long>(fresh));
  for (const std::size_t tools : {1U, 2U, 4U}) {
    for (int k = 0; k < scaled(40); ++k) wander(100 + static_cast<std::uint64_t>(k), tools);
    wander(fresh, tools);
  }
}

TEST_CASE("an event of a string has the place of the tool's surface where it touches") {
  EnsembleOptions options;
  options.instrument.vibration = true;
  options.instrument.tones.enabled = true;
  Ensemble ensemble(1, options);
  SplitMix64 random(11);
  Vector3 at(0.4, 0.02, 0.0);
  std::map<std::int64_t, Vector3> stood;
  int touches = 0;
  for (int leg = 0; leg < 60; ++leg) {
    const Vector3 to(random.uniform(0.2, 0.8), random.uniform(-3e-3, 0.02),
                     random.uniform(-8e-3, 8e-3));
    for (int k = 1; k <= 30; ++k) {
      ensemble.events.clear();
      const Tick& told = ensemble.tick({Vector3(at + (to - at) * k / 30)}).record();
      stood[static_cast<std::int64_t>(stood.size() + 1) * 1'000'000] =
          to_vector(told.tools[0].X_WG.p);
      for (const StringEvent& event : ensemble.events) {
        const bool is_touch = event.kind == StringEventKind::kTouch ||
                              event.kind == StringEventKind::kLeave ||
                              event.kind == StringEventKind::kRelease;
        if (!is_touch) continue;
        ++touches;
        const Vector3 n = to_vector(event.nhat_OG_W);
        CHECK(std::abs(n.norm() - 1.0) < 1e-12);
        const Vector3 centre = to_vector(event.p_WC) + kEnsembleTip * n;
        // After the tick that the instant is in; of one between two ticks, after either.
        const auto after = stood.lower_bound(event.t_ns);
        REQUIRE(after != stood.end());
        double off = (centre - after->second).norm();
        if (after->first == event.t_ns && std::next(after) != stood.end()) {
          off = std::min(off, (centre - std::next(after)->second).norm());
        }
        CHECK(off < 1e-9);
      }
    }
    at = to;
  }
  CHECK(touches > 10);
}

}  // namespace hapticd::test
