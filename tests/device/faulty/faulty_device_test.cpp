// Faults put in front of a device, each against the samples of a second device of the same data
// that nobody spoils. Truth: that device, and the words of kInjectedKinds.
#include "device/faulty/faulty_device.h"

#include <doctest/doctest.h>

#include <cmath>
#include <vector>

#include "device/replay/replay_device.h"
#include "device/simulated/simulated_device.h"
#include "tests/device/api/device_contract.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kMs = 1'000'000;

/// Moves all the time, so that no sample is like another.
std::vector<DeviceSample> moving(int count) {
  std::vector<DeviceSample> samples;
  samples.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    DeviceSample sample;
    sample.t_ns = i * kMs;
    sample.counter = static_cast<std::uint64_t>(i) + 1;
    sample.p_DH = {1e-3 * i, 0.5, -1.0};
    sample.q_DH = {0.5, 0.5, 0.5, 0.5};
    samples.push_back(sample);
  }
  return samples;
}

/// What came in one tick, and what would have come.
struct Tick {
  ReadOutcome outcome;
  DeviceSample came;
  DeviceSample truth;
  bool spoiling;
  bool written;
};

std::vector<Tick> play(InjectedFault fault, std::uint64_t seed, int ticks) {
  const std::vector<DeviceSample> samples = moving(ticks);
  DeviceProfile profile;
  auto replay = std::make_unique<ReplayDevice>(profile);
  ReplayDevice& source = *replay;
  FaultyDevice device(std::move(replay), {fault, seed, kMs});
  std::vector<Tick> all;
  all.reserve(samples.size());
  DeviceSample sample;
  for (int i = 0; i < ticks; ++i) {
    source.put({ReadOutcome::kFresh, samples[static_cast<std::size_t>(i)], true});
    const ReadOutcome outcome = device.read(i * kMs, sample);
    const bool written = device.write(i * kMs, {.enable = true});
    all.push_back(
        {outcome, sample, samples[static_cast<std::size_t>(i)], device.spoiling(), written});
  }
  return all;
}

bool same(const DeviceSample& a, const DeviceSample& b) {
  return a.p_DH == b.p_DH && a.q_DH == b.q_DH && a.counter == b.counter && a.t_ns == b.t_ns;
}

TEST_CASE("what to inject is a kind and a seed; anything else is refused") {
  for (const InjectedKind& kind : kInjectedKinds) {
    const auto injection = parse_injection(std::string(kind.name) + ":77");
    REQUIRE(injection);
    CHECK(injection->fault == kind.fault);
    CHECK(injection->seed == 77);
    CHECK(parse_injection(kind.name)->seed == 1);
  }
  for (const char* bad : {"", ":1", "nan:", "nan:x", "nan:1x", "nan:-1", "NaN:1", "nan 1", "none:1",
                          "nan:99999999999999999999999"}) {
    CAPTURE(bad);
    CHECK_FALSE(parse_injection(bad));
  }
}

TEST_CASE("quiet and fault follow each other within their bounds, equal for equal seeds") {
  const auto lengths = [](std::uint64_t seed) {
    std::vector<std::int64_t> spans{0};
    bool before = false;
    for (const Tick& tick : play(InjectedFault::kNan, seed, 20000)) {
      if (tick.spoiling != before) spans.push_back(0);
      before = tick.spoiling;
      ++spans.back();
    }
    spans.pop_back();
    return spans;
  };
  const std::vector<std::int64_t> spans = lengths(3);
  REQUIRE(spans.size() >= 10);
  for (std::size_t k = 0; k < spans.size(); ++k) {
    const bool fault = k % 2 == 1;
    CHECK(spans[k] * kMs >= (fault ? kFaultFrom_ns : kQuietFrom_ns));
    CHECK(spans[k] * kMs <= (fault ? kFaultTo_ns : kQuietTo_ns) + kMs);
  }
  CHECK(spans == lengths(3));
  CHECK(spans != lengths(4));
}

TEST_CASE("between faults everything passes to the bit, whatever the kind") {
  for (const InjectedKind& kind : kInjectedKinds) {
    if (kind.fault == InjectedFault::kStall || kind.fault == InjectedFault::kLate) continue;
    CAPTURE(kind.name);
    bool spoiled = false;
    for (const Tick& tick : play(kind.fault, 5, 5000)) {
      if (tick.spoiling) spoiled = true;
      if (tick.spoiling) continue;
      CHECK(tick.outcome == ReadOutcome::kFresh);
      CHECK(same(tick.came, tick.truth));
      CHECK(tick.written);
    }
    CHECK(spoiled);
  }
}

TEST_CASE("a spoiled sample is what its kind says, and a command is lost by that kind alone") {
  const auto check = [](InjectedFault fault, const auto& as_said) {
    int spoiled = 0;
    Tick before{};
    for (const Tick& tick : play(fault, 9, 5000)) {
      if (tick.spoiling) {
        ++spoiled;
        CHECK(as_said(tick, before, spoiled));
        CHECK(tick.written == (fault != InjectedFault::kWrite));
      }
      before = tick;
    }
    CHECK(spoiled >= 400);
  };
  using T = const Tick&;
  check(InjectedFault::kLost, [](T now, T, int) { return now.outcome == ReadOutcome::kNothing; });
  check(InjectedFault::kDetach, [](T now, T, int) { return now.outcome == ReadOutcome::kLost; });
  check(InjectedFault::kNan, [](T now, T, int) { return std::isnan(now.came.p_DH[1]); });
  check(InjectedFault::kInf, [](T now, T, int) { return std::isinf(now.came.p_DH[2]); });
  check(InjectedFault::kQuaternion, [](T now, T, int) { return now.came.q_DH == Array4{}; });
  check(InjectedFault::kWrite, [](T now, T, int) { return same(now.came, now.truth); });
  check(InjectedFault::kJump, [](T now, T, int) {
    return now.came.p_DH[0] == now.truth.p_DH[0] + 0.5 && now.came.p_DH[1] == now.truth.p_DH[1];
  });
  check(InjectedFault::kFlip, [](T now, T before, int) {
    return std::abs(now.came.q_DH[0]) == 0.5 && now.came.q_DH[0] == now.came.q_DH[3] &&
           (!before.spoiling || now.came.q_DH[0] == -before.came.q_DH[0]);
  });
  check(InjectedFault::kFrozen, [](T now, T before, int) {
    return now.came.p_DH == before.came.p_DH && now.came.counter == now.truth.counter;
  });
}

TEST_CASE("delayed samples are the true ones of 30 reads before, after 30 reads of nothing") {
  int into = 0;
  for (const Tick& tick : play(InjectedFault::kDelay, 2, 8000)) {
    into = tick.spoiling ? into + 1 : 0;
    if (into == 0) continue;
    CHECK(tick.outcome == (into <= 30 ? ReadOutcome::kNothing : ReadOutcome::kFresh));
    if (into > 30) CHECK(tick.came.counter == tick.truth.counter - 30);
  }
}

TEST_CASE("in quiet it keeps the contract of devices") {
  DeviceProfile profile;
  profile.name = {'f'};
  FaultyDevice device(std::make_unique<SimulatedDevice>(profile, SimulatedOptions{}), {});
  check_device_contract(device, virtual_ticks(kMs), 200);
}

}  // namespace
}  // namespace hapticd::test
