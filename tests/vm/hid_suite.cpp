// The HID driver against a device that the kernel believes in: runs in a guest, where time is
// exact. Truth: the device's own firmware, which counts what it was told, and the profile.
#include <doctest/doctest.h>
#include <pthread.h>
#include <time.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/rt/monotonic_clock.h"
#include "device/hid/device_features.h"
#include "device/hid/hid_device.h"
#include "server/haptic_loop/tick_pace.h"
#include "tests/vm/attached_loop.h"
#include "tests/vm/uhid_device.h"

namespace hapticd::test {
namespace {

/// What reading a sample and handing on a command may cost the loop, in instructions, those of the
/// kernel among them: one takes one nanosecond here. 6881 measured with gcc 12; the cheapest system
/// call more is beyond this.
constexpr std::int64_t kLoopBudget = 7'600;
/// The same for the writer's thread, from its waking to its sleep, with the kernel's way to uhid.
/// 15494 measured.
constexpr double kWriterBudget = 17'000.0;

/// Processor time of a thread, ns.
std::int64_t cpu_ns(std::thread& thread) {
  clockid_t clock{};
  REQUIRE(pthread_getcpuclockid(thread.native_handle(), &clock) == 0);
  timespec used{};
  REQUIRE(clock_gettime(clock, &used) == 0);
  return std::int64_t{used.tv_sec} * 1'000'000'000 + used.tv_nsec;
}

/// Ages of samples when they are read, by the device's own instant of the sample, us.
struct Ages {
  double median = 0.0;
  double most = 0.0;
};

Ages ages_of(std::vector<std::int64_t> ages) {
  std::sort(ages.begin(), ages.end());
  if (ages.empty()) return {};
  return {1e-3 * static_cast<double>(ages[ages.size() / 2]),
          1e-3 * static_cast<double>(ages.back())};
}

/// Ticks by the timer or the device; ages of the fresh samples, ns. Each tick has one, or `without`
/// counts it.
std::vector<std::int64_t> run_paced(const UhidDevice& plugged, AttachedLoop& loop, TickPace& pace,
                                    int ticks, int& without) {
  std::vector<std::int64_t> ages;
  ages.reserve(static_cast<std::size_t>(ticks));
  without = 0;
  for (int k = 0; k < ticks; ++k) {
    (void)pace.wait();
    if (loop.tick(0.2, true) == ReadOutcome::kFresh) {
      ages.push_back(monotonic_now_ns() - plugged.sampled_ns());
    } else {
      ++without;
    }
  }
  return ages;
}

TickPace paced_by(const PaceSource& source) { return {1'000'000, source, monotonic_pace_clock()}; }

/// Ages with ticks of the timer: where they lie in a frame of the device is chance, so they are
/// put at ten places.
Ages run_by_timer(const UhidDevice& plugged, AttachedLoop& loop) {
  std::vector<std::int64_t> ages;
  for (std::int64_t place = 0; place < 10; ++place) {
    sleep_until(plugged.sampled_ns() + 2'000'000 + place * 100'000);
    TickPace timer = paced_by({});
    int without = 0;
    const auto here = run_paced(plugged, loop, timer, 200, without);
    ages.insert(ages.end(), here.begin(), here.end());
  }
  return ages_of(std::move(ages));
}

}  // namespace

TEST_CASE("ten seconds at 1 kHz lose no sample and use none that is old") {
  UhidDevice plugged(UhidOptions{});
  AttachedLoop loop;
  loop.run(50);
  const hid::HidCounters before = loop.device->counters();
  const std::int64_t writer_ns = cpu_ns(loop.device->writer().thread());
  const int fresh = loop.run(10'000, 0.5, true);
  const double written =
      1e-4 * static_cast<double>(cpu_ns(loop.device->writer().thread()) - writer_ns);
  const hid::HidCounters after = loop.device->counters();
  CHECK(fresh >= 9'990);
  CHECK(after.lost == before.lost);
  CHECK(after.too_old == 0);
  CHECK(after.overflows == 0);
  CHECK(after.malformed == 0);
  CHECK((plugged.status() & kHapEnabled) != 0);
  CHECK(plugged.output().force_un[1] == 500'000);
  std::sort(loop.ages.begin(), loop.ages.end());
  std::printf("age us: p50 %.0f max %.0f; delay %.0f us; fresh %d\n",
              1e-3 * static_cast<double>(loop.ages[loop.ages.size() / 2]),
              1e-3 * static_cast<double>(loop.ages.back()), 1e6 * loop.sample.measured_delay_s,
              fresh);
  std::sort(loop.costs.begin(), loop.costs.end());
  std::printf("instructions of a tick: p50 %lld p99 %lld max %lld\n",
              static_cast<long long>(loop.costs[loop.costs.size() / 2]),
              static_cast<long long>(loop.costs[loop.costs.size() * 99 / 100]),
              static_cast<long long>(loop.costs.back()));
  CHECK(loop.costs[loop.costs.size() * 99 / 100] <= kLoopBudget);
  std::printf("instructions of the writer per command: %.0f\n", written);
  CHECK(written <= kWriterBudget);
  CHECK(loop.sample.measured_delay_s > 0.0);
  CHECK(loop.sample.measured_delay_s < 2e-3);
}

TEST_CASE("after a pause of 100 ms nothing that was queued is used, and the next sample is live") {
  UhidDevice plugged(UhidOptions{});
  AttachedLoop loop;
  loop.run(50);
  sleep_ms(100);
  CHECK(loop.tick(0.0, false) == ReadOutcome::kNothing);
  CHECK(loop.device->counters().overflows == 1);
  sleep_ms(2);
  CHECK(loop.tick(0.0, false) == ReadOutcome::kFresh);
  CHECK(monotonic_now_ns() - loop.sample.t_ns < hid::oldest_sample_ns(1000));
}

TEST_CASE("8000 reports a second are read by a loop of 1 kHz, always the newest") {
  UhidOptions options;
  options.rate_hz = 8000;
  UhidDevice plugged(options);
  AttachedLoop loop;
  loop.run(50);
  const auto before = loop.device->counters();
  CHECK(loop.run(2000) >= 1990);
  const auto after = loop.device->counters();
  CHECK(after.lost == before.lost);
  CHECK(after.superseded - before.superseded > 13'000);
  CHECK(after.overflows == 0);
}

TEST_CASE("a loop that stops is a device without force within its watchdog, and clearing resumes") {
  UhidDevice plugged(UhidOptions{});
  AttachedLoop loop;
  loop.run(100, 0.5, true);
  REQUIRE((plugged.status() & kHapEnabled) != 0);
  sleep_ms(30);
  CHECK((plugged.status() & kHapWatchdog) != 0);
  CHECK((plugged.status() & kHapEnabled) == 0);
  CHECK(plugged.since_force_us() > 5000);
  loop.run(20, 0.5, true);
  CHECK((plugged.status() & kHapEnabled) == 0);
}

TEST_CASE("a device that falls silent gives nothing new, and goes on when it speaks again") {
  UhidDevice plugged(UhidOptions{});
  AttachedLoop loop;
  loop.run(50);
  UhidFaults faults;
  faults.silent = true;
  plugged.set(faults);
  loop.run(2);
  CHECK(loop.run(50) == 0);
  plugged.set(UhidFaults{});
  loop.run(2);
  CHECK(loop.run(50) >= 49);
}

TEST_CASE("unplugged it is lost at once; under a new node it is found by its serial and goes on") {
  std::optional<UhidDevice> plugged;
  plugged.emplace(UhidOptions{});
  AttachedLoop loop;
  loop.run(50, 0.5, true);
  plugged.reset();
  sleep_ms(1);
  loop.tick(0.5, true);
  loop.tick(0.5, true);
  CHECK(loop.outcome == ReadOutcome::kLost);
  CHECK(loop.device->failed());
  plugged.emplace(UhidOptions{});
  loop.device->detach();
  const std::string old_path = loop.node.path;
  loop.open("A1");
  std::printf("was %s, is %s\n", old_path.c_str(), loop.node.path.c_str());
  loop.device->attach(loop.handles->channel());
  const std::uint64_t counter = loop.sample.counter;
  CHECK(loop.run(50) >= 48);
  CHECK(loop.sample.counter > counter);
}

TEST_CASE(
    "paced by the device every report is used in the tick it begins, fresher than by the timer") {
  for (const int rate_hz : {1000, 8000}) {
    UhidOptions options;
    options.rate_hz = rate_hz;
    UhidDevice plugged(options);
    AttachedLoop loop;
    int without = 0;
    const Ages by_timer = run_by_timer(plugged, loop);
    TickPace pace = paced_by(loop.device->pace());
    run_paced(plugged, loop, pace, 20, without);
    const hid::HidCounters before = loop.device->counters();
    const std::uint64_t held_up_before = plugged.held_up();
    const std::int64_t begun_ns = monotonic_now_ns();
    const Ages ages = ages_of(run_paced(plugged, loop, pace, 10'000, without));
    const double seconds = 1e-9 * static_cast<double>(monotonic_now_ns() - begun_ns);
    const hid::HidCounters after = loop.device->counters();
    const std::uint64_t held_up = plugged.held_up() - held_up_before;
    const std::uint64_t superseded = after.superseded - before.superseded;
    std::printf(
        "%d Hz: age us by the timer p50 %.0f max %.0f, by the device p50 %.0f max %.0f; %.4f s; "
        "%llu superseded, %llu frames held up\n",
        rate_hz, by_timer.median, by_timer.most, ages.median, ages.most, seconds,
        static_cast<unsigned long long>(superseded), static_cast<unsigned long long>(held_up));
    CHECK(without == 0);
    CHECK(after.samples - before.samples == 10'000);
    CHECK(after.lost == before.lost);
    if (rate_hz == 1000) CHECK(superseded <= held_up);
    CHECK(std::abs(seconds - 10.0) < 0.01);
    CHECK(ages.median <= (rate_hz == 1000 ? by_timer.median : 125.0));
    CHECK(ages.most <= (rate_hz == 1000 ? by_timer.most : 125.0));
    CHECK((plugged.status() & kHapEnabled) != 0);
  }
}

TEST_CASE("unplugged it leaves the loop the timer's ticks, and paces it again under its new node") {
  std::optional<UhidDevice> plugged;
  plugged.emplace(UhidOptions{});
  AttachedLoop loop;
  TickPace pace = paced_by(loop.device->pace());
  int without = 0;
  run_paced(*plugged, loop, pace, 200, without);
  plugged.reset();
  const std::int64_t begun_ns = monotonic_now_ns();
  for (int k = 0; k < 100; ++k) {
    (void)pace.wait();
    loop.tick(0.2, true);
  }
  CHECK(std::abs(monotonic_now_ns() - begun_ns - 100'000'000) < 2'000'000);
  CHECK(loop.device->failed());
  plugged.emplace(UhidOptions{});
  loop.reopen("A1");
  run_paced(*plugged, loop, pace, 50, without);
  const Ages ages = ages_of(run_paced(*plugged, loop, pace, 500, without));
  CHECK(without == 0);
  CHECK(ages.most < 100.0);
}

TEST_CASE("of two devices each is found by its serial") {
  UhidOptions other;
  other.serial = "B2";
  UhidDevice a(UhidOptions{});
  UhidDevice b(other);
  appears("A1");
  appears("B2");
  CHECK(find_devices().size() == 2);
  AttachedLoop loop("B2");
  loop.run(20);
  CHECK(b.commands() >= 19);
  CHECK(a.commands() == 0);
}

TEST_CASE("a device in use is refused to a second one, with the reason") {
  UhidDevice plugged(UhidOptions{});
  AttachedLoop loop;
  CHECK_THROWS_WITH_AS(HidrawHandles{loop.node}, doctest::Contains("another hapticd uses it"),
                       DeviceError);
}

TEST_CASE("what has another magic or major version is refused") {
  for (const bool magic : {true, false}) {
    CAPTURE(magic);
    UhidOptions options;
    if (magic) options.magic = 0x12345678;
    if (!magic) options.version = 2;
    UhidDevice plugged(options);
    HidrawHandles handles(appears("A1"));
    hid::Capabilities capabilities;
    std::string error;
    CHECK_FALSE(get_capabilities(handles.channel(), capabilities, error));
    CHECK(error.find(magic ? "magic" : "version") != std::string::npos);
  }
}

TEST_CASE("seq and the clock may wrap while it runs") {
  UhidOptions options;
  options.begin_us = 0U - 200'000U;
  options.begin_seq = 65'400;
  UhidDevice plugged(options);
  AttachedLoop loop;
  loop.run(50);
  const auto before = loop.device->counters();
  CHECK(loop.run(500, 0.2, true) >= 499);
  CHECK(loop.device->counters().lost == before.lost);
  CHECK(loop.device->counters().too_old == 0);
  CHECK((plugged.status() & kHapEnabled) != 0);
}

}  // namespace hapticd::test
