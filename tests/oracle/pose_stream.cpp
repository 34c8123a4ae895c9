// See pose_stream.h.
#include "tests/oracle/pose_stream.h"

#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "core/simulation/workspace_map.h"
#include "proto/recording/recording_reader.h"
#include "server/recorder/tick_record.h"

namespace hapticd {
namespace {

constexpr const char* kColumns = "t_s,x,y,z,qw,qx,qy,qz";

/// The eight numbers of a line; false when they are no such.
bool parse_row(const std::string& line, std::array<double, 8>& numbers) {
  std::stringstream fields(line);
  std::string field;
  for (double& number : numbers) {
    if (!std::getline(fields, field, ',')) return false;
    char* end = nullptr;
    number = std::strtod(field.c_str(), &end);
    if (end == field.c_str() || *end != '\0' || !std::isfinite(number)) return false;
  }
  return !std::getline(fields, field, ',');
}

template <typename Message>
Message parse(const RecordedMessage& message, const std::string& path) {
  Message parsed;
  if (!parsed.ParseFromArray(message.data.data(), static_cast<int>(message.data.size()))) {
    throw std::runtime_error(path + ": a " + Message::descriptor()->name() +
                             " is damaged. Name another recording.");
  }
  return parsed;
}

/// False where the message is not a tick.
bool read_tick(const RecordedMessage& message, const std::string& path, Tick& tick) {
  return message.kind == RecordKind::kTick && to_tick(parse<v1::TickRecord>(message, path), tick);
}

std::size_t tool_index(const RecordedStream& stream, const SceneDescription& scene) {
  SceneOption option;
  option.tool_id = stream.tool_id;
  return chosen_tool(option, scene);
}

}  // namespace

std::vector<TabledPose> read_poses(const std::string& file) {
  std::ifstream stream(file);
  std::string line;
  if (!stream || !std::getline(stream, line)) {
    throw std::runtime_error(file +
                             ": cannot be read, or is empty. Name a table of poses, as "
                             "hapticd-oracle poses writes it");
  }
  if (line != kColumns) {
    throw std::runtime_error(file + ":1: the columns are not " + kColumns +
                             ". Write the table with hapticd-oracle poses");
  }
  std::vector<TabledPose> poses;
  for (int number = 2; std::getline(stream, line); ++number) {
    std::array<double, 8> n{};
    const std::string where = file + ":" + std::to_string(number);
    if (!parse_row(line, n)) {
      throw std::runtime_error(where + ": not eight finite numbers. Correct the line");
    }
    const Quaternion q(n[4], n[5], n[6], n[7]);
    if (!(q.norm() >= 0.5 && q.norm() <= 2.0)) {
      throw std::runtime_error(where + ": a quaternion of norm " + std::to_string(q.norm()) +
                               ". Give one in [0.5, 2]");
    }
    if (!poses.empty() && !(n[0] > poses.back().t_s)) {
      throw std::runtime_error(where + ": time stands still or goes back. Correct the line");
    }
    poses.push_back({n[0], {renormalised(q), {n[1], n[2], n[3]}}});
  }
  if (poses.empty()) throw std::runtime_error(file + ": has no pose. Name another table");
  return poses;
}

void stream_table(const SceneOption& option, const std::string& file,
                  const StreamVisitor& visitor) {
  const std::vector<TabledPose> poses = read_poses(file);
  const std::unique_ptr<LoadedScene> loaded = load_scene(option);
  const SceneDescription& description = loaded->scene->description();
  const std::size_t tool = chosen_tool(option, description);
  const ToolScene scene = loaded->scene->tool_scene(tool);
  visitor.begin(*loaded->scene, scene);
  const WorkspaceMap& map = description.tools[tool].workspace;
  for (std::size_t k = 0; k < poses.size(); ++k) {
    const double dt_s = k > 0 ? poses[k].t_s - poses[k - 1].t_s : 0.0;
    visitor.tick(scene, {k, poses[k].t_s - poses[0].t_s, dt_s,
                         to_world(map, WorkspaceState{}, poses[k].X_DH)});
  }
}

void stream_recording(const RecordedStream& stream, const StreamVisitor& visitor) {
  RecordingReader reader(stream.recording);
  const ScenePaths paths = scene_paths(stream.data);
  v1::SceneRecord record;
  std::optional<v1::ParameterRecord> change;
  std::unique_ptr<RecordedScene> scene;
  std::size_t tool = 0;
  std::int64_t first_ns = 0;
  bool placed = false;
  RecordedMessage message;
  const auto kept = std::make_unique<Tick>();
  Tick& tick = *kept;
  while (reader.next(message)) {
    if (message.kind == RecordKind::kScene) record = parse<v1::SceneRecord>(message, reader.path());
    if (message.kind == RecordKind::kParameters) {
      change = parse<v1::ParameterRecord>(message, reader.path());
    }
    if (!read_tick(message, reader.path(), tick)) continue;
    const bool wanted = tick.scene_id == stream.scene_id.value_or(tick.scene_id);
    if (scene == nullptr && wanted && record.scene_id() == tick.scene_id) {
      scene = std::make_unique<RecordedScene>(record, reader.header(), reader.path(), paths);
      tool = tool_index(stream, scene->scene().description());
      visitor.begin(scene->scene(), scene->tool_scene(tool));
    }
    if (scene == nullptr || tick.scene_id != scene->scene_id()) continue;
    if (tick.change != 0 && change) scene->announce(*change);
    scene->begin_tick(tick);
    const ToolTick& told = tick.tools[tool];
    if (!placed && (!told.came || told.held)) continue;
    if (!placed) first_ns = tick.t_ns;
    const double dt_s = placed ? 1e-9 * static_cast<double>(tick.dt_ns) : 0.0;
    placed = true;
    visitor.tick(scene->tool_scene(tool), {tick.tick,
                                           1e-9 * static_cast<double>(tick.t_ns - first_ns),
                                           dt_s,
                                           {to_quaternion(told.X_WH.q), to_vector(told.X_WH.p)}});
  }
  if (!placed) {
    throw std::runtime_error(stream.recording +
                             ": holds no pose of that scene. Name another recording or --scene-id");
  }
}

}  // namespace hapticd
