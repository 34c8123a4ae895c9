// The device's clock read on the host's. Truth: the drift and the lateness that the test makes.
#include "device/hid/device_clock.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::test {

TEST_CASE("the time of a sample is right to the least lateness and the drift of a second") {
  for (const double drift : {-1e-4, 0.0, 1e-4}) {
    CAPTURE(drift);
    SplitMix64 random(9);
    hid::ClockMatch match;
    const std::int64_t seconds = std::max<std::int64_t>(3, scaled(200));
    for (std::int64_t k = 0; k < 1000 * seconds; ++k) {
      const double true_ns = 5e9 + 1e6 * static_cast<double>(k);
      const auto device_ns =
          static_cast<std::int64_t>((1.0 + drift) * 1e6 * static_cast<double>(k));
      // Mostly 50 to 100 us late, sometimes by milliseconds.
      const double late_ns = random.uniform(50e3, 100e3) + (random.chance(0.1) ? 3e6 : 0.0);
      const auto arrival_ns = static_cast<std::int64_t>(true_ns + late_ns);
      const std::int64_t seen_ns = hid::host_time(device_ns, arrival_ns, match);
      REQUIRE(seen_ns <= arrival_ns);
      if (k < 100) continue;
      REQUIRE(std::abs(static_cast<double>(seen_ns) - true_ns) < 100e3 + 1e-4 * 1e9 + 1.0);
    }
  }
}

}  // namespace hapticd::test
