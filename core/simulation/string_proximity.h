// A tool relative to a string after the contact problem of its tick: distance, force and speeds,
// as the string's response takes them (core/instrument). Frames: W. SI. RT: yes, about 0.1 us per
// string.
#pragma once

#include "core/simulation/tool_play.h"

namespace hapticd {

/// Distance that means "not near", m.
inline constexpr double kNotNear = 1.0;

/// A string relative to a tool.
struct StringProximity {
  StringTouch touch;
  Vector3 nhat_W{0.0, 0.0, 0.0};  ///< from string to tool
  Vector3 p_WC{0.0, 0.0, 0.0};
  Vector3 u_W{0.0, 0.0, 0.0};  ///< deflection of its vertex, m
  std::int32_t part = -1;      ///< of the tool, that is nearest; -1: none near
  double radius = 0.0;         ///< of the tool's sphere there, m
  double compliance = 0.0;     ///< of the soft parts that touch it, m/N
  Vector3 F_W{0.0, 0.0, 0.0};  ///< of the string on the tool by its law, friction included, N
};

/// The tool of `play` relative to string number `string`; `visit` is what is known from the tick
/// before.
[[nodiscard]] HD_REALTIME StringProximity proximity_to(const ToolPlay& play,
                                                       const ToolStringState& visit,
                                                       std::int32_t string) noexcept;

/// Looks again for pairs with strings when one may swing by `swing` (m) further than those of the
/// contact problem reach, or than the tool has moved since they were found.
HD_REALTIME void reach_out(double swing, ToolPlay& play) noexcept;

}  // namespace hapticd
