// See body.h.
#include "clients/audio/dsp/body.h"

namespace hapticd::audio {
namespace {

/// Inaudible by 500 dB.
constexpr double kSilent = 1e-25;
/// Frames after which it is looked for.
constexpr std::uint32_t kSettleEvery = 1024;

bool silent(double value) noexcept { return value < kSilent && value > -kSilent; }

}  // namespace

double Body::next(double strings) noexcept {
  const double difference = strings - in_2_;
  in_2_ = in_1_;
  in_1_ = strings;
  double sum = strings;
  for (std::size_t i = 0; i < kBodyModes; ++i) {
    const BodyMode& mode = filter_.modes[i];
    State& state = states_[i];
    const double out = mode.b * difference - mode.a1 * state.out_1 - mode.a2 * state.out_2;
    state.out_2 = state.out_1;
    state.out_1 = out;
    sum += out;
  }
  if (++age_ % kSettleEvery == 0) settle();
  return sum;
}

void Body::settle() noexcept {
  for (State& state : states_) {
    if (silent(state.out_1) && silent(state.out_2)) state = {};
  }
}

}  // namespace hapticd::audio
