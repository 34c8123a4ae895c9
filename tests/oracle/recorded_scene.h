// A scene of a recording as the loop played it: built from the recording alone, its settings those
// of each tick. Not RT.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/tick/tick.h"
#include "hapticd/v1/recording.pb.h"
#include "server/haptic_loop/settings_change.h"
#include "server/scene_io/scene_loader.h"

namespace hapticd {

class RecordedScene {
 public:
  /// The scene of `record` in the recording `path`; models are looked for beside it, then in
  /// `paths`. Throws std::runtime_error, naming file and remedy, when it cannot be played here or
  /// would be another one.
  RecordedScene(const v1::SceneRecord& record, const v1::RecordHeader& header,
                const std::string& path, const ScenePaths& paths);

  /// Notes a change of settings, which begins with the tick that names it.
  void announce(const v1::ParameterRecord& change) { announced_ = change; }
  /// Puts the settings of a tick in force; ticks one after the other. Throws std::runtime_error
  /// when they are not those that were recorded.
  void begin_tick(const Tick& tick);

  [[nodiscard]] const Scene& scene() const noexcept { return *loaded_->scene; }
  [[nodiscard]] std::uint32_t scene_id() const noexcept { return played_->scene_id; }
  /// As in force: stiffness, options, strings and instrument.
  [[nodiscard]] const ToolScene& tool_scene(std::size_t tool) {
    return played_->play.simulation->scene(tool);
  }

 private:
  void play(const v1::RecordHeader& header);
  void begin_change(std::uint64_t number, std::uint64_t tick);
  void learn_delays(const Tick& tick);
  [[noreturn]] void fail(const std::string& what) const;

  std::string path_;
  std::shared_ptr<const LoadedScene> loaded_;
  std::unique_ptr<PlayedScene> played_;
  std::optional<v1::ParameterRecord> announced_;
  std::unique_ptr<SettingsChange> change_;
  double change_share_ = 0.0;
  std::vector<PulledTool> pulled_;  ///< as the tick before left them
};

}  // namespace hapticd
