// Where tools meet a string that sounds, in axes across it. Frames: W. SI. RT: yes, 0.2 us per
// tool.
#pragma once

#include <array>
#include <cmath>

#include "core/instrument/wave_state.h"
#include "core/simulation/string_proximity.h"
#include "core/simulation/wave_player.h"

namespace hapticd {

/// Axes across the string, and along it.
struct StringFrame {
  Vector3 p_WA;
  Vector3 axis_W;  ///< A to B, m
  Vector3 y_W, z_W;
};

/// Of a string that runs along `line`.
[[nodiscard]] HD_REALTIME StringFrame frame_of(const Capsule& line) noexcept;

/// The part of a vector across the string.
[[nodiscard]] inline Transverse across(const StringFrame& frame, const Vector3& v_W) noexcept {
  return {v_W.dot(frame.y_W), v_W.dot(frame.z_W)};
}

[[nodiscard]] inline Vector3 in_world(const StringFrame& frame, const Transverse& v) noexcept {
  return v.y * frame.y_W + v.z * frame.z_W;
}

[[nodiscard]] inline double norm(const Transverse& a) noexcept {
  return std::sqrt(a.y * a.y + a.z * a.z);
}

/// One tool that is near the string.
struct NearTool {
  WaveTouch touch;
  StringProximity proximity;
};

/// Everything a tick of one string works on.
struct Playing {
  const PlayedWave& wave;
  const StringConstants& string;
  const InstrumentOptions& options;
  StringFrame frame;
  TickTime time;
  WaveMemory& kept;
};

using NearTools = std::array<NearTool, kMaxTools>;
using Touches = std::array<const WaveTouch*, kMaxTools>;

/// Of string number `string`.
[[nodiscard]] HD_REALTIME const StringConstants& constants_of(const SimulationMemory& memory,
                                                              std::int32_t string) noexcept;
[[nodiscard]] HD_REALTIME WaveMemory& kept_of(const SimulationMemory& memory,
                                              std::int32_t string) noexcept;

/// The tools that press the string, or that it may meet: false, and all null, where there is none.
[[nodiscard]] HD_REALTIME bool find_near(const Playing& playing, NearTools& tools,
                                         Touches& touches) noexcept;

}  // namespace hapticd
