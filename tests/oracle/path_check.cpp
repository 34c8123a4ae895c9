// See path_check.h.
#include "tests/oracle/path_check.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <utility>

#include "core/simulation/tool_renderer.h"
#include "proto/recording/recording_reader.h"
#include "server/recorder/tick_record.h"
#include "tests/oracle/recorded_scene.h"
#include "tests/oracle/table.h"
#include "tests/truth/path_run.h"

namespace hapticd {
namespace {

/// The same bits of a number that is not NaN; -0 is not 0.
template <std::size_t N>
bool same_bits(const std::array<double, N>& a, const std::array<double, N>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), [](double x, double y) {
    return x == y && std::signbit(x) == std::signbit(y);
  });
}

class Check {
 public:
  explicit Check(const PathCheck& check) : check_(check), reader_(check.recording) {}

  void run(const std::function<void(const SceneObjects&)>& begin,
           const std::function<void(const JudgedTick&)>& visit) {
    RecordedMessage message;
    while (reader_.next(message)) {
      if (message.kind == RecordKind::kScene) {
        record_ = parse<v1::SceneRecord>(message);
      } else if (message.kind == RecordKind::kParameters) {
        change_ = parse<v1::ParameterRecord>(message);
      } else if (message.kind == RecordKind::kTick) {
        if (!to_tick(parse<v1::TickRecord>(message), *tick_)) {
          fail("a tick is damaged. Name another recording");
        }
        if (scene_ == nullptr) take_scene(tick_->scene_id, begin);
        if (scene_ != nullptr && tick_->scene_id == scene_->scene_id()) take_tick(*tick_, visit);
      }
    }
    if (next_tick_ == 0) fail("it holds no tick of that scene. Name another one");
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw std::runtime_error(check_.recording + ": " + what + ".");
  }

  template <typename Message>
  Message parse(const RecordedMessage& message) const {
    Message parsed;
    if (!parsed.ParseFromArray(message.data.data(), static_cast<int>(message.data.size()))) {
      fail("a " + Message::descriptor()->name() + " is damaged. Name another recording");
    }
    return parsed;
  }

  void take_scene(std::uint32_t scene_id, const std::function<void(const SceneObjects&)>& begin) {
    if (record_.scene_id() != scene_id || scene_id != check_.scene_id.value_or(scene_id)) return;
    scene_ =
        std::make_unique<RecordedScene>(record_, reader_.header(), check_.recording, check_.paths);
    if (scene_->scene().description().tools.size() != 1) {
      fail(
          "its scene has several tools, which share strings; a path can be judged of one alone. "
          "Record a scene with one tool");
    }
    run_ = std::make_unique<PathRun>(scene_->scene());
    objects_ = scene_objects(scene_->scene());
    begin(objects_);
  }

  /// Time since the last good sample, as the simulation has it.
  double elapsed(const ToolTick& tool) {
    const std::int64_t before_ns = sample_t_ns_;
    if (!tool.held) sample_t_ns_ = std::max(sample_t_ns_, tool.sample.t_ns);
    if (!placed_ || sample_t_ns_ <= before_ns) return 0.0;
    return std::min(1e-9 * static_cast<double>(sample_t_ns_ - before_ns), kMaxElapsed);
  }

  void take_tick(const Tick& tick, const std::function<void(const JudgedTick&)>& visit) {
    if (next_tick_ == 0 && tick.tick - tick.skipped != 0) {
      fail("its first tick of the scene is number " + std::to_string(tick.tick) +
           ", and where the tool was before is not known. Record from the daemon's start, with "
           "hapticd --record");
    }
    if (next_tick_ != 0 && tick.tick != next_tick_ + tick.skipped) {
      fail("the recorder lost the ticks before number " + std::to_string(tick.tick) +
           ". Record again, with less else to do on the machine");
    }
    next_tick_ = tick.tick + 1;
    if (tick.change != 0 && change_) scene_->announce(*change_);
    scene_->begin_tick(tick);
    const ToolTick& tool = tick.tools[0];
    if (!placed_ && (!tool.came || tool.held)) return;
    judge(tick, tool, visit);
  }

  void judge(const Tick& tick, const ToolTick& tool,
             const std::function<void(const JudgedTick&)>& visit) {
    const Pose X_WH{to_quaternion(tool.X_WH.q), to_vector(tool.X_WH.p)};
    if (!placed_) {
      run_->place(X_WH);
      sample_t_ns_ = tool.sample.t_ns;
    }
    const double dt_s = elapsed(tool);
    placed_ = true;
    run_->follow(scene_->tool_scene(0));
    run_->allow(static_cast<std::int64_t>(tick.budget.work));
    JudgedTick judged;
    judged.tick = tick.tick;
    judged.path_gap = run_->judged_tick(X_WH, dt_s);
    const Pose& X_WG = run_->X_WG();
    if (!same_bits(to_array(X_WG.p), tool.X_WG.p) || !same_bits(to_array(X_WG.q), tool.X_WG.q)) {
      fail("at tick " + std::to_string(tick.tick) +
           " the graphic tool comes to another place than was recorded, " +
           exact_text((X_WG.p - to_vector(tool.X_WG.p)).norm()) +
           " m away. Use the version that recorded it");
    }
    judged.gap_of_object = object_gaps(objects_, run_->judge().gaps(run_->state()));
    for (const double gap : judged.gap_of_object) {
      judged.path_gap = std::min(judged.path_gap, gap);
    }
    visit(judged);
  }

  const PathCheck& check_;
  RecordingReader reader_;
  std::unique_ptr<Tick> tick_ = std::make_unique<Tick>();
  v1::SceneRecord record_;                     ///< of the ticks that come
  std::optional<v1::ParameterRecord> change_;  ///< that was announced last
  std::unique_ptr<RecordedScene> scene_;
  std::unique_ptr<PathRun> run_;
  SceneObjects objects_;
  std::uint64_t next_tick_ = 0;  ///< 0: none was seen
  std::int64_t sample_t_ns_ = 0;
  bool placed_ = false;
};

}  // namespace

void check_path(const PathCheck& check, const std::function<void(const SceneObjects&)>& begin,
                const std::function<void(const JudgedTick&)>& visit) {
  Check(check).run(begin, visit);
}

}  // namespace hapticd
