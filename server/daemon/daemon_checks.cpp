// The guided check of devices that can push a person, and their own calibration. See daemon.h.
#include <algorithm>

#include "proto/wire/request_result.h"
#include "server/daemon/daemon.h"

namespace hapticd {
namespace {

using wire::result_of;

constexpr const char* kStep = "calibrate.step";

v1::Result wrong_state(const std::string& message) {
  return result_of(v1::RESULT_CODE_WRONG_STATE, kStep, message);
}

/// The operation of the device that a step is; kNone: it is one of the guided check.
hid::CalibrationOp operation_of(v1::CalibrateStep step) {
  switch (step) {
    case v1::CALIBRATE_STEP_START:
      return hid::CalibrationOp::kStart;
    case v1::CALIBRATE_STEP_ZERO:
      return hid::CalibrationOp::kZeroHere;
    case v1::CALIBRATE_STEP_ABORT:
      return hid::CalibrationOp::kAbort;
    case v1::CALIBRATE_STEP_STORE:
      return hid::CalibrationOp::kStore;
    default:
      return hid::CalibrationOp::kNone;
  }
}

bool is_direction(v1::Axis axis) { return v1::Axis_IsValid(axis) && axis != v1::AXIS_UNSPECIFIED; }

PushAxis push_axis(v1::Axis axis) { return static_cast<PushAxis>(axis); }

v1::Result to_result(const CheckAnswer& answer) {
  switch (answer.verdict) {
    case CheckVerdict::kRight:
      return result_of(v1::RESULT_CODE_OK, "", answer.words);
    case CheckVerdict::kFeltWrong:
      return result_of(v1::RESULT_CODE_INVALID, "calibrate.axis", answer.words);
    case CheckVerdict::kNoPush:
      return wrong_state(answer.words);
    case CheckVerdict::kNotKept:
      return result_of(v1::RESULT_CODE_FAILED, "calibrate", answer.words);
  }
  return {};
}

}  // namespace

Answer Daemon::calibrate(const RequestId& id, const v1::Calibrate& calibrate) {
  const std::vector<std::uint32_t>& tools = scenes_.newest().index.tool_ids;
  const std::uint32_t tool_id = calibrate.tool_id();
  if (std::find(tools.begin(), tools.end(), tool_id) == tools.end()) {
    return result_of(v1::RESULT_CODE_NOT_FOUND, "calibrate.tool_id", "The scene has no such tool.");
  }
  const v1::CalibrateStep step = calibrate.step();
  if (step == v1::CALIBRATE_STEP_UNSPECIFIED || !v1::CalibrateStep_IsValid(step)) {
    return result_of(v1::RESULT_CODE_INVALID, kStep, "Say what to do.");
  }
  const OutsideDevice* outside = outside_of(tool_id);
  if (operation_of(step) != hid::CalibrationOp::kNone) {
    return outside == nullptr ? wrong_state("This device needs no calibration.")
                              : begin_calibration(id, *outside, step);
  }
  if (outside == nullptr || outside->check == nullptr) {
    return wrong_state("This device needs no check: it cannot push anyone.");
  }
  if (step == v1::CALIBRATE_STEP_CONFIRM && is_direction(calibrate.axis())) {
    // Felt along an axis that it cannot push along, it is wrong like any other.
    return to_result(outside->check->confirm(push_axis(calibrate.axis())));
  }
  if (!is_direction(calibrate.axis()) || !outside->check->has(push_axis(calibrate.axis()))) {
    return result_of(v1::RESULT_CODE_INVALID, "calibrate.axis",
                     "Give one of the directions that the device can push in.");
  }
  return push(id, calibrate, *outside);
}

Answer Daemon::push(const RequestId& id, const v1::Calibrate& calibrate,
                    const OutsideDevice& outside) {
  // Of a fault the loop says why.
  if (loop_.state() != LoopState::kEngaged && loop_.state() != LoopState::kFault) {
    return wrong_state("Engage first, with nothing near the tool: hapticctl engage.");
  }
  const std::vector<std::uint32_t>& tools = scenes_.newest().index.tool_ids;
  const auto found = std::find(tools.begin(), tools.end(), calibrate.tool_id());
  const PushCommand what{static_cast<std::uint32_t>(found - tools.begin()),
                         push_axis(calibrate.axis())};
  const AskedPush asked{loop_.next_number(), outside.check.get(), what.axis};
  Answer refused = loop_.command(id, what);
  if (!refused) push_ = asked;
  return refused;
}

void Daemon::note_push(const LoopEvent& event) {
  const auto* done = std::get_if<CommandDone>(&event.what);
  if (done == nullptr || !push_ || push_->number != done->number) return;
  push_->check->note_push(push_->axis, event.t_ns);
  push_.reset();
}

void Daemon::note_no_force(const Snapshot& snapshot) {
  if (snapshot.loop_state == LoopState::kEngaged) return;
  for (const OutsideDevice& outside : outside_) {
    if (outside.check != nullptr) outside.check->note_no_force(snapshot.t_ns);
  }
}

Answer Daemon::begin_calibration(const RequestId& id, const OutsideDevice& outside,
                                 v1::CalibrateStep step) {
  DeviceCalibration* calibration = outside.calibration.get();
  if (calibration == nullptr || !calibration->needed()) {
    return wrong_state("This device needs no calibration.");
  }
  if (loop_.state() == LoopState::kEngaged || loop_.state() == LoopState::kReleasing) {
    return wrong_state("Not while there may be force: hapticctl disengage, then try again.");
  }
  if (!calibration->ask(operation_of(step))) {
    return result_of(v1::RESULT_CODE_BUSY, kStep,
                     "The device has not answered the previous step yet.");
  }
  calibrations_.push_back({id, calibration});
  return std::nullopt;
}

void Daemon::finish_calibrations() {
  std::erase_if(calibrations_, [this](const AskedCalibration& asked) {
    const std::optional<std::string> error = asked.calibration->take_answer();
    if (!error) return false;
    clients_.answer(asked.request,
                    error->empty() ? result_of(v1::RESULT_CODE_OK)
                                   : result_of(v1::RESULT_CODE_FAILED, kStep,
                                               "The device cannot do that now: " + *error + "."));
    return true;
  });
}

}  // namespace hapticd
