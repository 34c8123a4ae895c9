// See scene_desk.h.
#include "server/daemon/scene_desk.h"

#include <google/protobuf/text_format.h>
#include <google/protobuf/util/message_differencer.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <filesystem>
#include <limits>
#include <new>
#include <system_error>
#include <utility>

#include "core/math/assert.h"
#include "core/rt/memory_boundary.h"
#include "core/rt/thread_role.h"
#include "proto/wire/request_result.h"
#include "server/confinement/landlock.h"
#include "server/haptic_loop/thread_policy.h"
#include "server/recorder/state_record.h"
#include "server/scene_io/gesture_loader.h"
#include "server/scene_io/scene_assignment.h"
#include "server/scene_io/scene_parameters.h"
#include "server/scene_io/told_scene.h"

namespace hapticd {
namespace {

using wire::result_of;

/// What a scene is refused for.
struct Faults {
  v1::ResultCode code = v1::RESULT_CODE_INVALID;
  std::string path;  ///< of the first
  std::string text;  ///< of all
};

Faults faults_of(const LoadResult& result) {
  Faults faults;
  if (result.missing) faults = {v1::RESULT_CODE_NOT_FOUND, "name", ""};
  for (const SceneProblem& problem : result.problems) {
    if (problem.doubt) continue;
    if (faults.path.empty()) faults.path = problem.field;
    faults.text += (faults.text.empty() ? "" : "\n") + to_text(problem);
  }
  return faults;
}

/// What of a good scene is without effect, or not as it was asked for: a line each.
std::string doubts_of(const LoadResult& result) {
  std::string doubts;
  for (const SceneProblem& problem : result.problems) {
    if (problem.doubt) doubts += (doubts.empty() ? "" : "\n") + to_text(problem);
  }
  return doubts;
}

/// The first file of a recorded scene that is not the same here; empty: all are.
std::string changed_asset(const v1::SceneRecord& record, const LoadedScene& loaded) {
  for (const v1::Asset& asset : record.assets()) {
    const auto same = [&](const SceneAsset& here) {
      return here.name == asset.name() &&
             std::equal(here.hash.begin(), here.hash.end(), asset.hash().begin(),
                        asset.hash().end(),
                        [](std::uint8_t a, char b) { return a == static_cast<std::uint8_t>(b); });
    };
    if (std::none_of(loaded.assets.begin(), loaded.assets.end(), same)) return asset.name();
  }
  return "";
}

/// Whether `now` says the same as `then` in all that `then` says: fields that are newer than it
/// have their defaults.
bool says_what_was_said(const v1::Scene& now, const v1::Scene& then) {
  google::protobuf::util::MessageDifferencer comparison;
  comparison.set_scope(google::protobuf::util::MessageDifferencer::PARTIAL);
  return comparison.Compare(then, now);
}

/// Paths of one GetParameters.
constexpr int kMaxPaths = 64;
/// Ticks that a change may wait for its own, at most.
constexpr std::uint64_t kMaxTicksToWait = 1'000'000;

/// Why a change cannot be taken while `waiting` others are under way; nothing: it can.
std::optional<v1::Result> refusal_of_change(const v1::SetParameter& set, std::uint64_t next,
                                            std::size_t waiting) {
  constexpr const char* kPath = "set_parameter.at_tick";
  if (set.has_at_tick() && set.at_tick() < next) {
    return result_of(v1::RESULT_CODE_OUT_OF_RANGE, kPath, "That tick has already begun.");
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

SceneDesk::SceneDesk(DaemonPlan& plan, LoopDesk& loop, ServedClients& clients,
                     RecorderThread* recorder)
    : plan_(plan), loop_(loop), clients_(clients), recorder_(recorder) {}

std::unique_ptr<PlayedScene> SceneDesk::first_scene() {
  LoadResult result = load_scene(plan_.options.config.scene(), load_options(plan_));
  std::string faults;
  for (const SceneProblem& problem : result.problems) {
    if (problem.doubt) {
      spdlog::warn("{}", to_text(problem));
    } else {
      faults += (faults.empty() ? "" : "\n") + to_text(problem);
    }
  }
  if (result.loaded == nullptr) throw StartError(kExitInput, faults);
  LiveScene& scene = begin_playing(std::move(result.loaded));
  return make_played_scene(scene.loaded, scene.id, first_gesture(*scene.loaded), plan_.player);
}

std::unique_ptr<PlayedScene> SceneDesk::recorded_scene(const v1::SceneRecord& record,
                                                       const std::string& path) {
  const std::string which =
      path + ": scene " + std::to_string(record.scene_id()) + " of the recording ";
  std::string text;
  google::protobuf::TextFormat::PrintToString(record.scene(), &text);
  LoadOptions options = load_options(plan_);
  options.quality = {};
  options.longest_info = std::numeric_limits<std::size_t>::max();  // It was played.
  options.paths.models.insert(options.paths.models.begin(),
                              std::filesystem::path(path).parent_path());
  LoadResult result = load_scene_text(text, options);
  if (result.loaded == nullptr) {
    throw StartError(kExitInput, which + "cannot be played here:\n" + faults_text(result.problems));
  }
  const std::string asset = changed_asset(record, *result.loaded);
  if (!asset.empty()) {
    throw StartError(kExitInput, which + "was made with another " + asset +
                                     " than the one here. Install the assets it was recorded "
                                     "with, or put the file beside the recording.");
  }
  if (!says_what_was_said(result.loaded->message, record.scene())) {
    throw StartError(kExitInput,
                     which + "means something else to this version. Use the one that recorded it.");
  }
  last_scene_id_ = record.scene_id() - 1;
  LiveScene& scene = begin_playing(std::move(result.loaded));
  scene.info.set_hash(record.hash());
  plan_.player.max_force = record.has_max_force_n() ? record.max_force_n() : kUnlimited;
  return make_played_scene(scene.loaded, scene.id, nullptr, plan_.player);
}

LiveScene& SceneDesk::begin_playing(std::shared_ptr<const LoadedScene> loaded) {
  LiveScene scene;
  scene.id = ++last_scene_id_;
  scene.index = index_scene(*loaded->scene);
  v1::SceneInfo& info = scene.info;
  info = describe_scene(*loaded);
  info.set_scene_id(scene.id);
  info.set_rate_hz(plan_.options.config.rate());
  info.set_clock(plan_.options.config.clock());
  info.set_server_version(HAPTICD_VERSION);
  if (plan_.stop_port) info.set_stop_port(*plan_.stop_port);
  scene.live = loaded->message;
  leave_open(loaded->given, scene.live);
  scene.choice = loaded->given.choice;
  tell_scene(scene.live, scene.choice, info);
  scene.settings = scene_settings(loaded->scene->description());
  scene.in_force = {scene.live, scene.choice, scene.settings};
  scene.loaded = std::move(loaded);
  announce(scene);
  if (playing_id_ == 0) playing_id_ = scene.id;
  scenes_.push_back(std::move(scene));
  return scenes_.back();
}

// The default gesture is for scenes it fits; one that was asked for has to fit.
std::unique_ptr<GesturePlan> SceneDesk::first_gesture(const LoadedScene& scene) const {
  if (!simulates(plan_.player)) return nullptr;
  const GestureResult result = load_gesture(plan_.options.config.gesture(), installed_gestures());
  if (!result.gesture) {
    std::string text;
    for (const SceneProblem& problem : result.problems) text += to_text(problem) + "\n";
    throw StartError(kExitInput, text.substr(0, text.size() - 1));
  }
  try {
    std::unique_ptr<GesturePlan> plan = plan_gesture(*result.gesture, scene);
    plan->repeat = 0;
    return plan;
  } catch (const std::runtime_error& error) {
    if (plan_.options.gesture_given) throw;
    spdlog::info("the hand rests: {}", error.what());
    return nullptr;
  }
}

const LiveScene& SceneDesk::playing(std::uint32_t scene_id) const {
  for (const LiveScene& scene : scenes_) {
    if (scene.id == scene_id) return scene;
  }
  HD_ASSERT(false);
  return scenes_.front();
}

void SceneDesk::forget_before(std::uint32_t scene_id) {
  if (scene_id != playing_id_) return;
  while (scenes_.front().id != playing_id_) scenes_.pop_front();
}

Answer SceneDesk::load(const RequestId& id, const v1::LoadScene& load, BroughtFiles brought) {
  if (load.source_case() == v1::LoadScene::SOURCE_NOT_SET) {
    return result_of(v1::RESULT_CODE_INVALID, "load_scene.source", "Give name or text.");
  }
  return build(id, load, std::move(brought));
}

Answer SceneDesk::build(const std::optional<RequestId>& request, const v1::LoadScene& load,
                        BroughtFiles brought) {
  if (build_ || swapping_) {
    return result_of(v1::RESULT_CODE_BUSY, "load_scene",
                     "Another scene is being loaded. Try again.");
  }
  LoadOptions options = load_options(plan_);
  options.brought = std::move(brought);
  if (load.has_preset()) options.preset = load.preset();
  // Of the configuration the name may be any file's; a peer's is an installed scene's.
  const bool any_file = !request;
  try {
    build_ = SceneBuild{request, load.check_only(),
                        std::async(std::launch::async, [load, options, any_file] {
                          name_thread("builder");
                          begin_role(ThreadRole::kBuilder);
                          if (load.has_text()) return load_scene_text(load.text(), options);
                          return any_file ? load_scene(load.name(), options)
                                          : load_installed_scene(load.name(), options);
                        })};
  } catch (const std::system_error& error) {
    return result_of(v1::RESULT_CODE_FAILED, "load_scene",
                     std::string("No thread can be had to load it: ") + error.code().message());
  }
  return std::nullopt;
}

void SceneDesk::finish_build() {
  if (!build_ || build_->result.wait_for(std::chrono::seconds(0)) != std::future_status::ready) {
    return;
  }
  SceneBuild build = std::move(*build_);
  build_.reset();
  if (within_memory([&] { take_build(build); })) return;
  if (build.request) {
    clients_.answer_with(*build.request, [] { return wire::out_of_memory(); });
  } else {
    spdlog::error("not enough memory for the scene: the one before plays on");
  }
}

void SceneDesk::take_build(SceneBuild& build) {
  const auto fail = [&](v1::ResultCode code, const std::string& path, const std::string& message) {
    if (build.request) {
      clients_.answer(*build.request, result_of(code, path, message));
    } else {
      spdlog::error("{}{}", message, reach_remedy(message));
    }
  };
  LoadResult result;
  try {
    result = build.result.get();
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception& error) {
    fail(v1::RESULT_CODE_FAILED, "load_scene", error.what());
    return;
  }
  if (result.loaded == nullptr) {
    const Faults faults = faults_of(result);
    fail(faults.code, faults.path, faults.text);
    return;
  }
  if (build.check_only) {
    clients_.answer(*build.request, result_of(v1::RESULT_CODE_OK, "", doubts_of(result)));
    return;
  }
  try {
    const std::string doubts = doubts_of(result);
    swap_to(std::move(result.loaded), build.request, doubts);
  } catch (const std::runtime_error& error) {
    fail(v1::RESULT_CODE_INVALID, "load_scene", error.what());
  }
}

void SceneDesk::swap_to(std::shared_ptr<const LoadedScene> loaded,
                        const std::optional<RequestId>& request, std::string doubts) {
  std::unique_ptr<GesturePlan> gesture;
  try {
    gesture = first_gesture(*loaded);
  } catch (const std::runtime_error& error) {
    spdlog::info("the hand rests: {}", error.what());
  }
  std::unique_ptr<PlayedScene> played =
      make_played_scene(loaded, last_scene_id_ + 1, std::move(gesture), plan_.player);
  begin_playing(std::move(loaded));
  // The loop may have it at once.
  swapping_ = true;
  bool lent = false;
  const bool asked = within_memory(
      [&] { lent = !loop_.lend(request, std::move(played), std::move(doubts)).has_value(); });
  if (lent) return;
  swapping_ = false;
  scenes_.pop_back();
  if (!asked) throw std::bad_alloc();
  throw std::runtime_error("The loop has too many commands to obey. Try again.");
}

void SceneDesk::finish_swap(std::uint32_t scene_id) {
  playing_id_ = scene_id;
  swapping_ = false;
  change_tick_ = 0;
  v1::Item item;
  *item.mutable_scene_info() = told().info;
  clients_.tell(item);
}

void SceneDesk::take(const LoopEvent& event) {
  if (const auto* swapped = std::get_if<SceneSwapped>(&event.what)) {
    finish_swap(swapped->scene_id);
  } else if (const auto* settled = std::get_if<SettingsRetired>(&event.what)) {
    settle_change(settled->number, settled->dropped);
  }
}

void SceneDesk::work() {
  finish_build();
  // A scene that a client has loaded, or is loading, comes first.
  if (!reload_waits_ || build_ || swapping_) return;
  reload_waits_ = false;
  v1::LoadScene load;
  load.set_name(plan_.options.config.scene());
  static_cast<void>(build(std::nullopt, load, {}));
}

void SceneDesk::reload() {
  const Reread read = reread(plan_);
  if (!read.good) return;
  const v1::Config& config = plan_.options.config;
  if (read.recording_differs) {
    recorder_->stop();
    if (!config.record().empty()) recorder_->start(config.record());
  }
  spdlog::info("reload: scene {}", config.scene());
  reload_waits_ = true;
}

// The loop gives the changes of a lost lease back a tick after the lease has ended. Until then
// whoever has the lease next would set them again.
Answer SceneDesk::parameters(const RequestId& id, const v1::Item& item) {
  if (!loop_.knows_lease_ends()) {
    held_.push_back({id, item, loop_.lease_ends()});
    return std::nullopt;
  }
  return item.has_set_parameter() ? set_parameters(id, item.set_parameter())
                                  : get_parameters(item.get_parameters());
}

// Each may end a lease: answered, its session goes on to the next, which may be a Release.
void SceneDesk::carry_out_held() {
  for (std::size_t count = held_.size(); count > 0 && !held_.empty(); --count) {
    const HeldRequest held = std::move(held_.front());
    held_.pop_front();
    const bool lost = held.item.has_set_parameter() && held.lease_ends != loop_.lease_ends();
    const Answer answer = lost ? result_of(v1::RESULT_CODE_NOT_OWNER, "", "The lease is over.")
                               : parameters(held.id, held.item);
    if (answer) clients_.answer(held.id, *answer);
  }
}

void SceneDesk::abandon(const RequestId& id) {
  std::erase_if(held_, [&](const HeldRequest& held) { return held.id == id; });
}

Answer SceneDesk::get_parameters(const v1::GetParameters& get) const {
  v1::Result result = result_of(v1::RESULT_CODE_OK);
  if (get.paths_size() > kMaxPaths) {
    return result_of(v1::RESULT_CODE_OUT_OF_RANGE, "get_parameters.paths",
                     "At most 64 paths; none asks for all parameters.");
  }
  const std::vector<std::string> paths(get.paths().begin(), get.paths().end());
  const auto values = parameter_values(newest().live, paths);
  if (values.unknown) {
    return result_of(v1::RESULT_CODE_NOT_FOUND, *values.unknown,
                     unknown_parameter(newest().live, *values.unknown));
  }
  for (const v1::Assignment& value : values.values) {
    *result.mutable_parameters()->add_values() = value;
  }
  result.mutable_parameters();
  return result;
}

Answer SceneDesk::set_parameters(const RequestId& id, const v1::SetParameter& set) {
  LiveScene& scene = scenes_.back();
  const std::uint64_t next = loop_.next_tick();
  if (auto refused = refusal_of_change(set, next, scene.changes.size())) return refused;
  const LoadOptions load = load_options(plan_);
  const QualityWish& wish = load.quality;
  AssignmentResult assigned = assign_parameters(scene.live, set, load.device_stiffness,
                                                wish.budget_us.value_or(wish.usual_budget_us));
  if (assigned.code != v1::RESULT_CODE_OK) {
    return result_of(assigned.code, assigned.path, assigned.message);
  }
  // What is of the whole scene is the same in all tools.
  const LiveSettings& before = scene.settings.tools.front();
  for (LiveSettings& live : assigned.settings.tools) {
    if (!live.quality_automatic || !before.quality_automatic) continue;
    take_to_level(static_cast<int>(before.quality_level), assigned.scene.solver(), live);
  }
  auto change = std::make_unique<SettingsChange>();
  change->at_tick = set.has_at_tick() ? set.at_tick() : 0;
  change->number = loop_.next_number();
  change->from = assigned.settings;
  change->to = assigned.settings;
  announce_change(change->to, &set);
  // Noted before the loop hears of it, which may give it back at once.
  const std::uint64_t number = change->number;
  const std::uint64_t at_tick = change->at_tick;
  change_tick_ = std::max(change_tick_, at_tick);
  LiveScene::Parameters after{std::move(assigned.scene), scene.choice,
                              std::move(assigned.settings)};
  follow_choice(set, after.choice);
  scene.changes.push_back({number, std::max(at_tick, next), after});
  Answer refused = wire::out_of_memory();
  within_memory([&] {
    scene.take(std::move(after));
    refused = loop_.lend(id, std::move(change));
  });
  if (refused) settle_change(number, true);
  return refused;
}

bool SceneDesk::set_level(int level, std::uint64_t tick) {
  LiveScene& scene = scenes_.back();
  SceneSettings settings = scene.settings;
  for (LiveSettings& live : settings.tools) take_to_level(level, scene.live.solver(), live);
  auto change = std::make_unique<SettingsChange>();
  change->number = loop_.next_number();
  change->from = settings;
  change->to = settings;
  announce_change(change->to, nullptr);
  const std::uint64_t number = change->number;
  scene.changes.push_back({number, tick + 1, {scene.live, scene.choice, settings}});
  bool lent = false;
  within_memory([&] { lent = !loop_.lend(std::nullopt, std::move(change)).has_value(); });
  if (lent) {
    scene.settings = std::move(settings);
  } else {
    scene.changes.pop_back();
  }
  return lent;
}

void SceneDesk::settle_change(std::uint64_t number, bool dropped) {
  if (dropped && recorder_ != nullptr) recorder_->forget_change(number);
  for (LiveScene& scene : scenes_) {
    if (!scene.settle(number, dropped)) continue;
    if (!dropped) return;
    change_tick_ = 0;
    for (const LiveScene::Change& each : scene.changes) {
      change_tick_ = std::max(change_tick_, each.at_tick);
    }
    return;
  }
}

void SceneDesk::announce(const LiveScene& scene) {
  if (recorder_ == nullptr) return;
  v1::SceneRecord record;
  record.set_scene_id(scene.id);
  *record.mutable_scene() = scene.loaded->message;
  record.set_hash(scene.info.hash());
  *record.mutable_assets() = scene.info.assets();
  if (plan_.player.max_force < kUnlimited) record.set_max_force_n(plan_.player.max_force);
  recorder_->announce(std::move(record), scene.index);
}

// Before the loop hears of the change, whose number is the next.
void SceneDesk::announce_change(const SceneSettings& settings, const v1::SetParameter* set) {
  if (recorder_ == nullptr) return;
  v1::ParameterRecord record;
  record.set_number(loop_.next_number());
  if (set != nullptr) *record.mutable_assignments() = set->assignments();
  put_settings(settings, record);
  recorder_->announce_change(std::move(record));
}

}  // namespace hapticd
