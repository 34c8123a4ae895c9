// The guided check and the calibration against a server on loopback and a person who does as told.
// Truth: how the device of the test lies and pushes.
#include "clients/ctl/guided_check.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <functional>
#include <limits>
#include <set>

#include "tests/clients/ctl/device_server.h"

namespace hapticd::test {
namespace {

using Vector = std::array<double, 3>;

/// Does what is said, and answers what is felt; ends after `patience` answers.
struct Person {
  explicit Person(DeviceServer& with) : server(with) {}

  DeviceServer& server;
  /// Reading of a movement in the room.
  std::function<Vector(const Vector&)> reading = [](const Vector& moved) { return moved; };
  /// What a hand feels of a push along an axis.
  std::function<std::string(v1::Axis)> feels = [](v1::Axis axis) {
    return std::string(1, "?rludta"[static_cast<int>(axis)]);
  };
  std::string lets_go;  ///< what is answered when the handle is to be let go: Enter
  std::string tries_again;
  int patience = 1000;
  std::vector<std::string> heard;
  std::vector<std::string> answers;

  ctl::Conversation conversation() {
    return {[this](const std::string& text) { hear(text); },
            [this]() -> std::optional<std::string> {
              if (answers.empty()) return std::nullopt;
              std::string answer = answers.front();
              answers.erase(answers.begin());
              --patience;
              return answer;
            },
            [this] { return patience <= 0; }};
  }

  void hear(const std::string& text) {
    heard.push_back(text);
    const std::lock_guard lock(server.mutex);
    if (text.starts_with("Move")) {
      const Vector moved = reading({text.find("right") != std::string::npos ? 0.04 : 0.0,
                                    text.find(" up") != std::string::npos ? 0.04 : 0.0,
                                    text.find("toward") != std::string::npos ? 0.04 : 0.0});
      for (std::size_t i = 0; i < 3; ++i) server.p_DH[i] += moved[i];
      answers.emplace_back();
    }
    if (text.starts_with("Which way")) answers.push_back(feels(server.pushed.back()));
    if (text.starts_with("Answer")) answers.emplace_back("n");
    if (text.starts_with("Take your hands off")) answers.push_back(lets_go);
    if (text.starts_with("Enter to try again")) answers.push_back(tries_again);
  }

  [[nodiscard]] bool was_told(const std::string& part) const {
    for (const std::string& text : heard) {
      if (text.find(part) != std::string::npos) return true;
    }
    return false;
  }
};

ctl::GlobalOptions options_of(const DeviceServer& server) {
  ctl::GlobalOptions options;
  options.daemon.server = server.address();
  return options;
}

/// The complaint; empty: the check was passed.
std::string check(Person& person, const ctl::CheckChoice& choice = {}) {
  const ctl::GlobalOptions options = options_of(person.server);
  const auto client = ctl::connect(options);
  try {
    run_check(*client, options, choice, person.conversation());
  } catch (const ctl::Failure& failure) {
    CHECK(client->lease().fence() == 0);
    return failure.what();
  }
  CHECK(client->lease().fence() == 0);
  return {};
}

std::string calibrate(Person& person, bool zero = false) {
  const ctl::GlobalOptions options = options_of(person.server);
  const auto client = ctl::connect(options);
  try {
    run_calibration(*client, options, 0, zero, person.conversation());
  } catch (const ctl::Failure& failure) {
    return failure.what();
  }
  return {};
}

bool contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

}  // namespace

TEST_CASE("a device that lies and pushes as its profile has it passes, and its force ends") {
  DeviceServer server;
  Person person(server);
  CHECK(check(person).empty());
  CHECK(server.engaged == 1);
  CHECK(server.disengaged == 1);
  CHECK(server.info.checked());
  CHECK(server.pushed.size() == 6);
  CHECK(std::set<v1::Axis>(server.pushed.begin(), server.pushed.end()).size() == 6);
  CHECK(server.confirmed == server.pushed);
  CHECK(person.was_told("Passed"));
  CHECK(server.info.damping_size() == 3);
  // Nobody may know before which way it will go.
  for (const std::string& text : person.heard) CHECK_FALSE(contains(text, "push left"));
}

TEST_CASE("axes that lie otherwise are told with the line that mends them, and nothing is pushed") {
  DeviceServer server;
  Person person(server);
  person.reading = [](const Vector& moved) { return Vector{moved[0], -moved[2], moved[1]}; };
  // Up reads as toward you, toward you as down: raw z is up, raw -y toward the user.
  const std::string why = check(person);
  CHECK(contains(why, "axes: [AXIS_POSITIVE_X, AXIS_POSITIVE_Z, AXIS_NEGATIVE_Y]"));
  CHECK(server.engaged == 0);
  CHECK(server.pushed.empty());
  CHECK(person.was_told("it came as 40 mm toward you"));
}

TEST_CASE(
    "a push that is felt the other way round is told with what mends it, and the force ends") {
  DeviceServer server;
  Person person(server);
  person.feels = [](v1::Axis axis) { return std::string(1, "?lrduat"[static_cast<int>(axis)]); };
  CHECK(contains(check(person), "starts again"));
  CHECK(server.pushed.size() == 1);
  CHECK(server.confirmed.size() == 1);
  CHECK(server.confirmed != server.pushed);
  CHECK(server.disengaged == 1);
  CHECK_FALSE(server.info.checked());
  server.refusal.clear();
  CHECK(contains(check(person), "force_sign { value: ["));
}

TEST_CASE("what was not felt is pushed again, and three times nothing is no check") {
  DeviceServer server;
  Person person(server);
  int asked = 0;
  person.feels = [&](v1::Axis axis) {
    ++asked;
    if (asked == 1) return std::string("n");
    return std::string(1, "?rludta"[static_cast<int>(axis)]);
  };
  CHECK(check(person).empty());
  CHECK(server.pushed.size() == 7);
  CHECK(server.pushed[0] == server.pushed[1]);

  DeviceServer dead;
  Person other(dead);
  other.feels = [](v1::Axis) { return std::string("huh"); };
  CHECK(contains(check(other), "motors"));
  CHECK(dead.confirmed.empty());
  CHECK(dead.disengaged == 1);
}

TEST_CASE("whoever breaks off a check leaves no force") {
  for (const int patience : {1, 3, 5}) {
    CAPTURE(patience);
    DeviceServer server;
    Person person(server);
    person.patience = patience;
    CHECK(contains(check(person), "ended"));
    CHECK(server.loop_state == v1::LOOP_STATE_READY);
    CHECK(server.disengaged == 1);
  }
}

TEST_CASE("a device that is not ready is not pushed with, and the remedy is named") {
  DeviceServer server;
  server.flags.push_back(v1::DEVICE_FLAG_EMERGENCY_STOP);
  Person person(server);
  CHECK(contains(check(person), "Release it"));
  CHECK(server.engaged == 0);
}

TEST_CASE("a handle that is not moved is asked for three times, then said to be another one") {
  DeviceServer server;
  Person person(server);
  person.reading = [](const Vector&) { return Vector{}; };
  CHECK(contains(check(person), "Is this the device"));
  CHECK(person.was_told("0 mm only"));
  CHECK(server.engaged == 0);
}

TEST_CASE("damping is measured along each axis after the check, and again where a hand held on") {
  DeviceServer server;
  server.held = 2;
  Person person(server);
  CHECK(check(person).empty());
  CHECK(server.info.damping_size() == 3);
  CHECK(std::count(server.steps.begin(), server.steps.end(), v1::CALIBRATE_STEP_MEASURE) == 5);
  CHECK(person.was_told("Take the hands off"));
  CHECK(person.was_told("At least 0.4"));
  CHECK(server.disengaged == 1);
}

TEST_CASE("who skips the measuring has passed the check all the same") {
  for (const bool at_once : {true, false}) {
    DeviceServer server;
    server.held = 100;
    Person person(server);
    (at_once ? person.lets_go : person.tries_again) = "skip";
    CHECK(check(person).empty());
    CHECK(server.info.checked());
    CHECK(server.info.damping_size() == 0);
    CHECK(person.was_told("Skipped"));
    CHECK(server.disengaged == 1);
  }
}

TEST_CASE("a device that was checked, and whose damping is a guess, is measured and not pushed") {
  DeviceServer server;
  server.info.set_checked(true);
  Person person(server);
  CHECK(check(person).empty());
  CHECK(server.pushed.empty());
  CHECK(server.info.damping_size() == 3);
  CHECK(server.engaged == 1);
  CHECK(server.disengaged == 1);
}

TEST_CASE("a device that needs no check is left alone, unless it is to be checked anyway") {
  DeviceServer server;
  server.info.set_checked(true);
  server.info.mutable_profile()->mutable_damping_n_s_per_m()->add_value(1.0);
  Person person(server);
  CHECK(check(person).empty());
  CHECK(person.was_told("Nothing needs checking"));
  CHECK(server.engaged == 0);
  ctl::CheckChoice anyway;
  anyway.anyway = true;
  CHECK(check(person, anyway).empty());
  CHECK(server.pushed.size() == 6);
}

TEST_CASE("a tool that is not there is refused with those that are") {
  DeviceServer server;
  Person person(server);
  ctl::CheckChoice other;
  other.tool_id = 4;
  CHECK(contains(check(person, other), "there is 0"));
}

TEST_CASE("a calibration is followed to its end and kept") {
  using Steps = std::vector<v1::CalibrateStep>;
  DeviceServer server;
  server.calibration = {v1::CALIBRATION_STATE_RUNNING, v1::CALIBRATION_STATE_RUNNING,
                        v1::CALIBRATION_STATE_DONE};
  server.info.set_calibration_progress(0.42);
  Person person(server);
  CHECK(calibrate(person).empty());
  CHECK(server.steps == Steps{v1::CALIBRATE_STEP_START, v1::CALIBRATE_STEP_STORE});
  CHECK(person.was_told("42 %"));
  server.steps.clear();
  CHECK(calibrate(person, true).empty());
  CHECK(server.steps == Steps{v1::CALIBRATE_STEP_ZERO, v1::CALIBRATE_STEP_STORE});
}

TEST_CASE("a share of a calibration that is none is told as nothing") {
  for (const double share : {std::numeric_limits<double>::quiet_NaN(), -1e300, 1e300}) {
    DeviceServer server;
    server.calibration = {v1::CALIBRATION_STATE_RUNNING, v1::CALIBRATION_STATE_DONE};
    server.info.set_calibration_progress(share);
    Person person(server);
    CHECK(calibrate(person).empty());
    CHECK(person.was_told("  0 %"));
  }
}

TEST_CASE("a calibration that fails or is broken off is aborted and not kept") {
  using Steps = std::vector<v1::CalibrateStep>;
  DeviceServer server;
  server.calibration = {v1::CALIBRATION_STATE_RUNNING, v1::CALIBRATION_STATE_FAILED};
  Person person(server);
  CHECK(contains(calibrate(person), "failed"));
  CHECK(server.steps == Steps{v1::CALIBRATE_STEP_START, v1::CALIBRATE_STEP_ABORT});
  server.steps.clear();
  server.calibration = {v1::CALIBRATION_STATE_RUNNING};
  person.patience = 0;
  CHECK(contains(calibrate(person), "ended"));
  CHECK(server.steps == Steps{v1::CALIBRATE_STEP_START, v1::CALIBRATE_STEP_ABORT});
}

}  // namespace hapticd::test
