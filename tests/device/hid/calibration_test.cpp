// A device's own calibration, asked for and followed. Truth: the reference firmware's own state.
#include "device/hid/calibration.h"

#include <doctest/doctest.h>

#include <stdexcept>

#include "tests/device/hid/firmware_bench.h"

namespace hapticd::test {
namespace {

constexpr std::int64_t kLook_ns = 100'000'000;

/// A device that needs calibration, as who keeps it attached speaks to it.
class Calibrated {
 public:
  Calibrated() { calibration.begin(channel()); }
  ReportChannel channel() { return {nullptr, this, nullptr, nullptr, get, set}; }
  void tend(std::int64_t later_ns = 0) {
    now_ns_ += later_ns;
    calibration.tend(
        [this] {
          if (!opens) throw std::runtime_error("it cannot be opened");
          return channel();
        },
        now_ns_);
  }
  CalibrationPhase phase() { return calibration.status().phase; }

  Bench bench{kHapNeedsCalibration};
  hid::DeviceCalibration calibration{true};
  bool opens = true;
  int calls = 0;

 private:
  static int get(void* self, std::uint8_t* bytes, std::size_t room) noexcept {
    auto& device = *static_cast<Calibrated*>(self);
    ++device.calls;
    const auto length =
        hap_get_feature(&device.bench.device, bytes[0], bytes, static_cast<std::uint32_t>(room));
    return length == 0 ? -1 : static_cast<int>(length);
  }
  static int set(void* self, const std::uint8_t* bytes, std::size_t length) noexcept {
    auto& device = *static_cast<Calibrated*>(self);
    const bool taken = hap_receive(&device.bench.device, device.bench.now_us, bytes,
                                   static_cast<std::uint32_t>(length));
    return taken ? static_cast<int>(length) : -1;
  }

  std::int64_t now_ns_ = 0;
};

}  // namespace

TEST_CASE("a calibration is begun, followed ten times a second to its end, and stored") {
  Calibrated run;
  CHECK(run.phase() == CalibrationPhase::kNeeded);
  REQUIRE(run.calibration.ask(CalibrationStep::kStart));
  CHECK_FALSE(run.calibration.take_answer().has_value());
  run.tend();
  CHECK(run.calibration.take_answer() == "");
  CHECK_FALSE(run.calibration.take_answer().has_value());
  CHECK(run.phase() == CalibrationPhase::kRunning);
  hap_calibration_progress(&run.bench.device, 40);
  run.tend(kLook_ns - 1);
  CHECK(run.calibration.status().progress == 0.0);
  run.tend(1);
  CHECK(run.calibration.status().progress == doctest::Approx(0.4));
  hap_calibration_end(&run.bench.device, true);
  run.tend(kLook_ns);
  CHECK(run.phase() == CalibrationPhase::kDone);
  CHECK(run.calibration.status().progress == 1.0);
  REQUIRE(run.calibration.ask(CalibrationStep::kStore));
  run.tend(kLook_ns);
  CHECK(run.calibration.take_answer() == "");
  std::uint16_t axes = 0;
  CHECK(hap_take_calibration(&run.bench.device, &axes) == kHapStore);
}

TEST_CASE("a device that is left alone is not spoken to") {
  Calibrated run;
  const int calls = run.calls;
  for (int k = 0; k < 50; ++k) run.tend(kLook_ns);
  CHECK(run.calls == calls);
}

TEST_CASE("what the device refuses is told, and the next request goes through") {
  Calibrated run;
  REQUIRE(run.calibration.ask(CalibrationStep::kStore));
  CHECK_FALSE(run.calibration.ask(CalibrationStep::kZero));
  run.tend();
  CHECK_FALSE(run.calibration.ask(CalibrationStep::kZero));
  CHECK(run.calibration.take_answer() != "");
  REQUIRE(run.calibration.ask(CalibrationStep::kZero));
  run.tend();
  CHECK(run.calibration.take_answer() == "");
  CHECK(run.phase() == CalibrationPhase::kDone);
}

TEST_CASE("aborted and failed calibrations are told apart") {
  Calibrated run;
  REQUIRE(run.calibration.ask(CalibrationStep::kStart));
  run.tend();
  REQUIRE(run.calibration.take_answer() == "");
  REQUIRE(run.calibration.ask(CalibrationStep::kAbort));
  run.tend();
  REQUIRE(run.calibration.take_answer() == "");
  CHECK(run.phase() == CalibrationPhase::kNeeded);
  REQUIRE(run.calibration.ask(CalibrationStep::kStart));
  run.tend();
  hap_calibration_end(&run.bench.device, false);
  run.tend(kLook_ns);
  CHECK(run.phase() == CalibrationPhase::kFailed);
}

TEST_CASE("unplugged it answers what was asked, and what is asked then") {
  Calibrated run;
  REQUIRE(run.calibration.ask(CalibrationStep::kStart));
  run.calibration.end();
  CHECK(run.calibration.take_answer() == "it is unplugged");
  REQUIRE(run.calibration.ask(CalibrationStep::kStart));
  CHECK(run.calibration.take_answer() == "it is unplugged");
  CHECK(run.phase() == CalibrationPhase::kUnknown);
  run.calibration.begin(run.channel());
  CHECK(run.phase() == CalibrationPhase::kNeeded);
  run.opens = false;
  REQUIRE(run.calibration.ask(CalibrationStep::kStart));
  run.tend();
  CHECK(run.calibration.take_answer() == "it cannot be opened");
}

}  // namespace hapticd::test
