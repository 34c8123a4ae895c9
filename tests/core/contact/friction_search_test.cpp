// An adversary looks for the press and the way of a finger on a yielding string at which friction
// is furthest from Coulomb's law: beyond mu N while it slips, or creeping while the hand is at rest
// and the force within the cone. Truth: the string as it is bent, with the normal across both of
// its legs alike, and the force on the hand.
#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>

#include "core/math/elementary.h"
#include "tests/core/contact/string_scenes.h"
#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {
namespace {

constexpr std::size_t kNumbers = 8;
/// What the adversary chooses, each in [0, 1].
using Choice = std::array<double, kNumbers>;

double spread(double least, double most, double share) {
  return least * std::pow(most / least, share);
}

/// What it means.
struct Stroke {
  double mu, kt, radius, tension;
  double x;       ///< of the press, the string reaches from 0 to 1.1 m
  double depth;   ///< m
  double beside;  ///< of the finger's centre beside the string, m
  double angle;   ///< of its way, from the axis of the string

  explicit Stroke(const Choice& c)
      : mu(spread(0.03, 1.0, c[0])),
        kt(spread(300.0, 5000.0, c[1])),
        radius(spread(2e-3, 10e-3, c[2])),
        tension(spread(30.0, 300.0, c[3])),
        x(0.15 + 0.8 * c[4]),
        depth(spread(0.5e-3, 5e-3, c[5])),
        beside(0.3 * radius * (2.0 * c[6] - 1.0)),
        angle(2.0 * kPi * c[7]) {}
};

/// What a stroke showed.
struct Faults {
  double beyond = 0.0;  ///< largest friction over mu N
  double creep = 0.0;   ///< of the force in a second at rest within the cone, N
  int stuck = 0;        ///< ticks in succession in which the tool could not follow the hand
};

/// Friction over mu N, with the force on the tool and the string as they are.
double share_of_cone(const ToolRun& run, const Vector3& f, double mu) {
  if (run.state.touched.empty()) return 0.0;
  const StringBend& bend = run.state.touched[0].bend;
  const Capsule& line = run.scene.capsules_W[0];
  // The contact itself yields where the coupling is stiffer than it.
  const double compliance =
      std::max(0.0, 1.0 / run.scene.strings[0].contact_stiffness - 1.0 / run.stiffness.kt);
  const Vector3 axis = (line.p_B - line.p_A).normalized();
  const Vector3& u = run.state.touched[0].u_felt_W;
  const double own = 1.0 - compliance * (f - axis.dot(f) * axis).norm() / std::max(u.norm(), 1e-9);
  const Vector3 straight = line.p_A + bend.lambda * (line.p_B - line.p_A);
  const Vector3 vertex = straight + std::max(0.0, own) * u;
  const Vector3 along =
      ((line.p_B - vertex).normalized() - (line.p_A - vertex).normalized()).normalized();
  Vector3 n = run.state.X_WG.p - (straight + u);
  n = (n - along.dot(n) * along).normalized();
  const double pressed = f.dot(n);
  return pressed > 0.02 ? (f - pressed * n).norm() / (mu * pressed) : 0.0;
}

Faults play(const Stroke& stroke) {
  StringParameters string = string_at();
  string.model = StringContact::kYielding;
  string.friction_coefficient = stroke.mu;
  string.tension = stroke.tension;
  RenderingScene scene = scene_of({string}, {{Vector3::Zero(), stroke.radius}});
  scene.instrument.friction = true;
  scene.instrument.anchor_stiffness = 10.0 * stroke.kt;
  const double height = stroke.radius + scene.capsules_W[0].r;
  ToolRun run(scene, pose_at({stroke.x, height + 1e-3, stroke.beside}));
  run.stiffness.kt = stroke.kt;
  run.stiffness.length = 1.0;
  Faults faults;
  Vector3 f(0.0, 0.0, 0.0);
  int stuck = 0;
  const auto tick = [&](const Vector3& p_WH) {
    run.tick(pose_at(p_WH));
    f = rendered(run).F_H_W.f;
    // The force of a tick that ends on the way of a leap belongs to another place of the tool.
    const bool refused = run.result.status == ContactStatus::kRefused;
    stuck = refused ? stuck + 1 : 0;
    faults.stuck = std::max(faults.stuck, stuck);
    const bool arrived = run.result.status == ContactStatus::kConverged;
    return arrived ? share_of_cone(run, f, stroke.mu) : 0.0;
  };
  const auto at = [&](double depth, double way) {
    return Vector3(stroke.x + way * std::cos(stroke.angle), height - depth,
                   stroke.beside + way * std::sin(stroke.angle));
  };
  for (int k = 1; k <= 100; ++k) {
    faults.beyond =
        std::max(faults.beyond, tick(at(-1e-3 + (stroke.depth + 1e-3) * k / 100.0, 0.0)));
  }
  for (int k = 0; k < 300; ++k) tick(at(stroke.depth, 0.0));
  const Vector3 held = f;
  double share = 0.0;
  for (int k = 0; k < 1000; ++k) share = tick(at(stroke.depth, 0.0));
  if (share < 0.98) faults.creep = (f - held).norm();
  for (int k = 1; k <= 200; ++k) {
    faults.beyond = std::max(faults.beyond, tick(at(stroke.depth, 2e-5 * k)));
  }
  return faults;
}

/// Climbs from `choice` by random steps that grow smaller.
template <typename Score>
double climb(Choice choice, int steps, SplitMix64& random, const Score& score) {
  double best = score(choice);
  for (int k = 0; k < steps; ++k) {
    Choice next = choice;
    const double size = 0.3 * std::pow(0.1, static_cast<double>(k) / steps);
    for (double& number : next) {
      number = std::clamp(number + size * random.uniform(-1.0, 1.0), 0.0, 1.0);
    }
    if (const double found = score(next); found > best) {
      best = found;
      choice = next;
    }
  }
  return best;
}

Choice anywhere(SplitMix64& random) {
  Choice choice;
  for (double& number : choice) number = random.uniform(0.0, 1.0);
  return choice;
}

}  // namespace

TEST_CASE("no stroke that is searched for makes friction exceed mu N, or a held finger creep") {
  for (const std::uint64_t seed : {std::uint64_t{1}, std::uint64_t{std::random_device{}()}}) {
    CAPTURE(seed);
    SplitMix64 random(seed);
    double beyond = 0.0;
    double creep = 0.0;
    int stuck = 0;
    for (std::int64_t start = scaled(10); start > 0; --start) {
      beyond = std::max(beyond, climb(anywhere(random), 30, random, [&](const Choice& choice) {
                          const Faults faults = play(Stroke(choice));
                          stuck = std::max(stuck, faults.stuck);
                          return faults.beyond;
                        }));
      creep = std::max(creep, climb(anywhere(random), 10, random, [](const Choice& choice) {
                         return play(Stroke(choice)).creep;
                       }));
    }
    MESSAGE("friction over mu N at most " << beyond << ", creep " << 1e6 * creep
                                          << " uN, stuck for " << stuck << " ticks");
    CHECK(beyond >= 0.9);
    CHECK(beyond <= 1.02);
    CHECK(creep <= 1e-6);
    CHECK(stuck <= 4);
  }
}

}  // namespace hapticd::test
