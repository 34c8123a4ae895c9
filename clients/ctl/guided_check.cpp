// See guided_check.h.
#include "clients/ctl/guided_check.h"

#include <algorithm>
#include <array>
#include <cstdio>
#include <memory>
#include <optional>
#include <utility>

#include "clients/ctl/check_verdict.h"
#include "clients/ctl/device_text.h"
#include "clients/ctl/text.h"

namespace hapticd::ctl {
namespace {

/// States per second asked for.
constexpr double kCheckRate = 100.0;
/// Tries of one movement, and of one push that nobody feels.
constexpr int kTries = 3;
/// How long the force may take to come on, s: a person holds the dead-man switch meanwhile.
constexpr double kEngageWait = 20.0;
/// How long a push may take to be done, s.
constexpr double kPushWait = 5.0;
/// How long measuring along one axis may take, s; the daemon needs 7 s of it.
constexpr double kMeasureWait = 15.0;
/// Requests at the end may take this long, ms; after that the end of the lease does it.
constexpr std::chrono::milliseconds kEndWait{1500};

std::string mm(double metres) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.0f mm", 1e3 * metres);
  return text.data();
}

v1::Item calibrate_item(std::uint32_t tool_id, v1::CalibrateStep step,
                        v1::Axis axis = v1::AXIS_UNSPECIFIED) {
  v1::Item item;
  v1::Calibrate& calibrate = *item.mutable_calibrate();
  calibrate.set_tool_id(tool_id);
  calibrate.set_step(step);
  calibrate.set_axis(axis);
  return item;
}

v1::Item disengage_item() {
  v1::Item item;
  item.mutable_disengage();
  return item;
}

/// What is asked of the daemon at the end, whatever happened; then the lease is given back.
class AtEnd {
 public:
  explicit AtEnd(client::Controller& controller) : controller_(controller) {}
  ~AtEnd() {
    try {
      if (last_.body_case() != v1::Item::BODY_NOT_SET) {
        static_cast<void>(controller_.call(last_, kEndWait));
      }
      v1::Item release;
      release.mutable_release();
      static_cast<void>(controller_.call(release, kEndWait));
    } catch (const std::exception&) {
      // The session has ended: so has its lease, and with it the force.
      return;
    }
  }
  AtEnd(const AtEnd&) = delete;
  AtEnd& operator=(const AtEnd&) = delete;

  /// Instead of what was to be asked before; an empty one: nothing.
  void ask(v1::Item last) { last_ = std::move(last); }

 private:
  client::Controller& controller_;
  v1::Item last_;
};

class GuidedCheck {
 public:
  GuidedCheck(client::Client& client, client::Controller& controller, const GlobalOptions& options,
              const CheckChoice& choice, const Conversation& person)
      : client_(client),
        controller_(controller),
        options_(options),
        choice_(choice),
        person_(person) {}

  /// Of the device that `info` describes; one that was checked is only measured.
  void run(v1::DeviceInfo info) {
    info_ = std::move(info);
    look();
    if (info_.checked() && !choice_.anyway) {
      measure();
      return;
    }
    lead();
    const std::vector<v1::Axis> order = push_order(pushed_axes(info_.profile()), choice_.seed);
    if (order.empty()) {
      person_.say("It has no motors: its axes are right, and there is nothing else to check.");
      return;
    }
    engage();
    person_.say("Hold the handle loosely, away from its stops. The device pushes " +
                std::to_string(order.size()) + " times, for one second each, with 0.3 N.");
    for (const v1::Axis asked : order) feel(asked);
    conclude();
    measure();
  }

 private:
  /// Asks for readings and refuses a device that is not ready.
  void look() {
    const std::uint32_t divisor = client::state_divisor(client_.scene()->rate_hz(), kCheckRate);
    require(client_.subscribe(divisor, {v1::SECTION_DEVICES, v1::SECTION_TIMING}));
    const auto heard = [&] {
      return client_.state() && device_of(*client_.state(), choice_.tool_id) != nullptr;
    };
    if (!live_until(client_, person_, heard, options_.timeout_s)) {
      throw Failure(kRefused, "no readings come from the device of tool " +
                                  std::to_string(choice_.tool_id) +
                                  ". Under the virtual clock there are none until it runs");
    }
    const std::string why = unready_text(*client_.state(), choice_.tool_id);
    if (!why.empty()) throw Failure(kRefused, why);
    for (const std::string& line : {std::string("Device: ") + info_.port(),
                                    std::string("Ctrl-C ends the check, with the force off.")}) {
      person_.say(line);
    }
  }

  [[nodiscard]] std::array<double, 3> position() const {
    std::array<double, 3> p{};
    const v1::DeviceState* device = device_of(*client_.state(), choice_.tool_id);
    for (int i = 0; device != nullptr && i < device->p_dh_m_size() && i < 3; ++i) {
      p[static_cast<std::size_t>(i)] = device->p_dh_m(i);
    }
    return p;
  }

  /// Readings that are newer than this moment.
  void refresh() {
    const std::uint64_t tick = client_.state()->tick();
    static_cast<void>(live_until(
        client_, person_, [&] { return client_.state()->tick() != tick; }, options_.timeout_s));
  }

  /// What the device reported of a movement along `direction`.
  v1::Axis led(v1::Axis direction) {
    std::string ask = std::string("Move the handle 3 cm or more ") +
                      (direction == v1::AXIS_POSITIVE_X ? "to the " : "") + name_of(direction) +
                      ", hold it there and press Enter.";
    for (int k = 0; k < kTries; ++k) {
      refresh();
      const std::array<double, 3> before = position();
      person_.say(ask);
      static_cast<void>(next_answer(client_, person_));
      refresh();
      std::array<double, 3> moved = position();
      for (std::size_t i = 0; i < 3; ++i) moved[i] -= before[i];
      const MovementVerdict verdict = judge_movement(moved);
      if (verdict.movement == Movement::kClear) {
        const bool right = verdict.came == direction;
        person_.say((right ? "  good: " : "  it came as ") + mm(verdict.length) + " " +
                    name_of(verdict.came) + (right ? "" : "."));
        return verdict.came;
      }
      person_.say(verdict.movement == Movement::kTooShort
                      ? "  that was " + mm(verdict.length) + " only. Once more from here."
                      : "  that was along two axes at once. Once more from here, straight.");
    }
    throw Failure(kRefused, std::string("no clear movement ") + name_of(direction) +
                                " was seen. Is this the device you moved? See hapticctl device "
                                "monitor");
  }

  /// Axes and signs of the readings.
  void lead() {
    const std::array<bool, 3> sensed = sensed_axes(info_.profile());
    std::array<v1::Axis, 3> came{};
    bool right = true;
    for (int i = 0; i < 3; ++i) {
      const auto k = static_cast<std::size_t>(i);
      if (!sensed[k]) continue;
      came[k] = led(direction_along(i, false));
      right = right && came[k] == direction_along(i, false);
    }
    if (right) return;
    const auto mended = mended_axes(info_.profile(), came);
    if (!mended) {
      throw Failure(kRefused, "two movements were along one axis. Start again, and move straight");
    }
    throw Failure(kRefused,
                  "the axes are not as its profile says. The device has not pushed. Write "
                  "into the profile: " +
                      axes_line(*mended) + "; start hapticd with it, and check again");
  }

  void engage() {
    if (client_.state()->loop_state() == v1::LOOP_STATE_ENGAGED) return;
    v1::Item item;
    item.mutable_engage();
    require(controller_.call(item, timeout_of(options_)));
    bool told = false;
    const auto engaged = [&] {
      const v1::State& state = *client_.state();
      if (state.cause() == v1::CAUSE_DEAD_MAN && !told) {
        person_.say("Hold the dead-man switch.");
        told = true;
      }
      return state.loop_state() == v1::LOOP_STATE_ENGAGED;
    };
    if (live_until(client_, person_, engaged, kEngageWait)) return;
    const std::string cause = v1::Cause_Name(client_.state()->cause());
    throw Failure(kRefused, "the force does not come on (" + plain_name(cause, "CAUSE_") +
                                "). See hapticctl status");
  }

  void push(v1::Axis asked) {
    const v1::Item item = calibrate_item(choice_.tool_id, v1::CALIBRATE_STEP_PUSH, asked);
    v1::Result result;
    const auto pushed = [&] {
      result = controller_.call(item, timeout_of(options_));
      return result.code() != v1::RESULT_CODE_BUSY;  // the one before lasts a second
    };
    static_cast<void>(live_until(client_, person_, pushed, kPushWait));
    require(result);
  }

  /// Pushes until something was felt; the person is not told which push it was.
  v1::Axis felt_of(v1::Axis asked) {
    for (int k = 0; k < kTries; ++k) {
      push(asked);
      person_.say(
          "Which way did it push? r)ight l)eft u)p d)own t)oward you a)way, or n for "
          "nothing, once more:");
      std::string answer = next_answer(client_, person_);
      std::optional<v1::Axis> felt = direction_of(answer);
      while (!felt && !felt_nothing(answer)) {
        person_.say("Answer r, l, u, d, t, a or n:");
        answer = next_answer(client_, person_);
        felt = direction_of(answer);
      }
      if (felt) return *felt;
    }
    throw Failure(kRefused,
                  "nothing was felt of 0.3 N. Are its motors powered? Where its profile "
                  "has a force_scale, that may be too large");
  }

  void feel(v1::Axis asked) {
    const v1::Axis felt = felt_of(asked);
    const v1::Result result = controller_.call(
        calibrate_item(choice_.tool_id, v1::CALIBRATE_STEP_CONFIRM, felt), timeout_of(options_));
    if (felt == asked) {
      require(result);
      last_word_ = result.message();
      return;
    }
    throw Failure(kRefused,
                  std::string("it was told to push ") + name_of(asked) + " and was felt " +
                      name_of(felt) + ". " +
                      (result.message().empty() ? push_advice(info_.profile(), asked, felt)
                                                : result.message()));
  }

  void conclude() {
    const v1::DeviceInfo after = device_info(client_, options_, choice_.tool_id);
    if (!after.checked()) {
      throw Failure(kRefused,
                    "all directions were right, yet hapticd does not count the "
                    "device as checked. Check again");
    }
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "Passed. Its limit now is %g N.",
                  after.force_limit_n());
    person_.say(text.data() + (last_word_.empty() ? std::string() : " " + last_word_));
  }

  /// Lets the handle ring along each axis that it pushes along; a person may skip any.
  void measure() {
    const std::array<bool, 3> axes = pushed_axes(info_.profile());
    const auto count = std::count(axes.begin(), axes.end(), true);
    if (count == 0) return;
    person_.say(
        "Last its damping is measured, " + std::to_string(count) +
        " times 7 seconds: hapticd pulls the handle up to 2.5 mm aside and lets it ring. Put the "
        "handle where it stays by itself, away from its stops.");
    for (int i = 0; i < 3; ++i) {
      if (!axes[static_cast<std::size_t>(i)]) continue;
      if (measured(direction_along(i, false))) continue;
      person_.say(
          "Skipped: its damping stays as its profile says. hapticctl device check measures "
          "it later.");
      return;
    }
  }

  /// Whether it may begin; an end of the input is a no, as what was checked is kept by now.
  bool is_ready() {
    try {
      return !skips(next_answer(client_, person_));
    } catch (const InputEnded&) {
      return false;
    }
  }

  /// What came of a measuring; Ctrl-C ends it at once.
  v1::Result ring(v1::Axis axis) {
    v1::Item item = calibrate_item(choice_.tool_id, v1::CALIBRATE_STEP_MEASURE, axis);
    item.set_fence(controller_.fence());
    v1::Result silence;
    silence.set_message("hapticd has not answered the measuring");
    // The answer may come after the wait for it.
    const auto result = std::make_shared<std::optional<v1::Result>>();
    client_.request(item, [result, silence](const v1::Result* told) {
      *result = told == nullptr ? silence : *told;
    });
    static_cast<void>(live_until(
        client_, person_, [&] { return result->has_value(); }, kMeasureWait));
    return result->value_or(silence);
  }

  /// False: the person skips it.
  bool measured(v1::Axis axis) {
    constexpr std::array<const char*, 3> kNames{"right and left", "up and down", "to and fro"};
    person_.say(std::string("Take your hands off the handle, so that it hangs free, and press "
                            "Enter; it will ring ") +
                kNames[static_cast<std::size_t>(index_of(axis))] + ". Or s to skip:");
    while (is_ready()) {
      engage();
      const v1::Result result = ring(axis);
      person_.say("  " + result.message());
      if (result.code() == v1::RESULT_CODE_OK) return true;
      if (result.code() != v1::RESULT_CODE_FAILED) require(result);
      person_.say("Enter to try again, or s to skip:");
    }
    return false;
  }

  client::Client& client_;
  client::Controller& controller_;
  const GlobalOptions& options_;
  const CheckChoice& choice_;
  const Conversation& person_;
  v1::DeviceInfo info_;
  std::string last_word_;  ///< of the daemon on the last push
};

}  // namespace

v1::DeviceInfo device_info(client::Client& client, const GlobalOptions& options,
                           std::uint32_t tool_id) {
  v1::Item item;
  item.mutable_get_device_info();
  const v1::Result result = ask(client, item, options);
  std::string others;
  for (const v1::DeviceInfo& info : result.devices().devices()) {
    if (info.tool_id() == tool_id) return info;
    others += (others.empty() ? "" : ", ") + std::to_string(info.tool_id());
  }
  throw Failure(kRefused, "there is no tool " + std::to_string(tool_id) +
                              (others.empty() ? "" : "; there is " + others));
}

void run_check(client::Client& client, const GlobalOptions& options, const CheckChoice& choice,
               const Conversation& person) {
  v1::DeviceInfo info = device_info(client, options, choice.tool_id);
  if (info.checked() && !choice.anyway && !needs_measuring(info)) {
    person.say(
        "Nothing needs checking: this device has been checked, or cannot push a person. "
        "--anyway checks it all the same.");
    return;
  }
  client::Controller controller(client);
  acquire(controller, client, options);
  AtEnd end(controller);
  end.ask(disengage_item());
  GuidedCheck(client, controller, options, choice, person).run(std::move(info));
}

void run_calibration(client::Client& client, const GlobalOptions& options, std::uint32_t tool_id,
                     bool zero, const Conversation& person) {
  constexpr double kLook = 0.25;  // s; a device need not be asked more often than 10 times a second
  client::Controller controller(client);
  acquire(controller, client, options);
  AtEnd end(controller);
  const auto step = [&](v1::CalibrateStep what) {
    require(controller.call(calibrate_item(tool_id, what), timeout_of(options)));
  };
  if (zero) {
    step(v1::CALIBRATE_STEP_ZERO);
  } else {
    step(v1::CALIBRATE_STEP_START);
    end.ask(calibrate_item(tool_id, v1::CALIBRATE_STEP_ABORT));
    person.say(
        "Its motors are free. Move the handle to its stops, as its manual says. Ctrl-C "
        "cancels.");
    v1::DeviceInfo info = device_info(client, options, tool_id);
    int told = -1;
    while (info.calibration() == v1::CALIBRATION_STATE_RUNNING) {
      const double share = info.calibration_progress();
      const int percent = share >= 0.0 && share <= 1.0 ? static_cast<int>(100.0 * share) : 0;
      if (percent != told) person.say("  " + std::to_string(percent) + " %");
      told = percent;
      static_cast<void>(live_until(
          client, person, [] { return false; }, kLook));
      info = device_info(client, options, tool_id);
    }
    if (info.calibration() != v1::CALIBRATION_STATE_DONE) {
      throw Failure(kRefused,
                    "the device says that its calibration has failed. Begin again, and "
                    "lead it to every stop");
    }
  }
  step(v1::CALIBRATE_STEP_STORE);
  end.ask({});
  person.say(zero ? "Its present pose is its zero." : "Calibrated, and kept in the device.");
}

}  // namespace hapticd::ctl
