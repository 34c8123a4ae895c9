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

/// The modes at the finger: x = phi_n q_n, y = phi_n v_n, and what a step does to them:
///   x <- xx x + xy y + F push_x,   y <- yy y - xy x + F push_y.
/// A step's push is only added when the next one turns it (turned_x, turned_y), in one pass.
struct TouchedModes {
  std::size_t groups;
  LaneArray x;  ///< m
  LaneArray y;
  LaneArray xx;
  LaneArray xy;
  LaneArray yy;
  LaneArray push_x;  ///< m/N
  LaneArray push_y;
  LaneArray turned_x;
  LaneArray turned_y;
};

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

/// Sets mode k, of `frequency` and `shape` at the finger, and adds its compliance.
void begin_mode(const StringConstants& string, const ModalString& modes, double frequency,
                double shape, const Damping& damping, std::size_t k, TouchedModes& touched,
                Compliance& sum) noexcept {
  const SinCos now = sin_cos(2.0 * kPi * turns_of_phase(modes.phase[k]));
  const DampedTurn turn = damped_turn(frequency, damping);
  const double compliance = shape * shape / modal_stiffness(string, frequency);
  const double push_x = compliance * (1.0 - turn.qq);
  const double push_y = compliance * turn.qv;
  touched.x.set(k, shape * (modes.amplitude[k] * now.cos));
  touched.y.set(k, -(shape * (modes.amplitude[k] * now.sin)));
  touched.xx.set(k, turn.qq);
  touched.xy.set(k, turn.qv);
  touched.yy.set(k, turn.vv);
  touched.push_x.set(k, push_x);
  touched.push_y.set(k, push_y);
  touched.turned_x.set(k, turn.qq * push_x + turn.qv * push_y);
  touched.turned_y.set(k, turn.vv * push_y - turn.qv * push_x);
  sum.at_rest += compliance;
  sum.of_step += push_x;
}

/// Adds the push of the last step's force, turns all modes through one step, and returns their
/// displacement at the finger without the force of this step, m.
double turn_modes(double last_force, TouchedModes& touched) noexcept {
  Lanes sum{{0.0, 0.0, 0.0, 0.0}};
  for (std::size_t g = 0; g < touched.groups; ++g) {
    Lanes& x = touched.x.group[g];
    Lanes& y = touched.y.group[g];
    const Lanes::Vector old_x = x.value;
    x.value = (touched.xx.group[g].value * old_x + touched.xy.group[g].value * y.value) +
              last_force * touched.turned_x.group[g].value;
    y.value = (touched.yy.group[g].value * y.value - touched.xy.group[g].value * old_x) +
              last_force * touched.turned_y.group[g].value;
    sum.value += x.value;
  }
  return (sum.value[0] + sum.value[2]) + (sum.value[1] + sum.value[3]);
}

void set_mode(double q, double v, std::size_t k, ModalString& modes) noexcept {
  modes.amplitude[k] = std::sqrt(q * q + v * v);
  modes.phase[k] = phase_of_turns(arctangent2(-v, q) / (2.0 * kPi));
}

/// A mode that does not feel the finger, through the whole tick.
void pass_mode(double frequency, const Damping& damping, std::size_t k,
               ModalString& modes) noexcept {
  const SinCos now = sin_cos(2.0 * kPi * turns_of_phase(modes.phase[k]));
  const DampedTurn turn = damped_turn(frequency, damping);
  const double q = modes.amplitude[k] * now.cos;
  const double v = -(modes.amplitude[k] * now.sin);
  set_mode(turn.qq * q + turn.qv * v, turn.vv * v - turn.qv * q, k, modes);
}

using Shapes = std::array<double, kMaxModes>;

bool feels(double shape) noexcept { return std::abs(shape) >= kNode; }

/// Amplitudes as of the start of the tick, shapes at the finger; returns how far the string can
/// reach there, m.
double prepare(const StringConstants& string, double lambda, std::int64_t start_ns,
               ModalString& modes, Shapes& shapes) noexcept {
  const double decay = decay_over(start_ns - modes.t_ns, string.decay);
  modes.t_ns = start_ns;
  double reach = 0.0;
  for (int n = 1; n <= modes.count; ++n) {
    const auto k = static_cast<std::size_t>(n - 1);
    modes.amplitude[k] *= decay;
    shapes[k] = mode_shape(n, lambda);
    reach += std::abs(shapes[k]) * modes.amplitude[k];
  }
  return reach;
}

/// Sets `touched` for steps of `step` seconds.
Compliance begin_touch(const StringConstants& string, const ModalString& modes,
                       const Shapes& shapes, double step, TouchedModes& touched) noexcept {
  touched = TouchedModes{};
  touched.groups = (static_cast<std::size_t>(modes.count) + kLanes - 1) / kLanes;
  const ModeSeries series = mode_series(string);
  const Damping damping = damping_over(step, string.touch_decay);
  Compliance sum;
  for (int n = 1; n <= modes.count; ++n) {
    const auto k = static_cast<std::size_t>(n - 1);
    if (!feels(shapes[k])) continue;
    begin_mode(string, modes, series.frequency(n), shapes[k], damping, k, touched, sum);
  }
  return sum;
}

/// Back to amplitudes and phases, with the push of the last step.
void end_touch(const StringConstants& string, const TouchedModes& touched, const Shapes& shapes,
               double last_force, double time, ModalString& modes) noexcept {
  const ModeSeries series = mode_series(string);
  const Damping damping = damping_over(time, string.touch_decay);
  for (int n = 1; n <= modes.count; ++n) {
    const auto k = static_cast<std::size_t>(n - 1);
    if (feels(shapes[k])) {
      set_mode((touched.x[k] + last_force * touched.push_x[k]) / shapes[k],
               (touched.y[k] + last_force * touched.push_y[k]) / shapes[k], k, modes);
    } else {
      pass_mode(series.frequency(n), damping, k, modes);
    }
  }
}

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

double displacement(const TouchedModes& touched) noexcept {
  double w = 0.0;
  for (std::size_t k = 0; k < touched.groups * kLanes; ++k) w += touched.x[k];
  return w;
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

ModalTouch touch_modes(const StringConstants& string, double lambda, double D_before,
                       double D_after, double stiffness, int steps, std::int64_t t_ns,
                       std::int64_t dt_ns, ModalString& modes) noexcept {
  if (!(string.frequency > 0.0)) modes.count = 0;
  Shapes shapes;
  const double reach = prepare(string, lambda, t_ns - dt_ns, modes, shapes);
  // A finger out of reach has nothing to step for.
  const bool reached = std::max(D_before, D_after) > -reach;
  const int count = reached ? std::clamp(steps, 1, kMaxSteps) : 1;
  const double share = 1.0 / count;
  const double time = static_cast<double>(dt_ns) * kSecondsPerNanosecond;
  TouchedModes touched;
  const Compliance compliance = begin_touch(string, modes, shapes, time * share, touched);
  const Contact contact = contact_of(string, lambda, stiffness, compliance);

  double compression = D_before - displacement(touched);
  const double stored_before = spring_energy(contact.stiffness, compression);
  double force = 0.0;
  double sum = 0.0;
  for (int i = 1; i <= count; ++i) {
    const double D = D_before + (D_after - D_before) * (i * share);
    const double free_compression = D - turn_modes(force, touched);
    force = step_force(contact, compression, free_compression);
    compression = free_compression - contact.compliance * force;
    sum += force;
  }

  end_touch(string, touched, shapes, force, time, modes);
  modes.t_ns = t_ns;
  const double mean = sum * share;
  return {mean, mean * (D_after - D_before), stored_before,
          spring_energy(contact.stiffness, compression)};
}

}  // namespace hapticd
