// Things that do not yield and that a string which sounds may strike or lie on: a fret, a board.
// Each is a plane across the string at one place (string_contacts.h). SI; across the string, (y,
// z). RT: yes.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/instrument/string_contacts.h"

namespace hapticd {

/// Those that one string may meet in a tick, at most: the nearest ones.
inline constexpr std::size_t kMaxWaveRests = 4;

/// One that the string may meet in a tick.
struct WaveRestTouch {
  std::int32_t number = -1;     ///< its own
  double lambda = 0.5;          ///< place along the string
  Transverse d;                 ///< of the string where it just lies on it, m
  Transverse normal{0.0, 1.0};  ///< unit, from it to the string
  double friction = 0.0;        ///< Coulomb's coefficient
};

/// The same from tick to tick.
struct WaveRest {
  std::int32_t number = -1;  ///< -1: none
  StringContactPath path;    ///< `force` is the mean of the last tick
  double lacking = 0.0;      ///< what it stands lower by, for the string was in it when it came, m
  Transverse load;           ///< force on the string, mean of some 5 ms, N
  double share = 0.0;        ///< of the time with force, mean of some 20 ms
};

using WaveRests = std::array<WaveRest, kMaxWaveRests>;

/// What they are led by.
struct RestLead {
  const ModeTable& table;
  const ModalMotion& motion;
  double bristle;  ///< of friction, N/m
  bool has_friction;
  double dt;  ///< of the tick's sub-steps, s
};

/// Makes `rests` those of `touches` (kMaxWaveRests at most), and adds their paths through the tick.
HD_REALTIME void prepare_rests(const RestLead& lead, std::span<const WaveRestTouch> touches,
                               WaveRests& rests, StringContactPaths& paths) noexcept;

/// Takes over what the tick has made of the paths that prepare_rests() added, which begin at
/// `first` of `paths`.
HD_REALTIME void follow_rests(const StringContactPaths& paths, std::size_t first, int steps,
                              double dt, WaveRests& rests) noexcept;

}  // namespace hapticd
