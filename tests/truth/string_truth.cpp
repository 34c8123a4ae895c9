// Recurrences, grid and waves of a string.
#include "tests/truth/string_truth.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

namespace hapticd {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kTick = 1e-3;

/// Collects force and work; the force between two samples is their mean.
class Ledger {
 public:
  Ledger(const TruthPress& press, TruthRun& run) : press_(&press), run_(&run) {
    run_->force.assign(static_cast<std::size_t>(press.ticks), 0.0);
  }

  /// The force at `time`, which may not step back, and at most one tick on.
  void add(double time, double force) {
    if (time > time_) {
      const double tick = std::floor(time_ / kTick + 1e-9);
      const double edge = std::min((tick + 1.0) * kTick, time);
      const double at_edge = force_ + (force - force_) * (edge - time_) / (time - time_);
      book(tick, time_, force_, edge, at_edge);
      book(tick + 1.0, edge, at_edge, time, force);
    }
    time_ = time;
    force_ = force;
  }

 private:
  void book(double tick, double from, double from_force, double to, double to_force) {
    const double mean = 0.5 * (from_force + to_force);
    run_->work += mean * (press_->hand(to) - press_->hand(from));
    const auto index = static_cast<std::size_t>(tick);
    if (index < run_->force.size()) run_->force[index] += mean * (to - from) / kTick;
  }

  const TruthPress* press_;
  TruthRun* run_;
  double time_ = 0.0;
  double force_ = 0.0;
};

/// One mode under friction, as a recurrence: next = a now + b before + push F.
struct Recurrence {
  double omega;
  double stiffness;  ///< K_n = n^2 pi^2 T / (2 L): its potential energy is K_n q^2 / 2
  double shape;      ///< at the finger
  double a;
  double b;
  double push;
  double now;
  double before;
};

/// Mode n at the start of the touch, for samples h apart.
Recurrence make_recurrence(const TruthString& string, const TruthPress& press, int n, double h) {
  const double gamma = 1.0 / string.touch_decay;
  const double fall = std::exp(-gamma * h);
  const double omega = 2.0 * kPi * n * string.frequency;
  const double damped = std::sqrt(omega * omega - gamma * gamma);
  const double stiffness = n * n * kPi * kPi * string.tension / (2.0 * string.length);
  // A point force that holds the triangle is its kink, T (delta/L1 + delta/L2).
  const double held = string.tension * press.pluck_delta /
                      (string.length * press.pluck_lambda * (1.0 - press.pluck_lambda));
  const double start = held * std::sin(n * kPi * press.pluck_lambda) / stiffness *
                       std::exp(-press.free_time / string.decay);
  const double now = start * std::cos(omega * press.free_time);
  const double speed = -start * omega * std::sin(omega * press.free_time) - now / string.decay;
  // The sample before the touch, as if there had been the touch's friction.
  const double before =
      (now * std::cos(damped * h) - (speed + gamma * now) / damped * std::sin(damped * h)) / fall;
  const double a = 2.0 * fall * std::cos(damped * h);
  const double b = -fall * fall;
  const double shape = std::sin(n * kPi * press.lambda);
  return {omega, stiffness, shape, a, b, (1.0 - a - b) * shape / stiffness, now, before};
}

/// Energy of free modes, J.
double modal_energy(const std::vector<Recurrence>& bank, double gamma, double h) {
  const double fall = std::exp(-gamma * h);
  double sum = 0.0;
  for (const Recurrence& mode : bank) {
    const double damped = std::sqrt(mode.omega * mode.omega - gamma * gamma);
    const double speed =
        (mode.now * std::cos(damped * h) - mode.before * fall) * damped / std::sin(damped * h) -
        gamma * mode.now;
    const double other = speed / mode.omega;
    sum += 0.5 * mode.stiffness * (mode.now * mode.now + other * other);
  }
  return sum;
}

double finger_force(double stiffness, double D, double w) {
  return std::max(0.0, stiffness * (D - w));
}

/// Height of the triangle at x, drawn aside at `lambda` by `delta`; odd and of period 2, as the
/// reflections at the ends make it.
double triangle(double lambda, double delta, double x) {
  x -= 2.0 * std::floor(0.5 * x + 0.5);  // in [-1, 1)
  const double size = std::abs(x);
  const double height =
      size <= lambda ? delta * size / lambda : delta * (1.0 - size) / (1.0 - lambda);
  return x < 0.0 ? -height : height;
}

}  // namespace

double TruthPress::hand(double time) const {
  const double s = std::clamp(time / ramp_time, 0.0, 1.0);
  return start_D + (end_D - start_D) * (s * s * s * (10.0 - 15.0 * s + 6.0 * s * s));
}

TruthRun play_modes(const TruthString& string, const TruthPress& press, int modes, int rate) {
  TruthRun run;
  Ledger ledger(press, run);
  const double h = 1.0 / rate;
  const double gamma = 1.0 / string.touch_decay;
  std::vector<Recurrence> bank;
  for (int n = 1; n <= modes; ++n) bank.push_back(make_recurrence(string, press, n, h));
  run.energy_before = modal_energy(bank, gamma, h);

  const std::int64_t samples = static_cast<std::int64_t>(press.ticks) * (rate / 1000);
  // Modes beyond the last would follow the force at once: a spring in series.
  double left_out = press.lambda * (1.0 - press.lambda) * string.length / string.tension;
  double w = 0.0;
  for (const Recurrence& mode : bank) {
    left_out -= mode.shape * mode.shape / mode.stiffness;
    w += mode.shape * mode.now;
  }
  const double spring = 1.0 / (1.0 / press.stiffness + left_out);
  for (std::int64_t i = 0;; ++i) {
    const double time = static_cast<double>(i) * h;
    const double force = finger_force(spring, press.hand(time), w);
    ledger.add(time, force);
    if (i == samples) {
      run.energy = modal_energy(bank, gamma, h) + 0.5 * force * force / spring;
      return run;
    }
    w = 0.0;
    for (Recurrence& mode : bank) {
      const double next = mode.a * mode.now + mode.b * mode.before + mode.push * force;
      mode.before = mode.now;
      mode.now = next;
      w += mode.shape * next;
    }
  }
}

TruthRun play_grid(const TruthString& string, const TruthPress& press, int cells) {
  TruthRun run;
  Ledger ledger(press, run);
  const double dx = string.length / cells;
  const double c = 2.0 * string.length * string.frequency;
  const double h = dx / c;
  const double impedance = string.tension / c;
  const double loss = h / string.touch_decay;
  const double response = h / impedance / (1.0 + loss);
  const auto finger = static_cast<std::size_t>(std::lround(press.lambda * cells));
  const auto size = static_cast<std::size_t>(cells) + 1;

  // The plucked shape at the start of the touch and one step before.
  const auto shape = [&](double lambda, double time) {
    return std::exp(-time / string.decay) *
           free_displacement(string, press.pluck_lambda, press.pluck_delta, lambda, time);
  };
  std::vector<double> now(size);
  std::vector<double> before(size);
  for (std::size_t j = 0; j < size; ++j) {
    const double lambda = static_cast<double>(j) / cells;
    now[j] = shape(lambda, press.free_time);
    before[j] = shape(lambda, press.free_time - h);
  }

  // Kinetic energy between two samples, potential energy as the product of both slopes: what the
  // scheme conserves exactly while nobody presses.
  const auto energy = [&] {
    double sum = 0.0;
    for (std::size_t j = 0; j + 1 < size; ++j) {
      const double speed = (now[j] - before[j]) / h;
      const double slopes = (now[j + 1] - now[j]) * (before[j + 1] - before[j]) / (dx * dx);
      sum += 0.5 * dx * string.tension * (speed * speed / (c * c) + slopes);
    }
    return sum;
  };
  run.energy_before = energy();

  std::vector<double> next(size, 0.0);
  for (std::int64_t i = 0;; ++i) {
    const double time = static_cast<double>(i) * h;
    for (std::size_t j = 1; j + 1 < size; ++j) {
      next[j] = (now[j + 1] + now[j - 1] - (1.0 - loss) * before[j]) / (1.0 + loss);
    }
    // The spring sees the mean of the samples before and after: at c h = dx a spring that sees the
    // sample of now is unstable.
    const double mean = 0.5 * (next[finger] + before[finger]);
    const double force = finger_force(press.stiffness, press.hand(time), mean) /
                         (1.0 + 0.5 * press.stiffness * response);
    ledger.add(time, force);
    if (time >= press.ticks * kTick) {
      run.energy = energy() + 0.5 * force * force / press.stiffness;
      return run;
    }
    next[finger] += force * response;
    before.swap(now);
    now.swap(next);
    now.front() = 0.0;
    now.back() = 0.0;
  }
}

double free_displacement(const TruthString& string, double pluck_lambda, double pluck_delta,
                         double lambda, double time) {
  const double way = 2.0 * string.frequency * time;  // in lengths of the string
  return 0.5 * (triangle(pluck_lambda, pluck_delta, lambda - way) +
                triangle(pluck_lambda, pluck_delta, lambda + way));
}

}  // namespace hapticd
