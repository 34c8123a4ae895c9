// See wave_rest.h. RT: yes.
#include "core/instrument/wave_rest.h"

#include <algorithm>

namespace hapticd {
namespace {

/// Of wood or metal under a string, N/m, and its damping, N s/m.
constexpr double kRestStiffness = 1e6;
constexpr double kRestDamping = 0.5;
/// What the string was in comes back under it no faster than this, m/s: it would throw the string.
constexpr double kRestReturn = 5e-3;
/// Of the means of load and share of the time, s.
constexpr double kLoadTime = 0.005;
constexpr double kShareTime = 0.02;

/// How far the string is in it, m.
double depth(const RestLead& lead, const WaveRestTouch& touch) noexcept {
  PerMode shapes{};
  mode_shapes(lead.table, touch.lambda, shapes);
  const Transverse u = displacement(lead.table, lead.motion, shapes);
  return (touch.d.y - u.y) * touch.normal.y + (touch.d.z - u.z) * touch.normal.z;
}

void lead_through(const RestLead& lead, const WaveRestTouch& touch, WaveRest& rest) noexcept {
  const double sunk = std::max(depth(lead, touch), 0.0);
  const auto at = [&](double lacking) {
    return Transverse{touch.d.y - lacking * touch.normal.y, touch.d.z - lacking * touch.normal.z};
  };
  if (rest.number != touch.number) {
    rest = WaveRest{};
    rest.number = touch.number;
    rest.lacking = sunk;
    rest.path.lambda_to = touch.lambda;
    rest.path.d_to = at(sunk);
  }
  rest.lacking = std::max(0.0, std::min(sunk, rest.lacking) - kRestReturn * lead.dt);
  StringContactPath& path = rest.path;
  path.shape = StringContactShape::kPlane;
  path.lambda_from = path.lambda_to;
  path.lambda_to = touch.lambda;
  path.normal = touch.normal;
  path.d_from = path.d_to;
  path.d_to = at(rest.lacking);
  path.stiffness = kRestStiffness;
  path.damping = kRestDamping;
  path.friction = lead.has_friction ? touch.friction : 0.0;
  path.bristle = lead.bristle;
}

}  // namespace

void prepare_rests(const RestLead& lead, std::span<const WaveRestTouch> touches, WaveRests& rests,
                   StringContactPaths& paths) noexcept {
  const auto is_met = [&](const WaveRest& rest) {
    return std::any_of(touches.begin(), touches.end(),
                       [&](const WaveRestTouch& touch) { return touch.number == rest.number; });
  };
  for (WaveRest& rest : rests) {
    if (!is_met(rest)) rest = WaveRest{};
  }
  for (const WaveRestTouch& touch : touches) {
    const auto same = [&](const WaveRest& rest) { return rest.number == touch.number; };
    auto* at = std::find_if(rests.begin(), rests.end(), same);
    if (at == rests.end()) {
      at = std::find_if(rests.begin(), rests.end(),
                        [](const WaveRest& rest) { return rest.number < 0; });
    }
    if (at != rests.end()) lead_through(lead, touch, *at);
  }
  for (const WaveRest& rest : rests) {
    if (rest.number >= 0) paths.push_back(rest.path);
  }
}

void follow_rests(const StringContactPaths& paths, std::size_t first, int steps, double dt,
                  WaveRests& rests) noexcept {
  for (WaveRest& rest : rests) {
    if (rest.number < 0) continue;
    rest.path = paths[first++];
    const double share = std::min(1.0, dt / kLoadTime);
    rest.load.y += share * (rest.path.force.y - rest.load.y);
    rest.load.z += share * (rest.path.force.z - rest.load.z);
    const double touched = static_cast<double>(rest.path.touched) / steps;
    rest.share += (touched - rest.share) * std::min(1.0, dt / kShareTime);
  }
}

}  // namespace hapticd
