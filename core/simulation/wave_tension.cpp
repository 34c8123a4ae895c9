// See wave_tension.h. RT: yes.
#include "core/simulation/wave_tension.h"

#include <algorithm>

namespace hapticd {
namespace {

/// Its tension is told from what bends it where that is at least this, m.
constexpr double kMinBend = 1e-6;
/// Tension that a bend may tell, over that at rest: more would turn the fastest modes by more than
/// a sub-step bears.
constexpr double kMinRaise = 0.5;
constexpr double kMaxRaise = 16.0;
/// And of that the most that its swinging may add: beyond it the swing would feed on itself.
constexpr double kMaxSwingRaise = 0.25;
/// A change of tension below this share is none: 0.02 cents.
constexpr double kSameTension = 2e-5;
/// What its swinging adds to the tension, N: E A times its mean extension, which holds half of its
/// energy.
double swing_tension(const Playing& playing, double held) noexcept {
  const StringConstants& string = playing.string;
  if (!playing.options.pitch_glide || !(string.axial_stiffness > 0.0)) return 0.0;
  const double extension = 0.5 * playing.kept.state.ringing / held;
  return std::min(string.axial_stiffness / string.length * extension, kMaxSwingRaise * held);
}

}  // namespace

bool is_parted(const Playing& playing, const Touches& touches) noexcept {
  const std::span<const ToolPlay> tools = playing.wave.memory.tools;
  std::size_t pressing = 0;
  bool parted = false;
  for (std::size_t k = 0; k < tools.size(); ++k) {
    if (touches[k] == nullptr || !(touches[k]->force > 0.0)) continue;
    ++pressing;
    parted = parted || part_of(tools[k].view, playing.wave.string) != nullptr;
  }
  return pressing > 1 || parted;
}

double extension_of(const Playing& playing) noexcept {
  StringTools views;
  StringPoints points;
  string_points(string_tools(playing.wave.memory, views), playing.wave.sharing, playing.wave.string,
                -1, points);
  double polyline = 0.0;
  for (std::size_t k = 0; k + 1 < points.size(); ++k) {
    polyline += (points[k + 1] - points[k]).norm();
  }
  return std::max(0.0, polyline - playing.string.length);
}

double tension_of(const Playing& playing, const NearTools& tools, const Touches& touches) noexcept {
  const StringConstants& string = playing.string;
  const NearTool* only = nullptr;
  for (std::size_t k = 0; k < touches.size(); ++k) {
    if (touches[k] != nullptr && touches[k]->force > 0.0) only = &tools[k];
  }
  if (only == nullptr) return string.tension;
  double tension = string.tension;
  if (is_parted(playing, touches)) {
    tension += string.axial_stiffness * (extension_of(playing) / string.length);
  } else {
    const double u = norm(across(playing.frame, only->proximity.u_W));
    const double run = only->touch.lambda * (1.0 - only->touch.lambda) * string.length;
    if (u < kMinBend || !(run > 0.0)) return playing.kept.state.held_tension;
    tension = norm(across(playing.frame, only->proximity.F_W)) * run / u;
  }
  return std::clamp(tension, kMinRaise * string.tension, kMaxRaise * string.tension);
}

void tune(const Playing& playing, double held) noexcept {
  WaveString& string = playing.kept.state.string;
  playing.kept.state.held_tension = held;
  double tension = held + swing_tension(playing, held);
  const double before = string.tuning.tension;
  if (std::abs(tension - before) < kSameTension * before) tension = before;
  retune(tuning_at(playing.string, tension, playing.options), playing.kept.table, string);
}

}  // namespace hapticd
