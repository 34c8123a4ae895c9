// Truth: a spring rendered at period T with delay t_d is stable up to K = b / (T/2 + t_d), since a
// sampled, delayed spring acts like one with the negative damping K (T/2 + t_d) (Colgate and
// Schenkel 1997 for t_d = 0); hands off, which is the worst case. A spring that the device renders
// by itself is none of these: it is the damped oscillator of any textbook.
#include <doctest/doctest.h>

#include <cmath>

#include "device/simulated/simulated_device.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr double kDamping = 2.0;

/// True when the handle swings farther and farther on a rendered spring of stiffness K.
bool grows(double K, double delay) {
  DeviceProfile profile;
  profile.peak_force = 1e3;
  profile.mass = {0.3, 0.3, 0.3};
  profile.damping = kDamping;
  profile.delay = delay;
  SimulatedDevice device(profile, {.X_DH = {{1, 0, 0, 0}, {1e-3, 0, 0}}, .arm = ArmKind::kOff});
  DeviceSample sample;
  double early = 0.0;
  double late = 0.0;
  for (int i = 0; i < 4000; ++i) {
    device.read(i * kMs, sample);
    const double x = sample.p_DH[0];
    if (i >= 500 && i < 1500) early = std::max(early, std::abs(x));
    if (i >= 3000) late = std::max(late, std::abs(x));
    device.write(i * kMs, {.f_H_D = {-K * x, 0.0, 0.0}, .enable = true});
  }
  return late > early;
}

/// The stiffness at which growth begins.
double critical(double delay) {
  double low = 10.0;
  double high = 20'000.0;
  while (high / low > 1.002) {
    const double middle = std::sqrt(low * high);
    (grows(middle, delay) ? high : low) = middle;
  }
  return std::sqrt(low * high);
}

}  // namespace

TEST_CASE("the stiffest stable spring is b / (T/2 + t_d) within a few per cent, hands off") {
  for (const double delay : {0.0, 1e-3, 2e-3}) {
    const double bound = kDamping / (0.5e-3 + delay);
    CAPTURE(delay);
    CHECK(std::abs(critical(delay) / bound - 1.0) < 0.03);
  }
}

TEST_CASE("a spring that the device renders by itself swings as a spring does, delayed or not") {
  for (const double delay : {0.0, 2e-3}) {
    // Eight times what can be rendered from outside at that delay.
    const double K = 8.0 * kDamping / (0.5e-3 + 2e-3);
    DeviceProfile profile;
    profile.peak_force = 1e3;
    profile.mass = {0.3, 0.3, 0.3};
    profile.damping = kDamping;
    profile.delay = delay;
    profile.affine = true;
    SimulatedDevice device(profile, {.X_DH = {{1, 0, 0, 0}, {1e-3, 0, 0}}, .arm = ArmKind::kOff});
    DeviceSample sample;
    const double decay = kDamping / (2.0 * profile.mass[0]);
    const double omega = std::sqrt(K / profile.mass[0] - decay * decay);
    double worst = 0.0;
    for (int i = 0; i < 1000; ++i) {
      device.read(i * kMs, sample);
      DeviceCommand command{.f_H_D = {-K * sample.p_DH[0], 0.0, 0.0}, .enable = true};
      command.sample_counter = sample.counter;
      command.spring.K_D[0] = K;
      device.write(i * kMs, command);
      // The first command takes effect after the delay; until then the handle rests.
      const double t = 1e-9 * static_cast<double>(sample.t_ns) - delay;
      if (t < 0.0) continue;
      const double truth =
          1e-3 * std::exp(-decay * t) * (std::cos(omega * t) + decay / omega * std::sin(omega * t));
      worst = std::max(worst, std::abs(sample.p_DH[0] - truth));
    }
    CAPTURE(delay);
    CHECK(worst < 0.06e-3);
  }
}

TEST_CASE("a device that is not affine leaves the spring of a command out") {
  DeviceProfile profile;
  profile.peak_force = 1e3;
  profile.mass = {0.3, 0.3, 0.3};
  SimulatedDevice device(profile, {.X_DH = {{1, 0, 0, 0}, {1e-3, 0, 0}}, .arm = ArmKind::kOff});
  DeviceSample sample;
  for (int i = 0; i < 50; ++i) {
    device.read(i * kMs, sample);
    DeviceCommand command{.f_H_D = {1.0, 0.0, 0.0}, .enable = true};
    command.sample_counter = sample.counter;
    command.spring.K_D = {1e3, 1e3, 1e3, 0.0, 0.0, 0.0};
    device.write(i * kMs, command);
    device.read(i * kMs + kMs - 1, sample);
    CHECK(device.plant().F_H_D.f.x() == 1.0);
  }
}

}  // namespace hapticd::test
