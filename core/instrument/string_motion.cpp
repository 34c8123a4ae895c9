// Exact rotation of modes by sub-steps. Sums run in four lanes in a fixed order, so that their bits
// are the same on every processor.
#include "core/instrument/string_motion.h"

#include <algorithm>
#include <cmath>

#include "core/instrument/mode_series.h"
#include "core/math/elementary.h"

namespace hapticd {
namespace {

constexpr std::size_t kLanes = 4;
/// Sub-steps of the fastest mode's period, at least.
constexpr double kStepsPerPeriod = 4.0;
/// sigma / omega, at most: beyond it a mode no longer swings.
constexpr double kMostDamped = 0.99;

std::size_t size(const ModeTable& table) noexcept { return static_cast<std::size_t>(table.count); }

/// What a mode is turned by, as in ModeTable.
struct Turn {
  double qq, qv, vv;
};

/// Over `time`, s; turns are reduced before they become an angle.
Turn turn_over(double omega, double sigma, double time) noexcept {
  const double r = std::min(sigma / omega, kMostDamped);
  const double w = std::sqrt(1.0 - r * r);
  const double turns = omega * w * time / (2.0 * kPi);
  const double fall = exponential(-sigma * time);
  const SinCos turned = sin_cos(2.0 * kPi * (turns - nearest_integer(turns)));
  const double c = fall * turned.cos;
  const double s = fall * turned.sin / w;
  return {c + r * s, s, c - r * s};
}

void fill(std::size_t i, const StringConstants& string, double sigma, ModeTable& table) noexcept {
  const double frequency = mode_series(string).frequency(static_cast<int>(i) + 1);
  const double omega = 2.0 * kPi * frequency;
  const double stiffness = modal_stiffness(string, frequency);
  const Turn turn = turn_over(omega, sigma, table.step);
  table.stiffness[i] = stiffness;
  table.omega[i] = omega;
  table.sigma[i] = sigma;
  table.qq[i] = turn.qq;
  table.qv[i] = turn.qv;
  table.vv[i] = turn.vv;
  table.push_q[i] = (1.0 - turn.qq) / stiffness;
  table.push_v[i] = turn.qv / stiffness;
}

}  // namespace

ModeTable mode_table(const StringConstants& string, const StringLoss& loss, int modes) noexcept {
  ModeTable table;
  table.step = 1.0 / kSubStepRate;
  if (!(string.frequency > 0.0)) return table;
  const double fitting = 1.0 / (kStepsPerPeriod * table.step * string.frequency);
  const double most = std::min(static_cast<double>(std::min(modes, kMaxModes)), fitting);
  table.count = 4 * static_cast<int>(most / 4.0);
  for (std::size_t i = 0; i < size(table); ++i) {
    const auto n = static_cast<double>(i + 1);
    fill(i, string, 1.0 / loss.decay + n * n * loss.loss_n2, table);
  }
  return table;
}

void mode_shapes(const ModeTable& table, double lambda, PerMode& shapes) noexcept {
  // From the nearer end, where shapes are small; mirrored, even modes change their sign.
  const bool mirrored = lambda > 0.5;
  const SinCos first = sin_cos(kPi * (mirrored ? 1.0 - lambda : lambda));
  double before = 0.0;
  double now = first.sin;
  for (std::size_t i = 0; i < size(table); ++i) {
    shapes[i] = mirrored && i % 2 == 1 ? -now : now;
    const double next = 2.0 * first.cos * now - before;
    before = now;
    now = next;
  }
}

Transverse displacement(const ModeTable& table, const ModalMotion& motion,
                        const PerMode& shapes) noexcept {
  std::array<double, kLanes> y{};
  std::array<double, kLanes> z{};
  for (std::size_t i = 0; i < size(table); i += kLanes) {
    for (std::size_t k = 0; k < kLanes; ++k) {
      y[k] += shapes[i + k] * motion.qy[i + k];
      z[k] += shapes[i + k] * motion.qz[i + k];
    }
  }
  return {(y[0] + y[1]) + (y[2] + y[3]), (z[0] + z[1]) + (z[2] + z[3])};
}

void turn(const ModeTable& table, ModalMotion& motion) noexcept {
  const auto plane = [&](PerMode& q, PerMode& v) {
    for (std::size_t i = 0; i < size(table); ++i) {
      const double turned = table.qq[i] * q[i] + table.qv[i] * v[i];
      v[i] = table.vv[i] * v[i] - table.qv[i] * q[i];
      q[i] = turned;
    }
  };
  plane(motion.qy, motion.vy);
  plane(motion.qz, motion.vz);
}

void turn_on(const ModeTable& table, std::int64_t steps, ModalMotion& motion) noexcept {
  const double time = table.step * static_cast<double>(steps);
  for (std::size_t i = 0; i < size(table); ++i) {
    const Turn by = turn_over(table.omega[i], table.sigma[i], time);
    const auto plane = [&](double& q, double& v) {
      const double turned = by.qq * q + by.qv * v;
      v = by.vv * v - by.qv * q;
      q = turned;
    };
    plane(motion.qy[i], motion.vy[i]);
    plane(motion.qz[i], motion.vz[i]);
  }
}

void push(const ModeTable& table, const PerMode& shapes, const Transverse& force,
          ModalMotion& motion) noexcept {
  for (std::size_t i = 0; i < size(table); ++i) {
    const double q = table.push_q[i] * shapes[i];
    const double v = table.push_v[i] * shapes[i];
    motion.qy[i] += q * force.y;
    motion.vy[i] += v * force.y;
    motion.qz[i] += q * force.z;
    motion.vz[i] += v * force.z;
  }
}

double energy(const ModeTable& table, const ModalMotion& motion) noexcept {
  double sum = 0.0;
  for (std::size_t i = 0; i < size(table); ++i) {
    sum += 0.5 * table.stiffness[i] *
           ((motion.qy[i] * motion.qy[i] + motion.vy[i] * motion.vy[i]) +
            (motion.qz[i] * motion.qz[i] + motion.vz[i] * motion.vz[i]));
  }
  return sum;
}

double residual_compliance(const StringConstants& string, const ModeTable& table, double lambda,
                           const PerMode& shapes) noexcept {
  double sum = 0.0;
  for (std::size_t i = 0; i < size(table); ++i) sum += shapes[i] * shapes[i] / table.stiffness[i];
  return std::max(0.0, lambda * (1.0 - lambda) * string.length / string.tension - sum);
}

}  // namespace hapticd
