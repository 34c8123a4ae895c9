// Truth: the mean square of a sum of sinusoids; the band, by correlation with sines and cosines.
#include "device/simulated/tremor.h"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

namespace hapticd::test {

TEST_CASE("tremor has the root mean square asked for, all three axes together") {
  for (const std::uint64_t seed : {1U, 2U, 77U}) {
    Tremor tremor(seed, 1e-4, 9.0, 1e-3);
    double sum = 0.0;
    const int count = 60'000;
    for (int i = 0; i < count; ++i) sum += tremor.next().squaredNorm();
    CHECK(std::abs(std::sqrt(sum / count) / 1e-4 - 1.0) < 0.05);
  }
}

TEST_CASE("tremor lies around its centre frequency and nowhere else") {
  Tremor tremor(5, 1.0, 9.0, 1e-3);
  const int count = 20'000;
  std::vector<double> x;
  x.reserve(count);
  for (int i = 0; i < count; ++i) x.push_back(tremor.next().x());
  double inside = 0.0;
  double outside = 0.0;
  // Power at every multiple of 1/20 s^-1 up to 40 Hz.
  for (int k = 1; k <= 800; ++k) {
    const double frequency = k * 0.05;
    double c = 0.0;
    double s = 0.0;
    for (int i = 0; i < count; ++i) {
      const double angle = 2.0 * 3.14159265358979323846 * frequency * i * 1e-3;
      c += x[static_cast<std::size_t>(i)] * std::cos(angle);
      s += x[static_cast<std::size_t>(i)] * std::sin(angle);
    }
    (frequency > 6.9 && frequency < 11.1 ? inside : outside) += c * c + s * s;
  }
  CHECK(outside < 0.02 * inside);
}

TEST_CASE("the same seed gives the same tremor to the bit, another seed another") {
  Tremor a(3, 1e-4, 9.0, 1e-3);
  Tremor b(3, 1e-4, 9.0, 1e-3);
  Tremor c(4, 1e-4, 9.0, 1e-3);
  bool differs = false;
  for (int i = 0; i < 1000; ++i) {
    const Vector3 x = a.next();
    REQUIRE(x == b.next());
    differs = differs || x != c.next();
  }
  CHECK(differs);
}

TEST_CASE("tremor of no amplitude is none") {
  Tremor tremor(1, 0.0, 9.0, 1e-3);
  CHECK(tremor.next() == Vector3::Zero());
  CHECK(Tremor().next() == Vector3::Zero());
}

}  // namespace hapticd::test
