// What clients ask for, beyond sessions and lease. See daemon.h.
#include <algorithm>

#include "proto/wire/request_result.h"
#include "server/daemon/daemon.h"
#include "server/scene_io/choice_check.h"
#include "server/scene_io/gesture_loader.h"

namespace hapticd {
namespace {

using wire::result_of;

Array3 three(const google::protobuf::RepeatedField<double>& numbers) {
  Array3 out{};
  for (int k = 0; k < 3 && k < numbers.size(); ++k) out[static_cast<std::size_t>(k)] = numbers[k];
  return out;
}

/// The pose as it came; numbers that make no sense are the loop's to judge.
ScriptedPose scripted_pose(const v1::PoseSample& sample) {
  ScriptedPose pose;
  pose.p_DH = three(sample.pose_dh().p_m());
  if (sample.pose_dh().q_size() == 4) {
    for (int k = 0; k < 4; ++k) pose.q_DH[static_cast<std::size_t>(k)] = sample.pose_dh().q(k);
  }
  pose.has_velocity = sample.has_twist_dh_d();
  pose.v_DH_D = three(sample.twist_dh_d().v_m_per_s());
  pose.w_DH_D = three(sample.twist_dh_d().w_rad_per_s());
  pose.buttons = static_cast<std::uint16_t>(sample.buttons());
  return pose;
}

/// Numbers that a pose has to have: none, or all of them.
bool complete(const v1::PoseSample& sample) {
  const auto none_or = [](int size, int all) { return size == 0 || size == all; };
  return sample.has_pose_dh() && none_or(sample.pose_dh().p_m_size(), 3) &&
         none_or(sample.pose_dh().q_size(), 4) &&
         none_or(sample.twist_dh_d().v_m_per_s_size(), 3) &&
         none_or(sample.twist_dh_d().w_rad_per_s_size(), 3);
}

/// Repetitions of a gesture, at most.
constexpr std::uint32_t kMaxRepeats = 1'000'000;
/// Buttons of a pose are 16 bits.
constexpr std::uint32_t kMaxButtons = 0xffff;

constexpr const char* kNoSuchTool = "The scene has no such tool.";

/// No tool.
constexpr std::uint32_t kNoTool = ~0U;

/// Which tool of the scene this is, in its order; kNoTool when it has none of that id.
std::uint32_t tool_of(std::uint32_t tool_id, const SceneIndex& index) {
  const auto found = std::find(index.tool_ids.begin(), index.tool_ids.end(), tool_id);
  if (found == index.tool_ids.end()) return kNoTool;
  return static_cast<std::uint32_t>(found - index.tool_ids.begin());
}

/// The command that a request is, for those that are one and nothing else.
std::optional<LoopCommandBody> command_of(const v1::Item& item, const SceneIndex& index) {
  switch (item.body_case()) {
    case v1::Item::kEngage:
      return EngageCommand{};
    case v1::Item::kDisengage:
      return DisengageCommand{};
    case v1::Item::kStop:
      return StopCommand{};
    case v1::Item::kClear:
      return ClearCommand{};
    case v1::Item::kRecentre:
      return RecentreCommand{tool_of(item.recentre().tool_id(), index)};
    case v1::Item::kClutch:
      return ClutchCommand{tool_of(item.clutch().tool_id(), index), item.clutch().open()};
    default:
      return std::nullopt;
  }
}

}  // namespace

void Daemon::request(const RequestId& id, const v1::Item& item) {
  if (refuse_in_replay(id, item)) return;
  if (virtual_time_) take_events();
  if (const std::optional<UnknownChoice> unknown = unknown_choice(item)) {
    server_->answer(id, result_of(v1::RESULT_CODE_INVALID, unknown->path, unknown->message));
    return;
  }
  if (hold(id, item)) return;
  const SceneIndex& index = scenes_.back().index;
  const auto unknown = [&](std::uint32_t tool_id) { return tool_of(tool_id, index) == kNoTool; };
  if ((item.has_recentre() && unknown(item.recentre().tool_id())) ||
      (item.has_clutch() && unknown(item.clutch().tool_id()))) {
    server_->answer(
        id, result_of(v1::RESULT_CODE_NOT_FOUND,
                      item.has_clutch() ? "clutch.tool_id" : "recentre.tool_id", kNoSuchTool));
    return;
  }
  stop_asked_ = stop_asked_ || (item.has_stop() && steps_.has_value());
  if (const auto what = command_of(item, index)) {
    command(id, *what);
    return;
  }
  switch (item.body_case()) {
    case v1::Item::kRun:
      return run_time(id, item.run());
    case v1::Item::kPoseBatch:
      return queue_poses(id, item.pose_batch());
    case v1::Item::kLoadScene:
      return load_scene_for(id, item.load_scene());
    case v1::Item::kGetParameters:
      return get_parameters(id, item.get_parameters());
    case v1::Item::kSetParameter:
      return set_parameters(id, item.set_parameter());
    case v1::Item::kPlayGesture:
      return play_gesture(id, item.play_gesture());
    case v1::Item::kRecord:
      return record(id, item.record());
    case v1::Item::kReplay:
      return answer_replay(id, item.replay());
    case v1::Item::kListScenes:
      return list(id, catalogues_.scenes());
    case v1::Item::kListGestures:
      return list(id, catalogues_.gestures());
    case v1::Item::kListRecordings:
      return list(id, catalogues_.recordings());
    case v1::Item::kGetDeviceInfo:
      return describe_devices(id);
    case v1::Item::kCalibrate:
      return calibrate(id, item.calibrate());
    default:
      return server_->answer(id, result_of(v1::RESULT_CODE_UNSUPPORTED, "",
                                           "This version of hapticd does not know the request."));
  }
}

void Daemon::load_scene_for(const RequestId& id, const v1::LoadScene& load) {
  if (load.source_case() == v1::LoadScene::SOURCE_NOT_SET) {
    server_->answer(id,
                    result_of(v1::RESULT_CODE_INVALID, "load_scene.source", "Give name or text."));
    return;
  }
  build_scene(id, load);
}

bool Daemon::command(const RequestId& id, const LoopCommandBody& what) {
  const std::uint64_t number = ++last_command_;
  if (!channels_->commands.push({number, what})) {
    server_->answer(id, result_of(v1::RESULT_CODE_BUSY, "", "Too many commands at once."));
    return false;
  }
  commands_.emplace_back(number, id);
  if (virtual_time_) {
    loop_->take_commands();
    take_events();
  }
  return true;
}

void Daemon::finish_command(std::uint64_t number, bool obeyed, Cause cause) {
  // They are obeyed in order.
  if (number >= lease_end_command_) lease_end_command_ = 0;
  const auto same = [&](const auto& command) { return command.first == number; };
  const auto found = std::find_if(commands_.begin(), commands_.end(), same);
  if (found == commands_.end()) return;
  const RequestId id = found->second;
  commands_.erase(found);
  server_->answer(id,
                  obeyed ? result_of(v1::RESULT_CODE_OK)
                         : result_of(v1::RESULT_CODE_WRONG_STATE, "", std::string(explain(cause))));
}

std::optional<v1::Result> Daemon::fault_of_pose(const v1::PoseSample& sample,
                                                const std::string& path) const {
  if (tool_of(sample.tool_id(), scenes_.back().index) == kNoTool) {
    return result_of(v1::RESULT_CODE_NOT_FOUND, path + ".tool_id", kNoSuchTool);
  }
  if (device_of(player_, sample.tool_id()).source != "scripted") {
    return result_of(v1::RESULT_CODE_WRONG_STATE, path + ".tool_id",
                     "Its device is not scripted: start hapticd with --device scripted.");
  }
  if (!complete(sample)) {
    return result_of(v1::RESULT_CODE_INVALID, path,
                     "A pose has 3 numbers p_m and 4 numbers q, or none of them.");
  }
  if (sample.buttons() > kMaxButtons) {
    return result_of(v1::RESULT_CODE_OUT_OF_RANGE, path + ".buttons",
                     "There are 16: at most 65535.");
  }
  return std::nullopt;
}

// The k-th sample of a tool is for first_tick + k.
void Daemon::queue_poses(const RequestId& id, const v1::PoseBatch& batch) {
  const SceneIndex& index = scenes_.back().index;
  if (batch.poses_size() < 1 || batch.poses_size() > 16) {
    server_->answer(id,
                    result_of(v1::RESULT_CODE_OUT_OF_RANGE, "pose_batch.poses", "Send 1 to 16."));
    return;
  }
  for (int k = 0; k < batch.poses_size(); ++k) {
    const auto fault = fault_of_pose(batch.poses(k), "pose_batch.poses[" + std::to_string(k) + "]");
    if (!fault) continue;
    server_->answer(id, *fault);
    return;
  }
  const std::uint64_t next = virtual_time_ ? loop_->next_tick() : newest_tick_ + 1;
  std::array<std::uint64_t, kMaxTools> ticks{};
  for (std::size_t k = 0; k < ticks.size(); ++k) {
    ticks[k] = batch.has_first_tick() ? batch.first_tick() : std::max(next_pose_ticks_[k], next);
  }
  // Any tick may have been asked for: nothing is added to it before it is known to be near.
  const auto queue_ends = [&](std::uint64_t tick) {
    return tick >= next && tick - next >= kScriptedQueue;
  };
  auto after = ticks;
  for (const v1::PoseSample& sample : batch.poses()) {
    std::uint64_t& tick = after[tool_of(sample.tool_id(), index)];
    if (queue_ends(tick)) {
      server_->answer(id, result_of(v1::RESULT_CODE_BUSY, "pose_batch.first_tick",
                                    "The queue holds the next 4096 ticks, " + std::to_string(next) +
                                        " to " + std::to_string(next + kScriptedQueue - 1) +
                                        ". Run or wait, or name a nearer first_tick."));
      return;
    }
    ++tick;
  }
  if (channels_->poses.size() + 16 > channels_->poses.capacity()) {
    server_->answer(id, result_of(v1::RESULT_CODE_BUSY, "pose_batch",
                                  "Poses come faster than the loop takes them. Wait a tick."));
    return;
  }
  for (const v1::PoseSample& sample : batch.poses()) {
    const std::uint32_t tool = tool_of(sample.tool_id(), index);
    channels_->poses.push({ticks[tool], tool, lease_ends_, scripted_pose(sample)});
    ++ticks[tool];
    next_pose_ticks_[tool] = std::max(next_pose_ticks_[tool], ticks[tool]);
  }
  if (virtual_time_) loop_->take_commands();
  server_->answer(id, result_of(v1::RESULT_CODE_OK));
}

void Daemon::play_gesture(const RequestId& id, const v1::PlayGesture& play) {
  if (!simulates()) {
    server_->answer(id, result_of(v1::RESULT_CODE_WRONG_STATE, "play_gesture",
                                  "Only the simulated hand plays gestures."));
    return;
  }
  if (play.repeat() > kMaxRepeats) {
    server_->answer(id, result_of(v1::RESULT_CODE_OUT_OF_RANGE, "play_gesture.repeat",
                                  "At most 1000000; 0 plays on until told otherwise."));
    return;
  }
  auto plan = std::make_unique<GesturePlan>();
  if (play.source_case() != v1::PlayGesture::SOURCE_NOT_SET) {
    const GestureResult loaded = play.has_gesture()
                                     ? check_gesture(play.gesture())
                                     : load_installed_gesture(play.name(), installed_gestures());
    if (!loaded.gesture) {
      const SceneProblem& problem = loaded.problems.front();
      server_->answer(
          id, loaded.missing
                  ? result_of(v1::RESULT_CODE_NOT_FOUND, "play_gesture.name", to_text(problem))
                  : result_of(v1::RESULT_CODE_INVALID, "play_gesture." + problem.field,
                              to_text(problem)));
      return;
    }
    try {
      plan = plan_gesture(*loaded.gesture, *scenes_.back().loaded);
    } catch (const std::runtime_error& error) {
      server_->answer(id, result_of(v1::RESULT_CODE_INVALID, "play_gesture", error.what()));
      return;
    }
  }
  if (play.arm() != v1::ARM_UNSPECIFIED) plan->arm = static_cast<ArmKind>(play.arm());
  if (play.has_seed()) plan->seed = play.seed();
  plan->repeat = play.has_repeat() ? play.repeat() : 1;
  // Taken by the loop, which may have given it back by now: not ours to free.
  if (command(id, PlayGestureCommand{plan.get()})) static_cast<void>(plan.release());
}

void Daemon::list(const RequestId& id, const std::vector<ListedName>& names) {
  v1::Result result = result_of(v1::RESULT_CODE_OK);
  v1::Listing& listing = *result.mutable_listing();
  for (const ListedName& each : names) {
    listing.add_names(each.name);
    listing.add_descriptions(each.description);
  }
  server_->answer(id, result);
}

void Daemon::describe_devices(const RequestId& id) {
  v1::Result result = result_of(v1::RESULT_CODE_OK);
  const std::vector<std::uint32_t>& tool_ids = scenes_.back().index.tool_ids;
  for (std::size_t k = 0; k < tool_ids.size(); ++k) {
    *result.mutable_devices()->add_devices() = device_info(k);
  }
  server_->answer(id, result);
}

}  // namespace hapticd
