// Where the strings of a scene can lie on the lines and bodies that they touch: one place for a
// line that crosses a string, one every few millimetres of a body, or of a line that runs along it.
// Offline.
#pragma once

#include <vector>

#include "core/scene/scene_description.h"
#include "core/simulation/tool_renderer.h"

namespace hapticd {

/// What lies further from a string at rest is out of its reach, m.
inline constexpr double kRestReach = 0.05;
/// Places on a string of a body, at most; and no closer to each other than this, m. Fewer: the
/// string gives between them, where a finger presses it on a board.
inline constexpr int kMaxBodyRests = 192;
inline constexpr double kMinRestPitch = 2e-3;
/// What a string lies in by up to this it touches at rest, m; more is a fault of the scene.
inline constexpr double kMaxRestOverlap = 0.5e-3;

/// A thing that a string touches, and how it lies to it.
struct RestPlaces {
  std::vector<StringRest> rests;    ///< ascending along the string
  double nearest_gap = kRestReach;  ///< of the string at rest to the thing, m
};

/// Of string number `string` and line number `line`; both straight pieces, the string of a length
/// above kMinString. Where the string's axis meets the line's, there is none.
[[nodiscard]] RestPlaces places_on_line(const SceneDescription& scene, std::size_t string,
                                        std::size_t line);

/// Of string number `string` and body number `body`.
[[nodiscard]] RestPlaces places_on_body(const SceneDescription& scene, std::size_t string,
                                        std::size_t body);

/// All of a scene whose strings are one piece each where they touch anything. `pieces[i]`: the
/// capsule of string i. By capsule, then along it.
[[nodiscard]] std::vector<StringRest> all_rests(const SceneDescription& scene,
                                                const std::vector<std::int32_t>& pieces);

}  // namespace hapticd
