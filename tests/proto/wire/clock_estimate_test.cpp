// The clock estimate against clocks whose offset and skew are known. PROTOCOL.md, section 7.
#include "proto/wire/clock_estimate.h"

#include <doctest/doctest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/support/random.h"
#include "tests/support/scale.h"

namespace hapticd::wire {
namespace {

constexpr std::int64_t kSecond_ns = 1'000'000'000;

/// Two clocks: server = own + offset + skew own.
struct Clocks {
  std::int64_t offset_ns = 0;
  double skew = 0.0;

  [[nodiscard]] std::int64_t server(std::int64_t own_ns) const {
    return own_ns + offset_ns + std::llround(skew * static_cast<double>(own_ns));
  }
  [[nodiscard]] std::int64_t true_offset(std::int64_t own_ns) const {
    return server(own_ns) - own_ns;
  }
  /// An exchange that begins at own_ns; the server keeps the Clock 500 us.
  [[nodiscard]] ClockSample exchange(std::int64_t own_ns, std::int64_t out_ns,
                                     std::int64_t back_ns) const {
    v1::Clock clock;
    clock.set_echoed_ns(static_cast<std::uint64_t>(own_ns));
    clock.set_received_ns(static_cast<std::uint64_t>(server(own_ns + out_ns)));
    clock.set_sent_ns(static_cast<std::uint64_t>(server(own_ns + out_ns + 500'000)));
    const auto sample = clock_sample(clock, own_ns + out_ns + 500'000 + back_ns);
    REQUIRE(sample.has_value());
    return *sample;
  }
};

TEST_CASE("the offset is that of the exchange with the smallest round trip of the last eight") {
  const Clocks clocks{5 * kSecond_ns, 0.0};
  ClockEstimate estimate;
  CHECK(!estimate.known());
  estimate.add(clocks.exchange(kSecond_ns, 9'000'000, 1'000'000));
  CHECK(estimate.at(kSecond_ns).offset_ns == 5 * kSecond_ns + 4'000'000);
  CHECK(estimate.round_trip_ns() == 10'000'000);
  estimate.add(clocks.exchange(2 * kSecond_ns, 100'000, 100'000));
  CHECK(estimate.at(2 * kSecond_ns).offset_ns == 5 * kSecond_ns);
  for (int i = 0; i < 7; ++i) {
    estimate.add(clocks.exchange((3 + i) * kSecond_ns, 300'000, 500'000));
    CHECK(estimate.at((3 + i) * kSecond_ns).offset_ns == 5 * kSecond_ns);
  }
  // The ninth: the best one is out of the eight.
  estimate.add(clocks.exchange(10 * kSecond_ns, 300'000, 500'000));
  CHECK(estimate.at(10 * kSecond_ns).offset_ns == 5 * kSecond_ns - 100'000);
}

TEST_CASE("the true offset is always within the uncertainty, at skews of 200 ppm") {
  test::SplitMix64 random(8);
  for (std::int64_t trial = test::scaled(300); trial > 0; --trial) {
    const Clocks clocks{static_cast<std::int64_t>(random.below(1'000'000'000'000)),
                        random.uniform(-200e-6, 200e-6)};
    ClockEstimate estimate;
    std::int64_t now_ns = kSecond_ns;
    for (int i = 0; i < 200; ++i) {
      const auto out = static_cast<std::int64_t>(random.below(3'000'000)) + 50'000;
      const auto back = static_cast<std::int64_t>(random.below(3'000'000)) + 50'000;
      estimate.add(clocks.exchange(now_ns, out, back));
      now_ns += 250'000'000;
      const ClockRelation relation = estimate.at(now_ns);
      const std::int64_t error = relation.offset_ns - clocks.true_offset(now_ns);
      CHECK(std::abs(error) <= relation.uncertainty_ns);
    }
    // 50 s of exchanges with up to 3 ms of jitter each way.
    const ClockRelation relation = estimate.at(now_ns);
    CHECK(std::fabs(relation.skew - clocks.skew) < 50e-6);
    CHECK(relation.uncertainty_ns < 3'000'000);
  }
}

TEST_CASE("no skew is claimed before five seconds have been seen") {
  const Clocks clocks{0, 200e-6};
  ClockEstimate estimate;
  for (int i = 0; i < 16; ++i) {
    estimate.add(clocks.exchange(kSecond_ns + i * std::int64_t{100'000'000}, 100'000, 100'000));
  }
  CHECK(estimate.at(3 * kSecond_ns).skew == 0.0);
}

TEST_CASE("the estimate is that of every case that the clients share") {
  std::ifstream file(HAPTICD_SOURCE_DIR "/tests/protocol/data/clock_cases.json");
  const nlohmann::json cases = nlohmann::json::parse(file);
  CHECK(cases.size() > 8);
  for (const nlohmann::json& each : cases) {
    CAPTURE(each["behaviour"].get<std::string>());
    ClockEstimate estimate;
    for (const nlohmann::json& exchange : each["exchanges"]) {
      v1::Clock clock;
      clock.set_echoed_ns(exchange[0]);
      clock.set_received_ns(exchange[1]);
      clock.set_sent_ns(exchange[2]);
      if (const auto sample = clock_sample(clock, exchange[3])) estimate.add(*sample);
    }
    CHECK(estimate.known() == each.contains("offset_ns"));
    if (!estimate.known()) continue;
    const ClockRelation relation = estimate.at(each["now_ns"]);
    CHECK(std::abs(relation.offset_ns - each["offset_ns"].get<std::int64_t>()) <=
          each["offset_error_ns"].get<std::int64_t>());
    CHECK(std::fabs(relation.skew - each["skew"].get<double>()) <=
          each["skew_error"].get<double>());
  }
}

}  // namespace
}  // namespace hapticd::wire
