// A handle on one axis, integrated by itself: m x'' = F(t - delay) - b x' - k_h x - c sign(x') + w,
// with a held force, a delay of ticks, the steps of an encoder, dry friction that sticks, and a
// hand that holds on. Truth for what is told of its damping.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "tests/support/random.h"

namespace hapticd::test {

/// What a handle is, SI.
struct HandleTruth {
  double mass = 0.15;
  double damping = 1.0;
  double friction = 0.0;  ///< dry, N
  double weight = 0.0;    ///< along the axis, not borne, N
  int delay = 0;          ///< of a force, ticks, 0 to 7
  double step = 0.0;      ///< of the encoder, m; 0: exact
  // A hand that holds on; all 0: none.
  double hand_mass = 0.0;
  double hand_damping = 0.0;
  double hand_stiffness = 0.0;

  [[nodiscard]] bool held() const { return hand_stiffness > 0.0; }
};

class RingingHandle {
 public:
  explicit RingingHandle(const HandleTruth& truth) : truth_(truth) {}

  /// As its encoder has it, m.
  [[nodiscard]] double position() const {
    return truth_.step > 0.0 ? truth_.step * std::floor(x_ / truth_.step + 0.5) : x_;
  }

  /// `force` was written at the start of a tick that lasts `tick_s`.
  void advance(double force, double tick_s) {
    std::copy_backward(written_.begin(), written_.end() - 1, written_.end());
    written_[0] = force;
    const double felt = written_[static_cast<std::size_t>(truth_.delay)];
    constexpr double kStep_s = 1.5e-5;
    const int steps = std::max(1, static_cast<int>(std::ceil(tick_s / kStep_s)));
    for (int k = 0; k < steps; ++k) step(felt, tick_s / steps);
  }

 private:
  // Halves of a step of the damping around one of the rest: exact for the damping alone.
  void step(double felt, double h) {
    const double mass = truth_.mass + truth_.hand_mass;
    const double fades = std::exp(-(truth_.damping + truth_.hand_damping) * h / mass);
    const double before = v_;
    const double push = felt - truth_.hand_stiffness * (x_ + 0.5 * h * v_) + truth_.weight;
    if (v_ == 0.0) {
      const double left = std::max(0.0, std::abs(push) - truth_.friction);
      v_ = std::copysign(left, push) * h / mass;
    } else {
      const double side = v_ > 0.0 ? 1.0 : -1.0;
      v_ = (v_ + 0.5 * h * push / mass) * fades + 0.5 * h * push / mass -
           side * truth_.friction * h / mass;
      if (v_ * side < 0.0) v_ = 0.0;
    }
    x_ += 0.5 * h * (before + v_);
  }

  HandleTruth truth_;
  double x_ = 0.0;
  double v_ = 0.0;
  std::array<double, 8> written_{};
};

/// Any handle: `held`: by a hand. Friction and steps of the encoder are there or not.
inline HandleTruth any_handle(SplitMix64& random, bool held) {
  const auto between = [&](double low, double high) {
    return low * std::pow(high / low, random.uniform());
  };
  HandleTruth truth;
  truth.mass = between(0.03, 1.0);
  truth.damping = between(0.03, 8.0);
  if (random.chance(0.4)) truth.friction = between(1e-3, 0.1);
  if (random.chance(0.3)) truth.weight = 0.2 * random.uniform() - 0.1;
  if (random.chance(0.5)) truth.step = between(1e-6, 1e-4);
  truth.delay = static_cast<int>(random.below(4));
  if (!held) return truth;
  truth.hand_mass = random.uniform();
  truth.hand_damping = between(0.3, 10.0);
  truth.hand_stiffness = between(10.0, 1000.0);
  return truth;
}

}  // namespace hapticd::test
