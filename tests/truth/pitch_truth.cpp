// See pitch_truth.h.
#include "tests/truth/pitch_truth.h"

#include <cmath>
#include <cstddef>
#include <numbers>
#include <vector>

namespace hapticd {
namespace {

using std::numbers::pi;

/// Amplitudes of a triangle: 2 h sin(n pi lambda) / (n^2 pi^2 lambda (1 - lambda)).
std::vector<double> triangle(const GlidingString& string, int modes) {
  const double lambda = string.pluck_lambda;
  std::vector<double> q;
  for (int n = 1; n <= modes; ++n) {
    q.push_back(2.0 * string.pluck_deflection * std::sin(n * pi * lambda) /
                (n * n * pi * pi * lambda * (1.0 - lambda)));
  }
  return q;
}

/// Tension over that at rest.
double tightening(const GlidingString& string, const std::vector<double>& q) {
  double sum = 0.0;
  for (std::size_t k = 0; k < q.size(); ++k) {
    const double slope = static_cast<double>(k + 1) * pi * q[k];
    sum += slope * slope;
  }
  return 1.0 +
         string.axial_stiffness * sum / (4.0 * string.length * string.length * string.tension);
}

}  // namespace

double mean_frequency(const GlidingString& string, double seconds, int modes, int rate) {
  const double dt = 1.0 / rate;
  const double omega = 2.0 * pi * string.frequency;
  const double kept = std::exp(-2.0 * dt / string.decay);
  std::vector<double> q = triangle(string, modes);
  std::vector<double> v(q.size(), 0.0);
  double turned = 0.0;
  double before = 0.0;
  const auto steps = std::lround(seconds * rate);
  for (long step = 0; step < steps; ++step) {
    // Half a drift, a kick with its decay, half a drift: second order in dt.
    for (std::size_t k = 0; k < q.size(); ++k) q[k] += 0.5 * dt * v[k];
    const double pull = omega * omega * tightening(string, q);
    for (std::size_t k = 0; k < q.size(); ++k) {
      const auto n = static_cast<double>(k + 1);
      v[k] = kept * v[k] - dt * n * n * pull * q[k];
      q[k] += 0.5 * dt * v[k];
    }
    const double angle = std::atan2(-v[0] / omega, q[0]);
    turned += std::remainder(angle - before, 2.0 * pi);
    before = angle;
  }
  return turned / (2.0 * pi * seconds);
}

}  // namespace hapticd
