// See virtual_time.h.
#include "server/daemon/virtual_time.h"

#include <utility>

#include "proto/wire/request_result.h"

namespace hapticd {
namespace {

using wire::result_of;

/// Ticks between two looks at the socket. More: Stop and Run{STOP} come later; fewer: slower.
constexpr int kStepsPerLook = 16;
constexpr std::uint64_t kMaxSteps = 1'000'000'000;

/// Ticks, of all tools, in which a scripted device had no pose of its own.
std::uint64_t held_inputs(const PlayedScene& scene) {
  std::uint64_t held = 0;
  for (const PlayedTool& tool : scene.tools) {
    if (tool.device.facets.poses != nullptr) held += tool.device.facets.poses->held();
  }
  return held;
}

}  // namespace

Answer VirtualTime::run(const RequestId& id, const v1::Run& run) {
  if (run.mode() == v1::RUN_MODE_STEP) {
    if (run.steps() < 1 || run.steps() > kMaxSteps) {
      return result_of(v1::RESULT_CODE_OUT_OF_RANGE, "run.steps", "Not in [1, 1e9].");
    }
    if (steps_) return result_of(v1::RESULT_CODE_BUSY, "run", "A Run of steps is under way.");
    steps_ = StepRun{id, run.steps(), 0, held_inputs(parts_.loop.loop().scene())};
    live_ = false;
    return std::nullopt;
  }
  if (steps_) end_steps();
  live_ = run.mode() == v1::RUN_MODE_LIVE;
  due_ns_ = 0;
  return result_of(v1::RESULT_CODE_OK);
}

void VirtualTime::abandon(const RequestId& id) {
  if (steps_ && steps_->request == id) end_steps();
}

void VirtualTime::end_steps() {
  const StepRun over = *steps_;
  steps_.reset();
  parts_.clients.answer_with(over.request, [&] {
    HapticLoop& loop = parts_.loop.loop();
    v1::Result result = result_of(v1::RESULT_CODE_OK);
    v1::RunResult& run = *result.mutable_run();
    run.set_steps(over.done);
    run.set_next_tick(loop.next_tick());
    run.set_state_hash(parts_.hash.hash.data(), parts_.hash.hash.size());
    run.set_held_inputs(held_inputs(loop.scene()) - over.held_before);
    return result;
  });
}

void VirtualTime::fail_steps() {
  if (!steps_) return;
  const RequestId request = steps_->request;
  steps_.reset();
  parts_.clients.answer_with(request, [] { return wire::out_of_memory(); });
}

void VirtualTime::step(std::int64_t now_ns) {
  parts_.recorder.make_room();
  parts_.loop.loop().tick_once(now_ns);
  parts_.hand_on(now_ns);
}

bool VirtualTime::pass(std::int64_t now_ns) {
  for (int k = 0; steps_ && k < kStepsPerLook; ++k) {
    // A Stop is obeyed by a tick, whomever time waits for.
    const bool stops = parts_.loop.channels().stop.waits() || std::exchange(hurried_, false);
    if (!stops && !parts_.clients.may_step(now_ns)) return false;
    const bool latched_before = parts_.loop.state() == LoopState::kFault;
    step(now_ns);
    if (!steps_) break;  // Its session has ended meanwhile.
    ++steps_->done;
    const bool latches = !latched_before && parts_.loop.state() == LoopState::kFault;
    if (steps_->done == steps_->wanted || latches) end_steps();
  }
  if (steps_) return true;
  if (!live_) return false;
  if (due_ns_ == 0) due_ns_ = now_ns;
  for (int k = 0; k < kStepsPerLook && due_ns_ <= now_ns; ++k) {
    step(now_ns);
    due_ns_ += period_ns_;
  }
  return due_ns_ <= now_ns;
}

}  // namespace hapticd
