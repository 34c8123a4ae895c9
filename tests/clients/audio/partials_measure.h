// How loud each partial of a sound is, without knowing how it was made: sines that decay are fitted
// to it by least squares. Frequencies and decays are the caller's, amplitudes what comes out.
#pragma once

#include <cmath>
#include <cstddef>
#include <numbers>
#include <span>
#include <utility>
#include <vector>

namespace hapticd::test {

/// A partial as it should be.
struct Sine {
  double frequency_hz = 0.0;
  double decay_s = 1.0;
};

/// The solution of a symmetric positive system, row after row, by Gauss and Jordan.
inline std::vector<double> solved(std::vector<std::vector<double>> rows,
                                  std::vector<double> right) {
  const std::size_t size = right.size();
  for (std::size_t i = 0; i < size; ++i) {
    for (std::size_t k = 0; k < size; ++k) {
      if (k == i) continue;
      const double share = rows[k][i] / rows[i][i];
      for (std::size_t j = i; j < size; ++j) rows[k][j] -= share * rows[i][j];
      right[k] -= share * right[i];
    }
  }
  for (std::size_t i = 0; i < size; ++i) right[i] /= rows[i][i];
  return right;
}

/// Amplitude of each sine at begin_s, from length_s of sound.
inline std::vector<double> amplitudes_in(std::span<const float> sound, double rate_hz,
                                         const std::vector<Sine>& sines, double begin_s,
                                         double length_s) {
  const auto first = static_cast<std::size_t>(std::lround(begin_s * rate_hz));
  const auto count = static_cast<std::size_t>(std::lround(length_s * rate_hz));
  const std::size_t size = 2 * sines.size();
  std::vector<std::vector<double>> squares(size, std::vector<double>(size));
  std::vector<double> right(size);
  std::vector<double> basis(size);
  for (std::size_t i = 0; i < count; ++i) {
    const double t = static_cast<double>(i) / rate_hz;
    for (std::size_t k = 0; k < sines.size(); ++k) {
      const double angle = 2.0 * std::numbers::pi * sines[k].frequency_hz * t;
      const double size_now = std::exp(-t / sines[k].decay_s);
      basis[2 * k] = size_now * std::cos(angle);
      basis[2 * k + 1] = size_now * std::sin(angle);
    }
    const double frame = first + i < sound.size() ? static_cast<double>(sound[first + i]) : 0.0;
    for (std::size_t k = 0; k < size; ++k) {
      right[k] += basis[k] * frame;
      for (std::size_t j = 0; j < size; ++j) squares[k][j] += basis[k] * basis[j];
    }
  }
  const std::vector<double> solution = solved(std::move(squares), std::move(right));
  std::vector<double> amplitudes;
  amplitudes.reserve(sines.size());
  for (std::size_t k = 0; k < sines.size(); ++k) {
    amplitudes.push_back(std::hypot(solution[2 * k], solution[2 * k + 1]));
  }
  return amplitudes;
}

}  // namespace hapticd::test
