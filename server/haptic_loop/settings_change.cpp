// See settings_change.h. RT: yes.
#include "server/haptic_loop/settings_change.h"

#include <algorithm>
#include <cmath>

namespace hapticd {
namespace {

/// What the device would feel of the settings, unclamped.
DeviceStiffness wanted_stiffness(const LiveSettings& live,
                                 const std::vector<StringParameters>& pieces) noexcept {
  const double to_device = live.scale * live.force_gain;
  DeviceStiffness wanted;
  wanted.kt = live.coupling.kt * to_device;
  wanted.kr = live.coupling.kr() * live.force_gain;
  for (const StringParameters& piece : pieces) {
    wanted.kc = std::max(wanted.kc, std::min(piece.contact_stiffness, live.coupling.kt));
  }
  wanted.kc *= to_device;
  return wanted;
}

/// Puts `live` in force for one tool, all but the strings.
void apply_to_tool(const LiveSettings& live, const std::vector<StringParameters>& pieces,
                   PlayedTool& played, ToolScene& tool) noexcept {
  StiffnessLimits limits = played.stiffness_limits;
  limits.coupling_damping = live.coupling_damping;
  played.grant = grant_stiffness(wanted_stiffness(live, pieces), limits);
  // Where poses come from data force moves nothing, and no stiffness is too high.
  if (played.device.traits.follows_data) played.grant.scale = 1.0;
  tool.stiffness = {live.coupling.kt * played.grant.scale, live.coupling.length};
  tool.coupling_damping = live.coupling_damping;
  tool.options = live.contact;
  tool.instrument = live.instrument;
  played.map.scale = live.scale;
  played.map.X_WD = live.X_WD;
  played.force_gain = live.force_gain;
}

}  // namespace

void apply_settings(PlayedScene& scene) noexcept {
  // Strings are shared: they are as stiff as the weakest device bears.
  double scale = 1.0;
  for (std::size_t k = 0; k < scene.tools.size(); ++k) {
    apply_to_tool(scene.settings.tools[k], scene.settings.pieces, scene.tools[k],
                  scene.play.simulation->scene(k));
    scale = std::min(scale, scene.tools[k].grant.scale);
  }
  scene.quality_level = scene.settings.tools.front().quality_level;
  for (std::size_t k = 0; k < scene.strings.size(); ++k) {
    scene.strings[k] = derive_string(scene.settings.pieces[k]);
    scene.strings[k].contact_stiffness *= scale;
  }
}

void begin_change(const PlayedScene& scene, SettingsChange& change) noexcept {
  HD_ASSERT(change.from.pieces.size() == scene.settings.pieces.size());
  HD_ASSERT(change.from.tools.size() == scene.settings.tools.size());
  std::copy(scene.settings.tools.begin(), scene.settings.tools.end(), change.from.tools.begin());
  std::copy(scene.settings.pieces.begin(), scene.settings.pieces.end(), change.from.pieces.begin());
}

void follow_change(const SettingsChange& change, double share, PlayedScene& scene) noexcept {
  HD_ASSERT(change.to.pieces.size() == scene.settings.pieces.size());
  for (std::size_t k = 0; k < scene.settings.tools.size(); ++k) {
    scene.settings.tools[k] = blend(change.from.tools[k], change.to.tools[k], share);
  }
  for (std::size_t k = 0; k < scene.settings.pieces.size(); ++k) {
    scene.settings.pieces[k] = blend(change.from.pieces[k], change.to.pieces[k], share);
  }
  apply_settings(scene);
}

bool usable(const SceneSettings& settings) noexcept {
  const auto positive = [](double x) { return std::isfinite(x) && x > 0.0; };
  const auto fine = [&](const LiveSettings& live) {
    return positive(live.coupling.kt) && positive(live.coupling.length) && positive(live.scale) &&
           usable(live.contact) && std::isfinite(live.force_gain) &&
           std::isfinite(live.coupling_damping) && !check_options(live.instrument);
  };
  return std::all_of(settings.tools.begin(), settings.tools.end(), fine) &&
         std::none_of(
             settings.pieces.begin(), settings.pieces.end(),
             [](const StringParameters& piece) { return check_string(piece).has_value(); });
}

}  // namespace hapticd
