// Events in the order of time, from which sound is rendered offline: out of a recording, or the
// seven open strings one after the other. Not RT.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "hapticd/v1/stream.pb.h"

namespace hapticd::audio {

/// An event, or the scene that plays from here on.
struct ScoreEntry {
  std::int64_t t_ns = 0;  ///< since the beginning of the score
  v1::Item item;
};

using Score = std::vector<ScoreEntry>;

/// The Guqin's tuning, zheng diao, from the lowest string.
struct OpenString {
  const char* name;
  double frequency_hz;
};
inline constexpr OpenString kZhengDiao[] = {{"C2", 65.4}, {"D2", 73.4},  {"F2", 87.3},
                                            {"G2", 98.0}, {"A2", 110.0}, {"C3", 130.8},
                                            {"D3", 146.8}};

/// The seven open strings, one a second, and then all of them within half a second.
[[nodiscard]] Score open_strings();

/// The score of a recording; `problem` says what is wrong with it, empty when nothing is. Time that
/// restarts with a scene, as the virtual clock's does, goes on where it was.
[[nodiscard]] Score recorded_score(const std::string& path, std::string& problem);

}  // namespace hapticd::audio
