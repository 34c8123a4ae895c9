// The poses a method is led along: those of a recording, or of a table as `hapticd-oracle poses`
// writes it. Not RT.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/math/pose.h"
#include "core/simulation/tool_renderer.h"
#include "tests/oracle/recorded_scene.h"
#include "tests/oracle/scene_option.h"

namespace hapticd {

/// One tick of a stream.
struct StreamedPose {
  std::uint64_t tick = 0;
  double t_s = 0.0;   ///< since the first
  double dt_s = 0.0;  ///< since the one before
  Pose X_WH;
};

/// Gets the scene before the first tick, and each tick with what it is rendered with.
struct StreamVisitor {
  std::function<void(const Scene&, const ToolScene&)> begin;
  std::function<void(const ToolScene&, const StreamedPose&)> tick;
};

/// Poses X_DH with their times, s, of a CSV file whose columns are t_s, x, y, z, qw, qx, qy, qz.
/// Throws std::runtime_error naming file, line and remedy.
struct TabledPose {
  double t_s = 0.0;
  Pose X_DH;
};
[[nodiscard]] std::vector<TabledPose> read_poses(const std::string& file);

/// The scene's tool led along a table of poses.
void stream_table(const SceneOption& option, const std::string& file, const StreamVisitor& visitor);

/// The ticks of a scene of a recording (none: the first that has any), each with its settings;
/// `tool_id` none: the first tool. Ticks before its first pose are passed over.
struct RecordedStream {
  std::string recording;
  std::string data;  ///< as SceneOption::data
  std::optional<std::uint32_t> scene_id;
  std::optional<std::uint32_t> tool_id;
};
void stream_recording(const RecordedStream& stream, const StreamVisitor& visitor);

}  // namespace hapticd
