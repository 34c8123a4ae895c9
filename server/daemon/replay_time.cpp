// See replay_time.h.
#include "server/daemon/replay_time.h"

#include <spdlog/spdlog.h>

#include <string>
#include <utility>

namespace hapticd {
namespace {

/// Ticks between two looks at the socket.
constexpr int kTicksPerLook = 64;

}  // namespace

std::unique_ptr<ReplayRun> open_replay(DaemonOptions& options) {
  const std::optional<DeviceSource> source = parse_source(options.config.device(0).source());
  if (source->driver->driver != DeviceDriver::kReplay) return nullptr;
  try {
    auto replay = std::make_unique<ReplayRun>(source->argument);
    v1::Config config = replay->header().config();
    config.set_clock(options.config.clock());
    config.set_listen(options.config.listen());
    config.set_keys(options.config.keys());
    config.set_verify(options.config.verify());
    config.clear_record();
    options.config = std::move(config);
    return replay;
  } catch (const RecordingError& error) {
    throw StartError(kExitInput, error.what());
  }
}

ReplayTime::ReplayTime(const Parts& parts, std::unique_ptr<ReplayRun> run, const v1::Config& config)
    : parts_(parts),
      run_(std::move(run)),
      verify_(config.verify()),
      paced_(config.clock() == v1::CLOCK_MODE_REALTIME) {
  const auto make_scene = [this](const v1::SceneRecord& record) {
    return parts_.scenes.recorded_scene(record, run_->path());
  };
  try {
    run_->begin(parts_.loop.loop(), parts_.loop.channels(), make_scene, verify_);
  } catch (const RecordingError& error) {
    throw StartError(kExitInput, error.what());
  }
}

bool ReplayTime::pass(std::int64_t now_ns) {
  if (ended_) return false;
  try {
    for (int k = 0; k < kTicksPerLook; ++k) {
      if (!paced_ && !parts_.clients.may_step(now_ns)) return false;
      if (!run_->fetch()) {
        end();
        return false;
      }
      const auto dt_ns = static_cast<std::int64_t>(run_->tick().dt_ns);
      if (due_ns_ == 0) due_ns_ = now_ns - dt_ns;
      if (paced_ && due_ns_ + dt_ns > now_ns) return false;
      due_ns_ += dt_ns;
      run_->play();
      parts_.hand_on(now_ns);
    }
  } catch (const std::runtime_error& error) {
    spdlog::error("the replay ends: {}", error.what());
    exit_code_ = kExitInput;
    end();
    return false;
  }
  return true;
}

void ReplayTime::end() {
  const ReplayReport& report = run_->report();
  const RecordingSummary& summary = run_->summary();
  spdlog::info("replayed {} of {} ticks of {}", report.ticks, summary.ticks, run_->path());
  if (report.skipped_ticks > 0) {
    spdlog::warn("{} ticks were not played: {}", report.skipped_ticks,
                 report.gaps > 0 ? "the recorder had lost some before them"
                                 : "there was no Snapshot before them");
  }
  if (!summary.complete) spdlog::warn("the recording was not closed: {}", summary.end);
  if (verify_) {
    const bool same = report.different_ticks == 0 && report.different_states == 0;
    if (same && run_->compared() == Compared::kPoses) {
      spdlog::warn("recorded with physics {}; compared: poses, not forces",
                   run_->header().physics());
      if (exit_code_ == kExitGood) exit_code_ = kExitPhysics;
    } else if (same) {
      spdlog::info("identical: every wrench to the bit, and {} states", report.states);
    } else {
      spdlog::error("different: {} of {} ticks and {} of {} states; the first is {}",
                    report.different_ticks, report.ticks, report.different_states, report.states,
                    report.first_difference);
      if (exit_code_ == kExitGood) exit_code_ = kExitReplay;
    }
  }
  ended_ = true;
}

void ReplayTime::fill(std::uint64_t tick, v1::ReplayState& state) const {
  state.set_tick(tick);
  state.set_last_tick(run_->summary().last_tick);
  state.set_different_ticks(run_->report().different_ticks);
}

}  // namespace hapticd
