// Virtual time: stopped, following the real one, or stepped as fast as the machine can. See
// daemon.h.
#include <utility>

#include "proto/wire/request_result.h"
#include "server/daemon/daemon.h"

namespace hapticd {
namespace {

using wire::result_of;

/// Ticks between two looks at the socket. More: Stop and Run{STOP} come later; fewer: slower.
constexpr int kStepsPerLook = 16;

/// Ticks, of all tools, in which a scripted device had no pose of its own.
std::uint64_t held_inputs(const PlayedScene& scene) {
  std::uint64_t held = 0;
  for (const PlayedTool& tool : scene.tools) {
    if (tool.device.scripted != nullptr) held += tool.device.scripted->held();
  }
  return held;
}

}  // namespace

void Daemon::run_time(const RequestId& id, const v1::Run& run) {
  const auto refuse = [&](v1::ResultCode code, const char* path, const char* message) {
    server_->answer(id, result_of(code, path, message));
  };
  if (run.mode() == v1::RUN_MODE_UNSPECIFIED) {
    refuse(v1::RESULT_CODE_INVALID, "run.mode", "Say LIVE, STOP or STEP.");
    return;
  }
  if (!virtual_time_ && run.mode() != v1::RUN_MODE_LIVE) {
    refuse(v1::RESULT_CODE_WRONG_STATE, "run.mode",
           "The real clock cannot be stopped or stepped. Start hapticd with --clock virtual.");
    return;
  }
  if (run.mode() == v1::RUN_MODE_STEP) {
    if (run.steps() < 1 || run.steps() > 1'000'000'000) {
      refuse(v1::RESULT_CODE_OUT_OF_RANGE, "run.steps", "Not in [1, 1e9].");
      return;
    }
    if (steps_) {
      refuse(v1::RESULT_CODE_BUSY, "run", "A Run of steps is under way.");
      return;
    }
    steps_ = StepRun{id, run.steps(), 0, held_inputs(loop_->scene())};
    mode_ = TimeMode::kStopped;
    return;
  }
  if (steps_) end_steps(v1::RESULT_CODE_OK);
  mode_ = run.mode() == v1::RUN_MODE_LIVE ? TimeMode::kLive : TimeMode::kStopped;
  live_due_ns_ = 0;
  server_->answer(id, result_of(v1::RESULT_CODE_OK));
}

void Daemon::end_steps(v1::ResultCode code) {
  v1::Result result = result_of(code);
  v1::RunResult& run = *result.mutable_run();
  run.set_steps(steps_->done);
  run.set_next_tick(loop_->next_tick());
  run.set_state_hash(hash_.hash.data(), hash_.hash.size());
  run.set_held_inputs(held_inputs(loop_->scene()) - steps_->held_before);
  server_->answer(steps_->request, result);
  steps_.reset();
}

void Daemon::step_once(std::int64_t now_ns) {
  recording_->make_room();
  loop_->tick_once(now_ns);
  take_events();
  take_snapshots(now_ns);
}

bool Daemon::pass_virtual_time(std::int64_t now_ns) {
  for (int k = 0; steps_ && k < kStepsPerLook; ++k) {
    // A Stop is obeyed by a tick, whomever time waits for.
    if (!std::exchange(stop_asked_, false) && !server_->may_step(now_ns)) return false;
    step_once(now_ns);
    ++steps_->done;
    const bool fault = newest_state_ == LoopState::kFault;
    if (steps_->done == steps_->wanted || fault) end_steps(v1::RESULT_CODE_OK);
  }
  if (steps_) return true;
  if (mode_ != TimeMode::kLive) return false;
  if (live_due_ns_ == 0) live_due_ns_ = now_ns;
  for (int k = 0; k < kStepsPerLook && live_due_ns_ <= now_ns; ++k) {
    step_once(now_ns);
    live_due_ns_ += player_.period_ns;
  }
  return live_due_ns_ <= now_ns;
}

}  // namespace hapticd
