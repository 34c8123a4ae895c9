// From a device's workspace to the world and back: scale, where the base stands, handedness, and
// where the hand has been brought by recentring and by the clutch, so that a small device on a desk
// reaches a whole instrument.
//   p_WH = M (p_WD + scale R_WD p_DH) + c,   R_WH = M R_WD R_DH M R_off,   M = diag of the mirror
// c and R_off are the state; R_off stands right, so that turning the device about an axis of the
// world turns the tool about the same axis. Forces are not scaled: a hand that moves `scale` times
// less feels the same newtons, so linear power at the device is that in the world over `scale`;
// power of torque is the same. RT: yes, about 30 ns.
#pragma once

#include <cstdint>
#include <type_traits>

#include "core/math/pose.h"
#include "core/math/realtime.h"
#include "core/math/wrench.h"

namespace hapticd {

/// A reflection of the world, for left-handed players: x -> -x or z -> -z.
enum class Mirror : std::uint8_t { kNone, kX, kZ };

/// As the scene says.
struct WorkspaceMap {
  double scale = 1.0;  ///< world metres per device metre, > 0
  Pose X_WD;           ///< where the device's base stands
  Mirror mirror = Mirror::kNone;
  int clutch_button = -1;    ///< lets go of the tool while held; [0, 15], -1: none
  int recentre_button = -1;  ///< brings the tool home when pressed; [0, 15], -1: none
};

/// Time in which the wrench comes back after the clutch or a recentring, s. Shorter: a contact that
/// the tool was let go in comes back as a blow.
inline constexpr double kReturnRamp_s = 0.2;
/// Longest step of that ramp in one tick, s.
inline constexpr double kMaxReturnStep_s = 0.005;

/// Kept between ticks; plain, for snapshots.
struct WorkspaceState {
  Array3 c_W{};                       ///< m
  Array4 q_off{1.0, 0.0, 0.0, 0.0};   ///< R_off, unit
  Array3 p_held_W{};                  ///< of the tool while the clutch is open, m
  Array4 q_held{1.0, 0.0, 0.0, 0.0};  ///< likewise
  double wrench_share = 1.0;          ///< see PlacedHand
  bool open = false;                  ///< the clutch
  bool recentre_was_down = true;      ///< a button held from the start is no press
};
static_assert(std::is_trivially_copyable_v<WorkspaceState>);

/// One tick.
struct WorkspaceInput {
  Pose X_DH;                  ///< measured, finite, unit quaternion
  Twist V_DH_D;               ///< measured
  std::uint32_t buttons = 0;  ///< bit i = button i
  bool clutch_open = false;   ///< asked for by a client, for as long as it lasts
  bool recentre = false;      ///< asked for by a client, for one tick
  double dt_s = 0.0;          ///< since the last tick
};

/// Where the tool is.
struct PlacedHand {
  Pose X_WH;          ///< unit quaternion; stands still while the clutch is open
  Twist V_WH_W;       ///< zero while it is open
  bool open = false;  ///< the clutch is open
  /// To multiply the wrench by, [0, 1]: none while the clutch is open, since a force that does not
  /// follow the hand would push it; 200 ms back to 1 after that and after recentring.
  double wrench_share = 1.0;
};

/// One tick: buttons and requests, then the map. Opening the clutch, moving and closing it leaves
/// the tool where it was; recentring puts it at `X_WG_home` (with the clutch open too), wherever
/// the device is.
[[nodiscard]] HD_REALTIME PlacedHand place(const WorkspaceMap& map, const Pose& X_WG_home,
                                           const WorkspaceInput& input,
                                           WorkspaceState& state) noexcept;

/// Largest |p_DH|, m, for which the tool is surely within kMaxPosition of the origin of W; <= 0
/// where it never is.
[[nodiscard]] HD_REALTIME double reach_of(const WorkspaceMap& map,
                                          const WorkspaceState& state) noexcept;

/// True when a state, which may come from a file, is finite and its quaternions are unit.
[[nodiscard]] bool usable(const WorkspaceState& state) noexcept;

/// X_WH of the device pose `X_DH`, the clutch being closed.
[[nodiscard]] HD_REALTIME Pose to_world(const WorkspaceMap& map, const WorkspaceState& state,
                                        const Pose& X_DH) noexcept;

/// X_DH for which to_world gives `X_WH`.
[[nodiscard]] HD_REALTIME Pose to_device(const WorkspaceMap& map, const WorkspaceState& state,
                                         const Pose& X_WH) noexcept;

/// V_WH_W of V_DH_D; neither c nor R_off has a part in it.
[[nodiscard]] HD_REALTIME Twist to_world(const WorkspaceMap& map, const Twist& V_DH_D) noexcept;

/// V_DH_D of V_WH_W.
[[nodiscard]] HD_REALTIME Twist to_device(const WorkspaceMap& map, const Twist& V_WH_W) noexcept;

/// F_H_D of F_H_W: turned and mirrored, not scaled.
[[nodiscard]] HD_REALTIME Wrench to_device(const WorkspaceMap& map, const Wrench& F_H_W) noexcept;

/// F_H_W of F_H_D.
[[nodiscard]] HD_REALTIME Wrench to_world(const WorkspaceMap& map, const Wrench& F_H_D) noexcept;

}  // namespace hapticd
