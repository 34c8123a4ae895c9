// Modes under a finger. Over a contact step the force F is constant, so every mode turns and decays
// exactly about the place F holds it at, F phi_n / (m omega_n^2). F is the finger spring's mean
// over the step in the sense of its energy, F = (V(x_1) - V(x_0)) / (x_1 - x_0), x the spring's
// compression: the discrete gradient of O. Gonzalez, "Time integration and discrete Hamiltonian
// systems", 1996, for collisions of strings V. Chatziioannou and M. van Walstijn, "Energy
// conserving schemes for the simulation of musical instrument contact dynamics", 2015. What the
// spring gains and the modes gain is then F times the hand's motion, but for what decays: passive
// at any step, stiffness and mode count. As x_1 is linear in F, it solves in closed form.
// Compliance that the modes leave out is in series with the finger, without mass.
//
// Lanes: four modes at a time, summed in one order, so that every compiler and processor gets the
// same bits. RT: yes; 1 to 2 ns per mode and step.
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

/// The modes at the finger: x = phi_n q_n, y = phi_n p_n, and what a step does to them:
///   x <- cos x + sin y + F push_x,   y <- cos y - sin x + F push_y.
/// A step's push is only added when the next one turns it (turned_x, turned_y), in one pass.
struct TouchedModes {
  std::size_t groups;
  LaneArray x;  ///< m
  LaneArray y;
  LaneArray cos;  ///< with the step's decay
  LaneArray sin;
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

/// Sets mode n from its amplitude now (m), and returns the displacement at the finger per force of
/// one step, m/N. `decay` is of one step of `step` seconds.
double begin_mode(const StringConstants& string, const ModeSeries& series, double shape,
                  double amplitude, std::uint64_t phase, double step, double decay, int n,
                  TouchedModes& touched) noexcept {
  const auto k = static_cast<std::size_t>(n - 1);
  if (std::abs(shape) < kNode) return 0.0;  // all zero
  const double frequency = series.frequency(n);
  const SinCos now = sin_cos(2.0 * kPi * turns_of_phase(phase));
  const SinCos turn = sin_cos(2.0 * kPi * turns_of_phase(phase_of_turns(frequency * step)));
  const double c = decay * turn.cos;
  const double s = decay * turn.sin;
  const double compliance = shape * shape / modal_stiffness(string, frequency);
  const double push_x = compliance * (1.0 - c);
  const double push_y = compliance * s;
  touched.x.set(k, shape * (amplitude * now.cos));
  touched.y.set(k, -(shape * (amplitude * now.sin)));
  touched.cos.set(k, c);
  touched.sin.set(k, s);
  touched.push_x.set(k, push_x);
  touched.push_y.set(k, push_y);
  touched.turned_x.set(k, c * push_x + s * push_y);
  touched.turned_y.set(k, c * push_y - s * push_x);
  return push_x;
}

/// Adds the push of the last step's force, turns all modes through one step, and returns their
/// displacement at the finger without the force of this step, m.
double turn_modes(double last_force, TouchedModes& touched) noexcept {
  Lanes sum{{0.0, 0.0, 0.0, 0.0}};
  for (std::size_t g = 0; g < touched.groups; ++g) {
    Lanes& x = touched.x.group[g];
    Lanes& y = touched.y.group[g];
    const Lanes& c = touched.cos.group[g];
    const Lanes& s = touched.sin.group[g];
    const Lanes::Vector turned_x =
        (c.value * x.value + s.value * y.value) + last_force * touched.turned_x.group[g].value;
    y.value =
        (c.value * y.value - s.value * x.value) + last_force * touched.turned_y.group[g].value;
    x.value = turned_x;
    sum.value += turned_x;
  }
  return (sum.value[0] + sum.value[2]) + (sum.value[1] + sum.value[3]);
}

/// Back to amplitude and phase, with the push of the last step.
void end_mode(const TouchedModes& touched, double shape, double last_force, std::size_t k,
              ModalString& modes) noexcept {
  const double q = (touched.x[k] + last_force * touched.push_x[k]) / shape;
  const double p = (touched.y[k] + last_force * touched.push_y[k]) / shape;
  modes.amplitude[k] = std::sqrt(q * q + p * p);
  modes.phase[k] = phase_of_turns(arctangent2(-p, q) / (2.0 * kPi));
}

using Shapes = std::array<double, kMaxModes>;

/// Turns and decays free modes through the tick.
void pass_freely(const StringConstants& string, std::int64_t t_ns, std::int64_t dt_ns,
                 ModalString& modes) noexcept {
  advance_free_modes(string, 1.0, dt_ns, modes);
  const double decay = decay_over(dt_ns, string.touch_decay);
  for (std::size_t k = 0; k < static_cast<std::size_t>(modes.count); ++k) {
    modes.amplitude[k] *= decay;
  }
  modes.t_ns = t_ns;
}

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

/// Sets `touched`; returns the displacement at the finger per force of one step, m/N.
double begin_touch(const StringConstants& string, const Shapes& shapes, double step,
                   const ModalString& modes, TouchedModes& touched) noexcept {
  touched = TouchedModes{};
  touched.groups = (static_cast<std::size_t>(modes.count) + kLanes - 1) / kLanes;
  const ModeSeries series = mode_series(string);
  const double decay = exponential(-step / string.touch_decay);
  double compliance = 0.0;
  for (int n = 1; n <= modes.count; ++n) {
    const auto k = static_cast<std::size_t>(n - 1);
    compliance += begin_mode(string, series, shapes[k], modes.amplitude[k], modes.phase[k], step,
                             decay, n, touched);
  }
  return compliance;
}

double displacement(const TouchedModes& touched) noexcept {
  double w = 0.0;
  for (std::size_t k = 0; k < touched.groups * kLanes; ++k) w += touched.x[k];
  return w;
}

}  // namespace

double residual_compliance(const StringConstants& string, double lambda, int count) noexcept {
  if (!(string.tension > 0.0)) return 0.0;
  const double all = lambda * (1.0 - lambda) * string.length / string.tension;
  if (!(string.frequency > 0.0)) return all;
  const ModeSeries series = mode_series(string);
  double modal = 0.0;
  for (int n = 1; n <= count; ++n) {
    const double shape = mode_shape(n, lambda);
    modal += shape * shape / modal_stiffness(string, series.frequency(n));
  }
  return std::max(all - modal, 0.0);
}

ModalTouch touch_modes(const StringConstants& string, double lambda, double D_before,
                       double D_after, double stiffness, int steps, std::int64_t t_ns,
                       std::int64_t dt_ns, ModalString& modes) noexcept {
  Shapes shapes;
  const double reach = prepare(string, lambda, t_ns - dt_ns, modes, shapes);
  // A slack string gives way; a finger out of reach has nothing to step for.
  if (!(string.tension > 0.0) || std::max(D_before, D_after) <= -reach) {
    pass_freely(string, t_ns, dt_ns, modes);
    return {0.0, 0.0, 0.0, 0.0};
  }

  const int count = std::clamp(steps, 1, kMaxSteps);
  const double share = 1.0 / count;
  const double step = static_cast<double>(dt_ns) * kSecondsPerNanosecond * share;
  TouchedModes touched;
  Contact contact{};
  contact.compliance = begin_touch(string, shapes, step, modes, touched);
  contact.stiffness =
      stiffness / (1.0 + stiffness * residual_compliance(string, lambda, modes.count));
  contact.kappa = 0.5 * contact.stiffness * contact.compliance;
  contact.gain = 0.5 * contact.stiffness / (1.0 + contact.kappa);

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

  // Modes with a node at the finger first: they turn freely, then the others are set.
  pass_freely(string, t_ns, dt_ns, modes);
  for (std::size_t k = 0; k < static_cast<std::size_t>(modes.count); ++k) {
    if (std::abs(shapes[k]) >= kNode) end_mode(touched, shapes[k], force, k, modes);
  }
  const double mean = sum * share;
  return {mean, mean * (D_after - D_before), stored_before,
          spring_energy(contact.stiffness, compression)};
}

}  // namespace hapticd
