// What tools feel and hear of each other through a string they share, and what they do not where
// they share none.
#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include <Eigen/Dense>

#include "core/contact/virtual_coupling.h"
#include "core/math/elementary.h"
#include "tests/core/simulation/ensemble.h"
#include "tests/core/simulation/wave_scene.h"
#include "tests/support/no_heap.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

/// Height of a fingertip's centre that touches the strings from above, m.
double on_top() { return kEnsembleTip + StringParameters{}.radius; }

/// Height of a finger that comes down to `depth` below touching in 0.1 s.
double press(int tick, double depth) { return on_top() - depth * std::min(1.0, tick / 100.0); }

const StringEvent* tone_of(const Ensemble& ensemble) {
  for (const StringEvent& event : ensemble.events) {
    if (event.kind == StringEventKind::kTone) return &event;
  }
  return nullptr;
}

bool same_bits(const RenderedTool& a, const RenderedTool& b) {
  return a.X_WG.p == b.X_WG.p && a.F_H_W.f == b.F_H_W.f && a.F_H_W.t == b.F_H_W.t &&
         a.contact.sub_steps == b.contact.sub_steps;
}

/// A string that fingers press from above, each a ball held by a spring: where the spring, and the
/// tension along both legs, balance. A finger stands off the vertex across the legs' mean
/// direction.
struct PressedPolyline {
  const std::vector<Vector3>& p_WH;
  std::vector<std::size_t> pressing;

  /// Ends and vertices, (x, y), m.
  [[nodiscard]] static std::vector<Eigen::Vector2d> points(const Eigen::VectorXd& v) {
    std::vector<Eigen::Vector2d> all{{0.0, 0.0}};
    for (Eigen::Index k = 0; k < v.size(); k += 2) all.emplace_back(v[k], v[k + 1]);
    all.emplace_back(kEnsembleLength, 0.0);
    return all;
  }

  /// Force on each finger that presses, N.
  [[nodiscard]] static std::vector<Eigen::Vector2d> pulls(const Eigen::VectorXd& v) {
    const std::vector<Eigen::Vector2d> at = points(v);
    double length = 0.0;
    for (std::size_t k = 1; k < at.size(); ++k) length += (at[k] - at[k - 1]).norm();
    const StringParameters string;
    const double axial = string.youngs_modulus * kPi * string.radius * string.radius;
    const double tension = string.tension + axial * (length / kEnsembleLength - 1.0);
    std::vector<Eigen::Vector2d> out;
    for (std::size_t k = 1; k + 1 < at.size(); ++k) {
      out.push_back(tension *
                    ((at[k - 1] - at[k]).normalized() + (at[k + 1] - at[k]).normalized()));
    }
    return out;
  }

  /// What is left of the balance, N.
  [[nodiscard]] Eigen::VectorXd residual(const Eigen::VectorXd& v) const {
    const std::vector<Eigen::Vector2d> at = points(v);
    const std::vector<Eigen::Vector2d> F = pulls(v);
    Eigen::VectorXd left(v.size());
    for (std::size_t k = 0; k < F.size(); ++k) {
      const auto row = static_cast<Eigen::Index>(2 * k);
      const Eigen::Vector2d along =
          (at[k + 1] - at[k]).normalized() + (at[k + 2] - at[k + 1]).normalized();
      const Eigen::Vector2d up = Eigen::Vector2d(-along.y(), along.x()).normalized();
      const Eigen::Vector2d ball = at[k + 1] + on_top() * up;
      left.segment<2>(row) = CouplingStiffness{}.kt * (p_WH[pressing[k]].head<2>() - ball) + F[k];
    }
    return left;
  }

  /// By Newton's method with differences.
  [[nodiscard]] Eigen::VectorXd vertices() const {
    Eigen::VectorXd v(static_cast<Eigen::Index>(2 * pressing.size()));
    for (std::size_t k = 0; k < pressing.size(); ++k) {
      v.segment<2>(static_cast<Eigen::Index>(2 * k)) << p_WH[pressing[k]].x(), -1e-3;
    }
    Eigen::VectorXd left = residual(v);
    for (int turn = 0; turn < 50 && left.norm() > 1e-10; ++turn) {
      Eigen::MatrixXd slope(v.size(), v.size());
      for (Eigen::Index k = 0; k < v.size(); ++k) {
        Eigen::VectorXd aside = v;
        aside[k] += 1e-8;
        slope.col(k) = (residual(aside) - left) / 1e-8;
      }
      v -= slope.partialPivLu().solve(left);
      left = residual(v);
    }
    REQUIRE(left.norm() <= 1e-10);
    return v;
  }
};

/// True where all that press are pushed up, and all others stand clear of the string.
bool holds_true(const PressedPolyline& fingers, const Eigen::VectorXd& v) {
  const std::vector<Eigen::Vector2d> F = PressedPolyline::pulls(v);
  if (std::any_of(F.begin(), F.end(), [](const auto& f) { return f.y() < 0.0; })) return false;
  for (const Vector3& p : fingers.p_WH) {
    const std::vector<Eigen::Vector2d> at = PressedPolyline::points(v);
    for (std::size_t k = 0; k + 1 < at.size(); ++k) {
      const Eigen::Vector2d& from = at[k];
      const Eigen::Vector2d& to = at[k + 1];
      const double share = (p.x() - from.x()) / (to.x() - from.x());
      const double height = from.y() + share * (to.y() - from.y());
      const bool presses = std::any_of(fingers.pressing.begin(), fingers.pressing.end(),
                                       [&](std::size_t tool) { return &fingers.p_WH[tool] == &p; });
      if (share >= 0.0 && share <= 1.0 && !presses && p.y() < height + on_top()) return false;
    }
  }
  return true;
}

/// Force on each finger that stands at p_WH above the first string at rest, N: of all sets of
/// fingers that may press the one that holds true.
std::vector<Eigen::Vector2d> statics_of(const std::vector<Vector3>& p_WH) {
  for (std::size_t set = 1; set < std::size_t{1} << p_WH.size(); ++set) {
    PressedPolyline fingers{p_WH, {}};
    for (std::size_t k = 0; k < p_WH.size(); ++k) {
      if ((set >> k & 1) != 0) fingers.pressing.push_back(k);
    }
    const Eigen::VectorXd v = fingers.vertices();
    if (!holds_true(fingers, v)) continue;
    const std::vector<Eigen::Vector2d> F = PressedPolyline::pulls(v);
    std::vector<Eigen::Vector2d> all(p_WH.size(), Eigen::Vector2d::Zero());
    for (std::size_t k = 0; k < F.size(); ++k) all[fingers.pressing[k]] = F[k];
    return all;
  }
  FAIL("no set of fingers balances");
  return {};
}

/// A finger that presses and plucks string `string` at `x`, over and over.
Vector3 plucking(int tick, std::int32_t string, double x) {
  const double turn = (tick % 400) / 400.0;
  const double y = turn < 0.5 ? on_top() + 1e-3 - 8e-3 * turn : on_top() + 1e-3;
  return {x, y, 0.02 * string};
}

/// What a string has rung with, and what its vibration has given to three fingers: one plucks it,
/// two then press it in time with it.
struct Drawn {
  double released = 0.0;
  double given = 0.0;
};

Drawn draw(SplitMix64& random) {
  Ensemble ensemble(3, {});
  Drawn drawn;
  std::vector<Vector3> p(3, Vector3(0.3, on_top() + 0.02, 0.0));
  p[1].x() = 0.5;
  p[2].x() = 0.7;
  std::vector<Vector3> held(3, Vector3::Zero());
  for (int tick = 0; tick < 1500; ++tick) {
    const std::vector<Vector3> before = p;
    p[0].y() = tick < 100 ? press(tick, 5e-3) : on_top() + 0.03;
    for (std::size_t k = 1; tick > 110 && k < 3; ++k) {
      const double down = std::min(1.0, (tick - 110) / 100.0);
      const double wave = std::sin(2.0 * kPi * 65.4 * (1e-3 * tick + 0.1 * static_cast<double>(k)));
      p[k].y() =
          on_top() + 0.02 * (1.0 - down) + down * (1e-3 * wave + random.uniform(-1e-4, 1e-4));
    }
    const SimulationTick& output = ensemble.tick(p);
    for (std::size_t k = 0; k < 3; ++k) {
      drawn.given += held[k].dot(p[k] - before[k]);
      held[k] = output.tool(k).F_computed_H_W.f;
      for (const PressedString& contact : output.tool(k).strings) held[k] -= contact.F_W;
    }
    for (const StringEvent& event : output.events()) {
      if (event.kind != StringEventKind::kTone) continue;
      drawn.released += ensemble.simulation().memory().tracks[0].state.vibration.released_energy;
    }
  }
  return drawn;
}

}  // namespace

TEST_CASE("a tool among others gives the bits it gives alone while they are at other strings") {
  for (std::size_t place = 0; place < 5; ++place) {
    CAPTURE(place);
    Ensemble alone(1, {});
    Ensemble among(5, {});
    bool same = true;
    bool pressed = false;
    for (int tick = 0; tick < std::max<int>(900, static_cast<int>(scaled(3000))); ++tick) {
      const Vector3 p = plucking(tick, 3, 0.4);
      std::vector<Vector3> all;
      for (std::size_t k = 0; k < 5; ++k) {
        const auto string = static_cast<std::int32_t>(k < 3 ? k : k + 1);
        all.push_back(k == place ? p : plucking(tick + 77 * string, string, 0.4));
      }
      const RenderedTool& expected = alone.tick({p}).tool(0);
      same = same && same_bits(among.tick(all).tool(place), expected);
      pressed = pressed || expected.F_H_W.f.norm() > 0.1;
    }
    CHECK(same);
    CHECK(pressed);
    std::vector<StringEvent> own;
    for (const StringEvent& event : among.events) {
      if (event.tool == static_cast<std::int32_t>(place)) own.push_back(event);
    }
    REQUIRE(own.size() == alone.events.size());
    for (std::size_t k = 0; k < own.size(); ++k) {
      CHECK(own[k].kind == alone.events[k].kind);
      CHECK(own[k].t_ns == alone.events[k].t_ns);
      CHECK(own[k].amplitude == alone.events[k].amplitude);
    }
  }
}

TEST_CASE("fingers apart on a string at rest feel its statics within half a percent and 1 mN") {
  const std::uint64_t seed = fresh_seed();
  CAPTURE(seed);
  SplitMix64 random(seed);
  for (int trial = 0; trial < std::max<int>(10, static_cast<int>(scaled(100))); ++trial) {
    CAPTURE(trial);
    const auto tools = static_cast<std::size_t>(2 + trial % 4);
    Ensemble ensemble(tools, {});
    std::vector<Vector3> p;
    for (std::size_t k = 0; k < tools; ++k) {
      const double apart = 0.8 / static_cast<double>(tools);
      p.push_back({0.15 + apart * (static_cast<double>(k) + random.uniform(0.1, 0.9)),
                   on_top() - random.uniform(1e-3, 3e-3), 0.0});
    }
    for (int tick = 0; tick < 300; ++tick) {
      std::vector<Vector3> now = p;
      for (Vector3& place : now) place.y() += 6e-3 * std::max(0.0, 1.0 - tick / 100.0);
      ensemble.tick(now);
      REQUIRE(ensemble.minimum_gap() >= 0.0L);
    }
    const std::vector<Eigen::Vector2d> truth = statics_of(p);
    for (std::size_t k = 0; k < tools; ++k) {
      CAPTURE(k);
      const Vector3 F = ensemble.output().tool(k).F_computed_H_W.f;
      const Vector3 expected(truth[k].x(), truth[k].y(), 0.0);
      CHECK((F - expected).norm() <= 0.005 * expected.norm() + 1e-3);
    }
  }
}

TEST_CASE("two tools squeeze a string: both stay on their side, and who is left has it alone") {
  for (const double apart : {0.0, 0.5e-3, 3e-3, 20e-3}) {
    CAPTURE(apart);
    Ensemble ensemble(2, {});
    Ensemble alone(1, {});
    const Vector3 below{0.5 + apart, -on_top() + 3e-3, 0.0};
    bool on_their_sides = true;
    double most = 0.0;
    for (int tick = 0; tick < 600; ++tick) {
      const Vector3 above{0.5, tick < 400 ? press(tick, 3e-3) : on_top() + 0.02, 0.0};
      Vector3 under = below;
      under.y() -= 5e-3 * std::max(0.0, 1.0 - std::max(0, tick - 100) / 100.0);
      ensemble.tick({above, under});
      alone.tick({under});
      REQUIRE(ensemble.minimum_gap() >= 0.0L);
      const RenderedTool& lower = ensemble.output().tool(1);
      on_their_sides = on_their_sides && ensemble.output().tool(0).X_WG.p.y() > lower.X_WG.p.y();
      most = std::max(most, lower.F_computed_H_W.f.norm());
    }
    CHECK(on_their_sides);
    const RenderedTool& left = ensemble.output().tool(1);
    const RenderedTool& expected = alone.output().tool(0);
    CHECK(expected.F_computed_H_W.f.norm() > 0.2);
    CHECK(most > 1.5 * expected.F_computed_H_W.f.norm());
    CHECK((left.F_computed_H_W.f - expected.F_computed_H_W.f).norm() < 1e-4);
    CHECK((left.X_WG.p - expected.X_WG.p).norm() < 1e-6);
    CHECK(ensemble.output().tool(0).F_computed_H_W.f.norm() == 0.0);
  }
}

TEST_CASE("a tool that is gone in one tick leaves the string to the other, and nobody inside it") {
  for (const bool first_goes : {true, false}) {
    CAPTURE(first_goes);
    Ensemble ensemble(2, {});
    Ensemble alone(1, {});
    for (int tick = 0; tick < 400; ++tick) {
      const double y = press(tick, 4e-3);
      std::vector<Vector3> p{{0.5, y, 0.0}, {0.52, y, 0.0}};
      const Vector3 stays = p[first_goes ? 1 : 0];
      if (tick > 200) p[first_goes ? 0 : 1] = {0.2, 0.3, 0.5};
      ensemble.tick(p);
      alone.tick({stays});
      REQUIRE(ensemble.minimum_gap() >= 0.0L);
    }
    const Vector3 F = ensemble.output().tool(first_goes ? 1 : 0).F_computed_H_W.f;
    CHECK((F - alone.output().tool(0).F_computed_H_W.f).norm() < 1e-4);
    CHECK(ensemble.shape(0).size() == 3);
  }
}

TEST_CASE("tools that cross each other along a string stay out of it") {
  Ensemble ensemble(5, {});
  for (int tick = 0; tick < std::max<int>(400, static_cast<int>(scaled(4000))); ++tick) {
    std::vector<Vector3> p;
    for (int k = 0; k < 5; ++k) {
      const double turn = (tick + 160 * k) % 800 / 400.0;
      const double x = 0.3 + 0.3 * (turn < 1.0 ? turn : 2.0 - turn);
      p.push_back({x,
                   (k % 2 == 0 ? 1.0 : -1.0) *
                       (press(tick, 1e-3 * (1 + k)) + 5e-3 * std::max(0.0, 1.0 - tick / 50.0)),
                   0.0});
    }
    ensemble.tick(p);
    REQUIRE(ensemble.minimum_gap() >= 0.0L);
  }
}

TEST_CASE("a finger stops the string and another plucks it: the tone is that of what is left") {
  for (const bool stop_first : {true, false}) {
    CAPTURE(stop_first);
    Ensemble ensemble(2, {});
    for (int tick = 0; tick < 700; ++tick) {
      const int stop_tick = stop_first ? tick : tick - 200;
      const int pluck_tick = stop_first ? tick - 200 : tick;
      const Vector3 stop{0.275, stop_tick < 0 ? on_top() + 5e-3 : press(stop_tick, 5e-3), 0.0};
      Vector3 pluck{0.8, pluck_tick < 0 ? on_top() + 5e-3 : press(pluck_tick, 3e-3), 0.0};
      if (tick > 450) pluck.y() = on_top() + 0.02;
      ensemble.tick({stop, pluck});
    }
    const StringEvent* tone = tone_of(ensemble);
    REQUIRE(tone != nullptr);
    CHECK(tone->tool == 1);
    CHECK(tone->part == 0);
    CHECK(std::abs(tone->lambda - 0.8 / kEnsembleLength) < 1e-3);
    // f = sqrt(T / mu) / (2 L) of what vibrates, under the tension of the string as it is bent: a
    // little less than at the release, when the other has pulled it further.
    const StringPoints points = ensemble.shape(0);
    REQUIRE(points.size() == 3);
    const double left = (points[2] - points[1]).norm();
    const double length = (points[1] - points[0]).norm() + left;
    const StringParameters string;
    const double stiffness = string.youngs_modulus * kPi * string.radius * string.radius;
    const double tension = string.tension + stiffness * (length / kEnsembleLength - 1.0);
    const double f = 65.4 * kEnsembleLength / left * std::sqrt(tension / string.tension);
    CHECK(std::abs(tone->frequency / f - 1.0) < 2e-3);
    // It rings while the first holds it, and that one is not said to have let go.
    CHECK(ensemble.output().strings().size() == 1);
    for (const StringEvent& event : ensemble.events) {
      CHECK((event.tool == 1 || event.kind != StringEventKind::kRelease));
    }
  }
}

TEST_CASE("fingers that touch a ringing string draw no more from it than what it rang with") {
  for (std::int64_t i = std::max<std::int64_t>(3, scaled(40)); i > 0; --i) {
    CAPTURE(i);
    SplitMix64 random(static_cast<std::uint64_t>(i));
    const Drawn drawn = draw(random);
    CHECK(drawn.released > 1e-5);
    CHECK(drawn.given <= drawn.released * (1.0 + 1e-9));
  }
}

TEST_CASE("five tools in one tick leave the heap alone") {
  Ensemble ensemble(5, {});
  std::int64_t touched = 0;
  std::array<HandPose, 5> hands;
  SimulationTick output;
  for (int tick = 1; tick <= 300; ++tick) {
    for (std::size_t k = 0; k < 5; ++k) {
      hands[k] = {std::int64_t{1'000'000} * tick,
                  {0.3 + 0.05 * static_cast<double>(k), press(tick, 4e-3), 0.0},
                  {1.0, 0.0, 0.0, 0.0}};
    }
    const NoHeapScope scope;
    output.step(ensemble.simulation(), hands);
    touched += scope.count();
  }
  CHECK(touched == 0);
  CHECK(output.tool(4).F_H_W.f.norm() > 0.0);
}

}  // namespace hapticd::test
