// Whether what is touched can be felt at all: a line for the log when a device gives no force, or
// bears so little of the scene's stiffness that hardly any is left, and when what it bears is that
// of an unknown device. Once for each scene, and again when a change makes it worse. Not RT.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "core/math/limits.h"
#include "device/api/device_profile.h"

namespace hapticd {

/// Share of the scene's stiffness below which a device is said to bear too little. Larger: is said
/// of devices that can be played; smaller: somebody looks for a force that is not there.
inline constexpr double kWeakShare = 0.05;

/// What a tool's device bears at present.
struct BorneStiffness {
  std::uint32_t tool_id = 0;
  double share = 1.0;  ///< of the scene's stiffness, (0, 1]
  double bound = 0.0;  ///< N/m
  double delay = 0.0;  ///< reckoned with, s
  /// Nobody has measured the damping of a device that a hand feels.
  bool unmeasured = false;
};

/// Kept from tick to tick.
class ForceWatch {
 public:
  /// The line to be logged of tool number `k`, below kMaxTools, in this scene; none when there is
  /// nothing new to say, or a change is under way. `max_force` is that of the configuration, N.
  [[nodiscard]] std::optional<std::string> look(std::uint32_t scene_id, std::size_t k,
                                                const BorneStiffness& borne,
                                                const DeviceProfile& profile, double max_force);

 private:
  struct Told {
    std::uint32_t scene_id = 0;  ///< 0: none yet
    double share = 1.0;          ///< said last; 1: nothing was
    double seen = -1.0;          ///< of the tick before; -1: none
  };
  std::array<Told, kMaxTools> told_{};
};

}  // namespace hapticd
