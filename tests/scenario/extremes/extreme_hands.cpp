// See extreme_hands.h.
#include "tests/scenario/extremes/extreme_hands.h"

#include <cmath>
#include <limits>

#include "core/math/elementary.h"
#include "core/math/rotation.h"
#include "tests/scenario/extremes/extreme_scene.h"
#include "tests/support/random.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kTick_ns = 1'000'000;
/// Height of the tip's centre that rests on a string, m.
constexpr double kRest = kTip + kStringRadius + 20e-6;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// Samples one after the other, at 1 kHz where nothing else is said.
class Writer {
 public:
  explicit Writer(std::string name) { hand_.name = std::move(name); }
  void at(const Vector3& p, const Quaternion& q = {1, 0, 0, 0}, std::int64_t dt_ns = kTick_ns) {
    t_ns_ += dt_ns;
    p_ = p;
    q_ = q;
    hand_.samples.push_back({t_ns_, to_array(p), to_array(q)});
  }
  /// On a straight way, `ticks` ticks.
  void to(const Vector3& p, int ticks) {
    const Vector3 from = p_;
    for (int i = 1; i <= ticks; ++i) at(from + (p - from) * (static_cast<double>(i) / ticks), q_);
  }
  void turn(const Vector3& phi, int ticks) {
    const Quaternion from = q_;
    for (int i = 1; i <= ticks; ++i) {
      at(p_, exp_rotation(phi * (static_cast<double>(i) / ticks)) * from);
    }
  }
  void hold(int ticks) {
    for (int i = 0; i < ticks; ++i) at(p_, q_);
  }
  HandPose& last() { return hand_.samples.back(); }
  [[nodiscard]] Vector3 place() const { return p_; }
  [[nodiscard]] Quaternion turned() const { return q_; }
  ExtremeHand done() { return std::move(hand_); }

 private:
  ExtremeHand hand_;
  std::int64_t t_ns_ = 0;
  Vector3 p_{0.5, 0.05, 0.0};
  Quaternion q_{1, 0, 0, 0};
};

ExtremeHand ends() {
  Writer hand("over both ends of a string, pressed");
  for (const double x : {0.0, 1.1}) {
    for (const double z : {0.0, 1e-3}) {
      hand.at({x - 0.03, 0.03, z});
      hand.to({x - 0.03, kRest - 3e-3, z}, 60);
      hand.to({x + 0.03, kRest - 3e-3, z}, 300);
      hand.to({x - 0.03, kRest - 3e-3, z}, 300);
      hand.to({x, kRest - 3e-3, z}, 100);
      hand.to({x, kRest + 0.02, z}, 60);
    }
  }
  return hand.done();
}

ExtremeHand hover() {
  Writer hand("at depth 0 and next to it");
  hand.to({0.5, kRest, 0.0}, 50);
  hand.hold(20);
  for (const double x : {0.5, 0.0, 1.1}) {
    for (const double depth : {0.0, 1e-12, 1e-9, 1e-6, 1e-4, 2e-2}) {
      hand.to({x, kRest + 1e-6, 0.0}, 20);
      hand.at({x, kRest - depth, 0.0});
      hand.hold(5);
    }
    hand.to({x, 0.03, 0.0}, 30);
  }
  return hand.done();
}

/// Numbers that are none or hardly any, one, two and three samples in a row.
ExtremeHand bad_numbers() {
  Writer hand("numbers that are none");
  const double worst[] = {kNan, kInfinity, -kInfinity, 1e308, -1e308, 5e-324, -0.0};
  for (const double number : worst) {
    for (int field = 0; field < 7; ++field) {
      // Two are bridged; a third would end the session, which another hand does.
      for (int count = 1; count <= 2; ++count) {
        hand.to({0.5, kRest - 2e-3, 0.0}, 4);
        for (int i = 0; i < count; ++i) {
          hand.hold(1);
          const auto at = static_cast<std::size_t>(field);
          if (at < 3) {
            hand.last().p_WH[at] = number;
          } else {
            hand.last().q_WH[at - 3] = number;
          }
        }
        hand.to({0.5, kRest - 1e-3, 0.0}, 4);
      }
    }
  }
  return hand.done();
}

ExtremeHand no_pose_any_more() {
  Writer hand("no number for good");
  hand.to({0.5, kRest - 2e-3, 0.0}, 50);
  hand.hold(1);
  hand.last().q_WH = {0.0, 0.0, 0.0, 0.0};
  for (int i = 0; i < 20; ++i) {
    hand.hold(1);
    hand.last().p_WH = {kNan, kNan, kNan};
  }
  hand.to({0.5, 0.03, 0.0}, 20);
  return hand.done();
}

ExtremeHand norms() {
  Writer hand("quaternions off unit, and negated");
  hand.to({0.5, kRest - 2e-3, 0.0}, 50);
  for (int i = 0; i < 200; ++i) {
    const double norm = i % 5 == 0 ? 0.5 : i % 5 == 1 ? 2.0 : 0.8 + 1e-3 * i;
    hand.at({0.5 + 1e-4 * i, kRest - 2e-3, 0.0});
    for (double& part : hand.last().q_WH) part *= i % 2 == 0 ? norm : -norm;
  }
  return hand.done();
}

ExtremeHand jumps() {
  Writer hand("jumps");
  for (const double far : {0.2, 10.0, 1e6}) {
    for (const Vector3& way :
         {Vector3(0, -1, 0), Vector3(1, 0, 0), Vector3(0, 0, 1), Vector3(0.6, -0.8, 0)}) {
      hand.to({0.5, kRest - 1e-3, 0.0}, 30);
      const Vector3 here = hand.place();
      hand.at(here + far * way);
      hand.hold(5);
      hand.at(here, exp_rotation({0, 0, kPi}));
      hand.hold(5);
      hand.at({0.5, 0.05, 0.0});
      hand.hold(3);
    }
  }
  return hand.done();
}

/// Across all strings and back from the other side, at an angle and along.
ExtremeHand strokes(double speed) {
  Writer hand("strokes at " + std::to_string(speed) + " m/s");
  const auto go = [&](const Vector3& to) {
    hand.to(to, std::max(1, static_cast<int>((to - hand.place()).norm() / (speed * 1e-3))));
  };
  for (const double depth : {1e-3, 3e-3}) {
    go({0.5, kRest - depth, 0.1});
    go({0.5, kRest - depth, -0.1});
    go({0.45, -0.03, -0.1});
    go({0.55, -kRest + depth, 0.1});
    go({0.5, 0.03, 0.1});
    go({0.52, -0.02, -0.09});
    go({0.4, 0.02, 0.0});
    go({1.2, kRest - depth, 0.0});
    go({0.5, kRest - depth, 0.0});
    go({0.8, -0.1, 0.0});
    go({0.8, 0.05, 0.0});
    go({0.5, 0.05, 0.0});
  }
  return hand.done();
}

ExtremeHand turning() {
  Writer hand("turning alone");
  hand.to({0.5, kRest - 2e-3, 0.0}, 60);
  for (const double angle : {kPi - 1e-6, kPi, kPi + 1e-6}) {
    for (const Vector3& axis : {Vector3(0, 1, 0), Vector3(1, 0, 0), Vector3(0, 0, 1)}) {
      hand.turn(angle * axis, 200);
      hand.turn(-angle * axis, 40);
      // In one tick.
      hand.at(hand.place(), exp_rotation(angle * axis) * hand.turned());
      hand.hold(5);
      hand.at(hand.place(), {1, 0, 0, 0});
      hand.hold(5);
    }
  }
  return hand.done();
}

ExtremeHand times() {
  Writer hand("time that stands, jumps and goes back");
  hand.to({0.5, kRest - 2e-3, 0.0}, 60);
  SplitMix64 random(7);
  const std::int64_t steps_ns[] = {0, 1, -1, 1'000'000, 5'000'000, -3'000'000, 1'000'000'000, 100};
  for (int i = 0; i < 600; ++i) {
    const Vector3 p(0.5 + 0.02 * std::sin(0.05 * i), kRest - 2e-3 + 4e-3 * std::sin(0.11 * i), 0.0);
    hand.at(p, {1, 0, 0, 0}, steps_ns[random.below(std::size(steps_ns))]);
  }
  return hand.done();
}

ExtremeHand deep() {
  Writer hand("pressed 50 mm deep");
  for (const double z : {0.0, 0.02, 0.04, 0.06, -0.02, -0.04, -0.06, -0.08}) {
    hand.at({0.5, 0.03, z});
    hand.to({0.5, -0.05, z}, 200);
    hand.to({0.5, 0.03, z}, 200);
  }
  hand.at({0.8, 0.03, 0.0});
  hand.to({0.8, -0.06, 0.01}, 200);
  hand.to({0.8, 0.03, 0.0}, 200);
  return hand.done();
}

}  // namespace

std::vector<ExtremeHand> extreme_hands() {
  std::vector<ExtremeHand> hands{ends(),  hover(), bad_numbers(), no_pose_any_more(),
                                 norms(), jumps(), turning(),     times(),
                                 deep()};
  for (const double speed : {0.1, 1.204, 10.0, 100.0}) hands.push_back(strokes(speed));
  return hands;
}

}  // namespace hapticd::test
