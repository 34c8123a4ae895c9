// See play_desk.h.
#include "server/daemon/play_desk.h"

#include <algorithm>
#include <utility>

#include "proto/wire/request_result.h"
#include "server/daemon/scene_tool.h"
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
QueuedPose queued_pose(const v1::PoseSample& sample) {
  QueuedPose pose;
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

}  // namespace

Answer PlayDesk::fault_of(const v1::PoseSample& sample, const std::string& path) const {
  if (tool_of(sample.tool_id(), scenes_.newest().index) == kNoTool) {
    return no_such_tool(path + ".tool_id");
  }
  if (!device_of(player_, sample.tool_id()).source.driver->takes_poses) {
    return result_of(v1::RESULT_CODE_WRONG_STATE, path + ".tool_id",
                     "Its device is not scripted: start hapticd with --device scripted.");
  }
  if (!complete(sample)) {
    return result_of(v1::RESULT_CODE_INVALID, path,
                     "A pose has 3 numbers p_m and 4 numbers q, or none of them.");
  }
  if (sample.buttons() > kMaxButtons) {
    return result_of(v1::RESULT_CODE_OUT_OF_RANGE, path + ".buttons",
                     "There are 16 buttons: at most 65535.");
  }
  return std::nullopt;
}

// The k-th sample of a tool is for first_tick + k.
Answer PlayDesk::queue_poses(const v1::PoseBatch& batch) {
  const SceneIndex& index = scenes_.newest().index;
  if (batch.poses_size() < 1 || batch.poses_size() > 16) {
    return result_of(v1::RESULT_CODE_OUT_OF_RANGE, "pose_batch.poses", "Send 1 to 16.");
  }
  for (int k = 0; k < batch.poses_size(); ++k) {
    Answer fault = fault_of(batch.poses(k), "pose_batch.poses[" + std::to_string(k) + "]");
    if (fault) return fault;
  }
  const std::uint64_t next = loop_.next_tick();
  std::array<std::uint64_t, kMaxTools> ticks{};
  for (std::size_t k = 0; k < ticks.size(); ++k) {
    ticks[k] = batch.has_first_tick() ? batch.first_tick() : std::max(next_ticks_[k], next);
  }
  // Any tick may have been asked for: nothing is added to it before it is known to be near.
  const auto queue_ends = [&](std::uint64_t tick) {
    return tick >= next && tick - next >= kPoseQueue;
  };
  auto after = ticks;
  for (const v1::PoseSample& sample : batch.poses()) {
    std::uint64_t& tick = after[tool_of(sample.tool_id(), index)];
    if (queue_ends(tick)) {
      return result_of(v1::RESULT_CODE_BUSY, "pose_batch.first_tick",
                       "The queue holds the next 4096 ticks, " + std::to_string(next) + " to " +
                           std::to_string(next + kPoseQueue - 1) +
                           ". Run or wait, or name a nearer first_tick.");
    }
    ++tick;
  }
  auto& poses = loop_.channels().poses;
  if (poses.size() + 16 > poses.capacity()) {
    return result_of(v1::RESULT_CODE_BUSY, "pose_batch",
                     "Poses come faster than the loop takes them. Wait a tick.");
  }
  for (const v1::PoseSample& sample : batch.poses()) {
    const std::uint32_t tool = tool_of(sample.tool_id(), index);
    poses.push({ticks[tool], tool, loop_.lease_ends(), queued_pose(sample)});
    ++ticks[tool];
    next_ticks_[tool] = std::max(next_ticks_[tool], ticks[tool]);
  }
  loop_.obey();
  return result_of(v1::RESULT_CODE_OK);
}

Answer PlayDesk::play_gesture(const RequestId& id, const v1::PlayGesture& play) {
  if (!simulates(player_)) {
    return result_of(v1::RESULT_CODE_WRONG_STATE, "play_gesture",
                     "Only the simulated hand plays gestures.");
  }
  if (play.repeat() > kMaxRepeats) {
    return result_of(v1::RESULT_CODE_OUT_OF_RANGE, "play_gesture.repeat",
                     "At most 1000000; 0 repeats until told otherwise.");
  }
  auto plan = std::make_unique<GesturePlan>();
  if (play.source_case() != v1::PlayGesture::SOURCE_NOT_SET) {
    const GestureResult loaded = play.has_gesture()
                                     ? check_gesture(play.gesture())
                                     : load_installed_gesture(play.name(), installed_gestures());
    if (!loaded.gesture) {
      SceneProblem problem = loaded.problems.front();
      const std::string path = "play_gesture." + problem.field;
      if (play.has_gesture()) problem.field.clear();  // the path has it
      return loaded.missing
                 ? result_of(v1::RESULT_CODE_NOT_FOUND, "play_gesture.name", to_text(problem))
                 : result_of(v1::RESULT_CODE_INVALID, path, to_text(problem));
    }
    try {
      plan = plan_gesture(*loaded.gesture, *scenes_.newest().loaded);
    } catch (const std::runtime_error& error) {
      return result_of(v1::RESULT_CODE_INVALID, "play_gesture", error.what());
    }
  }
  if (play.arm() != v1::ARM_UNSPECIFIED) plan->arm = static_cast<ArmKind>(play.arm());
  if (play.has_seed()) plan->seed = play.seed();
  plan->repeat = play.has_repeat() ? play.repeat() : 1;
  return loop_.lend(id, std::move(plan));
}

}  // namespace hapticd
