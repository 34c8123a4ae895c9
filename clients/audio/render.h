// Sound without a sound card: a score through the same engine as live, as fast as the processor
// can, and to the same bits in every run. Not RT.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <vector>

#include "clients/audio/event_player.h"
#include "clients/audio/score.h"

namespace hapticd::audio {

/// Frames rendered at a time; the result does not depend on it.
inline constexpr std::size_t kRenderBlock = 256;
/// The most that goes on after the last event, s.
inline constexpr double kMaxTail_s = 20.0;

/// What came of it.
struct RenderReport {
  double length_s = 0.0;
  EventCounts events;
  std::uint64_t played = 0;
  std::uint64_t stolen = 0;
  double limited_s = 0.0;  ///< in which it was made softer to stay below full scale
};

/// Renders a score into `write`, from its beginning until all tones have died away. `tones` as in
/// EventPlayer.
RenderReport render(const Score& score, const Sound& sound, ToneFiles* tones,
                    const std::function<void(std::span<const float>)>& write,
                    std::size_t block = kRenderBlock);

/// The recorded tones that are shipped: one file NAME.flac per string of zheng diao, by the
/// computed string, into a folder that is made if there is none. Throws std::runtime_error.
void render_tone_files(const std::string& folder, double rate_hz);

}  // namespace hapticd::audio
