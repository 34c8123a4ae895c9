// See settings_change.h. RT: yes.
#include "server/haptic_loop/settings_change.h"

#include <algorithm>

namespace hapticd {
namespace {

/// What the device would feel of the settings, unclamped.
DeviceStiffness wanted_stiffness(const SceneSettings& settings) noexcept {
  const LiveSettings& live = settings.live;
  const double to_device = live.scale * live.force_gain;
  DeviceStiffness wanted;
  wanted.kt = live.coupling.kt * to_device;
  wanted.kr = live.coupling.kr() * live.force_gain;
  for (const StringParameters& piece : settings.pieces) {
    wanted.kc = std::max(wanted.kc, std::min(piece.contact_stiffness, live.coupling.kt));
  }
  wanted.kc *= to_device;
  return wanted;
}

}  // namespace

void apply_settings(PlayedScene& scene) noexcept {
  const LiveSettings& live = scene.settings.live;
  StiffnessLimits limits = scene.stiffness_limits;
  limits.coupling_damping = live.coupling_damping;
  scene.grant = grant_stiffness(wanted_stiffness(scene.settings), limits);
  // Where poses come from data force moves nothing, and no stiffness is too high.
  if (follows_data(scene.device.device->profile().driver)) scene.grant.scale = 1.0;
  ToolScene& tool = scene.play.simulation->scene(0);
  tool.stiffness = {live.coupling.kt * scene.grant.scale, live.coupling.length};
  tool.coupling_damping = live.coupling_damping;
  tool.options = live.optimiser;
  tool.instrument = live.instrument;
  scene.map.scale = live.scale;
  scene.map.X_WD = live.X_WD;
  scene.force_gain = live.force_gain;
  scene.quality_level = live.quality_level;
  for (std::size_t k = 0; k < scene.strings.size(); ++k) {
    scene.strings[k] = derive_string(scene.settings.pieces[k]);
    scene.strings[k].contact_stiffness *= scene.grant.scale;
  }
}

void begin_change(const PlayedScene& scene, SettingsChange& change) noexcept {
  HD_ASSERT(change.from.pieces.size() == scene.settings.pieces.size());
  change.from.live = scene.settings.live;
  std::copy(scene.settings.pieces.begin(), scene.settings.pieces.end(), change.from.pieces.begin());
}

void follow_change(const SettingsChange& change, double share, PlayedScene& scene) noexcept {
  HD_ASSERT(change.to.pieces.size() == scene.settings.pieces.size());
  scene.settings.live = blend(change.from.live, change.to.live, share);
  for (std::size_t k = 0; k < scene.settings.pieces.size(); ++k) {
    scene.settings.pieces[k] = blend(change.from.pieces[k], change.to.pieces[k], share);
  }
  apply_settings(scene);
}

}  // namespace hapticd
