// See force_watch.h.
#include "server/daemon/force_watch.h"

#include <spdlog/fmt/fmt.h>

#include <utility>

namespace hapticd {
namespace {

/// Why the device gives no force, and what to do; none when it does, or is not made to.
std::optional<std::string> why_none(const DeviceProfile& profile, double max_force) {
  if (profile.actuated_axes == 0) return std::nullopt;
  if (!(max_force > 0.0)) return "--max-force is 0. Give it more than that";
  const char* zero = !(profile.peak_force > 0.0)         ? "peak_force_n"
                     : !(profile.continuous_force > 0.0) ? "continuous_force_n"
                                                         : nullptr;
  if (zero == nullptr) return std::nullopt;
  return fmt::format("{} of its profile {}, or what the device states of itself, is 0", zero,
                     device_name(profile));
}

/// What would make it bear more.
std::string remedy_of(const DeviceProfile& profile) {
  if (profile.damping_guessed) {
    return "damping_n_s_per_m of its profile is a guess: state what was measured, or take a scene "
           "with a softer coupling";
  }
  if (!(profile.damping > 0.0) && profile.stiffness_max == kUnlimited) {
    return "Its profile states neither damping_n_s_per_m nor stiffness_max_n_per_m: state what was "
           "measured";
  }
  return fmt::format(
      "It follows from damping_n_s_per_m {}, delay_s and stiffness_max_n_per_m of its profile: "
      "measure them, or take a scene with a softer coupling",
      profile.damping);
}

}  // namespace

std::optional<std::string> ForceWatch::look(std::uint32_t scene_id, std::size_t k,
                                            const BorneStiffness& borne,
                                            const DeviceProfile& profile, double max_force) {
  Told& told = told_[k];
  const bool new_scene = told.scene_id != scene_id;
  if (new_scene) told = {scene_id, 1.0, -1.0};
  if (const auto why = why_none(profile, max_force)) {
    if (!new_scene) return std::nullopt;
    return fmt::format("tool {} gives no force: {}", borne.tool_id, *why);
  }
  if (new_scene && borne.unmeasured) {
    return fmt::format(
        "tool {}: the damping of {} is a guess. It counts as none, and the stiffness of an unknown "
        "device is granted: {:.3g} N/m. State what was measured in its profile, without guess",
        borne.tool_id, device_name(profile), borne.bound);
  }
  // While a change is under way it is another one in every tick.
  const bool settled = borne.share == std::exchange(told.seen, borne.share);
  if (borne.share >= kWeakShare) {
    if (settled) told.share = 1.0;
    return std::nullopt;
  }
  const bool worse = told.share >= kWeakShare || borne.share < 0.5 * told.share;
  if (!settled || !worse) return std::nullopt;
  told.share = borne.share;
  return fmt::format(
      "tool {}: {} bears {:.3g} N/m at a delay of {:.3g} ms, {:.2g} % of the scene's stiffness: "
      "hardly any force is felt. {}",
      borne.tool_id, device_name(profile), borne.bound, 1e3 * borne.delay, 100.0 * borne.share,
      remedy_of(profile));
}

}  // namespace hapticd
