// Modes under a finger: m (q'' + 2 q' / T_d + omega_n^2 q) = F phi_n. Over a contact step the force
// F is constant, so every mode turns and decays exactly about the place F holds it at. F is the
// finger spring's mean over the step in the sense of its energy, F = (V(x_1) - V(x_0)) / (x_1 -
// x_0), x the spring's compression: the discrete gradient of O. Gonzalez, "Time integration and
// discrete Hamiltonian systems", 1996, for collisions of strings V. Chatziioannou and M. van
// Walstijn, "Energy conserving schemes for the simulation of musical instrument contact dynamics",
// 2015. What the spring gains and the modes gain is then F times the hand's motion, but for what
// decays: passive at any step, stiffness and mode count. As x_1 is linear in F, it solves in closed
// form. Compliance that the modes leave out is in series with the finger, without mass.
//
// Lanes: four modes at a time, summed in one order, so that every compiler and processor gets the
// same bits. RT: yes; 70 ns per mode, 0.5 to 1 ns per mode and step.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "core/instrument/modal_string.h"
#include "core/instrument/mode_series.h"
#include "core/math/elementary.h"

namespace hapticd {
namespace {

/// Modes whose shape at the finger is smaller do not feel it, and would underflow if divided by it.
/// Normal values: 0, or above 1e-17. Larger: modes with a node near the finger would pass through.
constexpr double kNode = 1e-100;

/// Damping of a mode over the critical one, at most. Normal values: below 0.1; a string so low and
/// so heavily damped that this binds no longer swings. 1 divides by zero.
constexpr double kMaxDamping = 0.99;

constexpr int kMaxSteps = 4096;

constexpr std::size_t kLanes = 4;
struct Lanes {
  using Vector [[gnu::vector_size(32)]] = double;
  Vector value;
};
struct LaneArray {
  std::array<Lanes, kMaxModes / kLanes> group;

  [[nodiscard]] double operator[](std::size_t k) const noexcept {
    return group[k / kLanes].value[k % kLanes];
  }
  void set(std::size_t k, double value) noexcept { group[k / kLanes].value[k % kLanes] = value; }
};

/// What a time of free, damped motion does to a mode, with v = (dq/dt) / omega:
///   q <- qq q + qv v,   v <- vv v - qv q.
struct DampedTurn {
  double qq;
  double qv;
  double vv;
};

/// Damping over a time, for all modes that swing.
struct Damping {
  double gamma;  ///< 1 / T_d, 1/s
  double time;   ///< s
  double fall;   ///< exp(-gamma time)
};

Damping damping_over(double time, double decay) noexcept {
  const double gamma = 1.0 / decay;
  return {gamma, time, exponential(-gamma * time)};
}

/// The exact solution of q'' + 2 gamma q' + omega^2 q = 0, gamma kept below the critical damping.
DampedTurn damped_turn(double frequency, const Damping& damping) noexcept {
  double ratio = damping.gamma / (2.0 * kPi * frequency);
  double fall = damping.fall;
  if (ratio > kMaxDamping) {
    ratio = kMaxDamping;
    fall = exponential(-ratio * (2.0 * kPi * frequency) * damping.time);
  }
  const double slower = std::sqrt(1.0 - ratio * ratio);
  const double turns = frequency * slower * damping.time;
  const SinCos turn = sin_cos(2.0 * kPi * turns_of_phase(phase_of_turns(turns)));
  const double c = fall * turn.cos;
  const double s = fall * turn.sin / slower;
  return {c + ratio * s, s, c - ratio * s};
}

/// What the solution of a contact step needs to know.
struct Contact {
  double stiffness;   ///< of the finger in series with what the modes leave out, N/m
  double compliance;  ///< displacement at the finger per force of the same step, m/N
  double kappa;       ///< stiffness compliance / 2
  double gain;        ///< force per sum of compressions when both are > 0
};

double spring_energy(double stiffness, double compression) noexcept {
  const double x = std::max(compression, 0.0);
  return 0.5 * stiffness * (x * x);
}

/// Compression of x0 at the start of a step, and of `x_free` at its end were there no force. The
/// force is the only root of F = (V(x1) - V(x0)) / (x1 - x0), x1 = x_free - compliance F.
double step_force(const Contact& contact, double x0, double x_free) noexcept {
  const double k = contact.stiffness;
  const double c = contact.compliance;
  if (x0 <= 0.0) {
    if (x_free <= 0.0) return 0.0;
    // Closing: (1 + kappa) x1^2 - (x_free + x0) x1 + x_free x0 = 0, its root > 0.
    const double b = x_free + x0;
    const double grown = 1.0 + contact.kappa;
    const double root = std::sqrt(b * b - 4.0 * grown * (x_free * x0));
    const double x1 = b > 0.0 ? (b + root) / (2.0 * grown) : 2.0 * (x_free * x0) / (b - root);
    return x1 > 0.0 ? 0.5 * k * (x1 * x1) / (x1 - x0) : 0.0;
  }
  if (x_free >= contact.kappa * x0) return contact.gain * (x0 + x_free);
  // Opening: c F^2 + (x0 - x_free) F - k x0^2 / 2 = 0.
  const double b = x0 - x_free;
  const double root = std::sqrt(b * b + 4.0 * contact.kappa * (x0 * x0));
  return b > 0.0 ? k * (x0 * x0) / (b + root) : (root - b) / (2.0 * c);
}

/// Displacement at the finger per force, m/N.
struct Compliance {
  double at_rest = 0.0;
  double of_step = 0.0;  ///< at the end of a step with that force
};

void set_mode(double q, double v, std::size_t k, ModalString& modes) noexcept {
  modes.amplitude[k] = std::sqrt(q * q + v * v);
  modes.phase[k] = phase_of_turns(arctangent2(-v, q) / (2.0 * kPi));
}

/// The modes at the finger over a tick: x = phi_n q_n, y = phi_n v_n, and what a step does to them:
///   x <- xx x + xy y + F push_x,   y <- yy y - xy x + F push_y.
/// A step's push is only added when the next one turns it (turned_x, turned_y), in one pass. First
/// begin(), then turn() for each step, then end().
class TouchedModes {
 public:
  /// Of a finger at lambda, from start_ns on: up to there the amplitudes decay freely.
  TouchedModes(const StringConstants& string, double lambda, std::int64_t start_ns,
               ModalString& modes) noexcept
      : string_(string), series_(mode_series(string)), modes_(modes) {
    const double decay = decay_over(start_ns - modes.t_ns, string.decay);
    modes.t_ns = start_ns;
    for (int n = 1; n <= modes.count; ++n) {
      const auto k = static_cast<std::size_t>(n - 1);
      modes.amplitude[k] *= decay;
      shape_[k] = mode_shape(n, lambda);
      reach_ += std::abs(shape_[k]) * modes.amplitude[k];
    }
  }

  /// How far the string can reach at the finger, m.
  [[nodiscard]] double reach() const noexcept { return reach_; }
  /// At the finger, m.
  [[nodiscard]] double displacement() const noexcept {
    double w = 0.0;
    for (std::size_t k = 0; k < groups_ * kLanes; ++k) w += x_[k];
    return w;
  }

  /// Gets ready for steps of `step` seconds.
  Compliance begin(double step) noexcept {
    groups_ = (static_cast<std::size_t>(modes_.count) + kLanes - 1) / kLanes;
    const Damping damping = damping_over(step, string_.touch_decay);
    Compliance sum;
    for (int n = 1; n <= modes_.count; ++n) {
      const auto k = static_cast<std::size_t>(n - 1);
      if (!feels(k)) continue;
      const double frequency = series_.frequency(n);
      const double compliance = shape_[k] * shape_[k] / modal_stiffness(string_, frequency);
      const DampedTurn turn = damped_turn(frequency, damping);
      sum.at_rest += compliance;
      sum.of_step += begin_mode(k, turn, compliance);
    }
    return sum;
  }

  /// Adds the push of the last step's force, turns all modes through one step, and returns their
  /// displacement at the finger without the force of this step, m.
  double turn(double last_force) noexcept {
    Lanes sum{{0.0, 0.0, 0.0, 0.0}};
    for (std::size_t g = 0; g < groups_; ++g) {
      Lanes& x = x_.group[g];
      Lanes& y = y_.group[g];
      const Lanes::Vector old_x = x.value;
      x.value = (xx_.group[g].value * old_x + xy_.group[g].value * y.value) +
                last_force * turned_x_.group[g].value;
      y.value = (yy_.group[g].value * y.value - xy_.group[g].value * old_x) +
                last_force * turned_y_.group[g].value;
      sum.value += x.value;
    }
    return (sum.value[0] + sum.value[2]) + (sum.value[1] + sum.value[3]);
  }

  /// Back to amplitudes and phases after a tick of `time` seconds, with the push of the last step.
  void end(double last_force, double time) noexcept {
    const Damping damping = damping_over(time, string_.touch_decay);
    for (int n = 1; n <= modes_.count; ++n) {
      const auto k = static_cast<std::size_t>(n - 1);
      if (feels(k)) {
        set_mode((x_[k] + last_force * push_x_[k]) / shape_[k],
                 (y_[k] + last_force * push_y_[k]) / shape_[k], k, modes_);
      } else {
        pass_mode(k, damped_turn(series_.frequency(n), damping));
      }
    }
  }

 private:
  [[nodiscard]] bool feels(std::size_t k) const noexcept { return std::abs(shape_[k]) >= kNode; }

  /// Sets mode k, of `compliance` at the finger; returns how far a step's force pushes it, m/N.
  double begin_mode(std::size_t k, const DampedTurn& turn, double compliance) noexcept {
    const SinCos now = sin_cos(2.0 * kPi * turns_of_phase(modes_.phase[k]));
    const double push_x = compliance * (1.0 - turn.qq);
    const double push_y = compliance * turn.qv;
    x_.set(k, shape_[k] * (modes_.amplitude[k] * now.cos));
    y_.set(k, -(shape_[k] * (modes_.amplitude[k] * now.sin)));
    xx_.set(k, turn.qq);
    xy_.set(k, turn.qv);
    yy_.set(k, turn.vv);
    push_x_.set(k, push_x);
    push_y_.set(k, push_y);
    turned_x_.set(k, turn.qq * push_x + turn.qv * push_y);
    turned_y_.set(k, turn.vv * push_y - turn.qv * push_x);
    return push_x;
  }

  /// A mode that does not feel the finger, through the whole tick.
  void pass_mode(std::size_t k, const DampedTurn& turn) noexcept {
    const SinCos now = sin_cos(2.0 * kPi * turns_of_phase(modes_.phase[k]));
    const double q = modes_.amplitude[k] * now.cos;
    const double v = -(modes_.amplitude[k] * now.sin);
    set_mode(turn.qq * q + turn.qv * v, turn.vv * v - turn.qv * q, k, modes_);
  }

  const StringConstants& string_;
  const ModeSeries series_;
  ModalString& modes_;
  double reach_ = 0.0;
  std::size_t groups_ = 0;
  std::array<double, kMaxModes> shape_;  ///< phi_n
  LaneArray x_{};                        ///< m
  LaneArray y_{};
  LaneArray xx_{};
  LaneArray xy_{};
  LaneArray yy_{};
  LaneArray push_x_{};  ///< m/N
  LaneArray push_y_{};
  LaneArray turned_x_{};
  LaneArray turned_y_{};
};

/// Compliance at lambda of which the modes have `modal`, m/N.
double left_out(const StringConstants& string, double lambda, double modal) noexcept {
  if (!(string.tension > 0.0)) return 0.0;
  return std::max(lambda * (1.0 - lambda) * string.length / string.tension - modal, 0.0);
}

Contact contact_of(const StringConstants& string, double lambda, double stiffness,
                   const Compliance& compliance) noexcept {
  Contact contact{};
  // A slack string gives way.
  if (string.tension > 0.0) {
    contact.stiffness =
        stiffness / (1.0 + stiffness * left_out(string, lambda, compliance.at_rest));
  }
  contact.compliance = compliance.of_step;
  contact.kappa = 0.5 * contact.stiffness * contact.compliance;
  contact.gain = 0.5 * contact.stiffness / (1.0 + contact.kappa);
  return contact;
}

}  // namespace

double residual_compliance(const StringConstants& string, double lambda, int count) noexcept {
  if (!(string.frequency > 0.0)) return left_out(string, lambda, 0.0);
  const ModeSeries series = mode_series(string);
  double modal = 0.0;
  for (int n = 1; n <= count; ++n) {
    const double shape = mode_shape(n, lambda);
    modal += shape * shape / modal_stiffness(string, series.frequency(n));
  }
  return left_out(string, lambda, modal);
}

ModalTouch touch_modes(const StringConstants& string, const PressingFinger& finger,
                       const TickTime& time, ModalString& modes) noexcept {
  if (!(string.frequency > 0.0)) modes.count = 0;
  TouchedModes touched(string, finger.lambda, time.t_ns - time.dt_ns, modes);
  // A finger out of reach has nothing to step for.
  const bool reached = std::max(finger.D_before, finger.D_after) > -touched.reach();
  const int count = reached ? std::clamp(finger.steps, 1, kMaxSteps) : 1;
  const double share = 1.0 / count;
  const double dt = static_cast<double>(time.dt_ns) * kSecondsPerNanosecond;
  const Compliance compliance = touched.begin(dt * share);
  const Contact contact = contact_of(string, finger.lambda, finger.stiffness, compliance);

  double compression = finger.D_before - touched.displacement();
  const double stored_before = spring_energy(contact.stiffness, compression);
  const double pressed = finger.D_after - finger.D_before;
  double force = 0.0;
  double sum = 0.0;
  for (int i = 1; i <= count; ++i) {
    const double D = finger.D_before + pressed * (i * share);
    const double free_compression = D - touched.turn(force);
    force = step_force(contact, compression, free_compression);
    compression = free_compression - contact.compliance * force;
    sum += force;
  }

  touched.end(force, dt);
  modes.t_ns = time.t_ns;
  const double mean = sum * share;
  return {mean, mean * pressed, stored_before, spring_energy(contact.stiffness, compression)};
}

}  // namespace hapticd
