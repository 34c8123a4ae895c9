// hapticd with a device that the kernel believes in, and a client: runs in a guest. Truth: what the
// device's own firmware was told and gave.
#include <doctest/doctest.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "clients/library/client.h"
#include "clients/library/controller.h"
#include "tests/support/within.h"
#include "tests/vm/uhid_device.h"

namespace hapticd::test {
namespace {

using client::Client;
using client::Controller;

constexpr double kPi = 3.14159265358979323846;
/// The fingertip touches the string when its centre is at this height, m.
constexpr double kTouching = 0.00534;

/// A hapticd of its own; killed at the end.
class Played {
 public:
  explicit Played(const std::string& serial = "A1", const std::string& pace = "timer") {
    start({"--scene=single_string", "--device=hid:" + serial, "--pace=" + pace});
  }
  explicit Played(std::vector<std::string> options) { start(std::move(options)); }
  ~Played() { end(SIGKILL); }
  Played(const Played&) = delete;
  Played& operator=(const Played&) = delete;

  void end(int how) {
    if (pid_ <= 0) return;
    kill(pid_, how);
    int status = 0;
    waitpid(pid_, &status, 0);
    pid_ = 0;
  }

 private:
  void start(std::vector<std::string> options) {
    options.insert(options.begin(), "hapticd");
    std::vector<char*> arguments;
    arguments.reserve(options.size() + 1);
    for (std::string& option : options) arguments.push_back(option.data());
    arguments.push_back(nullptr);
    std::string data = "HAPTICD_DATA=/share/hapticd";
    std::string state = "XDG_STATE_HOME=/tmp";
    char* environment[] = {data.data(), state.data(), nullptr};
    REQUIRE(posix_spawn(&pid_, "/bin/hapticd", nullptr, nullptr, arguments.data(), environment) ==
            0);
  }

  pid_t pid_ = 0;
};

/// A client in control.
struct Session {
  Session() : client("127.0.0.1", client::kDefaultPort, handlers()), controller(client) {
    REQUIRE(client.connect(std::chrono::seconds(20)));
    client.subscribe(10);
    REQUIRE(controller.acquire("test").code() == v1::RESULT_CODE_OK);
  }
  client::ClientHandlers handlers() {
    client::ClientHandlers made;
    made.item = [this](const v1::Item& item) {
      ++kinds[item.body_case()];
      if (item.has_fault() && item.fault().latched()) cause = item.fault().cause();
    };
    return made;
  }
  bool becomes(v1::LoopState wanted) {
    return client.poll_until(
        [&] { return client.state() && client.state()->loop_state() == wanted; });
  }
  v1::ResultCode ask(const v1::Item& item) { return controller.call(item).code(); }
  bool engage() {
    v1::Item item;
    item.mutable_engage();
    return becomes(v1::LOOP_STATE_READY) && ask(item) == v1::RESULT_CODE_OK &&
           becomes(v1::LOOP_STATE_ENGAGED);
  }
  v1::Result calibrate(v1::CalibrateStep step, v1::Axis axis = v1::AXIS_UNSPECIFIED) {
    v1::Item item;
    item.mutable_calibrate()->set_step(step);
    item.mutable_calibrate()->set_axis(axis);
    return controller.call(item);
  }
  v1::DeviceInfo device() {
    v1::Item item;
    item.mutable_get_device_info();
    const v1::Result result = controller.call(item);
    REQUIRE(result.devices().devices_size() == 1);
    return result.devices().devices(0);
  }
  v1::ResultCode clear() {
    v1::Item item;
    item.mutable_clear();
    return ask(item);
  }
  void play(double seconds) {
    client.poll_until([] { return false; }, std::chrono::milliseconds(std::lround(1e3 * seconds)));
  }

  std::map<int, int> kinds;
  v1::Cause cause = v1::CAUSE_UNSPECIFIED;
  Client client;
  Controller controller;
};

/// Where the handle is: above the string until `lower` says otherwise, then pressed on it, drawn
/// aside until the string slips, and back, once a second.
struct Hand {
  std::atomic<bool> lower{false};
  std::atomic<bool> hold{false};  ///< stays on the string
  double begun_s = -1.0;
  double press = 0.003;  ///< so far beyond the touch, m

  Motion motion() {
    return [this](double t_s, const HapOutput&) -> std::array<double, 3> {
      const double rest = 0.01534;
      // No hand is quite still: a sensor that seems so under force is a broken one.
      if (!lower) return {1e-6 * std::sin(20.0 * kPi * t_s), rest, 0.0};
      if (begun_s < 0.0) begun_s = t_s;
      const double t = hold ? std::min(t_s - begun_s, 0.3) : std::fmod(t_s - begun_s, 1.0);
      const double deep = rest - kTouching + press;
      if (t < 0.3) return {0.0, rest - 0.5 * deep * (1.0 - std::cos(kPi * t / 0.3)), 0.0};
      const double aside = 0.5 * 0.02 * (1.0 - std::cos(kPi * std::min(1.0, (t - 0.3) / 0.4)));
      if (t < 0.7) return {0.0, rest - deep, aside};
      const double back = (t - 0.7) / 0.3;
      return {0.0, rest - deep * (1.0 - back), 0.02 * (1.0 - back)};
    };
  }
};

double force_of(const HapOutput& output) {
  double sum = 0.0;
  for (const std::int32_t f : output.force_un) sum += std::pow(1e-6 * f, 2);
  return std::sqrt(sum);
}

}  // namespace

TEST_CASE("a string is played through a HID device: a client sees contact, radius and tone") {
  Hand hand;
  UhidDevice plugged(UhidOptions{}, hand.motion());
  Played daemon;
  Session session;
  REQUIRE(session.engage());
  hand.lower = true;
  double most = 0.0;
  for (int k = 0; k < 12; ++k) {
    session.play(0.1);
    most = std::max(most, force_of(plugged.output()));
  }
  CHECK(session.kinds[v1::Item::kContact] >= 2);
  CHECK(session.kinds[v1::Item::kStringRadius] >= 1);
  CHECK(session.kinds[v1::Item::kTone] >= 1);
  CHECK(session.kinds[v1::Item::kFault] == 0);
  CHECK(most > 0.05);
  CHECK(most <= 0.3001);
}

TEST_CASE(
    "a device that offers it renders the string's stiffness by itself where its profile asks") {
  Hand hand;
  UhidDevice plugged(UhidOptions{}, hand.motion());
  std::ofstream("/tmp/affine.textproto") << "name: 'affine' driver: DRIVER_HID affine: true\n"
                                            "damping_n_s_per_m { value: 0 source: 'the test' }\n"
                                            "peak_force_n { value: 20 source: 'the test' }\n"
                                            "peak_torque_n_m { value: 1 source: 'the test' }\n";
  std::ofstream("/tmp/config.textproto")
      << "scene: 'single_string' device { source: 'hid:A1' profile: '/tmp/affine.textproto' }\n";
  Played daemon(std::vector<std::string>{"--config=/tmp/config.textproto"});
  Session session;
  REQUIRE(session.engage());
  CHECK(plugged.springs() == 0);
  hand.lower = true;
  int shown = 0;
  for (int k = 0; k < 12; ++k) {
    session.play(0.1);
    for (const int flag : session.client.state()->tools(0).flags()) {
      shown += flag == v1::TOOL_FLAG_DEVICE_SPRING ? 1 : 0;
    }
    CHECK(force_of(plugged.output()) <= 0.3001);
  }
  CHECK(plugged.springs() > 100);
  CHECK(shown > 0);
  CHECK(session.kinds[v1::Item::kTone] >= 1);
  CHECK(session.kinds[v1::Item::kFault] == 0);
}

TEST_CASE("paced by the device it plays on, and unplugged it is a fault until Clear and Engage") {
  Hand hand;
  std::optional<UhidDevice> plugged;
  plugged.emplace(UhidOptions{}, hand.motion());
  Played daemon("A1", "device");
  Session session;
  REQUIRE(session.engage());
  hand.lower = true;
  session.play(1.2);
  CHECK(session.kinds[v1::Item::kContact] >= 1);
  CHECK(session.kinds[v1::Item::kFault] == 0);
  plugged.reset();
  CHECK(session.becomes(v1::LOOP_STATE_FAULT));
  CHECK(session.cause == v1::CAUSE_DEVICE_LOST);
  hand.lower = false;
  hand.begun_s = -1.0;
  plugged.emplace(UhidOptions{}, hand.motion());
  session.play(1.0);
  CHECK(session.clear() == v1::RESULT_CODE_OK);
  CHECK(session.engage());
  hand.lower = true;
  session.play(0.4);
  CHECK(force_of(plugged->output()) > 0.05);
}

TEST_CASE("unplugged on the string it is a fault; force returns only after Clear and Engage") {
  Hand hand;
  std::optional<UhidDevice> plugged;
  plugged.emplace(UhidOptions{}, hand.motion());
  Played daemon;
  Session session;
  REQUIRE(session.engage());
  hand.hold = true;
  hand.lower = true;
  session.play(0.5);
  CHECK(force_of(plugged->output()) > 0.05);
  plugged.reset();
  CHECK(session.becomes(v1::LOOP_STATE_FAULT));
  CHECK(session.cause == v1::CAUSE_DEVICE_LOST);
  CHECK(session.clear() != v1::RESULT_CODE_OK);
  hand.lower = false;
  hand.begun_s = -1.0;
  plugged.emplace(UhidOptions{}, hand.motion());
  session.play(1.0);
  CHECK((plugged->status() & kHapEnabled) == 0);
  CHECK(session.client.state()->loop_state() == v1::LOOP_STATE_FAULT);
  CHECK(session.clear() == v1::RESULT_CODE_OK);
  session.play(0.2);
  CHECK((plugged->status() & kHapEnabled) == 0);
  CHECK(session.engage());
  hand.lower = true;
  session.play(0.5);
  CHECK(force_of(plugged->output()) > 0.05);
}

TEST_CASE("a daemon that is killed leaves a device without force; the next one clears its latch") {
  Hand hand;
  UhidDevice plugged(UhidOptions{}, hand.motion());
  {
    Played daemon;
    Session session;
    REQUIRE(session.engage());
    hand.hold = true;
    hand.lower = true;
    session.play(0.5);
    CHECK(force_of(plugged.output()) > 0.05);
    daemon.end(SIGKILL);
    session.play(0.05);
    CHECK(force_of(plugged.output()) == 0.0);
    CHECK((plugged.status() & kHapWatchdog) != 0);
  }
  hand.lower = false;
  hand.begun_s = -1.0;
  Played daemon;
  Session session;
  CHECK(session.becomes(v1::LOOP_STATE_FAULT));
  CHECK(session.clear() == v1::RESULT_CODE_OK);
  CHECK(session.becomes(v1::LOOP_STATE_READY));
  CHECK((plugged.status() & kHapWatchdog) == 0);
}

namespace {

constexpr std::array<v1::Axis, 6> kDirections{v1::AXIS_POSITIVE_X, v1::AXIS_NEGATIVE_X,
                                              v1::AXIS_POSITIVE_Y, v1::AXIS_NEGATIVE_Y,
                                              v1::AXIS_POSITIVE_Z, v1::AXIS_NEGATIVE_Z};

/// The force along a direction that the motors give, N.
double along(const HapOutput& output, v1::Axis axis) {
  const int raw_axis = (axis - 1) / 2;
  return (axis % 2 == 1 ? 1e-6 : -1e-6) * output.force_un[raw_axis];
}

/// Pushes, and looks at the motors until it is over.
void push(Session& session, const UhidDevice& plugged, v1::Axis axis) {
  REQUIRE(session.calibrate(v1::CALIBRATE_STEP_PUSH, axis).code() == v1::RESULT_CODE_OK);
  double most = 0.0;
  for (int k = 0; k < 60; ++k) {
    session.play(0.02);
    const HapOutput output = plugged.output();
    most = std::max(most, along(output, axis));
    CHECK(along(output, axis) >= 0.0);
    CHECK(force_of(output) == doctest::Approx(along(output, axis)));
  }
  CHECK(most == within(0.3, 1e-4));
  CHECK(force_of(plugged.output()) == 0.0);
}

}  // namespace

TEST_CASE("checked in every direction a device gives full force from the next start on") {
  Hand hand;
  UhidOptions options;
  options.serial = "C1";
  UhidDevice plugged(options, hand.motion());
  {
    Played daemon("C1");
    Session session;
    CHECK_FALSE(session.device().checked());
    CHECK(session.device().force_limit_n() == doctest::Approx(0.3));
    const v1::Result early = session.calibrate(v1::CALIBRATE_STEP_PUSH, v1::AXIS_POSITIVE_X);
    CHECK(early.code() == v1::RESULT_CODE_WRONG_STATE);
    CHECK(session.calibrate(v1::CALIBRATE_STEP_START).code() == v1::RESULT_CODE_WRONG_STATE);
    REQUIRE(session.engage());
    session.play(0.3);
    push(session, plugged, v1::AXIS_POSITIVE_X);
    CHECK(session.calibrate(v1::CALIBRATE_STEP_CONFIRM, v1::AXIS_NEGATIVE_X).code() ==
          v1::RESULT_CODE_INVALID);
    for (const v1::Axis axis : kDirections) {
      push(session, plugged, axis);
      CHECK_FALSE(session.device().checked());
      CHECK(session.calibrate(v1::CALIBRATE_STEP_CONFIRM, axis).code() == v1::RESULT_CODE_OK);
      CHECK(session.calibrate(v1::CALIBRATE_STEP_CONFIRM, axis).code() ==
            v1::RESULT_CODE_WRONG_STATE);
    }
    CHECK(session.device().checked());
    CHECK(session.device().confirmed_size() == 6);
    CHECK(session.device().force_limit_n() == doctest::Approx(0.3));
    CHECK(session.kinds[v1::Item::kFault] == 0);
    daemon.end(SIGTERM);
  }
  Played daemon("C1");
  Session session;
  CHECK(session.device().checked());
  CHECK(session.device().force_limit_n() == doctest::Approx(9.0));
  REQUIRE(session.engage());
  hand.press = 0.008;
  hand.lower = true;
  double most = 0.0;
  for (int k = 0; k < 60; ++k) {
    session.play(0.02);
    most = std::max(most, force_of(plugged.output()));
  }
  // More than an unchecked device would ever get.
  CHECK(most > 0.35);
  CHECK(most <= 9.0);
}

TEST_CASE("a device that needs it is calibrated from here, and only without force") {
  Hand hand;
  UhidOptions options;
  options.serial = "N1";
  options.needs_calibration = true;
  UhidDevice plugged(options, hand.motion());
  Played daemon("N1");
  Session session;
  CHECK(session.becomes(v1::LOOP_STATE_ZEROING));
  CHECK(session.device().calibration() == v1::CALIBRATION_STATE_NEEDED);
  CHECK(session.calibrate(v1::CALIBRATE_STEP_STORE).code() == v1::RESULT_CODE_FAILED);
  CHECK(session.calibrate(v1::CALIBRATE_STEP_START).code() == v1::RESULT_CODE_OK);
  bool half = false;
  for (int k = 0; k < 50; ++k) {
    session.play(0.02);
    const v1::DeviceInfo device = session.device();
    half = half || (device.calibration() == v1::CALIBRATION_STATE_RUNNING &&
                    device.calibration_progress() > 0.1);
    if (device.calibration() == v1::CALIBRATION_STATE_DONE) break;
  }
  CHECK(half);
  CHECK(session.device().calibration() == v1::CALIBRATION_STATE_DONE);
  CHECK(session.calibrate(v1::CALIBRATE_STEP_STORE).code() == v1::RESULT_CODE_OK);
  session.play(0.02);
  CHECK(plugged.stored() == 1);
  REQUIRE(session.engage());
  CHECK(session.calibrate(v1::CALIBRATE_STEP_START).code() == v1::RESULT_CODE_WRONG_STATE);
  CHECK(session.client.state()->loop_state() == v1::LOOP_STATE_ENGAGED);
}

}  // namespace hapticd::test
