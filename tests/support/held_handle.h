// A handle with anything that a hand may passively do to it, integrated by itself in steps of
// 20 us at most: truth for the adversary of the measuring of a damping. The hand is along one axis,
// as a rule a mass, a spring and a damper to the ground; it may hold by a soft grip, fade, come and
// go, or push from one side only.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "tests/support/random.h"

namespace hapticd::test {

enum class HandKind : int {
  kNone,
  kFirm,    ///< one with the handle
  kSoft,    ///< by the spring and damper of a grip
  kFading,  ///< firm, but stiffness and damping fade with `fade_s`
  kComing,  ///< firm from `from_s` to `until_s`
  kBeside,  ///< pushes where the handle is beyond `gap`, never pulls
  kKinds,
};

/// SI.
struct HeldTruth {
  // The device.
  double mass = 0.15;
  double damping = 1.0;
  double friction = 0.0;  ///< dry, N
  double weight = 0.0;    ///< not borne, N
  double step = 0.0;      ///< of the encoder, m; 0: exact
  double noise = 0.0;     ///< of a position, standard deviation, m
  int delay = 0;          ///< of a force, ticks, 0 to 7
  // The hand.
  HandKind kind = HandKind::kNone;
  double hand_mass = 0.0;
  double hand_damping = 0.0;
  double hand_stiffness = 0.0;
  double hand_rest = 0.0;  ///< where its spring rests, m
  double grip_stiffness = 500.0;
  double grip_damping = 1.0;
  double fade_s = 1.0;
  double from_s = 0.0;
  double until_s = 1e9;
  double gap = 0.0;
  std::uint64_t seed = 1;  ///< of the noise
};

class HeldHandle {
 public:
  explicit HeldHandle(const HeldTruth& truth) : truth_(truth), random_(truth.seed) {}

  /// As its encoder has it, m; noise and all, so another one each time.
  [[nodiscard]] double position() {
    double y = x_;
    // Twelve of them are nearly normal.
    for (int k = 0; k < 12 && truth_.noise > 0.0; ++k)
      y += truth_.noise * (random_.uniform() - 0.5);
    return truth_.step > 0.0 ? truth_.step * std::floor(y / truth_.step + 0.5) : y;
  }

  /// `force` was written at the start of a tick that lasts `tick_s`.
  void advance(double force, double tick_s) {
    std::copy_backward(written_.begin(), written_.end() - 1, written_.end());
    written_[0] = force;
    const double felt = written_[static_cast<std::size_t>(truth_.delay)];
    const int steps = std::max(4, static_cast<int>(std::ceil(tick_s / 2e-5)));
    for (int k = 0; k < steps; ++k) step(felt, tick_s / steps);
  }

 private:
  /// How much of a firm hand is there.
  [[nodiscard]] double grip() const {
    if (truth_.kind == HandKind::kFirm) return 1.0;
    if (truth_.kind == HandKind::kFading) return std::exp(-t_s_ / truth_.fade_s);
    const bool there = t_s_ >= truth_.from_s && t_s_ < truth_.until_s;
    return truth_.kind == HandKind::kComing && there ? 1.0 : 0.0;
  }
  void step(double felt, double h) {
    double push = felt + truth_.weight - truth_.damping * v_;
    double mass = truth_.mass;
    if (truth_.kind == HandKind::kSoft) {
      const double between =
          truth_.grip_stiffness * (x_ - x_hand_) + truth_.grip_damping * (v_ - v_hand_);
      push -= between;
      v_hand_ += h * (between - truth_.hand_stiffness * x_hand_ - truth_.hand_damping * v_hand_) /
                 std::max(truth_.hand_mass, 0.01);
      x_hand_ += h * v_hand_;
    } else if (truth_.kind == HandKind::kBeside) {
      const double deep = x_ - truth_.gap;
      if (deep > 0.0) {
        push -= std::max(0.0, truth_.hand_stiffness * deep + truth_.hand_damping * v_);
      }
    } else if (truth_.kind != HandKind::kNone) {
      mass += truth_.hand_mass;
      push -= grip() * (truth_.hand_stiffness * (x_ - truth_.hand_rest) + truth_.hand_damping * v_);
    }
    const double free = v_ + h * push / mass;
    const double left = std::max(0.0, std::abs(free) - h * truth_.friction / mass);
    const double v = std::copysign(left, free);
    x_ += 0.5 * h * (v_ + v);
    v_ = v;
    t_s_ += h;
  }

  HeldTruth truth_;
  SplitMix64 random_;
  double t_s_ = 0.0;
  double x_ = 0.0;
  double v_ = 0.0;
  double x_hand_ = 0.0;
  double v_hand_ = 0.0;
  std::array<double, 8> written_{};
};

}  // namespace hapticd::test
