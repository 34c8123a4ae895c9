// See recorded_scene.h.
#include "tests/oracle/recorded_scene.h"

#include <google/protobuf/text_format.h>

#include <algorithm>
#include <filesystem>
#include <limits>
#include <stdexcept>
#include <utility>

#include "device/attach/drivers.h"
#include "server/haptic_loop/device_limits.h"
#include "server/haptic_loop/tool_loop.h"
#include "server/recorder/state_record.h"
#include "server/scene_io/profile_loader.h"
#include "tests/oracle/table.h"

namespace hapticd {
namespace {

/// The driver that was behind device number k.
DeviceDriver driver_of(const v1::RecordHeader& header, int k, const DeviceProfile& profile) {
  return recorded_driver(
      k < header.config().device_size() ? header.config().device(k).source() : "", profile);
}

/// Number of the device of a tool in the header: its own, or the first.
int device_of(const v1::RecordHeader& header, std::uint32_t tool_id) {
  for (int k = 0; k < header.devices_size(); ++k) {
    if (header.devices(k).tool_id() == tool_id) return k;
  }
  return 0;
}

/// The first file of a recorded scene that is not the same here; empty: all are.
std::string changed_asset(const v1::SceneRecord& record, const LoadedScene& loaded) {
  for (const v1::Asset& asset : record.assets()) {
    const auto same = [&](const SceneAsset& here) {
      return here.name == asset.name() &&
             std::string(here.hash.begin(), here.hash.end()) == asset.hash();
    };
    if (std::none_of(loaded.assets.begin(), loaded.assets.end(), same)) return asset.name();
  }
  return "";
}

}  // namespace

RecordedScene::RecordedScene(const v1::SceneRecord& record, const v1::RecordHeader& header,
                             const std::string& path, const ScenePaths& paths)
    : path_(path) {
  std::string text;
  google::protobuf::TextFormat::PrintToString(record.scene(), &text);
  LoadOptions options;
  options.paths = paths;
  options.longest_info = std::numeric_limits<std::size_t>::max();  // It was played.
  options.paths.models.insert(options.paths.models.begin(),
                              std::filesystem::path(path).parent_path());
  LoadResult result = load_scene_text(text, options);
  const std::string which = "scene " + std::to_string(record.scene_id()) + " of the recording ";
  if (result.loaded == nullptr) {
    fail(which + "cannot be played here:\n" + faults_text(result.problems));
  }
  const std::string asset = changed_asset(record, *result.loaded);
  if (!asset.empty()) {
    fail(which + "was made with another " + asset +
         " than the one here. Name the folder it was recorded with by --data, or put the file "
         "beside the recording");
  }
  if (result.loaded->message.SerializeAsString() != record.scene().SerializeAsString()) {
    fail(which + "means something else to this version. Use the one that recorded it");
  }
  loaded_ = std::move(result.loaded);
  play(header);
  played_->scene_id = record.scene_id();
}

void RecordedScene::play(const v1::RecordHeader& header) {
  const SceneDescription& description = scene().description();
  played_ = std::make_unique<PlayedScene>();
  played_->play = scene().simulate();
  played_->settings = scene_settings(description);
  played_->strings.resize(played_->settings.pieces.size());
  for (std::size_t k = 0; k < description.tools.size(); ++k) {
    const int device = device_of(header, description.tools[k].tool_id);
    if (header.devices().empty()) fail("it names no device. Name another recording");
    const ProfileResult profile = check_profile(header.devices(device).profile());
    if (!profile.loaded) {
      fail("its device profile does not hold in this version: " + faults_text(profile.problems) +
           ". Use the version that recorded it");
    }
    PlayedTool tool;
    tool.tool_id = description.tools[k].tool_id;
    tool.map = description.tools[k].workspace;
    InsideOptions inside;
    inside.recorded = driver_of(header, device, profile.loaded->profile);
    OpenDevice made = driver_entry(DeviceDriver::kReplay).make(*profile.loaded, inside);
    tool.device.owned = std::move(made.device);
    tool.device.device = tool.device.owned.get();
    tool.device.traits = driver_entry(inside.recorded).traits;
    DriverTraits bearing = tool.device.traits;
    bearing.has_no_clock = driver_entry(profile.loaded->profile.driver).traits.has_no_clock;
    tool.stiffness_limits = stiffness_limits_of(profile.loaded->profile, bearing,
                                                1e-9 * static_cast<double>(header.period_ns()));
    played_->tools.push_back(std::move(tool));
    played_->play.simulation->scene(k).strings = played_->strings;
  }
  pulled_.resize(played_->tools.size());
  apply_settings(*played_);
}

void RecordedScene::fail(const std::string& what) const {
  throw std::runtime_error(path_ + ": " + what + ".");
}

void RecordedScene::begin_change(std::uint64_t number, std::uint64_t tick) {
  const SceneSettings& now = played_->settings;
  auto change = std::make_unique<SettingsChange>(SettingsChange{number, 0, now, now});
  if (!announced_ || announced_->number() != number || !get_settings(*announced_, change->to)) {
    fail("the change of parameters at tick " + std::to_string(tick) +
         " is missing or damaged. Name another recording");
  }
  hapticd::begin_change(*played_, *change);
  change_ = std::move(change);
  change_share_ = 0.0;
}

void RecordedScene::learn_delays(const Tick& tick) {
  bool learned = false;
  for (std::size_t k = 0; k < played_->tools.size(); ++k) {
    learned = learn_delay(tick.tools[k].sample, played_->tools[k]) || learned;
  }
  if (learned) apply_settings(*played_);
}

// In the order of the loop: SettingsRamp::follow, HapticLoop::read_devices. What the tick gave is
// for the next.
void RecordedScene::begin_tick(const Tick& tick) {
  if (tick.tools.size() != played_->tools.size()) {
    fail("tick " + std::to_string(tick.tick) +
         " has other tools than its scene. The file is "
         "damaged: name another recording");
  }
  if (tick.change != 0) begin_change(tick.change, tick.tick);
  if (change_ != nullptr) {
    const double dt_s = 1e-9 * static_cast<double>(tick.dt_ns);
    change_share_ = next_share(*change_, change_share_, dt_s, *played_, pulled_);
    follow_change(*change_, change_share_, *played_);
    if (change_share_ >= 1.0) change_.reset();
  }
  learn_delays(tick);
  for (std::size_t k = 0; k < pulled_.size(); ++k) {
    const ToolTick& tool = tick.tools[k];
    if (tool.came) pulled_[k].p_DH = tool.sample.p_DH;
    pulled_[k].X_WH = {to_quaternion(tool.X_WH.q), to_vector(tool.X_WH.p)};
    pulled_[k].X_WG = {to_quaternion(tool.X_WG.q), to_vector(tool.X_WG.p)};
  }
  for (std::size_t k = 0; k < played_->tools.size(); ++k) {
    const double scale = played_->tools[k].grant.scale;
    if (scale == tick.tools[k].stiffness.scale) continue;
    fail("tick " + std::to_string(tick.tick) + ": the stiffness was scaled by " +
         exact_text(tick.tools[k].stiffness.scale) + ", which would be " + exact_text(scale) +
         " here. Use the version that recorded it");
  }
}

}  // namespace hapticd
