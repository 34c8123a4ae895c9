// See axis_response.h.
#include "device/simulated/axis_response.h"

#include <algorithm>
#include <array>

namespace hapticd {
namespace {

/// Damping and stiffness per sub-step (B dt / M and k dt^2 / M) up to which the series is used.
/// Normal value 1; larger would lose digits to cancellation.
constexpr double kResolved = 1.0;
/// Terms of the series: 3^28 / 28! is below the last bit.
constexpr int kTerms = 28;

using Row = std::array<double, 3>;

/// exp(A) of A = [0 1 0; -stiffness -damping 1; 0 0 0], first two rows, by its Taylor series.
std::array<Row, 2> exponential_rows(double stiffness, double damping) noexcept {
  // Columns of A^n / n!, summed. The last column of A feeds the force in.
  std::array<Row, 2> sum{Row{1.0, 0.0, 0.0}, Row{0.0, 1.0, 0.0}};
  std::array<Row, 2> power = sum;
  std::array<double, 3> force_row{0.0, 0.0, 1.0};
  for (int n = 1; n <= kTerms; ++n) {
    std::array<Row, 2> next{};
    for (std::size_t column = 0; column < 3; ++column) {
      const double y = power[0][column];
      const double w = power[1][column];
      next[0][column] = w / n;
      next[1][column] = (force_row[column] - stiffness * y - damping * w) / n;
    }
    force_row = {0.0, 0.0, 0.0};
    power = next;
    for (std::size_t row = 0; row < 2; ++row)
      for (std::size_t column = 0; column < 3; ++column) sum[row][column] += power[row][column];
  }
  return sum;
}

}  // namespace

AxisResponse make_axis_response(const AxisPlant& plant, double dt) noexcept {
  // Without dimension: time in sub-steps, force in mass times length per square of them.
  const double damping = (plant.damping + plant.arm_damping) * dt / plant.mass;
  const double stiffness = plant.stiffness * dt * dt / plant.mass;
  std::array<Row, 2> rows{};
  if (damping <= kResolved && stiffness <= kResolved) {
    rows = exponential_rows(stiffness, damping);
  } else {
    const double divisor = 1.0 + damping + stiffness;
    rows[1] = {-stiffness / divisor, 1.0 / divisor, 1.0 / divisor};
    rows[0] = {1.0 + rows[1][0], rows[1][1], rows[1][2]};
  }
  AxisResponse response;
  response.dt = dt;
  response.damping = plant.damping;
  response.coulomb = plant.coulomb;
  response.y_y = rows[0][0];
  response.y_w = rows[0][1] * dt;
  response.y_f = rows[0][2] * dt * dt / plant.mass;
  response.w_y = rows[1][0] / dt;
  response.w_w = rows[1][1];
  response.w_f = rows[1][2] * dt / plant.mass;
  return response;
}

AxisStep advance_axis(const AxisResponse& response, const AxisState& state, double force) noexcept {
  // Relative to the target the ground moves: its damping is a force besides.
  const double driving = force - response.damping * state.v_target;
  const double w = state.v - state.v_target;
  const double v_free =
      state.v_target + (response.w_y * state.y + response.w_w * w + response.w_f * driving);
  // The friction that would bring it to rest, as far as there is enough.
  const double stopping = -v_free / response.w_f;
  const bool sticks = stopping >= -response.coulomb && stopping <= response.coulomb;
  const double friction = std::clamp(stopping, -response.coulomb, response.coulomb);
  const double y = response.y_y * state.y + response.y_w * w + response.y_f * (driving + friction);
  return {(y - state.y) + state.v_target * response.dt,
          sticks ? 0.0 : v_free + response.w_f * friction};
}

}  // namespace hapticd
