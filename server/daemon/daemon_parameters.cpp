// Live parameters: told, changed at a tick, and put back where whoever asked for a change has lost
// the lease before its tick. See daemon.h.
#include <algorithm>

#include "proto/wire/request_result.h"
#include "server/daemon/daemon.h"
#include "server/scene_io/scene_assignment.h"
#include "server/scene_io/scene_parameters.h"
#include "server/scene_io/told_scene.h"

namespace hapticd {
namespace {

using wire::result_of;

/// Paths of one GetParameters.
constexpr int kMaxPaths = 64;
/// Ticks that a change may wait for its own, at most.
constexpr std::uint64_t kMaxTicksToWait = 1'000'000;

/// Why a change cannot be taken while `waiting` others are under way; nothing: it can.
std::optional<v1::Result> refusal_of_change(const v1::SetParameter& set, std::uint64_t next,
                                            std::size_t waiting) {
  constexpr const char* kPath = "set_parameter.at_tick";
  if (set.has_at_tick() && set.at_tick() < next) {
    return result_of(v1::RESULT_CODE_OUT_OF_RANGE, kPath, "That tick has begun.");
  }
  if (set.has_at_tick() && set.at_tick() - next > kMaxTicksToWait) {
    return result_of(v1::RESULT_CODE_OUT_OF_RANGE, kPath,
                     "At most 1000000 ticks ahead; the next tick is " + std::to_string(next) + ".");
  }
  // One place is left for the change that automatic quality may make.
  if (waiting + 1 >= kWaitingChanges) {
    return result_of(v1::RESULT_CODE_BUSY, "set_parameter",
                     "63 changes wait for their tick. Let time run, or put several assignments "
                     "into one request.");
  }
  return std::nullopt;
}

}  // namespace

void Daemon::LiveScene::take(Parameters now) {
  live = std::move(now.live);
  choice = std::move(now.choice);
  settings = std::move(now.settings);
  tell_scene(live, choice, info);
}

// The loop gives the changes of a lost lease back a tick after the lease has ended. Until then they
// are among what is set, and whoever has the lease next would set them again.
bool Daemon::hold(const RequestId& id, const v1::Item& item) {
  if (!item.has_set_parameter() && !item.has_get_parameters()) return false;
  // The loop hears of nothing more once it ends.
  const bool known = told_lease_ends_ == lease_ends_ && lease_end_command_ == 0;
  if (known || ending_since_ns_ >= 0) return false;
  held_.push_back({id, item, lease_ends_});
  return true;
}

// Each may end a lease: answered, its session goes on to the next, which may be a Release.
void Daemon::carry_out_held() {
  for (std::size_t count = held_.size(); count > 0 && !held_.empty(); --count) {
    const HeldRequest held = std::move(held_.front());
    held_.pop_front();
    if (held.item.has_set_parameter() && held.lease_ends != lease_ends_) {
      server_->answer(held.id, result_of(v1::RESULT_CODE_NOT_OWNER, "", "The lease is over."));
    } else {
      request(held.id, held.item);
    }
  }
}

void Daemon::get_parameters(const RequestId& id, const v1::GetParameters& get) {
  v1::Result result = result_of(v1::RESULT_CODE_OK);
  if (get.paths_size() > kMaxPaths) {
    server_->answer(id, result_of(v1::RESULT_CODE_OUT_OF_RANGE, "get_parameters.paths",
                                  "At most 64 paths; none asks for all parameters."));
    return;
  }
  const std::vector<std::string> paths(get.paths().begin(), get.paths().end());
  const auto values = parameter_values(scenes_.back().live, paths);
  if (!values.unknown.empty()) {
    server_->answer(id, result_of(v1::RESULT_CODE_NOT_FOUND, values.unknown,
                                  "No live parameter has this path; SceneInfo lists them."));
    return;
  }
  for (const v1::Assignment& value : values.values) {
    *result.mutable_parameters()->add_values() = value;
  }
  result.mutable_parameters();
  server_->answer(id, result);
}

void Daemon::set_parameters(const RequestId& id, const v1::SetParameter& set) {
  LiveScene& scene = scenes_.back();
  const std::uint64_t next = virtual_time_ ? loop_->next_tick() : newest_tick_ + 1;
  if (const auto refused = refusal_of_change(set, next, scene.changes.size())) {
    server_->answer(id, *refused);
    return;
  }
  const LoadOptions load = load_options();
  const QualityWish& wish = load.quality;
  AssignmentResult assigned = assign_parameters(scene.live, set, load.device_stiffness,
                                                wish.budget_us.value_or(wish.usual_budget_us));
  if (assigned.code != v1::RESULT_CODE_OK) {
    server_->answer(id, result_of(assigned.code, assigned.path, assigned.message));
    return;
  }
  // What is of the whole scene is the same in all tools.
  const LiveSettings& before = scene.settings.tools.front();
  for (LiveSettings& live : assigned.settings.tools) {
    if (!live.quality_automatic || !before.quality_automatic) continue;
    take_to_level(static_cast<int>(before.quality_level), assigned.scene.solver(), live);
  }
  auto change = std::make_unique<SettingsChange>();
  change->at_tick = set.has_at_tick() ? set.at_tick() : 0;
  change->number = last_command_ + 1;
  change->from = assigned.settings;
  change->to = assigned.settings;
  announce_change(change->to, &set);
  // Noted before the loop hears of it, which may give it back at once.
  const SettingsChange* lent = change.get();
  change_tick_ = std::max(change_tick_, lent->at_tick);
  LiveScene::Parameters after{std::move(assigned.scene), scene.choice,
                              std::move(assigned.settings)};
  follow_choice(set, after.choice);
  scene.changes.push_back({lent, std::max(lent->at_tick, next), after});
  scene.take(std::move(after));
  if (command(id, ChangeSettingsCommand{change.get()})) {
    static_cast<void>(change.release());
  } else {
    settle_change(*change, true);
  }
}

void Daemon::settle_change(const SettingsChange& change, bool dropped) {
  if (dropped && recording_) recording_->forget_change(change.number);
  for (LiveScene& scene : scenes_) {
    const auto found =
        std::find_if(scene.changes.begin(), scene.changes.end(),
                     [&](const LiveScene::Change& each) { return each.lent == &change; });
    if (found == scene.changes.end()) continue;
    // Changes are over in the order in which they began.
    if (!dropped) scene.in_force = std::move(found->parameters);
    scene.changes.erase(found);
    if (!dropped) return;
    scene.take(scene.changes.empty() ? scene.in_force : scene.changes.back().parameters);
    change_tick_ = 0;
    for (const LiveScene::Change& each : scene.changes) {
      change_tick_ = std::max(change_tick_, each.at_tick);
    }
    return;
  }
}

}  // namespace hapticd
